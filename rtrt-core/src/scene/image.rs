//! Textures and their mip chains.

use super::bvh::Join;
use super::encoder::Encoder;
use crate::kernel::texture::half;
use crate::lane::Word;
use crate::layout::{Texture, Wrap};
use crate::num::srgb_byte_decode;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// The meaning of the bytes of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Content {
    /// sRGB, and alpha, which is averaged like a color.
    Color,
    /// sRGB, and alpha that hides: in averages a texel counts as far as it is seen. A texel that is not seen at all
    /// takes the color of those around it, so that filters find no other color at the edge of what is seen.
    SeeThrough,
    /// Numbers from 0 to 1, of 255 steps.
    Numbers,
    /// Normals, whose coordinates −1 ..= 1 are 0 ..= 255. Texels of coarser levels have the direction of the mean
    /// of the normals that they cover; alpha, which images of normals do not use, is how much those vary (see
    /// `kernel::variance::of_map`).
    Normals,
}

/// A picture with alpha, 8 bits a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rows from top to bottom, four bytes a pixel: red, green, blue, alpha.
    pub rgba: Vec<u8>,
}

/// Why an image was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The size is 0, or beyond [`Image::MAX_SIDE`].
    #[error("a texture of {width} x {height} is not within 1 .. 16384 on a side")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The bytes are not four a pixel.
    #[error("{bytes} bytes do not make {width} x {height} RGBA pixels")]
    Bytes {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// The number of bytes.
        bytes: usize,
    },
}

impl Image {
    /// The most columns or rows.
    pub const MAX_SIDE: u32 = 16_384;

    fn check(&self) -> Result<(), ImageError> {
        let &Self { width, height, ref rgba } = self;
        let side = 1..=Self::MAX_SIDE;
        if !side.contains(&width) || !side.contains(&height) {
            return Err(ImageError::Size { width, height });
        }
        if rgba.len() as u64 != u64::from(width) * u64::from(height) * 4 {
            return Err(ImageError::Bytes { width, height, bytes: rgba.len() });
        }
        Ok(())
    }

    /// Appends the starts of the levels and the mip chain to `texels`. Returns its place.
    ///
    /// Each level halves the one before, rounding down; a texel is the average of the
    /// texels it covers (two by two, or three where a size is odd), in linear light if they
    /// are colors. See [`Content::SeeThrough`] for those with alpha. The result does not depend on `join`.
    ///
    /// # Errors
    /// The size or the number of bytes is wrong.
    pub(super) fn append(
        &self,
        wrap: [Wrap; 2],
        content: Content,
        texels: &mut Vec<u32>,
        join: &impl Join,
    ) -> Result<Texture, ImageError> {
        self.check()?;
        let mut normals = Vec::new();
        let channels = Channels::new(content);
        let first = texels.len();
        let levels = self.width.max(self.height).ilog2() as usize + 1;
        texels.resize(first + levels, 0);
        texels[first] = texels.len() as u32;
        let is_normal = content == Content::Normals;
        texels.extend(self.rgba.chunks_exact(4).map(|p| {
            let alpha = if is_normal { 0 } else { p[3] };
            u32::from_le_bytes([p[0], p[1], p[2], alpha])
        }));
        let (mut size, mut start) = ([self.width, self.height], first + levels);
        for level in 1..levels {
            let finer = size;
            size = size.map(half);
            let finer_texels = &texels[start..];
            let coarser = if is_normal {
                normals = filled(size, join, |at| mean_normal(finer_texels, &normals, finer, size, at));
                filled(size, join, |[x, y]| encode_normal(normals[(y * size[0] + x) as usize]))
            } else {
                filled(size, join, |at| channels.average(finer_texels, finer, covered(finer, size, at)))
            };
            start = texels.len();
            texels[first + level] = start as u32;
            texels.extend(coarser);
        }
        if content == Content::SeeThrough {
            color_unseen(texels, first, levels, [self.width, self.height]);
        }
        let log_size = libm::log2(f64::from(self.width) * f64::from(self.height)) * 0.5;
        Ok(Texture {
            first: first as u32,
            width: self.width,
            height: self.height,
            levels: levels as u32,
            log_size: log_size as f32,
            wrap_u: wrap[0] as u32,
            wrap_v: wrap[1] as u32,
            ..Texture::NONE
        })
    }
}

/// The columns and rows of the finer level that one texel of the coarser covers.
#[inline(always)]
fn covered(finer: [u32; 2], coarser: [u32; 2], at: [u32; 2]) -> [Range<u32>; 2] {
    [0, 1].map(|axis| {
        let end = if at[axis] + 1 == coarser[axis] { finer[axis] } else { 2 * at[axis] + 2 };
        2 * at[axis]..end.min(finer[axis]).max(2 * at[axis] + 1)
    })
}

