//! The color of a texture at a point.

use crate::kernel::mip::{Levels, levels};
use crate::lane::{Bits, Lane, Mask, Row, Select, Word, groups};
use crate::layout::{Filter, FinestLevel, MaterialRecord, Wrap};
use crate::num::{clamp, floor, from_integer, srgb_byte_decode, to_integer};

/// 1/255.
const BYTE: f32 = 1.0 / 255.0;

/// The materials of a scene, and the texels that they are read from.
#[derive(Clone, Copy)]
pub struct Maps<'a> {
    /// The materials.
    pub materials: &'a [MaterialRecord],
    /// One word, so that nothing begins at 0, then textures.
    pub texels: &'a [u32],
}

/// The materials of a group of surfaces. (Apart from [`Maps`]: rust-gpu takes slices out of
/// a structure only where nothing in it is indexed.)
#[derive(Clone, Copy)]
pub struct MaterialLookup<L: Lane> {
    /// The material in each lane; another lane's where a lane has no hit.
    indices: <L::Bits as Bits>::Row,
    /// Whether that is the same one in all lanes.
    same: bool,
}

impl<L: Lane> MaterialLookup<L> {
    /// The materials numbered `material`, from 1 on; there must be one.
    #[inline(always)]
    pub fn new(material: L::Bits) -> Self {
        let none = material.broadcast(0);
        let found = material.gt(none);
        let any = if found.any() { found.bits().trailing_zeros() as usize } else { 0 };
        let material = found.select(material, none.broadcast(material.row().at(any)));
        let indices = material.gt(none).select(material - none.broadcast(1), none);
        let row = indices.row();
        Self { indices: row, same: !(!indices.eq(none.broadcast(row.at(0)))).any() }
    }

    /// Numbers of each lane's material.
    #[inline(always)]
    pub fn numbers<P: MaterialField<N>, const N: usize>(&self, token: L::Token, maps: &Maps<'_>) -> [L; N] {
        if L::WIDTH > 1 && self.same {
            let numbers = P::pick(&maps.materials[self.indices.at(0) as usize]);
            return groups(
                #[inline(always)]
                |i| L::splat(token, numbers[i]),
            );
        }
        L::gather(
            token,
            #[inline(always)]
            |lane| P::pick(&maps.materials[self.indices.at(lane) as usize]),
        )
    }

    /// Where the numbers of the levels of each lane's texture `MAP` begin in the texels.
    #[inline(always)]
    fn first<const MAP: usize>(&self, token: L::Token, maps: &Maps<'_>) -> L::Bits {
        if L::WIDTH > 1 && self.same {
            let first = maps.materials[self.indices.at(0) as usize].textures[MAP].first;
            return L::splat(token, 0.0).broadcast_bits(first);
        }
        L::bits_from_fn(
            token,
            #[inline(always)]
            |lane| maps.materials[self.indices.at(lane) as usize].textures[MAP].first,
        )
    }
}

/// Picks numbers of a material. (A trait, since rust-gpu does not compile a closure that captures another.)
pub trait MaterialField<const N: usize> {
    /// The numbers.
    fn pick(material: &MaterialRecord) -> [f32; N];
}

/// How the texture `MAP` is laid out.
struct Layout<const MAP: usize>;

impl<const MAP: usize> MaterialField<14> for Layout<MAP> {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 14] {
        let map = &material.textures[MAP];
        [
            map.levels as f32,
            map.width as f32,
            map.height as f32,
            map.log_size,
            map.wrap_u as f32,
            map.wrap_v as f32,
            map.set as f32,
            map.filter as f32,
            map.turn[0][0],
            map.turn[0][1],
            map.turn[1][0],
            map.turn[1][1],
            map.shift[0],
            map.shift[1],
        ]
    }
}

/// Texture coordinates of a group of surfaces, and the side of the ray's footprint in them, for each set.
#[derive(Clone, Copy)]
pub struct TexCoords<L> {
    /// `u` and `v` in each set.
    pub uv: [[L; 2]; 2],
    /// In each set.
    pub footprint: [L; 2],
}

