//! Rows of eight numbers in lanes, and boxes that rays enter: many boxes and one ray, or one box and many rays.

use super::wide::WIDTH;
use crate::kernel::slab::STRETCH;
use crate::lane::{Lane, Row, V3};

/// The numbers of a row from `first` on.
#[inline(always)]
pub(super) fn load<L: Lane>(token: L::Token, row: &[f32; WIDTH], first: usize) -> L {
    L::from_fn(
        token,
        #[inline(always)]
        |lane| row[first + lane],
    )
}

/// The vectors of three rows from `first` on.
#[inline(always)]
pub(super) fn load_v3<L: Lane>(token: L::Token, [x, y, z]: &[[f32; WIDTH]; 3], first: usize) -> V3<L> {
    V3 { x: load(token, x, first), y: load(token, y, first), z: load(token, z, first) }
}

/// Puts vectors into three rows from `first` on.
#[inline(always)]
pub(super) fn store_v3<L: Lane>(vector: V3<L>, rows: &mut [[f32; WIDTH]; 3], first: usize) {
    let [x, y, z] = rows;
    store(vector.x, x, first);
    store(vector.y, y, first);
    store(vector.z, z, first);
}

/// Puts numbers into a row from `first` on.
#[inline(always)]
pub(super) fn store<L: Lane>(numbers: L, row: &mut [f32; WIDTH], first: usize) {
    let numbers = numbers.row();
    let mut lane = 0;
    while lane < L::WIDTH {
        row[first + lane] = numbers.at(lane);
        lane += 1;
    }
}

/// Three numbers, each in all lanes.
#[inline(always)]
pub(super) fn splat<L: Lane>(token: L::Token, [x, y, z]: [f32; 3]) -> [L; 3] {
    [L::splat(token, x), L::splat(token, y), L::splat(token, z)]
}

/// Where rays enter and leave the slab between a lower and an upper plane across an axis. `origins` are what the two
/// planes are measured from.
///
/// A ray enters at the plane with the smaller `t`: products with a number of one sign are ordered as their other
/// factors, or the other way round.
#[inline(always)]
pub(super) fn cross<L: Lane>([low, high]: [L; 2], origins: [L; 2], inverse: L) -> (L, L) {
    let (a, b) = ((low - origins[0]) * inverse, (high - origins[1]) * inverse);
    (a.min(b), a.max(b))
}

/// Where rays enter boxes, not before `from`, and whether they do so within `limit`. The slabs are those of
/// [`cross`] along each axis.
#[inline(always)]
pub(super) fn enter<L: Lane>([(x0, x1), (y0, y1), (z0, z1)]: [(L, L); 3], from: L, limit: L) -> (L, L::Mask) {
    let near = x0.max(y0).max(z0).max(from);
    let far = x1.min(y1).min(z1) * STRETCH;
    (near, !near.gt(far) & near.le(limit))
}
