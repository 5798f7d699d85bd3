//! The ray–triangle test: which triangles a ray meets after Woop, Benthin and Wald ("Watertight Ray/Triangle
//! Intersection", JCGT 2013), and where after Möller and Trumbore ("Fast, Minimum Storage Ray/Triangle
//! Intersection", 1997).

use crate::kernel::ray::Ray;
use crate::kernel::slab::{RelativeBox, slab};
use crate::lane::{Lane, Mask, Select, V3};
use crate::num::{TINY, flush, recip};
use core::ops::Mul;

/// Products of two coordinates of the plane that are smaller than this in magnitude may be flushed, or be of places
/// that are: 2⁻⁶⁴, for coordinates of up to 2³⁴.
const NOISE: f32 = f32::from_bits((127 - 64) << 23);

/// How far a ray may pass from a triangle that it meets, as a share of the largest coordinate of the triangle's
/// corners relative to the ray's origin: 2⁻²⁰.
///
/// A place in the plane is off by at most 6 · 2⁻²⁴ of it: a rounded subtraction from the origin, the rounded lean
/// (a reciprocal and a product) and its product, a rounded subtraction.
const PASSING: f32 = f32::from_bits((127 - 20) << 23);

/// How much wider boxes within this one have to be, so that none that a hit lies in is culled. `reach` is the
/// largest coordinate of the box's corners relative to the origins of rays, in magnitude.
///
/// Twice [`PASSING`]: the other half is for the rounding of wider planes relative to the origin. That of the
/// planes themselves, or of origins moved as much, is 2⁻²⁴ of their coordinates, which the second term covers.
#[inline(always)]
pub(crate) fn passing(reach: f32, low: &[f32; 3], high: &[f32; 3]) -> f32 {
    let most = |c: &[f32; 3]| Lane::max(Lane::max(Lane::abs(c[0]), Lane::abs(c[1])), Lane::abs(c[2]));
    reach * (2.0 * PASSING) + Lane::max(most(low), most(high)) * (0.25 * PASSING)
}

/// A triangle, ready to be tested.
#[derive(Clone, Copy)]
pub struct Triangle {
    /// Its corners.
    pub corners: [[f32; 3]; 3],
}

impl Triangle {
    /// The triangle with these corners.
    #[inline(always)]
    pub fn new(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Self {
        Self { corners: [a, b, c] }
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
        let token = origin.x.token();
        let [a, b, c] = &self.corners;
        RelativeTriangle {
            corners: [
                V3::splat(token, *a) - origin,
                V3::splat(token, *b) - origin,
                V3::splat(token, *c) - origin,
            ],
            ab: [b[0] - a[0], b[1] - a[1], b[2] - a[2]],
            ac: [c[0] - a[0], c[1] - a[1], c[2] - a[2]],
        }
    }
}

/// A triangle relative to the origin of rays: one for all lanes, or with `E = O` each lane's own.
#[derive(Clone, Copy)]
pub struct RelativeTriangle<O, E = f32> {
    /// From the origin to the corners.
    corners: [V3<O>; 3],
    /// First to second corner.
    ab: [E; 3],
    /// First to third corner.
    ac: [E; 3],
}

#[cfg(feature = "alloc")]
impl<L: Lane> RelativeTriangle<L, L> {
    /// Each lane's triangle with these corners.
    #[inline(always)]
    pub(crate) fn of([a, b, c]: [V3<L>; 3], origin: V3<L>) -> Self {
        let (ab, ac) = (b - a, c - a);
        Self { corners: [a - origin, b - origin, c - origin], ab: [ab.x, ab.y, ab.z], ac: [ac.x, ac.y, ac.z] }
    }
}

impl<O: Lane + Mul<E, Output = O>, E: Lane> RelativeTriangle<O, E> {
    /// `ac × ab`.
    #[inline(always)]
    fn across(&self) -> [E; 3] {
        let (ab, ac) = (&self.ab, &self.ac);
        [ac[1] * ab[2] - ac[2] * ab[1], ac[2] * ab[0] - ac[0] * ab[2], ac[0] * ab[1] - ac[1] * ab[0]]
    }

    /// `ac × (o − a)`.
    #[inline(always)]
    fn u(&self) -> V3<O> {
        let (a, ac) = (&self.corners[0], &self.ac);
        V3 { x: a.y * ac[2] - a.z * ac[1], y: a.z * ac[0] - a.x * ac[2], z: a.x * ac[1] - a.y * ac[0] }
    }

    /// `(o − a) × ab`.
    #[inline(always)]
    fn v(&self) -> V3<O> {
        let (a, ab) = (&self.corners[0], &self.ab);
        V3 { x: a.z * ab[1] - a.y * ab[2], y: a.x * ab[2] - a.z * ab[0], z: a.y * ab[0] - a.x * ab[1] }
    }