/// Linear RGB of the texture `MAP` of each lane's material, and alpha: bilinear in the two
/// levels that fit the footprint, then a linear mix of the two. White without a texture.
/// With `COLOR`, texels are sRGB; else they are numbers within 0 ..= 1.
///
/// Sums run in the order in which they are written: rows within a level, levels last. The
/// cost does not depend on the size of the texture. Places are computed for all lanes at once, texels are
/// read lane by lane.
#[inline(always)]
pub fn sample<L: Lane, const MAP: usize, const COLOR: bool>(
    maps: &Maps<'_>,
    chosen: &MaterialLookup<L>,
    tex_coords: &TexCoords<L>,
) -> [L; 4] {
    let token = tex_coords.footprint[0].token();
    let [count, width, height, log_size, wrap_u, wrap_v, set, filter, a, b, c, d, e, f] =
        chosen.numbers::<Layout<MAP>, 14>(token, maps);
    let (zero, one) = (count.broadcast(0.0), count.broadcast(1.0));
    if !count.gt(zero).any() {
        return [one; 4];
    }
    let second = set.gt(zero);
    let [u, v] = [
        second.select(tex_coords.uv[1][0], tex_coords.uv[0][0]),
        second.select(tex_coords.uv[1][1], tex_coords.uv[0][1]),
    ];
    let footprint = second.select(tex_coords.footprint[1], tex_coords.footprint[0]);
    let uv = [u * a + v * b + e, u * c + v * d + f];
    let Levels { fine, coarse, share } = levels(footprint, log_size, count.max(one));
    let nearest = if filter.gt(zero).any() {
        let is_minified = fine.gt(zero) | share.gt(zero);
        is_nearest(filter, is_minified)
    } else {
        zero.gt(zero)
    };
    let has = count.gt(zero);
    let first = chosen.first::<MAP>(token, maps);
    let first = has.select(first, first.broadcast(0));
    let (texels, size, wrap) = (maps.texels, [width, height], [wrap_u, wrap_v]);
    let sharp = Site::new(texels, first, uv, size, wrap, fine, nearest).color::<COLOR>(texels);
    // Without a share the coarser level would change nothing.
    let mixed = if share.gt(zero).any() {
        lerp(sharp, Site::new(texels, first, uv, size, wrap, coarse, nearest).color::<COLOR>(texels), share)
    } else {
        sharp
    };
    groups(
        #[inline(always)]
        |i| has.select(mixed[i], one),
    )
}

/// Where a [`Filter`] shows the nearest texel.
#[inline(always)]
fn is_nearest<L: Lane>(filter: L, is_minified: L::Mask) -> L::Mask {
    let (both, minified) = (Filter::Nearest as u32 as f32, Filter::NearestMinified as u32 as f32);
    let magnified = filter.gt(filter.broadcast(0.0)) & filter.lt(filter.broadcast(minified));
    (is_minified & filter.ge(filter.broadcast(both))) | (!is_minified & magnified)
}

/// Linear RGB and alpha of a texture of colors at one point, by the filter of magnified textures, in its finest level.
#[inline(always)]
pub fn finest(texels: &[u32], map: &FinestLevel, uv: [f32; 2]) -> [f32; 4] {
    let nearest = is_nearest(map.filter as f32, false);
    // Columns after rows: before them, compilers use a form of `vmovq` that valgrind 3.19 does not know.
    let (y, share_y) = chosen(neighbors(uv[1], map.height as f32, map.wrap_v as f32), nearest);
    let first = texels[map.first as usize];
    let (row, next_row) = (first + y[0].0 * map.width, first + y[1].0 * map.width);
    let (x, share_x) = chosen(neighbors(uv[0], map.width as f32, map.wrap_u as f32), nearest);
    let at = |row: u32, x: Word| decode::<f32, true>(Word(texels[(row + x.0) as usize]));
    let upper = lerp(at(row, x[0]), at(row, x[1]), share_x);
    let lower = lerp(at(next_row, x[0]), at(next_row, x[1]), share_x);
    lerp(upper, lower, share_y)
}

/// The words at these places.
#[inline(always)]
fn read<L: Lane>(token: L::Token, texels: &[u32], places: L::Bits) -> L::Bits {
    let row = places.row();
    L::bits_from_fn(
        token,
        #[inline(always)]
        |lane| texels[row.at(lane) as usize],
    )
}

