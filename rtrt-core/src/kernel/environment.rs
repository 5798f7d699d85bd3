//! Environment maps: light from every direction, sharp and blurred.
//!
//! The map is octahedral: a direction is divided by the sum of its coordinates' magnitudes, which puts it
//! on an octahedron. The upper half is seen from above; the corners of the lower half fold out to those
//! of a square (Engelhardt and Dachsbacher, "Octahedron Environment Maps", 2008). That takes a
//! reciprocal, comparisons and products, and no arc tangent. Unlike a cube, a square has no edges between
//! faces: a border of one texel repeats the texels across the fold.

use crate::kernel::texture::Maps;
use crate::lane::{Bits, Lane, Row, Select, V3};
use crate::layout::Sky;
use crate::num::{clamp, floor, flush, from_integer, recip, to_integer};

/// Side of the square that holds the light on a surface from its whole hemisphere.
pub const IRRADIANCE_SIDE: u32 = 16;

/// The direction in which the environment is looked up.
#[inline(always)]
fn turned<L: Lane>(sky: Sky, direction: V3<L>) -> V3<L> {
    let [cosine, sine] = sky.turn;
    if cosine == 1.0 {
        return direction;
    }
    let V3 { x, y, z } = direction;
    // A sign decides where below the horizon is, so it is not that of what some devices do not keep.
    let [ahead, aside] = [flush(z * cosine), flush(z * sine)];
    V3 { x: flush(flush(x * cosine) + aside), y, z: flush(ahead - flush(x * sine)) }
}

/// The place of a direction of any length in a square, `0 ..= 1` each. `y` is up; from above,
/// columns run along `x` and rows along `z`.
#[inline(always)]
pub fn octahedral<L: Lane>(direction: V3<L>) -> [L; 2] {
    let size = direction.x.abs() + direction.y.abs() + direction.z.abs();
    let (zero, one) = (size.broadcast(0.0), size.broadcast(1.0));
    let shrink = recip(size);
    let (x, z) = (direction.x * shrink, direction.z * shrink);
    let below = direction.y.lt(zero);
    let folded = |a: L, b: L| {
        let over = one - b.abs();
        below.select(a.lt(zero).select(-over, over), a)
    };
    [folded(x, z) * 0.5 + 0.5, folded(z, x) * 0.5 + 0.5]
}

/// The side of the squares of rough surfaces is at least this: a square for mirrors is half as large as the one
/// before, down to it.
pub const LEAST_SIDE: u32 = 32;

/// The light that a surface of this roughness (0 ..= 1) mirrors from a direction of any
/// length, linear RGB: bilinear in the two squares between whose roughness it lies, then a
/// linear mix of the two. The lobe of the last square has the width α = 1, that of each one before half of the
/// next one's; the first is sharp.
#[inline(always)]
pub fn mirrored<L: Lane>(maps: &Maps<'_>, sky: Sky, direction: V3<L>, roughness: L) -> V3<L> {
    let last = (sky.levels - 1) as f32;
    let level = level(roughness, last);
    let fine = floor(level);
    let coarse = (fine + 1.0).min(fine.broadcast(last));
    let place = octahedral(turned(sky, direction));
    let sites = (Site::new(sky, place, fine), Site::new(sky, place, coarse), (level - fine).row());
    V3::from_fn(
        direction.x.token(),
        #[inline(always)]
        |lane| {
            let (fine, coarse, share) = &sites;
            let (a, b, share) = (fine.fetch(maps, lane), coarse.fetch(maps, lane), share.at(lane));
            [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share, a[2] + (b[2] - a[2]) * share]
        },
    )
    .scale(direction.x.broadcast(sky.intensity))
}

/// The square of a surface of this roughness, whole numbers for squares, `0 ..= last`.
///
/// ```text
/// last + log₂ α,   α = roughness²
/// ```
///
/// with a line between powers of two in place of the logarithm: a number's bits, read as an integer, are that.
#[inline(always)]
fn level<L: Lane>(roughness: L, last: f32) -> L {
    /// One bit of the mantissa's upper 15.
    const STEP: f32 = 1.0 / 32_768.0;
    let roughness = clamp(roughness, 0.0, 1.0);
    let alpha = (roughness * roughness).to_bits();
    // Without the last 8 bits, for which there is no room in a number.
    let log = from_integer::<L>((alpha >> 8) - alpha.broadcast(127 << 15)) * STEP;
    clamp(log + last, 0.0, last)
}

/// The light on a surface with this normal from its whole hemisphere, by Lambert's cosine, as
/// a share of what it would be if light came from everywhere: linear RGB.
#[inline(always)]
pub fn arriving<L: Lane>(maps: &Maps<'_>, sky: Sky, normal: V3<L>) -> V3<L> {
    let site = Site::of_side(
        octahedral(turned(sky, normal)),
        normal.x.broadcast(IRRADIANCE_SIDE as f32),
        sky.first + sky.levels,
    );
    V3::from_fn(
        normal.x.token(),
        #[inline(always)]
        |lane| site.fetch(maps, lane),
    )
    .scale(normal.x.broadcast(sky.intensity))
}

