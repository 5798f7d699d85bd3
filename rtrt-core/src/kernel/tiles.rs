//! The rays of a packet in tiles, each bounded by intervals: one test finds all tiles that may hit a
//! box.

use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::ray::Ray;
use crate::kernel::slab::{RelativeBox, STRETCH};
use crate::lane::{Lane, Mask, V3};

/// Rays in a tile: 16 neighbors in number, 4 × 4 of the grid.
pub const TILE: usize = 16;
/// The most tiles in a packet: those of a block.
pub const TILES: usize = 16;
/// The most vectors of tiles: two of eight lanes.
const VECTORS: usize = 2;

/// Bounds on the rays of a packet of `G` groups. Tile `i` is in lane `i % L::WIDTH` of vector
/// `i / L::WIDTH`.
///
/// Every bound is taken over the very numbers that [`crate::kernel::slab::slab`] uses, and
/// rounding is monotone, so [`Tiles::hit_mask`] is exact interval arithmetic: it never culls
/// a box that one of the rays would enter, without any epsilon (after Boulos, Wald and
/// Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets", 2006).
#[derive(Clone, Copy)]
pub struct Tiles<L, const G: usize> {
    origin: [Range<L>; VECTORS],
    inverse: [Range<L>; VECTORS],
    /// The rays' origin, if they have one in common.
    start: [f32; 3],
    /// The signs of the directions along each axis.
    signs: [Sign; 3],
}

/// The sign of the reciprocal directions along an axis.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Sign {
    Positive,
    Negative,
    Mixed,
}

impl Sign {
    /// That of numbers from `least` to `most`.
    #[inline(always)]
    pub fn of(least: f32, most: f32) -> Self {
        if least > 0.0 {
            Self::Positive
        } else if most < 0.0 {
            Self::Negative
        } else {
            Self::Mixed
        }
    }
}

/// The smallest and the largest of some vectors, component by component.
#[derive(Clone, Copy)]
struct Range<L> {
    low: V3<L>,
    high: V3<L>,
}

impl<L: Lane, const G: usize> Tiles<L, G> {
    /// Groups in a tile.
    const GROUPS: usize = if L::WIDTH < TILE { TILE / L::WIDTH } else { 1 };
    /// Vectors of tiles in the packet.
    const VECTORS: usize = G / TILE;

    /// The bounds of the rays whose limit is not negative, in the active tiles: at least one, each with such
    /// a ray. Zeros for a packet of one group, which reads none.
    #[inline(always)]
    pub fn of<O: Lane>(rays: &[Ray<L, O>; G], best: &[ClosestHit<L>; G], active: u32) -> Self {
        let like = best[0].t;
        if G == 1 {
            let zero = like.broadcast(0.0);
            let zero = V3 { x: zero, y: zero, z: zero };
            let nothing = [Range { low: zero, high: zero }; VECTORS];
            return Self { origin: nothing, inverse: nothing, start: [0.0; 3], signs: [Sign::Mixed; 3] };
        }
        let mut rows = [[0.0_f32; TILES]; 12];
        let (mut least, mut most) = ([f32::MAX; 3], [-f32::MAX; 3]);
        let mut remaining = active;
        while remaining != 0 {
            let tile = remaining.trailing_zeros() as usize;
            remaining &= remaining - 1;
            let first = tile * Self::GROUPS;
            let inverse = Range::of(
                best,
                first,
                Self::GROUPS,
                #[inline(always)]
                |g| rays[g].inverse,
            );
            store(&mut rows, 0, tile, inverse);
            let mut axis = 0;
            while axis < 3 {
                least[axis] = Lane::min(least[axis], inverse.0[axis]);
                most[axis] = Lane::max(most[axis], inverse.1[axis]);
                axis += 1;
            }
            let origin = if O::WIDTH < L::WIDTH {
                let start = rays[first].origin.lane(0);
                (start, start)
            } else {
                Range::of(
                    best,
                    first,
                    Self::GROUPS,
                    #[inline(always)]
                    |g| each(like, rays[g].origin),
                )
            };
            store(&mut rows, 6, tile, origin);
        }
        let last = if Self::VECTORS > 1 { 1 } else { 0 };
        let (token, rows) = (like.token(), &rows);
        let sign = |axis: usize| Sign::of(least[axis], most[axis]);
        Self {
            start: rays[active.trailing_zeros() as usize * Self::GROUPS].origin.lane(0),
            signs: [sign(0), sign(1), sign(2)],
            inverse: [Range::load(token, rows, 0, 0), Range::load(token, rows, 0, last)],
            origin: [Range::load(token, rows, 6, 0), Range::load(token, rows, 6, last)],
        }
    }