/// Where levels begin whose numbers are at these places: mostly the same in all lanes.
#[inline(always)]
fn first_of_level<L: Lane>(token: L::Token, texels: &[u32], places: L::Bits) -> L::Bits {
    let place = places.lane(0);
    if L::WIDTH > 1 && !(!places.eq(places.broadcast(place))).any() {
        return places.broadcast(texels[place as usize]);
    }
    read::<L>(token, texels, places)
}

/// The four texels around a point in one level, and how near their centers are.
struct Site<L: Lane> {
    /// Where they are, row by row.
    places: [L::Bits; 4],
    /// The share of the second column.
    share_x: L,
    /// The share of the second row.
    share_y: L,
}

impl<L: Lane> Site<L> {
    /// The texels around `uv` in a level of textures whose finest have this size; the nearest alone in the lanes of
    /// `nearest`. `first` is that of [`Texture`](crate::layout::Texture).
    #[inline(always)]
    fn new(
        texels: &[u32],
        first: L::Bits,
        uv: [L; 2],
        size: [L; 2],
        wrap: [L; 2],
        level: L,
        nearest: L::Mask,
    ) -> Self {
        let level = to_integer(level);
        let start = first_of_level::<L>(size[0].token(), texels, first + level);
        // 2 to the power of -level: sizes are below 2^15, so the product and its floor are exact.
        let shrunk = L::from_bits(level.broadcast(127 << 23) - (level << 23));
        let (width, height) = (floor(size[0] * shrunk), floor(size[1] * shrunk));
        let ([x, next_x], share_x) = chosen(neighbors(uv[0], width, wrap[0]), nearest);
        let ([y, next_y], share_y) = chosen(neighbors(uv[1], height, wrap[1]), nearest);
        let width = to_integer(width.max(shrunk.broadcast(1.0)));
        let (row, next_row) = (start + y * width, start + next_y * width);
        Self { places: [row + x, row + next_x, next_row + x, next_row + next_x], share_x, share_y }
    }

    /// The mixed texels.
    #[inline(always)]
    fn color<const COLOR: bool>(&self, texels: &[u32]) -> [L; 4] {
        let token = self.share_x.token();
        let [a, b, c, d] = self.places;
        let upper = lerp(
            decode::<L, COLOR>(read::<L>(token, texels, a)),
            decode::<L, COLOR>(read::<L>(token, texels, b)),
            self.share_x,
        );
        let lower = lerp(
            decode::<L, COLOR>(read::<L>(token, texels, c)),
            decode::<L, COLOR>(read::<L>(token, texels, d)),
            self.share_x,
        );
        lerp(upper, lower, self.share_y)
    }
}

/// The size of the next level.
#[inline(always)]
pub fn half(size: u32) -> u32 {
    if size > 1 { size / 2 } else { 1 }
}

/// The two columns (or rows) around a coordinate, and the share of the second. The size is
/// a whole number; below 1 it counts as 1. `wrap` is a [`Wrap`].
#[inline(always)]
fn neighbors<L: Lane>(coordinate: L, size: L, wrap: L) -> ([L::Bits; 2], L) {
    let (zero, one) = (size.broadcast(0.0), size.broadcast(1.0));
    let repeats = wrap.le(size.broadcast(Wrap::Repeat as u32 as f32));
    let mirrors = wrap.ge(size.broadcast(Wrap::Mirror as u32 as f32));
    // Beyond 2^20 a coordinate has no fraction worth having; NaN becomes 0.
    let c = Lane::abs(coordinate).lt(size.broadcast(1_048_576.0)).select(coordinate, zero);
    // Folding into one period first keeps the texel number small.
    let half = c * 0.5;
    let pair = (half - floor(half)) * 2.0;
    let mirrored = pair.gt(one).select(pair.broadcast(2.0) - pair, pair);
    let c = repeats.select(c - floor(c), mirrors.select(mirrored, clamp(c, 0.0, 1.0)));
    let size = size.max(one);
    let position = c * size - 0.5;
    let before = floor(position);
    let share = position - before;
    let last = size - 1.0;
    // -1 and `size` are the neighbors across the edge.
    let outside = before.lt(zero);
    let at_end = before.ge(last);
    let x = outside.select(repeats.select(last, zero), before.min(last));
    let next = outside.select(zero, at_end.select(repeats.select(zero, last), before + 1.0));
    ([to_integer(x), to_integer(next)], share)
}