/// The mean of the normals of the finer level that one texel of the coarser covers. Those of the finest level,
/// of length 1, are in `texels`, those of others in `normals`.
#[inline]
fn mean_normal(
    texels: &[u32],
    normals: &[[f32; 3]],
    finer: [u32; 2],
    coarser: [u32; 2],
    at: [u32; 2],
) -> [f32; 3] {
    let [columns, rows] = covered(finer, coarser, at);
    let count = (columns.len() * rows.len()) as f32;
    let mut sum = [0.0_f32; 3];
    for place in rows.flat_map(|y| columns.clone().map(move |x| (y * finer[0] + x) as usize)) {
        let normal = normals.get(place).copied().unwrap_or_else(|| decode_normal(texels[place]));
        sum = [sum[0] + normal[0], sum[1] + normal[1], sum[2] + normal[2]];
    }
    [sum[0] / count, sum[1] / count, sum[2] / count]
}

/// The normal of a texel of the finest level; straight up where it has no length.
#[inline]
fn decode_normal(texel: u32) -> [f32; 3] {
    let [x, y, z, _] = texel.to_le_bytes();
    let coordinate = |byte: u8| f32::from(byte) / 127.5 - 1.0;
    unit([coordinate(x), coordinate(y), coordinate(z)]).map_or([0.0, 0.0, 1.0], |(normal, _)| normal)
}

/// The vector at length 1, and its length; none for one that is too short.
#[inline]
fn unit(v: [f32; 3]) -> Option<([f32; 3], f32)> {
    let length = libm::sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    (length > 1e-3).then(|| ([v[0] / length, v[1] / length, v[2] / length], length))
}

/// The texel of a mean of normals: its direction, and, as alpha, the deviation of the normals, 0 ..= 1. Of
/// normals that vary by `v`, both axes summed, the mean is shorter than 1 by `v / 2`, to first order:
///
/// ```text
/// v = 2 (1 − |mean|) / |mean|
/// ```
#[inline]
fn encode_normal(mean: [f32; 3]) -> u32 {
    let (normal, length) = unit(mean).unwrap_or(([0.0, 0.0, 1.0], 0.0));
    let deviation = libm::sqrtf((2.0 * (1.0 - length)).max(0.0) / length.max(1e-3)).min(1.0);
    let coordinate = |c: f32| byte((c * 0.5 + 0.5).clamp(0.0, 1.0));
    let [x, y, z] = normal;
    coordinate(x) | coordinate(y) << 8 | coordinate(z) << 16 | byte(deviation) << 24
}

/// What the bytes of texels mean.
struct Channels {
    /// Of colors.
    encoder: Option<Encoder>,
    /// The value of each byte: light, or a share.
    values: [f32; 256],
    shares: [f32; 256],
    is_see_through: bool,
}

impl Channels {
    fn new(content: Content) -> Self {
        let shares = core::array::from_fn(|byte| byte as f32 / 255.0);
        let is_color = matches!(content, Content::Color | Content::SeeThrough);
        let light = |byte: usize| srgb_byte_decode(Word(byte as u32));
        let values = if is_color { core::array::from_fn(light) } else { shares };
        let is_see_through = content == Content::SeeThrough;
        Self { encoder: is_color.then(Encoder::new), values, shares, is_see_through }
    }

    /// The average of the texels of the finer level in these columns and rows.
    #[inline(always)]
    fn average(&self, texels: &[u32], finer: [u32; 2], [columns, rows]: [Range<u32>; 2]) -> u32 {
        let row = |y: u32| &texels[(y * finer[0] + columns.start) as usize..][..columns.len()];
        if let ([a, b], 2) = (row(rows.start), rows.len())
            && let [c, d] = row(rows.start + 1)
        {
            return self.mean([a, b, c, d].into_iter());
        }
        self.mean(rows.flat_map(row))
    }

    /// The average of some texels.
    #[inline(always)]
    fn mean<'a>(&self, texels: impl Iterator<Item = &'a u32>) -> u32 {
        // Of colors and alpha, and what they count.
        let (mut sum, mut alpha, mut seen, mut count) = ([0.0; 3], 0.0, 0.0, 0.0);
        for texel in texels {
            let [r, g, b, a] = texel.to_le_bytes();
            let weight = if self.is_see_through { f32::from(a) } else { 1.0 };
            for (sum, byte) in sum.iter_mut().zip([r, g, b]) {
                *sum += self.values[usize::from(byte)] * weight;
            }
            alpha += self.shares[usize::from(a)];
            seen += weight;
            count += 1.0;
        }
        let sum = if seen > 0.0 { sum } else { [0.0; 3] };
        let [r, g, b] = match &self.encoder {
            Some(encoder) => [0, 1, 2].map(
                #[inline(always)]
                |i| encoder.byte(sum[i] / seen.max(1.0)),
            ),
            None => [0, 1, 2].map(
                #[inline(always)]
                |i| byte(sum[i] / count),
            ),
        };
        r | g << 8 | b << 16 | byte(alpha / count) << 24
    }
}