    /// No less than the largest coordinate, in magnitude, of a corner of the box relative to the origin of a ray.
    #[inline(always)]
    pub(crate) fn reach(&self, low: &[f32; 3], high: &[f32; 3]) -> f32 {
        let token = self.origin[0].low.x.token();
        let (low, high) = (V3::<L>::splat(token, *low), V3::splat(token, *high));
        let mut reach = -1.0;
        let mut v = 0;
        while v < Self::VECTORS {
            let Range { low: least, high: most } = &self.origin[v];
            let corners = RelativeBox { low: low - *most, high: high - *least };
            reach = Lane::max(reach, corners.reach().largest());
            v += 1;
        }
        reach
    }

    /// The tiles of `active` in which a ray may hit the box at some `0 ≤ t ≤` the tile's
    /// limit: every tile in which one does, and few more. `O` is the type of the rays' origin. NaN misses.
    #[inline(always)]
    pub fn hit_mask<O: Lane>(
        &self,
        low: &[f32; 3],
        high: &[f32; 3],
        limits: &[f32; TILES],
        active: u32,
    ) -> u32 {
        let token = self.origin[0].low.x.token();
        let mut hit_mask = 0;
        let mut v = 0;
        while v < Self::VECTORS {
            let shift = (v * L::WIDTH) as u32;
            if Self::VECTORS == 1 || active >> shift & ((1 << L::WIDTH) - 1) != 0 {
                let (origin, inverse) = (&self.origin[v], &self.inverse[v]);
                let (i, j) = (&inverse.low, &inverse.high);
                let ((x0, x1), (y0, y1), (z0, z1)) = if O::WIDTH < L::WIDTH {
                    let start = &self.start;
                    let to = |axis: usize| [low[axis] - start[axis], high[axis] - start[axis]];
                    (
                        common_origin(self.signs[0], to(0), i.x, j.x),
                        common_origin(self.signs[1], to(1), i.y, j.y),
                        common_origin(self.signs[2], to(2), i.z, j.z),
                    )
                } else {
                    let a = V3::splat(token, *low) - origin.high;
                    let b = V3::splat(token, *high) - origin.low;
                    (
                        separate_origins(self.signs[0], [a.x, b.x], i.x, j.x),
                        separate_origins(self.signs[1], [a.y, b.y], i.y, j.y),
                        separate_origins(self.signs[2], [a.z, b.z], i.z, j.z),
                    )
                };
                let near = x0.max(y0).max(z0);
                let far = x1.min(y1).min(z1) * STRETCH;
                let limit = vector(token, limits, v);
                hit_mask |= near.max(near.broadcast(0.0)).le(far.min(limit)).bits() << shift;
            }
            v += 1;
        }
        hit_mask & active
    }

    /// The largest limit of a tile's rays, in the order of the tiles; −1 for a tile that is not whole, and for
    /// those beyond the packet.
    #[inline(always)]
    pub fn limits(best: &[ClosestHit<L>; G]) -> [f32; TILES] {
        let mut limits = [-1.0; TILES];
        let mut tile = 0;
        while (tile + 1) * Self::GROUPS <= G && tile < TILES {
            limits[tile] = Self::limit(best, tile);
            tile += 1;
        }
        limits
    }

    /// The largest limit of one tile's rays.
    #[inline(always)]
    pub fn limit(best: &[ClosestHit<L>; G], tile: usize) -> f32 {
        let first = tile * Self::GROUPS;
        let mut limit = best[first].t;
        let mut g = first + 1;
        while g < first + Self::GROUPS {
            limit = limit.max(best[g].t);
            g += 1;
        }
        limit.largest()
    }

    /// The largest of all limits; negative when every ray is done.
    #[inline(always)]
    pub fn widest(token: L::Token, limits: &[f32; TILES]) -> f32 {
        let mut widest: L = vector(token, limits, 0);
        let mut v = 1;
        while v < Self::VECTORS {
            widest = widest.max(vector(token, limits, v));
            v += 1;
        }
        widest.largest()
    }