/// The [`neighbors`]; where only the nearest counts, it is both of them.
#[inline(always)]
fn chosen<L: Lane>((x, share): ([L::Bits; 2], L), nearest: L::Mask) -> ([L::Bits; 2], L) {
    if !nearest.any() {
        return (x, share);
    }
    let near = share.ge(share.broadcast(0.5)).select(x[1], x[0]);
    ([nearest.select(near, x[0]), nearest.select(near, x[1])], share)
}

/// Linear RGB and alpha of texels, 8 bits each, red lowest.
#[inline(always)]
fn decode<L: Lane, const COLOR: bool>(words: L::Bits) -> [L; 4] {
    let alpha = channel::<L>(words, 3);
    if COLOR {
        let [r, g, b] = [byte::<L>(words, 0), byte::<L>(words, 1), byte::<L>(words, 2)];
        return [srgb_byte_decode(r), srgb_byte_decode(g), srgb_byte_decode(b), alpha];
    }
    [channel::<L>(words, 0), channel::<L>(words, 1), channel::<L>(words, 2), alpha]
}

/// Byte `number` of a word, the lowest first.
#[inline(always)]
fn byte<L: Lane>(word: L::Bits, number: u32) -> L::Bits {
    (word >> (8 * number)) & word.broadcast(255)
}

/// Byte `number` of a color of 8 bits a channel, as 0 ..= 1.
#[inline(always)]
pub fn channel<L: Lane>(color: L::Bits, number: u32) -> L {
    from_integer::<L>(byte::<L>(color, number)) * BYTE
}

