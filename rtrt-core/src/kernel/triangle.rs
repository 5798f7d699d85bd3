//! The ray–triangle test of Möller and Trumbore ("Fast, Minimum Storage Ray/Triangle
//! Intersection", 1997), and what exactly counts as a hit.

use crate::kernel::ray::Ray;
use crate::kernel::slab::{RelativeBox, slab};
use crate::lane::{Lane, Mask, V3};
use crate::num::{FLOOR, TINY, flush, recip};
use core::ops::Mul;

/// A determinant smaller than this in magnitude is of a ray in the triangle's plane, or
/// of a triangle without area: 2⁻⁸⁰, far above anything that a device may flush.
pub(crate) const DETERMINANT_FLOOR: f32 = f32::from_bits((127 - 80) << 23);

/// A triangle, ready to be tested.
#[derive(Clone, Copy)]
pub struct Triangle {
    /// Its corners.
    pub corners: [[f32; 3]; 3],
    /// First to second corner.
    ab: [f32; 3],
    /// First to third corner.
    ac: [f32; 3],
    /// `ac × ab`.
    across: [f32; 3],
}

impl Triangle {
    /// The triangle with these corners.
    #[inline(always)]
    pub fn new(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Self {
        let ab = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let ac = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
        Self {
            corners: [a, b, c],
            ab,
            ac,
            across: [
                ac[1] * ab[2] - ac[2] * ab[1],
                ac[2] * ab[0] - ac[0] * ab[2],
                ac[0] * ab[1] - ac[1] * ab[0],
            ],
        }
    }

    /// Lower and upper corner of the bounds.
    #[inline(always)]
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let [a, b, c] = &self.corners;
        let low = |i: usize| Lane::min(Lane::min(a[i], b[i]), c[i]);
        let high = |i: usize| Lane::max(Lane::max(a[i], b[i]), c[i]);
        ([low(0), low(1), low(2)], [high(0), high(1), high(2)])
    }

    /// What [`intersect`] needs of the triangle for rays that start at `origin`.
    #[inline(always)]
    pub fn relative_to<O: Lane>(&self, origin: V3<O>) -> RelativeTriangle<O> {
        let (ab, ac) = (&self.ab, &self.ac);
        let s = origin - V3::splat(origin.x.token(), self.corners[0]);
        let v =
            V3 { x: s.y * ab[2] - s.z * ab[1], y: s.z * ab[0] - s.x * ab[2], z: s.x * ab[1] - s.y * ab[0] };
        RelativeTriangle {
            u: V3 {
                x: s.z * ac[1] - s.y * ac[2],
                y: s.x * ac[2] - s.z * ac[0],
                z: s.y * ac[0] - s.x * ac[1],
            },
            v,
            distance: flush(v.x * ac[0] + v.y * ac[1] + v.z * ac[2]),
        }
    }
}

/// A triangle relative to the origin of rays: the terms that directions are multiplied with.
#[derive(Clone, Copy)]
pub struct RelativeTriangle<O> {
    /// `ac × (o − a)`.
    u: V3<O>,
    /// `(o − a) × ab`.
    v: V3<O>,
    /// `ac · v`.
    distance: O,
}

impl<O: Lane> RelativeTriangle<O> {
    /// Whether the origin is in front of the triangle, where its corners are counterclockwise: `(o − a) · (ab × ac) > 0`. `like` is a value of the rays.
    ///
    /// The triangle and what it is seen from are in the space of its instance, so that the front
    /// of one that is placed mirrored is that of one that is not, as glTF 2.0 has it (section
    /// 3.7.4).
    #[inline(always)]
    pub fn front<L: Lane + Mul<O, Output = L>>(&self, like: L) -> L::Mask {
        (like.broadcast(1.0) * self.distance).gt(like.broadcast(0.0))
    }
}