    /// The tiles whose limit is not negative.
    #[inline(always)]
    pub fn active(token: L::Token, limits: &[f32; TILES]) -> u32 {
        let mut active = 0;
        let mut v = 0;
        while v < Self::VECTORS {
            let limit = vector::<L>(token, limits, v);
            active |= limit.ge(limit.broadcast(0.0)).bits() << (v * L::WIDTH);
            v += 1;
        }
        active
    }

    /// The groups of a tile: the first, and the one after the last.
    #[inline(always)]
    pub fn groups(tile: usize) -> (usize, usize) {
        (tile * Self::GROUPS, (tile + 1) * Self::GROUPS)
    }
}

/// One vector of a number a tile.
#[inline(always)]
fn vector<L: Lane>(token: L::Token, numbers: &[f32; TILES], v: usize) -> L {
    L::from_fn(
        token,
        #[inline(always)]
        |lane| numbers[v * L::WIDTH + lane],
    )
}

/// Bounds on where rays from one origin enter and leave the slab between two planes across an axis: `to` are
/// the distances of the planes, `low` and `high` the smallest and the largest reciprocal direction of each
/// tile.
#[inline(always)]
fn common_origin<L: Lane>(sign: Sign, to: [f32; 2], low: L, high: L) -> (L, L) {
    let [entry, exit] = match sign {
        Sign::Positive => to,
        Sign::Negative => [to[1], to[0]],
        Sign::Mixed => {
            return separate_origins(sign, [low.broadcast(to[0]), low.broadcast(to[1])], low, high);
        }
    };
    let near = if entry >= 0.0 { low } else { high };
    let far = if exit >= 0.0 { high } else { low };
    (near * entry, far * exit)
}

/// The same for rays with origins of their own: `to` are the least distance of the first plane and the
/// largest of the second.
#[inline(always)]
pub(crate) fn separate_origins<L: Lane>(sign: Sign, to: [L; 2], low: L, high: L) -> (L, L) {
    let [entry, exit] = match sign {
        Sign::Positive => to,
        Sign::Negative => [to[1], to[0]],
        Sign::Mixed => {
            let (p, q, r, s) = (to[0] * low, to[0] * high, to[1] * low, to[1] * high);
            return (p.min(q).min(r.min(s)), p.max(q).max(r.max(s)));
        }
    };
    ((entry * low).min(entry * high), (exit * low).max(exit * high))
}

/// Puts a range into six rows from `row` on.
#[inline(always)]
fn store(rows: &mut [[f32; TILES]; 12], row: usize, tile: usize, (low, high): ([f32; 3], [f32; 3])) {
    let mut i = 0;
    while i < 3 {
        rows[row + i][tile] = low[i];
        rows[row + 3 + i][tile] = high[i];
        i += 1;
    }
}

impl<L: Lane> Range<L> {
    /// Vector `v` of the range in six rows from `row` on.
    #[inline(always)]
    fn load(token: L::Token, rows: &[[f32; TILES]; 12], row: usize, v: usize) -> Self {
        let at = |i: usize| vector(token, &rows[row + i], v);
        Self { low: V3 { x: at(0), y: at(1), z: at(2) }, high: V3 { x: at(3), y: at(4), z: at(5) } }
    }

    /// The range of `value(g)` in those lanes of the `count` groups from `first` on whose
    /// limit is not negative.
    #[inline(always)]
    fn of<const G: usize>(
        best: &[ClosestHit<L>; G],
        first: usize,
        count: usize,
        value: impl Fn(usize) -> V3<L>,
    ) -> ([f32; 3], [f32; 3]) {
        let like = best[0].t;
        let (largest, smallest) = (like.broadcast(f32::MAX), like.broadcast(-f32::MAX));
        let everything = V3 { x: largest, y: largest, z: largest };
        let nothing = V3 { x: smallest, y: smallest, z: smallest };
        let (mut low, mut high) = (everything, nothing);
        let mut g = first;
        while g < first + count {
            let active = best[g].t.ge(like.broadcast(0.0));
            let value = value(g);
            low = low.min(V3::select(active, value, everything));
            high = high.max(V3::select(active, value, nothing));
            g += 1;
        }
        (
            [low.x.smallest(), low.y.smallest(), low.z.smallest()],
            [high.x.largest(), high.y.largest(), high.z.largest()],
        )
    }
}

