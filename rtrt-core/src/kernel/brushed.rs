//! Microfacets that are steeper along one direction than along another, as on brushed metal
//! (KHR_materials_anisotropy).
//!
//! ```text
//! D = 1 / (π αₜ α_b ((t·h / αₜ)² + (b·h / α_b)² + (n·h)²)²)
//! V = 1 / (2 ((n·l) |(αₜ t·v, α_b b·v, n·v)| + (n·v) |(αₜ t·l, α_b b·l, n·l)|))
//! αₜ = α + (1 − α) · strength²,   α_b = α
//! ```
//!
//! GGX for an ellipse of slopes (Burley, "Physically Based Shading at Disney", 2012; Heitz 2014). With strength 0 it
//! is the lobe of [`microfacet`](crate::kernel::microfacet).

use crate::kernel::microfacet::{LOBE_LIMIT, Response, schlick};
use crate::lane::{Lane, V3};
use crate::num::{TINY, clamp, flush, normalize, recip, rsqrt, sqrt};
use core::f32::consts::FRAC_1_PI;

/// Such facets, and where they are seen from.
#[derive(Clone, Copy)]
pub struct Brushed<L> {
    normal: V3<L>,
    tangent: V3<L>,
    bitangent: V3<L>,
    to_viewer: V3<L>,
    cosine: L,
    along: L,
    across: L,
    viewer_root: L,
}

impl<L: Lane> Brushed<L> {
    /// Facets of the width `alpha_squared`, wider along `tangent` by `strength`, 0 ..= 1, seen from `to_viewer`.
    /// Vectors have unit length; of the tangent, what is at a right angle to the normal counts.
    #[inline(always)]
    pub fn new(normal: V3<L>, tangent: V3<L>, to_viewer: V3<L>, alpha_squared: L, strength: L) -> Self {
        let bitangent = normalize(normal.cross(tangent));
        let tangent = bitangent.cross(normal);
        let across = sqrt(alpha_squared);
        let along = across + (across.broadcast(1.0) - across) * strength * strength;
        let cosine = clamp(normal.dot(to_viewer), 0.0, 1.0);
        let viewer_root =
            stretched(along * tangent.dot(to_viewer), across * bitangent.dot(to_viewer), cosine);
        Self { normal, tangent, bitangent, to_viewer, cosine, along, across, viewer_root }
    }

    /// As [`Microfacets::respond`](crate::kernel::microfacet::Microfacets::respond).
    #[inline(always)]
    pub fn respond(&self, to_light: V3<L>, cosine: L, strength: L) -> Response<L> {
        let one = cosine.broadcast(1.0);
        let half = normalize(to_light + self.to_viewer);
        let area = self.along * self.across;
        let x = self.tangent.dot(half) * self.across;
        let y = self.bitangent.dot(half) * self.along;
        let z = self.normal.dot(half).max(one.broadcast(0.0)) * area;
        // α⁴ times the sum of the squares of the slopes' shares.
        let spread = x * x + y * y + z * z;
        let root = stretched(
            self.along * self.tangent.dot(to_light),
            self.across * self.bitangent.dot(to_light),
            cosine,
        );
        let masking = cosine * self.viewer_root + self.cosine * root;
        let ratio = area * recip(spread);
        let lobe = ratio * ratio * area * cosine * recip(masking) * (0.5 * FRAC_1_PI);
        let lobe = lobe.min(one.broadcast(LOBE_LIMIT));
        let grazing = schlick(half.dot(self.to_viewer));
        Response {
            diffuse: flush(cosine * (one - strength * grazing) * FRAC_1_PI),
            specular: flush(lobe * (one - grazing)),
            grazing: flush(lobe * grazing),
        }
    }
}

/// The length of a vector.
#[inline(always)]
fn stretched<L: Lane>(x: L, y: L, z: L) -> L {
    let square = (x * x + y * y + z * z).max(x.broadcast(TINY));
    square * rsqrt(square)
}

