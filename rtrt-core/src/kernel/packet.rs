//! A packet: groups of rays that traverse together, and their hits.

use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::ray::Ray;
use crate::kernel::slab::{RelativeBox, intersects};
use crate::kernel::tiles::{TILES, Tiles};
use crate::kernel::triangle::passing;
use crate::lane::{Lane, Mask};
use crate::layout::Instance;
use core::ops::Mul;

/// Up to so many active tiles test a box ray by ray: that is as quick as the tiles' bounds, and exact.
/// One more where rays have origins of their own: the bounds of their tiles then take longer to test,
/// and cull less.
const RAY_TEST_MAX_TILES: [u32; 2] = [5, 6];

/// The rays of a packet in one space, and the bounds of its tiles there.
///
/// A packet of one group, as a GPU invocation has it, is one tile. Sets of tiles are words: bit `i` stands
/// for tile `i`.
#[derive(Clone, Copy)]
pub struct Packet<'a, L: Lane, O: Lane, const G: usize> {
    /// Group after group.
    pub rays: &'a [Ray<L, O>; G],
    /// Bounds on them; those of a packet of one group are never read.
    pub tiles: &'a Tiles<L, G>,
}

/// What the rays of a packet have found so far.
#[derive(Clone, Copy)]
pub struct PacketHits<L: Lane, const G: usize> {
    /// The closest hit of each group; its `t` is the limit up to which a ray is still traced.
    pub closest: [ClosestHit<L>; G],
    /// The largest limit of each tile; unused by a packet of one group.
    limits: [f32; TILES],
    /// Set where a ray meets a triangle, whether the filter accepts it or not.
    pub(crate) has_met: bool,
}

impl<L: Lane, const G: usize> PacketHits<L, G> {
    /// Rays that are traced up to the `t` of `closest`.
    #[inline(always)]
    pub fn new(closest: [ClosestHit<L>; G]) -> Self {
        let limits = if G == 1 { [0.0; TILES] } else { Tiles::<L, G>::limits(&closest) };
        Self { closest, limits, has_met: false }
    }

    /// The tiles with a ray that is still traced. Of a packet of one group, its tile.
    #[inline(always)]
    pub fn active(&self) -> u32 {
        if G == 1 { 1 } else { Tiles::<L, G>::active(self.closest[0].t.token(), &self.limits) }
    }

    /// The largest limit of all rays; negative when none is traced any more.
    #[inline(always)]
    pub fn limit(&self) -> f32 {
        if G == 1 {
            self.closest[0].t.largest()
        } else {
            Tiles::<L, G>::widest(self.closest[0].t.token(), &self.limits)
        }
    }

    /// Finds the limits of these tiles anew, after those of their rays have changed.
    #[inline(always)]
    pub(crate) fn update_limits(&mut self, changed: u32) {
        let mut remaining = changed;
        while G > 1 && remaining != 0 {
            let tile = remaining.trailing_zeros() as usize;
            remaining &= remaining - 1;
            self.limits[tile] = Tiles::<L, G>::limit(&self.closest, tile);
        }
    }
}

impl<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize> Packet<'_, L, O, G> {
    /// No less than the largest coordinate, in magnitude, of a corner of the box relative to the origin of a ray
    /// in the active tiles.
    #[inline(always)]
    fn reach(&self, low: &[f32; 3], high: &[f32; 3], active: u32) -> f32 {
        if G == 1 || O::WIDTH < L::WIDTH {
            RelativeBox::new(self.first_active(active).origin, low, high).reach().largest()
        } else {
            self.tiles.reach(low, high)
        }
    }

    /// How much wider the boxes within this one have to be for the packet (see
    /// [`passing`](crate::kernel::triangle::passing)).
    #[inline(always)]
    pub(crate) fn passing(&self, low: &[f32; 3], high: &[f32; 3], active: u32) -> f32 {
        passing(self.reach(low, high, active), low, high)
    }

    /// The tiles of `active` that may hit a box before their limits: all that do, and few more.
    #[inline(always)]
    pub(crate) fn hit_mask(
        &self,
        low: &[f32; 3],
        high: &[f32; 3],
        active: u32,
        hits: &PacketHits<L, G>,
    ) -> u32 {
        let few = RAY_TEST_MAX_TILES[(O::WIDTH == L::WIDTH) as usize];
        if G == 1 || active.count_ones() <= few {
            ray_hit_mask(self.rays, low, high, active, &hits.closest)
        } else {
            self.tile_hit_mask(low, high, active, hits)
        }
    }

    /// [`Packet::hit_mask`] by the bounds of tiles, however few are active.
    #[inline(always)]
    pub(crate) fn tile_hit_mask(
        &self,
        low: &[f32; 3],
        high: &[f32; 3],
        active: u32,
        hits: &PacketHits<L, G>,
    ) -> u32 {
        if G == 1 {
            ray_hit_mask(self.rays, low, high, active, &hits.closest)
        } else {
            self.tiles.hit_mask::<O>(low, high, &hits.limits, active)
        }
    }

    /// Writes the rays of these tiles, in the space of an instance, into `local_rays`.
    #[inline(always)]
    pub(crate) fn place(&self, instance: &Instance, tiles: u32, local_rays: &mut [Ray<L, O>; G]) {
        let mut remaining = tiles;
        while remaining != 0 {
            let tile = first_tile::<G>(remaining);
            remaining &= remaining - 1;
            let (mut g, end) = groups_of_tile::<L, G>(tile);
            while g < end {
                let ray = &self.rays[g];
                local_rays[g] = if instance.is_identity == 1 { *ray } else { ray.to_object(instance) };
                g += 1;
            }
        }
    }

    /// The first ray of the first tile in `active`.
    #[inline(always)]
    pub(crate) fn first_active(&self, active: u32) -> &Ray<L, O> {
        &self.rays[first_active_group::<L, G>(active)]
    }
}

