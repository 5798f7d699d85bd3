//! A sphere: where a ray hits it, and its normal and texture coordinates there.
//!
//! In its own space every sphere is the ball of radius 1 around the origin; the matrix of its instance
//! places it and may make an ellipsoid of it. A sphere counts as a mesh of two triangles: 0 is where a
//! ray enters, 1 is where it leaves. So layers, masks, colored shadows and ties need no rule of their
//! own. The scene stores one mesh for all spheres, two triangles without area that span the ball's box,
//! so that stages that read corners and colors find some.
//!
//! A hit's `u` and `v` are octahedral coordinates of the point (see `octahedral`). The point computed
//! from them lies on the sphere as exactly as `f32` allows, however far away the camera is, and shadow
//! rays start there.

use crate::kernel::environment::octahedral;
use crate::kernel::ray::Ray;
use crate::kernel::slab::{RelativeBox, slab};
use crate::kernel::triangle::Intersection;
use crate::lane::{Lane, Select, V3};
use crate::num::{TINY, atan2, flush, normalize, recip, sqrt};
use core::ops::Mul;

/// Where a ray enters.
pub const ENTRY: u32 = 0;
/// Where a ray leaves.
pub(crate) const EXIT: u32 = 1;

/// How far off the sphere rays that leave it start, in radii: 2⁻¹⁹, beside what
/// [`offset`](crate::kernel::offset::offset) adds. A ray's way into the sphere's space is off by
/// some 2⁻²¹ of its radius where that is as large as the coordinates of the world, and
/// `offset` cannot know of that.
const APART: f32 = 1.0 / 524_288.0;

/// The intersection of a ray's line with the ball of radius 1.
#[derive(Clone, Copy)]
pub struct Chord<L: Lane> {
    /// The lanes whose line hits the ball.
    mask: L::Mask,
    /// The point of the line that is nearest to the center.
    nearest: V3<L>,
    /// The `t` of that point.
    middle: L,
    /// The distance in `t` from there to entry and exit.
    half: L,
    /// The interval of the ball's box.
    near: L,
    /// The other end.
    far: L,
}

impl<L: Lane> Chord<L> {
    /// The chord of a ray in the sphere's space.
    ///
    /// ```text
    /// middle  = −(o · d) / (d · d)
    /// nearest = o + middle · d
    /// half    = √((1 − nearest · nearest) / (d · d))
    /// ```
    ///
    /// The quadratic formula with the discriminant taken from the nearest point rather than from
    /// `(o · d)² − (d · d) (o · o − 1)`, of which little is left where the sphere is small and far
    /// away (Hearn and Baker, as given by Haines, Günther and Akenine-Möller, "Precision
    /// Improvements for Ray/Sphere Intersection", Ray Tracing Gems, chapter 7). Their other
    /// improvement, which finds the nearer root from `o · o − 1`, is left out: in units of the
    /// radius that difference is no more exact than this one.
    ///
    /// Directions are meant to have lengths within 2⁻⁴⁵ ..= 2⁴⁵ radii. NaN
    /// meets nothing.
    #[inline(always)]
    pub fn new<O: Lane>(ray: &Ray<L, O>) -> Self
    where
        L: Mul<O, Output = L>,
    {
        let (d, o) = (ray.direction, ray.origin);
        let one = d.x.broadcast(1.0);
        let origin = V3 { x: one * o.x, y: one * o.y, z: one * o.z };
        let inverse = recip(flush(d.dot(d)));
        let middle = flush(-origin.dot(d)) * inverse;
        let nearest = origin + d.scale(middle);
        let left = one - nearest.dot(nearest);
        let half = sqrt(left * inverse);
        let (near, far) = slab(ray, &RelativeBox::new(o, &[-1.0; 3], &[1.0; 3]));
        let mask = left.ge(one.broadcast(0.0)) & near.le(far);
        Self { mask, nearest, middle, half, near, far }
    }

    /// Where the ray enters, or leaves, at some 2⁻⁹⁰ < `t` ≤ `limit`.
    ///
    /// `t` is clamped into the interval of the ball's box, as that of a triangle is (see
    /// [`intersect`](crate::kernel::triangle::intersect)), so that culling by boxes loses no hit.
    #[inline(always)]
    pub fn side(&self, ray_direction: V3<L>, side: u32, limit: L) -> Intersection<L> {
        let half = if side == ENTRY { -self.half } else { self.half };
        let t = (self.middle + half).min(self.far).max(self.near);
        let mask = self.mask & t.gt(t.broadcast(TINY)) & t.le(limit);
        let [u, v] = octahedral(self.nearest + ray_direction.scale(half));
        Intersection { mask, t, u: flush(u), v: flush(v) }
    }
}

