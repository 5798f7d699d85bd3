//! The ray–triangle test of Möller and Trumbore ("Fast, Minimum Storage Ray/Triangle
//! Intersection", 1997), and what exactly counts as a hit.

use crate::kernel::ray::Ray;
use crate::kernel::slab::slab;
use crate::lane::{Lane, Mask, V3};
use crate::num::{FLOOR, TINY, flush, recip};

/// A determinant smaller than this in magnitude is of a ray in the triangle's plane, or
/// of a triangle without area: 2⁻⁸⁰, far above anything that a device may flush.
pub const DETERMINANT_FLOOR: f32 = f32::from_bits((127 - 80) << 23);

/// A triangle, ready to be tested.
#[derive(Clone, Copy)]
pub struct Triangle {
    /// First corner.
    pub a: [f32; 3],
    /// First to second corner.
    pub ab: [f32; 3],
    /// First to third corner.
    pub ac: [f32; 3],
    /// Lower corner of the bounds.
    pub low: [f32; 3],
    /// Upper corner of the bounds.
    pub high: [f32; 3],
}

impl Triangle {
    /// The triangle with these corners.
    #[inline(always)]
    pub fn new(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Self {
        let low = |i: usize| Lane::min(Lane::min(a[i], b[i]), c[i]);
        let high = |i: usize| Lane::max(Lane::max(a[i], b[i]), c[i]);
        Self {
            a,
            ab: [b[0] - a[0], b[1] - a[1], b[2] - a[2]],
            ac: [c[0] - a[0], c[1] - a[1], c[2] - a[2]],
            low: [low(0), low(1), low(2)],
            high: [high(0), high(1), high(2)],
        }
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy)]
pub struct Meeting<L: Lane> {
    /// The lanes that meet it; the rest of the fields mean nothing in the others.
    pub mask: L::Mask,
    /// Where on the ray.
    pub t: L,
    /// Barycentric weight of the second corner, 0 ..= 1.
    pub u: L,
    /// Barycentric weight of the third corner, 0 ..= 1.
    pub v: L,
}

/// Where the ray meets the triangle, at some 2⁻⁹⁰ < `t` ≤ `limit`, from either side.
///
/// ```text
/// p = d × ac,  s = o − a,  q = s × ab,  det = ab · p
/// u = s · p / det,  v = d · q / det,  t = ac · q / det
/// hit: |det| ≥ 2⁻⁸⁰,  u ≥ 0,  v ≥ 0,  u + v ≤ 1,  t > 0
/// ```
///
/// with two additions that make the result independent of how the triangle was found:
/// the interval of the triangle's own box must not be empty, and `t` is clamped into it.
/// A test on an almost edge-on triangle can return a `t` far from the triangle; clamped,
/// it is inside every box around the triangle, so no culling by boxes can lose it.
/// (Rejecting instead of clamping would lose real hits: a triangle parallel to an axis
/// has a box without thickness, whose `t` differs from the above by rounding.)
///
/// Comparisons are made before the division, on numerators with the determinant's sign
/// folded in, and a numerator below 2⁻¹⁰⁰ counts as 0, as it does on devices that flush
/// denormals.
#[inline(always)]
pub fn meet<L: Lane>(ray: &Ray<L>, triangle: &Triangle, limit: L) -> Meeting<L> {
    let token = limit.token();
    let ab = V3::splat(token, triangle.ab);
    let ac = V3::splat(token, triangle.ac);
    let p = ray.direction.cross(ac);
    let s = ray.origin - V3::splat(token, triangle.a);
    let q = s.cross(ab);
    let determinant = ab.dot(p);
    let sign = determinant.sign_bit();
    let size = determinant.abs();
    let u = s.dot(p).flip_sign(sign);
    let v = ray.direction.dot(q).flip_sign(sign);
    // Cheap, and wider than the test below by more than any flushing: most rays end here.
    let below = size.like(-2.0 * FLOOR);
    let mut mask = below.less_than(u)
        & below.less_than(v)
        & size.like(DETERMINANT_FLOOR).less_equal(size)
        & ((u + v) * 0.999).less_equal(size);
    let mut t = limit;
    let (mut weight_u, mut weight_v) = (u, v);
    if mask.any() {
        let zero = size.like(0.0);
        let (u, v) = (flush(u), flush(v));
        let along = flush(ac.dot(q).flip_sign(sign));
        let inverse = recip(size);
        let (near, far) = slab(ray, &triangle.low, &triangle.high);
        let t_plane = along * inverse;
        t = t_plane.min(far).max(near);
        mask = mask
            & zero.less_equal(u)
            & zero.less_equal(v)
            & (u + v).less_equal(size)
            & near.less_equal(far)
            & zero.less_than(t_plane)
            & zero.like(TINY).less_than(t)
            & t.less_equal(limit);
        weight_u = flush(u * inverse);
        weight_v = flush(v * inverse);
    }
    Meeting { mask, t, u: weight_u, v: weight_v }
}