/// A vector of as many lanes as `like`, from one of as many.
#[inline(always)]
fn each<L: Lane, O: Lane>(like: L, v: V3<O>) -> V3<L> {
    let row = v.row();
    V3::from_fn(
        like.token(),
        #[inline(always)]
        |lane| row.at(lane),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::packet::ray_hit_mask;
    use crate::lane::plain::Plain;
    use core::ops::Mul;

    /// Numbers within −1 .. 1 that look random.
    fn random(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// Of many boxes: how many pairs of a tile and a box there are, in how many a ray hits the box, and how
    /// many the bounds let pass. No pair with a hit may be culled.
    fn judge<L: Lane<Token = ()> + Mul<O, Output = L>, O: Lane<Token = ()>, const G: usize>(
        rays: &[Ray<L, O>; G],
    ) -> [u32; 3] {
        let mut closest = [ClosestHit::none(L::splat((), 4.0)); G];
        // The rays of one tile are not traced.
        let (first, end) = Tiles::<L, G>::groups(5);
        for closest in &mut closest[first..end] {
            closest.t = L::splat((), -1.0);
        }
        let active = 0xffff & !(1 << 5);
        let tiles = Tiles::of(rays, &closest, active);
        let limits = Tiles::<L, G>::limits(&closest);
        assert_eq!(Tiles::<L, G>::active((), &limits), active);
        let (mut seed, mut counts) = (3, [0; 3]);
        for _ in 0..2000 {
            let low = [0; 3].map(|_| random(&mut seed) * 3.0);
            let high = low.map(|c| c + random(&mut seed).abs());
            let hit = ray_hit_mask(rays, &low, &high, active, &closest);
            let passed = tiles.hit_mask::<O>(&low, &high, &limits, active);
            assert_eq!(hit & !passed, 0, "{low:?} {high:?}");
            for (count, more) in counts.iter_mut().zip([active, hit, passed]) {
                *count += more.count_ones();
            }
        }
        counts
    }

    /// The direction of ray `i` of a packet that is 16 rays wide.
    fn direction(i: usize) -> [f32; 3] {
        let (tile, inside) = (i / TILE, i % TILE);
        let (x, y) = (tile % 4 * 4 + inside % 4, tile / 4 * 4 + inside / 4);
        [x as f32 * 0.05 - 0.4, y as f32 * 0.05 - 0.4, 1.0]
    }

    #[test]
    fn no_tile_with_a_ray_that_hits_a_box_is_culled_and_most_others_are() {
        let at = |g: usize, lane: usize| direction(g * 8 + lane);
        let common: [Ray<Plain<8>, f32>; 32] = core::array::from_fn(|g| {
            Ray::new(V3::splat((), [0.1, 0.2, -3.0]), V3::from_fn((), |lane| at(g, lane)))
        });
        let apart: [Ray<Plain<8>>; 32] = core::array::from_fn(|g| {
            let origin = V3::from_fn((), |lane| at(g, lane).map(|c| c * 0.3 - 2.0));
            Ray::new(origin, V3::from_fn((), |lane| at(g, lane)))
        });
        for [pairs, hit, passed] in [judge(&common), judge(&apart)] {
            assert!(hit > pairs / 100, "{hit} of {pairs}");
            assert!(passed - hit < pairs / 20, "{passed} passed, {hit} hit, of {pairs}");
        }
    }

    #[test]
    fn limits_are_the_largest_of_each_tile() {
        let mut closest = [ClosestHit::none(Plain([1.0; 16])); 16];
        closest[3].t.0[4] = 7.0;
        closest[9].t = Plain([-1.0; 16]);
        let limits = Tiles::limits(&closest);
        assert_eq!((limits[3], limits[9], limits[0]), (7.0, -1.0, 1.0));
        assert_eq!(Tiles::<Plain<16>, 16>::widest((), &limits), 7.0);
        assert_eq!(Tiles::<Plain<16>, 16>::active((), &limits), 0xffff & !(1 << 9));
        // A group of eight is half a tile.
        assert_eq!(Tiles::<Plain<8>, 1>::limits(&[ClosestHit::none(Plain([1.0; 8]))]), [-1.0; TILES]);
        assert_eq!(Tiles::<Plain<8>, 32>::groups(3), (6, 8));
    }
}