/// The point of the sphere at octahedral coordinates: also its normal there.
#[inline(always)]
pub fn point<L: Lane>(u: L, v: L) -> V3<L> {
    let (zero, one) = (u.broadcast(0.0), u.broadcast(1.0));
    let (x, z) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let y = one - x.abs() - z.abs();
    let below = y.lt(zero);
    let unfolded = |a: L, b: L| {
        let over = one - b.abs();
        below.select(a.lt(zero).select(-over, over), a)
    };
    normalize(V3 { x: unfolded(x, z), y, z: unfolded(z, x) })
}

/// Where a ray starts that leaves the sphere at a point of it, in the sphere's space; outside
/// where rays enter.
#[inline(always)]
pub fn start<L: Lane>(point: V3<L>, enters: L::Mask) -> V3<L> {
    let one = point.x.broadcast(1.0);
    point.scale(enters.select(one + APART, one - APART))
}

/// Texture coordinates of a point of the sphere: longitude and latitude. The middle of a
/// texture is at `+z`, its right edge, and its left one, at `−z`, its upper edge at `+y`; `+x`
/// is to the right of the middle.
#[inline(always)]
pub(crate) fn longitude_and_latitude<L: Lane>(point: V3<L>) -> [L; 2] {
    let (around, down) = (atan2(point.x, point.z), atan2(ring(point), point.y));
    [flush(around * (0.5 * core::f32::consts::FRAC_1_PI) + 0.5), flush(down * core::f32::consts::FRAC_1_PI)]
}

/// The distance of a point of the sphere from its axis: the cosine of its latitude.
#[inline(always)]
fn ring<L: Lane>(point: V3<L>) -> L {
    sqrt(point.x * point.x + point.z * point.z)
}

/// The density of texture coordinates at a point, the share of the texture on a unit of area:
/// `1 / (2 π² cos(latitude))`.
#[inline(always)]
pub(crate) fn density<L: Lane>(point: V3<L>) -> L {
    const SHARE: f32 = 0.5 * core::f32::consts::FRAC_1_PI * core::f32::consts::FRAC_1_PI;
    // At the poles a texture is crowded without limit; its coarsest level serves there.
    const POLE: f32 = 1.0 / 4096.0;
    recip(ring(point).max(point.x.broadcast(POLE))) * SHARE
}