/// A share, 0 ..= 1, as a byte.
#[inline(always)]
fn byte(share: f32) -> u32 {
    (share * 255.0 + 0.5) as u32
}

/// Levels with fewer texels are made by one worker.
const PARALLEL: usize = 1 << 14;

/// A level of this size, row by row, of what is at each column and row.
fn filled<T: Copy + Default + Send>(
    [width, height]: [u32; 2],
    join: &impl Join,
    at: impl Fn([u32; 2]) -> T + Sync,
) -> Vec<T> {
    let mut level = vec![T::default(); (width * height) as usize];
    fill_rows(&mut level, width, 0, join, &at);
    level
}

/// [`filled`] for the rows from `first` on.
fn fill_rows<T: Send>(
    level: &mut [T],
    width: u32,
    first: u32,
    join: &impl Join,
    at: &(impl Fn([u32; 2]) -> T + Sync),
) {
    let rows = level.len() / width as usize;
    if level.len() < PARALLEL || rows < 2 {
        for (y, row) in (first..).zip(level.chunks_exact_mut(width as usize)) {
            for (x, texel) in (0..).zip(row) {
                *texel = at([x, y]);
            }
        }
        return;
    }
    let (upper, lower) = level.split_at_mut(rows / 2 * width as usize);
    let middle = first + (rows / 2) as u32;
    join.join(|| fill_rows(upper, width, first, join, at), || fill_rows(lower, width, middle, join, at));
}