/// The groups of a tile: the first, and the one after the last.
#[inline(always)]
pub(crate) fn groups_of_tile<L: Lane, const G: usize>(tile: usize) -> (usize, usize) {
    if G == 1 { (0, 1) } else { Tiles::<L, G>::groups(tile) }
}

/// The tile of a group.
#[inline(always)]
pub(crate) fn tile_of_group<L: Lane, const G: usize>(group: usize) -> usize {
    group / groups_of_tile::<L, G>(0).1
}

/// The first tile of a set that is not empty. A packet of one group has only one.
#[inline(always)]
pub(crate) fn first_tile<const G: usize>(tiles: u32) -> usize {
    if G == 1 { 0 } else { tiles.trailing_zeros() as usize }
}

/// The first group of the first tile in `active`.
#[inline(always)]
fn first_active_group<L: Lane, const G: usize>(active: u32) -> usize {
    groups_of_tile::<L, G>(first_tile::<G>(active)).0
}

/// The tiles of `active` in which a ray hits the box.
#[inline(always)]
pub fn ray_hit_mask<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize>(
    rays: &[Ray<L, O>; G],
    low: &[f32; 3],
    high: &[f32; 3],
    active: u32,
    closest: &[ClosestHit<L>; G],
) -> u32 {
    let shared = RelativeBox::new(rays[first_active_group::<L, G>(active)].origin, low, high);
    if G == 1 {
        return intersects(&rays[0], &shared, closest[0].t).any() as u32;
    }
    let mut hit_mask = 0;
    let mut remaining = active;
    while remaining != 0 {
        let tile = remaining.trailing_zeros();
        remaining &= remaining - 1;
        let (mut g, end) = Tiles::<L, G>::groups(tile as usize);
        while g < end {
            let ray = &rays[g];
            let relative = if O::WIDTH < L::WIDTH { shared } else { RelativeBox::new(ray.origin, low, high) };
            hit_mask |= (intersects(ray, &relative, closest[g].t).any() as u32) << tile;
            g += 1;
        }
    }
    hit_mask
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::V3;
    use crate::lane::plain::Plain;

    type Lanes = Plain<8>;

    #[test]
    fn groups_are_in_tiles_of_16_rays() {
        assert_eq!(groups_of_tile::<Lanes, 32>(3), (6, 8));
        assert_eq!(groups_of_tile::<Plain<16>, 16>(3), (3, 4));
        // A packet of one group is one tile.
        assert_eq!(
            (groups_of_tile::<f32, 1>(0), first_tile::<1>(1), first_tile::<32>(0b1100)),
            ((0, 1), 0, 2)
        );
    }

    #[test]
    fn limits_are_those_of_the_farthest_ray_of_a_tile() {
        let mut closest = [ClosestHit::none(Plain([-1.0; 8])); 32];
        closest[6].t.0[2] = 3.0;
        closest[7].t.0[7] = 5.0;
        closest[20].t.0[0] = 4.0;
        let mut hits = PacketHits::<Lanes, 32>::new(closest);
        assert_eq!((hits.active(), hits.limit()), (1 << 3 | 1 << 10, 5.0));
        hits.closest[7].t.0[7] = 1.0;
        hits.update_limits(1 << 3);
        assert_eq!((hits.active(), hits.limit()), (1 << 3 | 1 << 10, 4.0));
        hits.closest[20].t.0[0] = -1.0;
        hits.update_limits(1 << 10);
        assert_eq!((hits.active(), hits.limit()), (1 << 3, 3.0));
    }

    #[test]
    fn the_tiles_that_hit_a_box_are_found_with_few_and_with_many() {
        // Tile i looks along +z from x = i.
        let rays: [Ray<Lanes>; 32] = core::array::from_fn(|g| {
            let x = (g / 2) as f32;
            Ray::new(V3::splat((), [x, 0.0, 0.0]), V3::splat((), [0.0, 0.0, 1.0]))
        });
        let hits = PacketHits::new([ClosestHit::none(Plain([9.0; 8])); 32]);
        let tiles = Tiles::of(&rays, &hits.closest, 0xffff);
        let packet = Packet { rays: &rays, tiles: &tiles };
        let mask = |z: f32, active| packet.hit_mask(&[2.5, -1.0, z], &[6.5, 1.0, z + 1.0], active, &hits);
        assert_eq!([mask(3.0, 0xffff), mask(3.0, 0b1_1001)], [0b111_1000, 0b1_1000]);
        assert_eq!([mask(9.5, 0xffff), mask(-3.0, 0xffff)], [0; 2]);
    }
}