/// Two directions along the surface at right angles, of length 1, whose cross product is the
/// point (Duff and others, "Building an Orthonormal Basis, Revisited", 2017).
#[inline(always)]
pub fn tangents<L: Lane>(point: V3<L>) -> [V3<L>; 2] {
    let V3 { x, y, z } = point;
    let sign = z.broadcast(1.0).flip_sign(z.sign_bit());
    let a = -recip(sign + z);
    let b = x * y * a;
    [V3 { x: sign * x * x * a + 1.0, y: sign * b, z: -(sign * x) }, V3 { x: b, y: sign + y * y * a, z: -y }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray<f32> {
        Ray::new(V3::splat((), origin), V3::splat((), direction))
    }

    /// Numbers within −1 .. 1 that look random.
    fn random(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    #[test]
    fn rays_enter_and_leave() {
        let through = ray([0.0, 0.0, 4.0], [0.0, 0.0, -2.0]);
        let chord = Chord::new(&through);
        let [entry, exit] = [ENTRY, EXIT].map(|side| chord.side(through.direction, side, 9.0));
        assert!(entry.mask && exit.mask);
        assert!((entry.t - 1.5).abs() < 1e-6 && (exit.t - 2.5).abs() < 1e-6);
        assert!(!chord.side(through.direction, EXIT, 2.0).mask);
        let within = ray([0.0, 0.25, 0.0], [0.0, 1.0, 0.0]);
        let chord = Chord::new(&within);
        assert!(!chord.side(within.direction, ENTRY, 9.0).mask);
        assert!((chord.side(within.direction, EXIT, 9.0).t - 0.75).abs() < 1e-6);
        let inside = ray([0.999, 0.0, 4.0], [0.0, 0.0, -1.0]);
        assert!(Chord::new(&inside).side(inside.direction, ENTRY, 9.0).mask);
        for past in [ray([1.1, 0.0, 4.0], [0.0, 0.0, -1.0]), ray([0.0, 0.0, 4.0], [f32::NAN, 0.0, -1.0])] {
            assert!(!Chord::new(&past).side(past.direction, ENTRY, 9.0).mask);
        }
    }

    #[test]
    fn meets_what_f64_meets() {
        let mut seed = 1;
        let (mut met, mut missed) = (0, 0);
        for i in 0..20_000 {
            let far = [2.0, 30.0, 1000.0][i % 3];
            let mut point = || [random(&mut seed), random(&mut seed), random(&mut seed)];
            let (from, to) = (point().map(|c| c * far), point().map(|c| c * 1.2));
            let ray = ray(from, [to[0] - from[0], to[1] - from[1], to[2] - from[2]]);
            let [o, d] = [from, ray.direction.lane(0)].map(|v| DVec3::from(v.map(f64::from)));
            let nearest = o - d * (o.dot(d) / d.length_squared());
            let left = 1.0 - nearest.length_squared();
            // What a rounding of the start makes of the discriminant.
            let doubt = 1e-6 * f64::from(far);
            let chord = Chord::new(&ray);
            for side in [ENTRY, EXIT] {
                let found = chord.side(ray.direction, side, f32::MAX);
                let half = libm::sqrt(left.max(0.0) / d.length_squared()) * (2.0 * f64::from(side) - 1.0);
                let t = half - o.dot(d) / d.length_squared();
                if left < -doubt || t < -doubt {
                    missed += 1;
                    assert!(!found.mask, "{o} {d}");
                } else if left > 2.0 * doubt && t > doubt {
                    met += 1;
                    assert!(found.mask, "{o} {d}");
                    let off = (f64::from(found.t) - t).abs() * d.length();
                    assert!(off < 2.0 * doubt / libm::sqrt(left), "{o} {d}: {off}");
                    let place = point_of(&found);
                    assert!((place - (o + d * t)).length() < 4.0 * doubt / libm::sqrt(left), "{o} {d}");
                }
            }
        }
        assert!(met > 9000 && missed > 9000, "{met} {missed}");
    }

    fn point_of(found: &Intersection<f32>) -> DVec3 {
        DVec3::from(point(found.u, found.v).lane(0).map(f64::from))
    }

    #[test]
    fn rays_that_leave_do_not_come_back() {
        let mut seed = 7;
        for _ in 0..20_000 {
            let mut direction = || V3::splat((), [random(&mut seed), random(&mut seed), random(&mut seed)]);
            let normal = normalize(direction());
            let [u, v] = octahedral(normal);
            let (normal, way) = (point(u, v), direction());
            for side in [ENTRY, EXIT] {
                // Out of the surface on this side.
                let up = if side == ENTRY { normal } else { -normal };
                let way = if way.dot(up) < 0.0 { -way } else { way };
                let ray = Ray::new(start(normal, side == ENTRY), way);
                let met = [ENTRY, EXIT].map(|s| Chord::new(&ray).side(way, s, 1e-4).mask);
                assert!(side == EXIT || met == [false; 2], "{:?} {:?}", normal.lane(0), way.lane(0));
                assert!(!met[0]);
            }
        }
    }

    #[test]
    fn places_on_the_sphere_are_what_they_are_called() {
        let at = |p: [f32; 3]| longitude_and_latitude(V3::<f32>::splat((), p));
        assert_eq!(at([0.0, 0.0, 1.0]), [0.5, 0.5]);
        assert_eq!(at([1.0, 0.0, 0.0]), [0.75, 0.5]);
        assert_eq!(at([0.0, 1.0, 0.0])[1], 0.0);
        assert_eq!(at([0.0, -1.0, 0.0])[1], 1.0);
        for p in [[0.6, 0.0, 0.8], [0.0, 0.6, -0.8], [-0.48, -0.6, 0.64], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]] {
            let n = V3::splat((), p);
            let [u, v] = octahedral(n);
            let again = point(u, v);
            let [a, b]: [V3<f32>; 2] = tangents(n);
            let normal = a.cross(b);
            for ((p, q), r) in p.into_iter().zip(again.lane(0)).zip(normal.lane(0)) {
                assert!((p - q).abs() < 1e-6 && (p - r).abs() < 1e-6, "{p} {q} {r}");
            }
            assert!((a.dot(a) - 1.0).abs() < 1e-6 && (b.dot(b) - 1.0).abs() < 1e-6);
        }
    }
}