/// Gives texels with an alpha of 0 the color of the texel that covers them in the next coarser level, from the coarsest
/// level on. `first` is where the starts of the levels are, `finest` the size of the first one.
fn color_unseen(texels: &mut [u32], first: usize, levels: usize, finest: [u32; 2]) {
    let size = |level: usize| finest.map(|side| (side >> level).max(1));
    for level in (1..levels).rev() {
        let ([width, height], coarser) = (size(level - 1), size(level));
        let [start, coarser_start] = [level - 1, level].map(|level| texels[first + level] as usize);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let at = start + (y * width + x) as usize;
            if texels[at] >> 24 == 0 {
                let [above, beside] = [(y / 2).min(coarser[1] - 1), (x / 2).min(coarser[0] - 1)];
                texels[at] = texels[coarser_start + (above * coarser[0] + beside) as usize] & 0x00ff_ffff;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::srgb_byte_encode;
    use crate::scene::Sequential;

    fn chain(width: u32, height: u32, rgba: Vec<u8>) -> (Texture, Vec<u32>) {
        let mut texels = vec![0];
        let image = Image { width, height, rgba };
        (image.append([Wrap::Repeat; 2], Content::Color, &mut texels, &Sequential).unwrap(), texels)
    }

    #[test]
    fn a_chain_ends_at_one_texel_of_the_average_light() {
        let (texture, texels) = chain(2, 1, vec![255, 255, 255, 255, 0, 0, 0, 255]);
        assert_eq!((texture.levels, texels.len()), (2, 1 + 2 + 3));
        // Half the light of white is 188 in sRGB, not 128.
        assert_eq!(texels[1 + 2 + 2], 0xff_bc_bc_bc);
    }

    fn normals(width: u32, height: u32, rgba: Vec<u8>) -> Vec<u32> {
        let mut texels = vec![0];
        let image = Image { width, height, rgba };
        let levels =
            image.append([Wrap::Repeat; 2], Content::Normals, &mut texels, &Sequential).unwrap().levels;
        texels.split_off(1 + levels as usize)
    }

    #[test]
    fn normals_keep_their_mean_and_how_much_they_vary() {
        let flat = normals(4, 4, [128, 128, 255, 77].repeat(16));
        assert!(flat.iter().all(|&texel| texel & 0xff_00_00_00 == 0), "{flat:x?}");
        // Two slopes of 0.5 that face each other: v = 2 (1/cos − 1) of an angle whose tangent is 0.5.
        let sloped = normals(2, 1, vec![71, 128, 242, 255, 185, 128, 242, 255]);
        let expected = (2.0 * (1.25_f32.sqrt() - 1.0)).sqrt();
        let [x, y, z, alpha] = sloped[2].to_le_bytes().map(|byte| f32::from(byte) / 255.0);
        assert!((x - 0.5).abs() < 0.01 && (y - 0.5).abs() < 0.01 && z > 0.99, "{x} {y} {z}");
        assert!((alpha - expected).abs() < 0.01, "{alpha} {expected}");
        // Small slopes too, which bytes of a mean could not tell: 2/127.5 either way.
        let slight = normals(2, 1, vec![130, 128, 255, 0, 125, 128, 255, 0]);
        let [.., alpha] = slight[2].to_le_bytes();
        assert_eq!(alpha, 5);
        // Where nothing is left of the mean, everything varies.
        let [.., most] = normals(2, 1, vec![255, 128, 128, 0, 0, 128, 128, 0])[2].to_le_bytes();
        assert_eq!(most, 255);
    }

    #[test]
    fn each_normal_stays_in_its_place() {
        // Four columns and two rows of blocks of two by two texels.
        let slope = |x: u32, y: u32| [128 + 20 * (x / 2) as u8, 128 + 50 * (y / 2) as u8, 200, 255];
        let texels = normals(8, 4, (0..4).flat_map(|y| (0..8).flat_map(move |x| slope(x, y))).collect());
        let level = &texels[32..][..8];
        for (i, &texel) in (0..).zip(level) {
            let (direction, length) = unit(decode_normal(texel)).unwrap();
            let [x, y, z, _] = slope(i % 4 * 2, i / 4 * 2).map(|c| f32::from(c) / 127.5 - 1.0);
            let (expected, _) = unit([x, y, z]).unwrap();
            let cosine: f32 = (0..3).map(|axis| direction[axis] * expected[axis]).sum();
            assert!(cosine > 0.9998 && length > 0.99, "{i}: {direction:?} {expected:?}");
        }
    }

    #[test]
    fn what_is_not_seen_colors_nothing() {
        let (clear, faint, green) = ([255, 0, 0, 0], [0, 0, 255, 51], [0, 255, 0, 255]);
        let rgba = [[clear, green], [faint, green], [clear, clear], [clear, clear]].concat().concat();
        let levels = |content| {
            let mut texels = vec![0];
            let image = Image { width: 2, height: 4, rgba: rgba.clone() };
            image.append([Wrap::Clamp; 2], content, &mut texels, &Sequential).unwrap();
            texels.split_off(1 + 3)
        };
        let texels = levels(Content::SeeThrough);
        // A fifth as much is seen of blue as of each green: 10/11 of the light is green, 1/11 blue.
        let [_, g, b] = [0.0, 10.0 / 11.0, 1.0 / 11.0].map(|c: f32| srgb_byte_encode(c).0);
        let color = g << 8 | b << 16;
        // 561/4 of alpha, rounded, and half of it.
        assert_eq!(texels[8..], [color | 140 << 24, color, color | 70 << 24]);
        let [faint, green] = [faint, green].map(u32::from_le_bytes);
        assert_eq!(texels[..8], [color, green, faint, green, color, color, color, color]);
        // As numbers, or where alpha means nothing, red counts.
        assert!([Content::Color, Content::Numbers].iter().all(|&content| levels(content)[10] & 0xff > 60));
    }

    #[test]
    fn odd_sizes_lose_no_texel() {
        let (texture, texels) = chain(5, 3, [9, 9, 9, 9].repeat(15));
        assert_eq!(texture.levels, 3);
        assert_eq!(texels[1 + 3..], [0x0909_0909; 15 + 2 + 1]);
    }

    #[test]
    fn each_place_of_a_level_is_filled_whoever_works() {
        struct LastFirst;
        impl Join for LastFirst {
            fn join<A: Send, B: Send>(
                &self,
                a: impl FnOnce() -> A + Send,
                b: impl FnOnce() -> B + Send,
            ) -> (A, B) {
                let b = b();
                (a(), b)
            }
        }
        for size in [[301, 223], [1, 40_000], [40_000, 1], [7, 5]] {
            let places: Vec<_> = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])).collect();
            assert!(filled(size, &Sequential, |at| at) == places, "{size:?}");
            assert!(filled(size, &LastFirst, |at| at) == places, "{size:?}");
        }
    }

    #[test]
    fn refuses_wrong_sizes() {
        let image = |width, height, bytes| Image { width, height, rgba: vec![0; bytes] };
        let append =
            |image: Image| image.append([Wrap::Clamp; 2], Content::Numbers, &mut vec![0], &Sequential);
        assert!(matches!(append(image(0, 4, 0)), Err(ImageError::Size { .. })));
        assert!(matches!(append(image(2, 2, 15)), Err(ImageError::Bytes { .. })));
    }
}