    /// `ac · v`, for this `v`; 0 where it is less than [`FLOOR`](crate::num::FLOOR).
    #[inline(always)]
    fn distance(&self, v: &V3<O>) -> O {
        flush(self.unflushed_distance(v))
    }

    /// `ac · v`.
    #[inline(always)]
    fn unflushed_distance(&self, v: &V3<O>) -> O {
        v.x * self.ac[0] + v.y * self.ac[1] + v.z * self.ac[2]
    }

    /// Whether the origin is in front of the triangle, where its corners are counterclockwise: `(o − a) · (ab × ac) > 0`. `like` is a value of the rays.
    ///
    /// The triangle and what it is seen from are in the space of its instance, so that the front
    /// of one that is placed mirrored is that of one that is not, as glTF 2.0 has it (section
    /// 3.7.4).
    #[inline(always)]
    pub fn front<L: Lane + Mul<O, Output = L>>(&self, like: L) -> L::Mask {
        (like.broadcast(1.0) * self.distance(&self.v())).gt(like.broadcast(0.0))
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

/// Two products; their difference is the area of the parallelogram between two places and the origin.
#[inline(always)]
fn products<L: Lane>(p: &[L; 2], q: &[L; 2]) -> [L; 2] {
    [p[0] * q[1], p[1] * q[0]]
}

/// On which side of the edges that are across from each corner the origin is, and how far; numbers below
/// [`NOISE`] may have the wrong sign on devices that flush denormals.
#[inline(always)]
fn sides<L: Lane>([a, b, c]: &[[L; 2]; 3]) -> [L; 3] {
    let [[p, q], [r, s], [x, y]] = [products(b, c), products(c, a), products(a, b)];
    [p - q, r - s, x - y]
}

/// The lanes whose ray may meet the triangle with its corners at these places of the plane: all that do.
#[inline(always)]
pub(crate) fn may_meet<L: Lane>(places: &[[L; 2]; 3]) -> L::Mask {
    let [is_counterclockwise, is_clockwise] = orientations(&sides(places));
    is_counterclockwise | is_clockwise
}

/// Whether the triangle with the origin on these [`sides`] of its edges may go around it counterclockwise, and whether
/// it may clockwise.
#[inline(always)]
fn orientations<L: Lane>([u, v, w]: &[L; 3]) -> [L::Mask; 2] {
    let noise = u.broadcast(NOISE);
    [u.min(*v).min(*w).gt(-noise), u.max(*v).max(*w).lt(noise)]
}

/// The lanes whose ray may meet the triangle, and not behind its origin: all that [`intersect`] it. `along` is the
/// direction's coordinate [along](crate::kernel::shear::Shear::along) the axis of its shear.
#[cfg(feature = "alloc")]
#[inline(always)]
pub(crate) fn may_meet_ahead<L: Lane>(ray: &Ray<L>, along: L, seen: &RelativeTriangle<L, L>) -> L::Mask {
    let sides = sides(&ray.shear.flatten(ray, &seen.corners));
    let [is_counterclockwise, is_clockwise] = orientations(&sides);
    // As `windings` has it, also where numbers are too large to be.
    let (u, noise) = (sides[0], along.broadcast(NOISE));
    let turns_back = u.lt(-noise) | (is_clockwise & !u.gt(noise));
    let distance = seen.unflushed_distance(&seen.v());
    let towards = distance.flip_sign(turns_back.select(along, -along).sign_bit());
    let is_ahead = towards.ge(along.broadcast(crate::num::FLOOR));
    (is_counterclockwise & is_clockwise) | ((is_counterclockwise | is_clockwise) & is_ahead)
}

/// Where the ray meets the triangle, at some 2⁻⁹⁰ < `t` ≤ `limit`, from either side.
/// `seen` is the triangle relative to the origin of the ray.
///
/// **Which.** In the plane of the ray's [`Shear`](crate::kernel::shear::Shear) the corners are `a`, `b` and `c`,
/// and the ray is the origin:
///
/// ```text
/// hit: b_x c_y ≥ b_y c_x,  c_x a_y ≥ c_y a_x,  a_x b_y ≥ a_y b_x,  not all equal; or all with ≤
/// ```
///
/// Triangles at an edge compare the same two rounded products, each the other way round, and rounding keeps their
/// order. So a ray is never outside of both: closed meshes have no gaps, at edges and at corners, and what exactly
/// meets an edge meets both its sides. Numbers below 2⁻¹⁰⁰ count as 0, as on devices that flush denormals.
///
/// **Where.**
///
/// ```text
/// s = o − a,  det = d · (ac × ab)
/// u = d · (ac × s) / det,  v = d · (s × ab) / det,  t = ac · (s × ab) / det
/// ```
///
/// These are the triple products of Möller and Trumbore, turned so that the direction comes
/// last: all else is the same for rays that start at one point (as Kensler and Shirley, "Optimizing Ray-Triangle
/// Intersection via Automated Search", 2006, do). The determinant has the sign that the plane gives it, and the
/// weights are clamped into their range.
///
/// Two additions make the result independent of how the triangle was found: `t` is clamped into the interval of
/// the triangle's own box, and where that is empty, into that of the box widened by `PASSING`, which must not
/// be empty. A test on an almost edge-on triangle can return a `t` far from the triangle; clamped, it is inside
/// every box around the triangle that is widened by `passing`, so no culling by such boxes can lose it.
#[inline(always)]
pub fn intersect<L: Lane + Mul<O, Output = L>, O: Lane>(
    ray: &Ray<L, O>,
    seen: &RelativeTriangle<O>,
    limit: L,
) -> Intersection<L> {
    let places = ray.shear.flatten(ray, &seen.corners);
    // Cheap, and conservative even if denormals are flushed: most rays end here.
    let mut mask = may_meet(&places);
    let (mut t, mut u, mut v) = (limit, limit, limit);
    if mask.any() {
        let (zero, one) = (limit.broadcast(0.0), limit.broadcast(1.0));
        let [is_clockwise, is_counterclockwise] = windings(&places, mask);
        let d = &ray.direction;
        let along = ray.shear.along(*d);
        let sign = is_counterclockwise.select(-along, along).sign_bit();
        let n = seen.across();
        let determinant = d.x * n[0] + d.y * n[1] + d.z * n[2];
        let inverse = recip(determinant.abs()).flip_sign(sign);
        let (of_u, of_v) = (seen.u(), seen.v());
        let distance = seen.distance(&of_v);
        let own = RelativeBox::around(&seen.corners);
        let (near, far) = slab(ray, &own);
        t = (inverse * distance).min(far).max(near);
        mask = mask
            & ((is_clockwise & !is_counterclockwise) | (is_counterclockwise & !is_clockwise))
            & along.abs().ge(zero.broadcast(TINY));
        let is_beside = mask & near.gt(far);
        if is_beside.any() {
            let (near, far) = slab(ray, &own.widened(own.reach() * PASSING));
            t = is_beside.select(t.min(far).max(near), t);
            mask = mask & near.le(far);
        }
        mask = mask & (one.flip_sign(sign) * distance).gt(zero) & t.gt(zero.broadcast(TINY)) & t.le(limit);
        u = flush(flush(d.x * of_u.x + d.y * of_u.y + d.z * of_u.z) * inverse).max(zero).min(one);
        v = flush(flush(d.x * of_v.x + d.y * of_v.y + d.z * of_v.z) * inverse).max(zero).min(one - u);
    }
    Intersection { mask, t, u, v }
}

/// Whether the corners at these places go around the origin clockwise, and whether they do counterclockwise; both
/// if they are in a line with it. `mask` has the lanes that matter.
#[inline(always)]
fn windings<L: Lane>(places: &[[L; 2]; 3], mask: L::Mask) -> [L::Mask; 2] {
    let [u, v, w] = sides(places);
    let (zero, noise) = (u.broadcast(0.0), u.broadcast(NOISE));
    // Beyond noise no flushed number can turn a sign.
    if !(mask & !u.abs().min(v.abs()).min(w.abs()).gt(noise)).any() {
        return [u.lt(zero), u.gt(zero)];
    }
    let (a, b, c) = (flushed(&places[0]), flushed(&places[1]), flushed(&places[2]));
    let [p, q, r] = [products(&b, &c), products(&c, &a), products(&a, &b)];
    let (p, q, r) = (flushed(&p), flushed(&q), flushed(&r));
    [p[0].le(p[1]) & q[0].le(q[1]) & r[0].le(r[1]), p[0].ge(p[1]) & q[0].ge(q[1]) & r[0].ge(r[1])]
}

#[inline(always)]
fn flushed<L: Lane>(pair: &[L; 2]) -> [L; 2] {
    [flush(pair[0]), flush(pair[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

    fn met(corners: [[f32; 3]; 3], origin: [f32; 3], direction: [f32; 3], limit: f32) -> Intersection<f32> {
        let ray = Ray::<f32>::new(V3::splat((), origin), V3::splat((), direction));
        let triangle = Triangle::new(corners[0], corners[1], corners[2]);
        intersect(&ray, &triangle.relative_to(ray.origin), limit)
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
