//! Where a ray is inside a box.

use crate::kernel::ray::Ray;
use crate::lane::{Lane, V3};

/// How much the far end of an interval is stretched before it is compared: 1 + 2⁻¹⁹.
///
/// Each end is a rounded subtraction, reciprocal and multiplication, off by at most
/// 4 · 2⁻²⁴ of itself; a box without thickness would otherwise be missed by chance.
/// Stretching is monotone, so it keeps the order of nested intervals.
pub const STRETCH: f32 = 1.0 + 1.0 / 524_288.0;

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
pub fn slab<L: Lane>(ray: &Ray<L>, low: &[f32; 3], high: &[f32; 3]) -> (L, L) {
    let token = ray.origin.x.token();
    let (low, high) = (V3::<L>::splat(token, *low), V3::<L>::splat(token, *high));
    let (o, i) = (ray.origin, ray.inverse);
    let (x0, x1) = ((low.x - o.x) * i.x, (high.x - o.x) * i.x);
    let (y0, y1) = ((low.y - o.y) * i.y, (high.y - o.y) * i.y);
    let (z0, z1) = ((low.z - o.z) * i.z, (high.z - o.z) * i.z);
    let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1));
    let far = x0.max(x1).min(y0.max(y1)).min(z0.max(z1));
    (near, far * STRETCH)
}

/// Where the ray meets the box at some `0 ≤ t ≤ limit`. A negative limit meets nothing.
#[inline(always)]
pub fn meets<L: Lane>(ray: &Ray<L>, low: &[f32; 3], high: &[f32; 3], limit: L) -> L::Mask {
    let (near, far) = slab(ray, low, high);
    near.max(near.like(0.0)).less_equal(far.min(limit))
}
