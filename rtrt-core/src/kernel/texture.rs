//! The color of a texture at a point.

use crate::kernel::mip::{Levels, levels};
use crate::lane::Lane;
use crate::layout::{Texture, Wrap};
use crate::num::{clamp, floor, to_integer};

/// Words at the start of the scene's texels: for each byte of an sRGB color, the bits of
/// the linear light that it stands for.
pub const DECODE_WORDS: usize = 256;

/// Linear RGB of the texture at `uv`, and alpha: bilinear in the two levels that fit the
/// footprint, then a linear mix of the two. White without a texture.
///
/// Sums run in the order in which they are written: rows within a level, levels last. The
/// size of the texture does not change what this costs.
#[inline(always)]
pub fn sample(texels: &[u32], texture: &Texture, uv: [f32; 2], footprint: f32) -> [f32; 4] {
    if texture.levels == 0 {
        return [1.0; 4];
    }
    let Levels { fine, coarse, share } = levels(footprint, texture.log_size, texture.levels);
    let sharp = bilinear(texels, texture, uv, fine);
    if coarse == fine {
        return sharp;
    }
    lerp(sharp, bilinear(texels, texture, uv, coarse), share)
}

/// Where a level starts in the texels, and its size.
#[inline(always)]
fn level(texture: &Texture, level: u32) -> (u32, [u32; 2]) {
    let mut first = texture.first;
    let mut size = [texture.width, texture.height];
    let mut i = 0;
    while i < level {
        first += size[0] * size[1];
        size = [half(size[0]), half(size[1])];
        i += 1;
    }
    (first, size)
}

/// The size of the next level.
#[inline(always)]
pub fn half(size: u32) -> u32 {
    if size > 1 { size / 2 } else { 1 }
}

/// The four texels around `uv` in one level, weighted by how near their centers are.
#[inline(always)]
fn bilinear(texels: &[u32], texture: &Texture, uv: [f32; 2], number: u32) -> [f32; 4] {
    let (first, size) = level(texture, number);
    let (x0, x1, fx) = neighbors(uv[0], size[0], texture.wrap_u);
    let (y0, y1, fy) = neighbors(uv[1], size[1], texture.wrap_v);
    let at = |x: u32, y: u32| decode(texels, texels[(first + y * size[0] + x) as usize]);
    lerp(lerp(at(x0, y0), at(x1, y0), fx), lerp(at(x0, y1), at(x1, y1), fx), fy)
}

/// The two columns (or rows) around a coordinate, and the share of the second.
#[inline(always)]
fn neighbors(coordinate: f32, size: u32, wrap: u32) -> (u32, u32, f32) {
    // Beyond 2²⁰ a coordinate has no fraction worth having; NaN becomes 0.
    let c = if Lane::abs(coordinate) < 1_048_576.0 { coordinate } else { 0.0 };
    // Folding into one period first keeps the texel number small.
    let c = if wrap == Wrap::Repeat as u32 {
        c - floor(c)
    } else if wrap == Wrap::Mirror as u32 {
        let pair = c * 0.5;
        let c = (pair - floor(pair)) * 2.0;
        if c > 1.0 { 2.0 - c } else { c }
    } else {
        clamp(c, 0.0, 1.0)
    };
    let position = c * size as f32 - 0.5;
    let before = floor(position);
    let x = to_integer(before).0;
    let share = position - before;
    let last = size - 1;
    // -1 and `size` are the neighbors across the edge.
    if x == u32::MAX {
        (if wrap == Wrap::Repeat as u32 { last } else { 0 }, 0, share)
    } else if x >= last {
        (last, if wrap == Wrap::Repeat as u32 { 0 } else { last }, share)
    } else {
        (x, x + 1, share)
    }
}

/// Linear RGB and alpha of a texel: sRGB, 8 bits each, red lowest.
#[inline(always)]
fn decode(texels: &[u32], texel: u32) -> [f32; 4] {
    let linear = |shift: u32| f32::from_bits(texels[(texel >> shift & 255) as usize]);
    [linear(0), linear(8), linear(16), (texel >> 24) as f32 * BYTE]
}

/// 1/255.
pub const BYTE: f32 = 1.0 / 255.0;

/// `a + (b − a) · share`, component by component.
#[inline(always)]
fn lerp(a: [f32; 4], b: [f32; 4], share: f32) -> [f32; 4] {
    [
        a[0] + (b[0] - a[0]) * share,
        a[1] + (b[1] - a[1]) * share,
        a[2] + (b[2] - a[2]) * share,
        a[3] + (b[3] - a[3]) * share,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbors_wrap_as_asked() {
        let at = |c, wrap: Wrap| {
            let (a, b, _) = neighbors(c, 4, wrap as u32);
            [a, b]
        };
        assert_eq!(at(0.5, Wrap::Repeat), [1, 2]);
        assert_eq!(at(0.0, Wrap::Repeat), [3, 0]);
        assert_eq!(at(-0.4, Wrap::Repeat), [1, 2]);
        assert_eq!(at(0.999, Wrap::Repeat), [3, 0]);
        assert_eq!(at(0.0, Wrap::Clamp), [0, 0]);
        assert_eq!(at(7.0, Wrap::Clamp), [3, 3]);
        assert_eq!(at(1.4, Wrap::Mirror), [1, 2]);
        assert_eq!(at(-0.05, Wrap::Mirror), [0, 0]);
        assert_eq!(at(f32::NAN, Wrap::Repeat), [3, 0]);
        assert_eq!(neighbors(0.3, 1, Wrap::Repeat as u32).0, 0);
    }
}
