//! Which two levels of a texture's mip chain to use, and how much of each.

use crate::lane::{Lane, Select};
use crate::num::{FLOOR, floor, log2, sqrt};

/// Side of a ray's footprint in texture coordinates: the footprint's side in the world,
/// which grows with distance, times the density of texture coordinates on the triangle.
///
/// ```text
/// footprint · √(area in texture coordinates / area in the world)
/// ```
///
/// The paper chooses levels by the intersection distance alone; this is that distance,
/// in the triangle's own units. Both areas are given doubled; 0 where the triangle has
/// no area in the world.
#[inline(always)]
pub fn footprint<L: Lane>(world_footprint: L, uv_area: L, world_area: L) -> L {
    let density = sqrt(uv_area.abs() * crate::num::recip(world_area));
    world_area.gt(world_area.broadcast(FLOOR)).select(world_footprint * density, world_area.broadcast(0.0))
}

/// Two neighboring levels and the share of the coarser one; the finer has the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels<L> {
    /// The finer level, 0 for the full size.
    pub fine: L,
    /// The coarser level: the next one, or the same at the end of the chain.
    pub coarse: L,
    /// Share of the coarser level, 0 ..= 1.
    pub share: L,
}

/// The levels whose texels are nearest in size to the footprint: `log₂(footprint · size)`
/// lies between them and divides them (the paper's weights, which sum to 1).
///
/// `log_size` is log₂ of the texture's size, `count` the number of levels, at least 1; it
/// and the levels are whole numbers. A footprint of 0 or NaN takes the finest level.
#[inline(always)]
pub fn levels<L: Lane>(footprint: L, log_size: L, count: L) -> Levels<L> {
    let zero = footprint.broadcast(0.0);
    let last = count - 1.0;
    let is_seen = footprint.gt(footprint.broadcast(FLOOR));
    let wanted = is_seen.select(log2(footprint) + log_size, zero).max(zero).min(last);
    let fine = floor(wanted);
    Levels { fine, coarse: (fine + 1.0).min(last), share: wanted - fine }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_footprint_of_one_texel_is_level_0_and_of_two_is_level_1() {
        let at = |texels: f32| levels(texels / 256.0, 8.0, 9.0);
        assert_eq!(at(1.0), Levels { fine: 0.0, coarse: 1.0, share: 0.0 });
        assert_eq!(at(2.0), Levels { fine: 1.0, coarse: 2.0, share: 0.0 });
        let between = at(2.9);
        assert_eq!((between.fine, between.coarse), (1.0, 2.0));
        assert!((between.share - 0.536).abs() < 1e-3);
    }

    #[test]
    fn ends_of_the_chain_hold() {
        assert_eq!(levels(0.0_f32, 8.0, 9.0).fine, 0.0);
        assert_eq!(levels(f32::NAN, 8.0, 9.0).fine, 0.0);
        assert_eq!(levels(1e9_f32, 8.0, 9.0), Levels { fine: 8.0, coarse: 8.0, share: 0.0 });
        assert_eq!(levels(0.5_f32, 0.0, 1.0), Levels { fine: 0.0, coarse: 0.0, share: 0.0 });
    }
}
