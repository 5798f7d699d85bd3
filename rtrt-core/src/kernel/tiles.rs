//! A packet of rays as tiles, each bounded by intervals: one test for all of them tells
//! which tiles may meet a box.

use crate::kernel::ray::Ray;
use crate::kernel::slab::STRETCH;
use crate::kernel::traverse::Best;
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
/// rounding is monotone, so [`Tiles::meets`] is exact interval arithmetic: it never passes
/// over a box that one of the rays would enter, without any epsilon (after Boulos, Wald and
/// Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets", 2006).
#[derive(Clone, Copy)]
pub struct Tiles<L, const G: usize> {
    origin: [Range<L>; VECTORS],
    inverse: [Range<L>; VECTORS],
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

    /// The bounds of those rays whose limit is not negative, in the tiles whose bits are set
    /// in `among`; each of them has such a ray. Nothing for a packet of one group, which needs
    /// none.
    #[inline(always)]
    pub fn of<O: Lane>(rays: &[Ray<L, O>; G], best: &[Best<L>; G], among: u32) -> Self {
        let like = best[0].t;
        if G == 1 {
            let zero = like.like(0.0);
            let zero = V3 { x: zero, y: zero, z: zero };
            let nothing = [Range { low: zero, high: zero }; VECTORS];
            return Self { origin: nothing, inverse: nothing };
        }
        let mut rows = [[0.0_f32; TILES]; 12];
        let mut left = among;
        while left != 0 {
            let tile = left.trailing_zeros() as usize;
            left &= left - 1;
            let first = tile * Self::GROUPS;
            let inverse = Range::of(
                best,
                first,
                Self::GROUPS,
                #[inline(always)]
                |g| rays[g].inverse,
            );
            store(&mut rows, 0, tile, inverse);
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
        Self {
            inverse: [Range::load(token, rows, 0, 0), Range::load(token, rows, 0, last)],
            origin: [Range::load(token, rows, 6, 0), Range::load(token, rows, 6, last)],
        }
    }

    /// The tiles of `among` in which a ray may meet the box at some `0 ≤ t ≤` the tile's
    /// limit: every tile in which one does, and few more.
    #[inline(always)]
    pub fn meets(&self, low: &[f32; 3], high: &[f32; 3], limits: &[f32; TILES], among: u32) -> u32 {
        let token = self.origin[0].low.x.token();
        let mut met = 0;
        let mut v = 0;
        while v < Self::VECTORS {
            let shift = (v * L::WIDTH) as u32;
            if Self::VECTORS == 1 || among >> shift & ((1 << L::WIDTH) - 1) != 0 {
                let (origin, inverse) = (&self.origin[v], &self.inverse[v]);
                let a = V3::splat(token, *low) - origin.high;
                let b = V3::splat(token, *high) - origin.low;
                let (x0, x1) = product(a.x, b.x, inverse.low.x, inverse.high.x);
                let (y0, y1) = product(a.y, b.y, inverse.low.y, inverse.high.y);
                let (z0, z1) = product(a.z, b.z, inverse.low.z, inverse.high.z);
                let near = x0.max(y0).max(z0);
                let far = x1.min(y1).min(z1) * STRETCH;
                let limit = vector(token, limits, v);
                met |= near.max(near.like(0.0)).less_equal(far.min(limit)).bits() << shift;
            }
            v += 1;
        }
        met & among
    }

    /// The largest limit of a tile's rays, in the order of the tiles.
    #[inline(always)]
    pub fn limits(best: &[Best<L>; G]) -> [f32; TILES] {
        let mut limits = [-1.0; TILES];
        let mut tile = 0;
        while tile * Self::GROUPS < G {
            limits[tile] = Self::limit(best, tile);
            tile += 1;
        }
        limits
    }

    /// The largest limit of one tile's rays.
    #[inline(always)]
    pub fn limit(best: &[Best<L>; G], tile: usize) -> f32 {
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
    pub fn searching(token: L::Token, limits: &[f32; TILES]) -> u32 {
        let mut searching = 0;
        let mut v = 0;
        while v < Self::VECTORS {
            let limit = vector::<L>(token, limits, v);
            searching |= limit.like(0.0).less_equal(limit).bits() << (v * L::WIDTH);
            v += 1;
        }
        searching
    }

    /// The tile that a group is in.
    #[inline(always)]
    pub fn tile(group: usize) -> u32 {
        (group / Self::GROUPS) as u32
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

/// The smallest and the largest product of a number in `a ..= b` and one in `c ..= d`.
#[inline(always)]
fn product<L: Lane>(a: L, b: L, c: L, d: L) -> (L, L) {
    let (p, q, r, s) = (a * c, a * d, b * c, b * d);
    (p.min(q).min(r.min(s)), p.max(q).max(r.max(s)))
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
        best: &[Best<L>; G],
        first: usize,
        count: usize,
        value: impl Fn(usize) -> V3<L>,
    ) -> ([f32; 3], [f32; 3]) {
        let like = best[0].t;
        let (largest, smallest) = (like.like(f32::MAX), like.like(-f32::MAX));
        let everything = V3 { x: largest, y: largest, z: largest };
        let nothing = V3 { x: smallest, y: smallest, z: smallest };
        let (mut low, mut high) = (everything, nothing);
        let mut g = first;
        while g < first + count {
            let active = like.like(0.0).less_equal(best[g].t);
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
