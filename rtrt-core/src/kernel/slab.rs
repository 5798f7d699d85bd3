//! Slab test: the interval of a ray inside a box.

use crate::kernel::ray::Ray;
use crate::lane::{Lane, V3};
use core::ops::Mul;

/// How much the far end of an interval is stretched before it is compared: 1 + 2⁻¹⁹.
///
/// Each end is a rounded subtraction, reciprocal and multiplication, off by at most
/// 4 · 2⁻²⁴ of itself; a box without thickness would otherwise be missed by chance.
/// Stretching is monotone, so it keeps the order of nested intervals.
pub const STRETCH: f32 = 1.0 + 1.0 / 524_288.0;

/// A box, as seen from where rays start.
#[derive(Clone, Copy)]
pub struct RelativeBox<O> {
    /// From the start to the lower corner.
    pub low: V3<O>,
    /// From the start to the upper corner.
    pub high: V3<O>,
}

impl<O: Lane> RelativeBox<O> {
    /// The box between `low` and `high`, seen from `origin`.
    #[inline(always)]
    pub fn new(origin: V3<O>, low: &[f32; 3], high: &[f32; 3]) -> Self {
        let token = origin.x.token();
        Self { low: V3::splat(token, *low) - origin, high: V3::splat(token, *high) - origin }
    }
}

/// The interval of `t` for which the ray is between the box's planes: `(near, far)`,
/// with `far` stretched by [`STRETCH`]. Empty where `far < near`.
///
/// ```text
/// near = max over axes of min((low − o) / d, (high − o) / d)
/// far  = min over axes of max((low − o) / d, (high − o) / d) · STRETCH
/// ```
///
/// The slab method of Kay and Kajiya, 1986. Bits: rounded subtraction, multiplication,
/// minimum and maximum are monotone, so the interval of a box contains, exactly, the
/// interval of every box inside it. No term is NaN: coordinates are finite and the
/// reciprocal of 0 is finite.
#[inline(always)]
pub fn slab<L: Lane + Mul<O, Output = L>, O: Lane>(ray: &Ray<L, O>, relative: &RelativeBox<O>) -> (L, L) {
    let (i, low, high) = (&ray.inverse, &relative.low, &relative.high);
    let (x0, x1) = (i.x * low.x, i.x * high.x);
    let (y0, y1) = (i.y * low.y, i.y * high.y);
    let (z0, z1) = (i.z * low.z, i.z * high.z);
    let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1));
    let far = x0.max(x1).min(y0.max(y1)).min(z0.max(z1));
    (near, far * STRETCH)
}

/// Where the ray meets the box at some `0 ≤ t ≤ limit`. A negative limit meets nothing.
#[inline(always)]
pub fn intersects<L: Lane + Mul<O, Output = L>, O: Lane>(
    ray: &Ray<L, O>,
    relative: &RelativeBox<O>,
    limit: L,
) -> L::Mask {
    let (near, far) = slab(ray, relative);
    near.max(near.broadcast(0.0)).le(far.min(limit))
}