/// The four texels around a place in a square.
struct Site<L: Lane> {
    /// The word that says where the square starts.
    table: <L::Bits as Bits>::Row,
    /// Texels in a row, the border included.
    width: <L::Bits as Bits>::Row,
    column: <L::Bits as Bits>::Row,
    row: <L::Bits as Bits>::Row,
    share_x: L::Row,
    share_y: L::Row,
}

impl<L: Lane> Site<L> {
    /// In the square of this level.
    #[inline(always)]
    fn new(sky: Sky, place: [L; 2], level: L) -> Self {
        let halvings = to_integer(level);
        let shrunk = L::from_bits(halvings.broadcast(127 << 23) - (halvings << 23));
        let side = (shrunk * sky.side as f32).max(shrunk.broadcast(LEAST_SIDE as f32));
        let mut site = Self::of_side(place, side, 0);
        site.table = (halvings + halvings.broadcast(sky.first)).row();
        site
    }

    /// In a square of this side.
    #[inline(always)]
    fn of_side(place: [L; 2], side: L, table: u32) -> Self {
        // The border moves everything by one texel.
        let at = |p: L| {
            let position = p * side + 0.5;
            let before = floor(position).max(side.broadcast(0.0)).min(side);
            (to_integer(before), position - before)
        };
        let ((column, share_x), (row, share_y)) = (at(place[0]), at(place[1]));
        Self {
            table: column.broadcast(table).row(),
            width: to_integer(side + 2.0).row(),
            column: column.row(),
            row: row.row(),
            share_x: share_x.row(),
            share_y: share_y.row(),
        }
    }

    /// The mixed texels in one lane.
    #[inline(always)]
    fn fetch(&self, maps: &Maps<'_>, lane: usize) -> [f32; 3] {
        let texels = maps.texels;
        let width = self.width.at(lane);
        let first = texels[self.table.at(lane) as usize] + self.row.at(lane) * width + self.column.at(lane);
        let x = self.share_x.at(lane);
        let a = lerp(decode(texels[first as usize]), decode(texels[(first + 1) as usize]), x);
        let below = first + width;
        let b = lerp(decode(texels[below as usize]), decode(texels[(below + 1) as usize]), x);
        lerp(a, b, self.share_y.at(lane))
    }
}

/// Linear RGB of a texel: three mantissas of 9 bits, red lowest, and their common exponent
/// (the format RGB9E5).
#[inline(always)]
pub fn decode(texel: u32) -> [f32; 3] {
    let scale = f32::from_bits(((texel >> 27) + 127 - 24) << 23);
    let (r, g, b) = (texel & 511, texel >> 9 & 511, texel >> 18 & 511);
    [r as f32 * scale, g as f32 * scale, b as f32 * scale]
}

#[inline(always)]
fn lerp(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share, a[2] + (b[2] - a[2]) * share]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_their_places() {
        let at = |v| octahedral(V3::<f32>::splat((), v));
        let near = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-6;
        assert!(near(at([0.0, 2.0, 0.0]), [0.5, 0.5]));
        assert!(near(at([3.0, 0.0, 0.0]), [1.0, 0.5]) && near(at([0.0, 0.0, -1.0]), [0.5, 0.0]));
        // Straight down is all four corners.
        assert!(near(at([1e-9, -1.0, 1e-9]), [1.0, 1.0]) && near(at([-1e-9, -1.0, 1e-9]), [0.0, 1.0]));
        assert!(at([0.0; 3]).iter().all(|c| (0.0..=1.0).contains(c)));
    }

    #[test]
    fn a_quarter_of_a_turn_looks_up_x_where_z_is() {
        let sky = Sky { turn: [0.0, 1.0], ..Sky::default() };
        let V3 { x, y, z } = turned(sky, V3::<f32>::splat((), [0.25, 0.5, 1.0]));
        assert_eq!([x, y, z], [1.0, 0.5, -0.25]);
        let V3 { x, y, z } = turned(Sky::default(), V3::<f32>::splat((), [0.25, 0.5, 1.0]));
        assert_eq!([x, y, z], [0.25, 0.5, 1.0]);
    }

    #[test]
    fn widths_of_lobes_double_from_square_to_square() {
        let at = |alpha: f32| level(crate::num::sqrt(alpha), 6.0);
        for (alpha, expected) in [(1.0, 6.0), (0.5, 5.0), (0.25, 4.0), (0.375, 4.5), (1.0 / 64.0, 0.0)] {
            assert!((at(alpha) - expected).abs() < 1e-4, "{alpha} {}", at(alpha));
        }
        assert_eq!([level(0.0_f32, 6.0), level(1e-30, 6.0), level(7.0, 6.0)], [0.0, 0.0, 6.0]);
        assert!((0.0..=6.0).contains(&level(f32::NAN, 6.0)));
    }
}