/// The normal of the plane whose mirrored ray stands for those of a brushed surface: leaning from the normal
/// toward the viewer, across the direction along which facets are steeper (McAuley, "Rendering the World of Far Cry
/// 4", 2015, as the extension's notes have it).
///
/// ```text
/// mix(b × v × b, n, (1 − strength · (1 − roughness))⁴),   b = n × t
/// ```
#[inline(always)]
pub fn bent<L: Lane>(normal: V3<L>, tangent: V3<L>, to_viewer: V3<L>, roughness: L, strength: L) -> V3<L> {
    let one = strength.broadcast(1.0);
    let bitangent = normalize(normal.cross(tangent));
    let toward = normalize(bitangent.cross(to_viewer).cross(bitangent));
    let stays = one - strength * (one - roughness);
    let square = stays * stays;
    let share = square * square;
    normalize(toward.scale(one - share) + normal.scale(share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::microfacet::{Microfacets, alpha_squared};

    fn unit(v: [f32; 3]) -> V3<f32> {
        normalize(V3::splat((), v))
    }

    #[test]
    fn without_strength_it_is_the_round_lobe() {
        let (n, t) = (unit([0.0, 0.0, 1.0]), unit([0.3, 1.0, 0.5]));
        for roughness in [0.1, 0.4, 1.0] {
            for v in [[0.0, 0.0, 1.0], [0.4, -0.2, 0.5], [-1.0, 0.3, 0.2]].map(unit) {
                for l in [[0.1, 0.1, 1.0], [-0.3, 0.3, 0.4], [1.0, 0.0, 0.1]].map(unit) {
                    let width = alpha_squared(roughness, 0.0);
                    let round = Microfacets::new(n, v, width).respond(l, l.z, 1.0);
                    let brushed = Brushed::new(n, t, v, width, 0.0).respond(l, l.z, 1.0);
                    for (a, b) in [
                        (round.specular, brushed.specular),
                        (round.grazing, brushed.grazing),
                        (round.diffuse, brushed.diffuse),
                    ] {
                        assert!((a - b).abs() <= 2e-3 * a + 1e-6, "{roughness} {a} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn is_the_formula() {
        let (n, t, b) = (unit([0.0, 0.0, 1.0]), unit([1.0, 0.0, 0.0]), unit([0.0, 1.0, 0.0]));
        let (strength, width) = (0.7_f32, alpha_squared(0.3, 0.0));
        let across = 0.09_f64;
        let along = across + (1.0 - across) * f64::from(strength * strength);
        for v in [[0.1, 0.2, 1.0], [0.9, 0.1, 0.4], [0.0, -0.9, 0.3]].map(unit) {
            for l in [[0.2, -0.1, 1.0], [-0.8, 0.1, 0.5], [0.3, 0.9, 0.2]].map(unit) {
                let wide = |v: V3<f32>| v.lane(0).map(f64::from);
                let dot =
                    |a: V3<f32>, b: V3<f32>| wide(a).iter().zip(wide(b)).map(|(a, b)| a * b).sum::<f64>();
                let h = normalize(v + l);
                let sum = (dot(t, h) / along).powi(2) + (dot(b, h) / across).powi(2) + dot(n, h).powi(2);
                let distribution = 1.0 / (core::f64::consts::PI * along * across * sum * sum);
                let length = |w: V3<f32>| {
                    ((along * dot(t, w)).powi(2) + (across * dot(b, w)).powi(2) + dot(n, w).powi(2)).sqrt()
                };
                let visibility = 0.5 / (dot(n, l) * length(v) + dot(n, v) * length(l));
                let expected = distribution * visibility * dot(n, l);
                let got = Brushed::new(n, t, v, width, strength).respond(l, l.z, 1.0);
                let sum = f64::from(got.specular) + f64::from(got.grazing);
                assert!((sum - expected).abs() < 2e-3 * expected, "{sum} {expected}");
            }
        }
    }

    #[test]
    fn the_highlight_is_longer_along_the_tangent() {
        let (n, t) = (unit([0.0, 0.0, 1.0]), unit([1.0, 0.0, 0.0]));
        let facets = Brushed::new(n, t, n, alpha_squared(0.3, 0.0), 0.8);
        let at = |l| facets.respond(unit(l), unit(l).z, 1.0).specular;
        assert!(at([0.6, 0.0, 1.0]) > 5.0 * at([0.0, 0.6, 1.0]));
    }

    #[test]
    fn a_bent_normal_stays_where_nothing_is_brushed() {
        let (n, t, v) = (unit([0.0, 0.0, 1.0]), unit([1.0, 0.0, 0.0]), unit([0.5, 0.5, 1.0]));
        let at = |roughness, strength| bent(n, t, v, roughness, strength).lane(0);
        assert!((at(0.3, 0.0)[2] - 1.0).abs() < 1e-6 && (at(1.0, 1.0)[2] - 1.0).abs() < 1e-6);
        let [x, y, _] = at(0.1, 1.0);
        assert!(x > 0.2 && y.abs() < 1e-6);
    }
}