/// `a + (b − a) · share`, component by component.
#[inline(always)]
fn lerp<L: Lane>(a: [L; 4], b: [L; 4], share: L) -> [L; 4] {
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
    use crate::lane::plain::{Plain, PlainBits};
    use crate::scene::{Content, Image, Material, Scene};
    use std::vec;

    #[test]
    fn neighbors_wrap_as_asked() {
        let of = |c: f32, size: f32, wrap: Wrap| neighbors(c, size, wrap as u32 as f32).0.map(|x| x.0);
        let at = |c, wrap| of(c, 4.0, wrap);
        assert_eq!(at(0.5, Wrap::Repeat), [1, 2]);
        assert_eq!(at(0.0, Wrap::Repeat), [3, 0]);
        assert_eq!(at(-0.4, Wrap::Repeat), [1, 2]);
        assert_eq!(at(0.999, Wrap::Repeat), [3, 0]);
        assert_eq!(at(0.0, Wrap::Clamp), [0, 0]);
        assert_eq!(at(7.0, Wrap::Clamp), [3, 3]);
        assert_eq!(at(1.4, Wrap::Mirror), [1, 2]);
        assert_eq!(at(-0.05, Wrap::Mirror), [0, 0]);
        assert_eq!(at(f32::NAN, Wrap::Repeat), [3, 0]);
        assert_eq!(of(0.3, 1.0, Wrap::Repeat), [0, 0]);
        assert_eq!(of(0.3, 0.0, Wrap::Repeat), [0, 0]);
    }

    /// Floors of textures of several sizes, and a material without one.
    #[test]
    fn lanes_read_the_textures_of_their_own_materials() {
        let mut seed = 3_u32;
        let mut below = |most: usize| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as usize % most
        };
        let mut scene = Scene::new();
        let mut numbers = vec![0];
        for size in [[4, 4], [8, 2], [1, 1], [64, 64]] {
            let rgba = (0..size[0] * size[1] * 4).map(|_| below(256) as u8).collect();
            let image = Image { width: size[0], height: size[1], rgba };
            let map = scene.add_texture(&image, [Wrap::Repeat, Wrap::Mirror]).unwrap();
            let material = scene.add_material(Material::default().base_color_map(map)).unwrap();
            numbers.push(material.number() + 1);
        }
        numbers.push(scene.add_material(Material::default()).unwrap().number() + 1);
        let maps = scene.maps();
        for round in 0..400 {
            // From one material in all lanes to any in each.
            let same = numbers[1 + below(numbers.len() - 1)];
            let material: [u32; 8] =
                core::array::from_fn(
                    |_| {
                        if below(400) < round { numbers[below(numbers.len())] } else { same }
                    },
                );
            let mut one = || core::array::from_fn::<f32, 8, _>(|_| below(6001) as f32 / 1000.0 - 3.0);
            let (u, v, footprint) = (one(), one(), one().map(Lane::abs));
            let tex_coords = TexCoords { uv: [[Plain(u), Plain(v)]; 2], footprint: [Plain(footprint); 2] };
            let chosen = MaterialLookup::new(PlainBits(material));
            let colors = sample::<Plain<8>, { MaterialRecord::COLOR }, true>(&maps, &chosen, &tex_coords);
            for lane in (0..8).filter(|&lane| material[lane] > 0) {
                let tex_coords = TexCoords { uv: [[u[lane], v[lane]]; 2], footprint: [footprint[lane]; 2] };
                let chosen = MaterialLookup::new(Word(material[lane]));
                let alone = sample::<f32, { MaterialRecord::COLOR }, true>(&maps, &chosen, &tex_coords);
                assert_eq!(colors.map(|channel| channel.0[lane]), alone, "{material:?} {lane}");
            }
        }
    }

    /// Four texels of one channel: 0, 1 / 255, 2 / 255 and 3 / 255, row by row.
    #[test]
    fn rows_and_columns_are_mixed_by_their_shares() {
        let mut scene = Scene::new();
        let rgba = (0..4).flat_map(|texel| [texel, 0, 0, 255]).collect();
        let image = Image { width: 2, height: 2, rgba };
        let map = scene.add_map(&image, [Wrap::Clamp; 2], Content::Numbers).unwrap();
        let material = scene.add_material(Material::default().base_color_map(map)).unwrap();
        let red = |uv: [f32; 2]| {
            let tex_coords = TexCoords { uv: [uv; 2], footprint: [0.0; 2] };
            let chosen = MaterialLookup::new(Word(material.number() + 1));
            255.0 * sample::<f32, { MaterialRecord::COLOR }, false>(&scene.maps(), &chosen, &tex_coords)[0]
        };
        let near = |uv, value: f32| assert!((red(uv) - value).abs() < 1e-5, "{uv:?} {} {value}", red(uv));
        near([0.0, 0.0], 0.0);
        near([1.0, 0.0], 1.0);
        near([0.0, 1.0], 2.0);
        near([1.0, 1.0], 3.0);
        near([0.5, 0.25], 0.5);
        near([0.25, 0.5], 1.0);
        near([0.5, 0.5], 1.5);
        near([0.625, 0.375], 0.75 + 2.0 * 0.25);
    }

    #[test]
    fn a_filter_counts_where_texels_are_larger_or_smaller_than_pixels() {
        let is = |filter: Filter, is_minified| is_nearest(filter as u32 as f32, is_minified);
        let all = [Filter::Linear, Filter::NearestMagnified, Filter::Nearest, Filter::NearestMinified];
        assert_eq!(all.map(|filter| is(filter, false)), [false, true, true, false]);
        assert_eq!(all.map(|filter| is(filter, true)), [false, false, true, true]);
        let texel = |c: f32| chosen(neighbors(c, 4.0, Wrap::Repeat as u32 as f32), true).0.map(|x| x.0);
        for (c, near) in
            [(0.0, 0), (0.24, 0), (0.26, 1), (0.49, 1), (0.51, 2), (0.99, 3), (-0.01, 3), (1.01, 0)]
        {
            assert_eq!(texel(c), [near; 2], "{c}");
        }
    }

    /// The floor of a negative denormal is −1 or 0, as a device has it.
    #[test]
    fn a_denormal_coordinate_is_where_zero_is() {
        let of = |c: f32, wrap: u32| {
            let (texels, share) = neighbors(c, 4.0, wrap as f32);
            (texels.map(|x| x.0), share)
        };
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            for tiny in [1e-40, -1e-40] {
                assert_eq!(of(tiny, wrap as u32), of(0.0, wrap as u32), "{tiny:e} {wrap:?}");
            }
        }
    }
}