/// The intersection of a ray with a triangle.
#[derive(Clone, Copy)]
pub struct Intersection<L: Lane> {
    /// The lanes that hit it. The other fields have no meaning in the other lanes.
    pub mask: L::Mask,
    /// The parameter of the hit on the ray.
    pub t: L,
    /// Barycentric weight of the second corner, 0 ..= 1.
    pub u: L,
    /// Barycentric weight of the third corner, 0 ..= 1.
    pub v: L,
}

/// Where the ray meets the triangle, at some 2⁻⁹⁰ < `t` ≤ `limit`, from either side.
/// `seen` is the triangle relative to the origin of the ray.
///
/// ```text
/// s = o − a,  det = d · (ac × ab)
/// u = d · (ac × s) / det,  v = d · (s × ab) / det,  t = ac · (s × ab) / det
/// hit: |det| ≥ 2⁻⁸⁰,  u ≥ 0,  v ≥ 0,  u + v ≤ 1,  t > 0
/// ```
///
/// These are the triple products of Möller and Trumbore, turned so that the direction comes
/// last: all else is the same for rays that start at one point, and is computed once for a
/// packet of them (as Kensler and Shirley, "Optimizing Ray-Triangle Intersection via
/// Automated Search", 2006, do).
///
/// Two additions make the result independent of how the triangle was found: the interval of
/// the triangle's own box must not be empty, and `t` is clamped into it. A test on an almost
/// edge-on triangle can return a `t` far from the triangle; clamped, it is inside every box
/// around the triangle, so no culling by boxes can lose it. (Rejecting instead of clamping
/// would lose real hits: a triangle parallel to an axis has a box without thickness, whose
/// `t` differs from the above by rounding.)
///
/// Comparisons are made before the division, on numerators with the determinant's sign
/// folded in, and a numerator below 2⁻¹⁰⁰ counts as 0, as it does on devices that flush
/// denormals.
#[inline(always)]
pub fn intersect<L: Lane + Mul<O, Output = L>, O: Lane>(
    ray: &Ray<L, O>,
    triangle: &Triangle,
    seen: &RelativeTriangle<O>,
    limit: L,
) -> Intersection<L> {
    let d = &ray.direction;
    let n = &triangle.across;
    let determinant = d.x * n[0] + d.y * n[1] + d.z * n[2];
    let sign = determinant.sign_bit();
    let size = determinant.abs();
    let u = (d.x * seen.u.x + d.y * seen.u.y + d.z * seen.u.z).flip_sign(sign);
    let v = (d.x * seen.v.x + d.y * seen.v.y + d.z * seen.v.z).flip_sign(sign);
    // Cheap, and conservative even if denormals are flushed: most rays end here.
    let below = size.broadcast(-2.0 * FLOOR);
    let mut mask =
        u.gt(below) & v.gt(below) & size.ge(size.broadcast(DETERMINANT_FLOOR)) & ((u + v) * 0.999).le(size);
    let mut t = limit;
    let (mut weight_u, mut weight_v) = (u, v);
    if mask.any() {
        let zero = size.broadcast(0.0);
        let (u, v) = (flush(u), flush(v));
        let inverse = recip(size);
        let (low, high) = triangle.bounds();
        let (near, far) = slab(ray, &RelativeBox::new(ray.origin, &low, &high));
        let t_plane = inverse.flip_sign(sign) * seen.distance;
        t = t_plane.min(far).max(near);
        mask = mask
            & u.ge(zero)
            & v.ge(zero)
            & (u + v).le(size)
            & near.le(far)
            & (zero.broadcast(1.0).flip_sign(sign) * seen.distance).gt(zero)
            & t.gt(zero.broadcast(TINY))
            & t.le(limit);
        weight_u = flush(u * inverse);
        weight_v = flush(v * inverse);
    }
    Intersection { mask, t, u: weight_u, v: weight_v }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

    fn met(corners: [[f32; 3]; 3], origin: [f32; 3], direction: [f32; 3], limit: f32) -> Intersection<f32> {
        let ray = Ray::<f32>::new(V3::splat((), origin), V3::splat((), direction));
        let triangle = Triangle::new(corners[0], corners[1], corners[2]);
        intersect(&ray, &triangle, &triangle.relative_to(ray.origin), limit)
    }

    /// Numbers within −1 .. 1 that look random.
    fn random(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    #[test]
    fn a_ray_meets_a_triangle_from_both_sides() {
        for (z, way) in [(3.0, -2.0), (-3.0, 2.0)] {
            let hit = met(CORNERS, [1.0, 0.5, z], [0.0, 0.0, way], 9.0);
            assert!(hit.mask);
            for (got, exact) in [(hit.t, 1.5), (hit.u, 0.25), (hit.v, 0.25)] {
                assert!((got - exact).abs() < 1e-6, "{got} is not {exact}");
            }
        }
    }

    #[test]
    fn the_limit_counts_and_what_is_behind_does_not() {
        let at = |limit: f32| met(CORNERS, [1.0, 0.5, 3.0], [0.0, 0.0, -1.0], limit);
        let t = at(9.0).t;
        assert!(at(t).mask && !at(t * 0.999).mask && !at(-1.0).mask);
        assert!(!met(CORNERS, [1.0, 0.5, 3.0], [0.0, 0.0, 1.0], 9.0).mask);
    }

    #[test]
    fn edges_belong_to_the_triangle_and_what_is_past_them_does_not() {
        let at = |x: f32, y: f32| met(CORNERS, [x - 0.5, y - 0.25, 1.0], [0.5, 0.25, -1.0], 9.0).mask;
        assert!(at(0.0, 0.0) && at(4.0, 0.0) && at(0.0, 2.0) && at(2.0, 1.0) && at(2.0, 0.0) && at(0.0, 1.0));
        assert!(!at(-1e-3, 0.5) && !at(1.0, -1e-3) && !at(2.01, 1.0));
    }

    #[test]
    fn rays_in_the_plane_and_triangles_without_area_meet_nothing() {
        assert!(!met(CORNERS, [-1.0, 0.5, 0.0], [1.0, 0.0, 0.0], 9.0).mask);
        let line = [[0.0; 3], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]];
        assert!(!met(line, [1.0, 1.0, 1.0], [0.0, 0.0, -1.0], 9.0).mask);
        assert!(!met(CORNERS, [1.0, 0.5, 1.0], [f32::NAN, 0.0, -1.0], 9.0).mask);
    }

    #[test]
    fn the_front_is_where_corners_are_counterclockwise() {
        let [a, b, c] = CORNERS;
        let front = |triangle: Triangle, z: f32| {
            triangle.relative_to(V3::<f32>::splat((), [0.3, 0.2, z])).front(0.0_f32)
        };
        assert!(front(Triangle::new(a, b, c), 1.0) && !front(Triangle::new(a, b, c), -1.0));
        assert!(!front(Triangle::new(a, c, b), 1.0) && front(Triangle::new(a, c, b), -1.0));
    }

    #[test]
    fn a_hit_lies_in_the_interval_of_the_triangles_own_box() {
        let (mut seed, mut count) = (1, 0);
        for _ in 0..100_000 {
            let mut point = |flat: f32| [random(&mut seed), random(&mut seed), random(&mut seed) * flat];
            // Almost in one plane, and the rays almost in it as well.
            let (corners, origin, to) = ([0; 3].map(|_| point(1e-5)), point(1e-4), point(1e-5));
            let direction = [0, 1, 2].map(|i| to[i] - origin[i]);
            let hit = met(corners, origin, direction, f32::MAX);
            if hit.mask {
                let ray = Ray::<f32>::new(V3::splat((), origin), V3::splat((), direction));
                let (low, high) = Triangle::new(corners[0], corners[1], corners[2]).bounds();
                let (near, far) = slab(&ray, &RelativeBox::new(ray.origin, &low, &high));
                assert!(near <= hit.t && hit.t <= far, "{near} {} {far}", hit.t);
                count += 1;
            }
        }
        assert!(count > 1000, "{count}");
    }
}
