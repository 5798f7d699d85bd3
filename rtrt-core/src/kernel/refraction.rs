//! How light turns where it enters a body and where it leaves it.
//!
//! Rays go on straight: what they meet next is found by the lists of their blocks. Only the environment, which is
//! behind everything, is looked up where light comes from that the body has turned. So what is known of a body are the
//! two surfaces that a straight ray meets; the turned one would leave it somewhere else.

use crate::lane::{Lane, V3};
use crate::num::{clamp, flush, flush3, normalize, sqrt};

/// The direction, of unit length, of light on the other side of a surface (Snell's law). `direction` and `normal` have
/// unit length, and the normal is on the side that light comes from.
///
/// ```text
/// η d + (η c − √(1 − η² (1 − c²))) n,    c = −d·n
/// ```
///
/// `ratio`, η, is the index of refraction before the surface over the one behind it. Light that would be mirrored
/// inside, because no angle is large enough, goes along the surface.
#[inline(always)]
pub fn refracted<L: Lane>(direction: V3<L>, normal: V3<L>, ratio: L) -> V3<L> {
    let one = ratio.broadcast(1.0);
    let cosine = clamp(-direction.dot(normal), 0.0, 1.0);
    let square = one - flush(ratio * ratio * (one - cosine * cosine));
    let along = ratio * cosine - sqrt(square.max(one.broadcast(0.0)));
    normalize(flush3(direction.scale(ratio) + normal.scale(along)))
}

/// The normal, of unit length, of the surface at which turned light leaves a body that it has entered at one with the
/// normal `entry`, where a straight ray leaves it at one with the normal `exit`; both have unit length and face the ray.
///
/// ```text
/// entry, turned toward exit by A',    sin(A'/2) = sin(A/2) / ior
/// ```
///
/// with the angle `A` between the two. Derived here so that a ball and a pane turn light as they do: of a ball that a ray
/// meets at the angle `i`, `A = 2i`, and the turned ray leaves it where the normals differ by `2r`, with
/// `sin r = sin i / ior`. Of a pane both are 0. Of other bodies it is an estimate.
#[inline(always)]
pub fn exit_normal<L: Lane>(entry: V3<L>, exit: V3<L>, inverse_ior: L) -> V3<L> {
    let one = inverse_ior.broadcast(1.0);
    let apart = exit - entry;
    // sin²(A/2) is a quarter of the square of the chord.
    let square = clamp(apart.dot(apart) * 0.25, 0.0, 1.0) * inverse_ior * inverse_ior;
    let square = flush(square);
    let aside = normalize(flush3(apart - entry.scale(entry.dot(apart))));
    let sine = sqrt(square * (one - square)) * 2.0;
    normalize(flush3(entry.scale(one - square * 2.0) + aside.scale(sine)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vector(v: [f64; 3]) -> V3<f32> {
        V3::splat((), v.map(|c| c as f32))
    }

    /// The angle between two unit vectors, degrees.
    fn apart(a: V3<f32>, b: V3<f32>) -> f64 {
        let dot = |a: V3<f32>, b: V3<f32>| f64::from(a.dot(b));
        let difference = a - b;
        (2.0 * (dot(difference, difference).sqrt() * 0.5).min(1.0).asin()).to_degrees()
    }

    #[test]
    fn sines_are_as_the_indices_say() {
        for ior in [1.0_f64, 1.33, 1.5, 2.4] {
            for degrees in [0.0_f64, 10.0, 45.0, 80.0] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let d = refracted(vector([sin, 0.0, -cos]), vector([0.0, 0.0, 1.0]), (1.0 / ior) as f32);
                assert!((f64::from(d.x) - sin / ior).abs() < 1e-5 && d.y == 0.0, "{ior} {degrees} {}", d.x);
                assert!((f64::from(d.dot(d)) - 1.0).abs() < 1e-5 && d.z < 0.0);
            }
        }
        // Beyond the critical angle, 41.8°.
        let (sin, cos) = 60.0_f64.to_radians().sin_cos();
        let d = refracted(vector([sin, 0.0, -cos]), vector([0.0, 0.0, 1.0]), 1.5);
        assert!((d.x - 1.0).abs() < 1e-5 && d.z.abs() < 1e-5);
    }

    /// The angle by which a body turns light that comes along −z.
    fn turned(entry: V3<f32>, exit: V3<f32>, ior: f64) -> f64 {
        let straight = vector([0.0, 0.0, -1.0]);
        let inside = refracted(straight, entry, (1.0 / ior) as f32);
        apart(straight, refracted(inside, exit_normal(entry, exit, (1.0 / ior) as f32), ior as f32))
    }

    #[test]
    fn a_ball_turns_light_as_a_ball_does_and_a_pane_not_at_all() {
        for ior in [1.33_f64, 1.5, 2.4] {
            for degrees in [1.0_f64, 15.0, 30.0, 60.0, 80.0] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                // Of the far side, the normal that faces the ray.
                let (entry, exit) = (vector([sin, 0.0, cos]), vector([-sin, 0.0, cos]));
                let exact = 2.0 * (degrees - (sin / ior).asin().to_degrees());
                let found = turned(entry, exit, ior);
                assert!((found - exact).abs() < 0.1, "{ior} {degrees}: {found} {exact}");
                assert!(turned(entry, entry, ior) < 0.05, "{ior} {degrees}");
            }
        }
    }
}
