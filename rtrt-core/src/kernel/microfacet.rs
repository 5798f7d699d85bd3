//! How a surface of microfacets answers one light: the specular lobe of glTF's metallic-roughness model.
//!
//! ```text
//! f = D · V · F                         glTF 2.0, Appendix B
//!
//! D = α² / (π ((n·h)² (α² − 1) + 1)²)                            GGX (Trowbridge and Reitz 1975; Walter et al. 2007)
//! V = 1 / (2 ((n·l) √((n·v)² (1 − α²) + α²) + (n·v) √((n·l)² (1 − α²) + α²)))    Smith, height-correlated (Heitz 2014)
//! F = F₀ + (F₉₀ − F₀) (1 − v·h)⁵                                 Schlick 1994
//! h = (l + v) / |l + v|,   α = roughness²
//! ```
//!
//! What is not mirrored and not metal goes on to the diffuse color, `(1 − F) · color / π` (Lambert). `F` depends
//! on the material's colors, the rest does not: what a light gives is summed in parts that colors multiply
//! afterwards (see [`Response`]).

use crate::lane::{Lane, Mask, Select, V3};
use crate::num::{clamp, flush, normalize, recip, sqrt};
use core::f32::consts::FRAC_1_PI;

/// The least α², 2⁻¹⁸: a roughness of 0.044. A point light on a smoother surface would be a highlight
/// without size, whose peak `1/(πα²)` has no bound.
pub const LEAST_ALPHA_SQUARED: f32 = 1.0 / 262_144.0;

/// The largest `D · V · (n·l)`, 2¹⁶: at grazing angles the peak of the smoothest lobe goes beyond. Sums of
/// the brightest lights stay finite (see [`LIGHT_LIMIT`](crate::layout::LIGHT_LIMIT)).
pub const LOBE_LIMIT: f32 = 65_536.0;

/// α² of a surface of this roughness, 0 ..= 1, whose normals vary by `variance` within a ray's footprint (see
/// [`variance`](crate::kernel::variance));
/// see [`crate::kernel::variance`].
#[inline(always)]
pub fn alpha_squared<L: Lane>(roughness: L, variance: L) -> L {
    let alpha = roughness * roughness;
    clamp(alpha * alpha + variance, LEAST_ALPHA_SQUARED, 1.0)
}

/// The roughness of the lobe whose α² is that of a surface of this roughness whose normals vary.
#[inline(always)]
pub fn widened<L: Lane>(roughness: L, variance: L) -> L {
    let varies = variance.gt(variance.broadcast(0.0));
    if !varies.any() {
        return roughness;
    }
    varies.select(sqrt(sqrt(alpha_squared(roughness, variance))), roughness)
}

/// Lambert's cosine between unit vectors; 0 for a light behind the surface, and where it is
/// too small to count on every device (see [`flush`]).
#[inline(always)]
pub fn lambert<L: Lane>(normal: V3<L>, to_light: V3<L>) -> L {
    let cosine = normal.dot(to_light);
    flush(cosine.max(cosine.broadcast(0.0)))
}

/// `(1 − cosine)⁵`: the share of `F₉₀ − F₀` in Schlick's approximation. 0 for a cosine of 1, 1 for 0 or less.
#[inline(always)]
pub fn schlick<L: Lane>(cosine: L) -> L {
    let x = cosine.broadcast(1.0) - clamp(cosine, 0.0, 1.0);
    let square = x * x;
    flush(square * square * x)
}

/// A surface of microfacets, and where it is seen from.
#[derive(Clone, Copy)]
pub struct Microfacets<L> {
    /// Unit length.
    normal: V3<L>,
    /// Unit length.
    to_viewer: V3<L>,
    /// Of normal and viewer, 0 ..= 1.
    cosine: L,
    alpha_squared: L,
    /// `√((n·v)² (1 − α²) + α²)`.
    viewer_root: L,
}

/// What light of unit strength, at its cosine, gives; see [`Lit`](crate::layout::Lit).
#[derive(Clone, Copy)]
pub struct Response<L> {
    /// `(n·l) · (1 − s · (1 − v·h)⁵) / π`, where a surface that is no metal mirrors the share `s` at grazing angles:
    /// the diffuse color, and 1 − F₀, multiply it. (Exact for `s` = 1; else `s` stands for (s − F₀) / (1 − F₀).)
    pub diffuse: L,
    /// `D · V · (n·l) · (1 − (1 − v·h)⁵)`: `F₀` multiplies it.
    pub specular: L,
    /// `D · V · (n·l) · (1 − v·h)⁵`: `F₉₀` multiplies it.
    pub grazing: L,
}

impl<L: Lane> Microfacets<L> {
    /// A surface with this normal, seen from this direction, both of unit length. A normal that faces away
    /// from the viewer counts as one at a right angle.
    #[inline(always)]
    pub fn new(normal: V3<L>, to_viewer: V3<L>, alpha_squared: L) -> Self {
        let cosine = clamp(normal.dot(to_viewer), 0.0, 1.0);
        let viewer_root = root(cosine, alpha_squared);
        Self { normal, to_viewer, cosine, alpha_squared, viewer_root }
    }

    /// The answer to light from this direction, of unit length, at the cosine `n·l`. A surface that is no metal
    /// mirrors the share `strength` at grazing angles.
    ///
    /// `n·h` is near 1 where a lobe is, and 1 − (n·h)² has few bits there; with `x = |n − h|²` it is
    /// `x − x²/4`, to the last bits of unit vectors.
    #[inline(always)]
    pub fn respond(&self, to_light: V3<L>, cosine: L, strength: L) -> Response<L> {
        let one = cosine.broadcast(1.0);
        let half = normalize(to_light + self.to_viewer);
        let apart = self.normal - half;
        // A half vector below the horizon, of a normal that faces away, counts as one at a right angle.
        let x = apart.dot(apart).min(one.broadcast(2.0));
        let sine_squared = x - x * x * 0.25;
        let spread = self.alpha_squared + sine_squared * (one - self.alpha_squared);
        let masking = cosine * self.viewer_root + self.cosine * root(cosine, self.alpha_squared);
        let lobe = self.alpha_squared * cosine * recip(spread * spread * masking) * (0.5 * FRAC_1_PI);
        let lobe = lobe.min(lobe.broadcast(LOBE_LIMIT));
        let grazing = schlick(half.dot(self.to_viewer));
        let head_on = one - grazing;
        Response {
            diffuse: flush(cosine * (one - strength * grazing) * FRAC_1_PI),
            specular: flush(lobe * head_on),
            grazing: flush(lobe * grazing),
        }
    }
}

/// `√(cosine² (1 − α²) + α²)`.
#[inline(always)]
fn root<L: Lane>(cosine: L, alpha_squared: L) -> L {
    let square = cosine * cosine;
    sqrt(alpha_squared + (square - square * alpha_squared))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    fn unit(v: [f64; 3]) -> [f64; 3] {
        let length = dot(v, v).sqrt();
        v.map(|c| c / length)
    }

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    fn single(v: [f64; 3]) -> V3<f32> {
        V3::splat((), v.map(|c| c as f32))
    }

    /// The lobe and `(1 − v·h)⁵` as Appendix B writes them, with `n` = +z.
    fn exact(l: [f64; 3], v: [f64; 3], a2: f64) -> [f64; 2] {
        let h = unit([l[0] + v[0], l[1] + v[1], l[2] + v[2]]);
        let spread = h[2] * h[2] * (a2 - 1.0) + 1.0;
        let root = |c: f64| (c * c * (1.0 - a2) + a2).sqrt();
        let lobe = a2 / (PI * spread * spread) * 0.5 / (l[2] * root(v[2]) + v[2] * root(l[2]));
        [lobe * l[2], (1.0 - dot(v, h)).powi(5)]
    }

    fn respond(l: [f64; 3], v: [f64; 3], a2: f32) -> Response<f32> {
        let surface = Microfacets::new(V3::splat((), [0.0, 0.0, 1.0]), single(v), a2);
        surface.respond(single(l), l[2] as f32, 1.0)
    }

    /// Directions of the upper half.
    fn directions() -> impl Iterator<Item = [f64; 3]> {
        (0..60_u32).map(|i| {
            let (turn, z) = (f64::from(i) * 2.399_963, (f64::from(i) + 0.5) / 60.0);
            let r = (1.0 - z * z).sqrt();
            [r * turn.cos(), r * turn.sin(), z]
        })
    }

    #[test]
    fn is_the_formula() {
        for roughness in [0.05_f32, 0.1, 0.3, 0.6, 1.0] {
            let a2 = alpha_squared(roughness, 0.0);
            for l in directions() {
                for v in directions().chain([[-l[0], -l[1], l[2]]]) {
                    let [lobe, fresnel] = exact(l, v, a2.into());
                    let lobe = lobe.min(LOBE_LIMIT.into());
                    let got = respond(l, v, a2);
                    let sum = f64::from(got.specular) + f64::from(got.grazing);
                    // Of the smoothest lobes, in the last bits of unit vectors.
                    assert!((sum - lobe).abs() <= lobe * 1e-3 + 1e-9, "{roughness} {l:?} {v:?} {sum} {lobe}");
                    let diffuse = l[2] * (1.0 - fresnel) / PI;
                    assert!((f64::from(got.diffuse) - diffuse).abs() < 1e-5);
                    assert!((f64::from(got.grazing) - lobe * fresnel).abs() <= lobe * 1e-3 + 1e-9);
                }
            }
        }
    }

    #[test]
    fn light_and_viewer_may_be_swapped() {
        for l in directions() {
            for v in directions() {
                let (there, back) = (respond(l, v, 0.09), respond(v, l, 0.09));
                // Both carry the cosine of their light.
                let (a, b) = (f64::from(there.specular) * v[2], f64::from(back.specular) * l[2]);
                assert!((a - b).abs() <= 1e-4 * a.max(b));
            }
        }
    }

    #[test]
    fn a_matte_surface_spreads_and_a_smooth_one_peaks() {
        let up = [0.0, 0.0, 1.0];
        // At α = 1: 1/π · 1/4; at the least α²: 1/(π α²) · 1/4.
        let matte = respond(up, up, alpha_squared(1.0, 0.0)).specular;
        assert!((matte - 0.25 * FRAC_1_PI).abs() < 1e-6);
        let smooth = respond(up, up, alpha_squared(0.0, 0.0)).specular;
        assert!((smooth - 0.25 * FRAC_1_PI * 262_144.0).abs() < 1.0);
        assert_eq!(alpha_squared(0.0_f32, 0.0), LEAST_ALPHA_SQUARED);
        assert_eq!([alpha_squared(1.0_f32, 0.5), alpha_squared(0.0, f32::NAN)], [1.0; 2]);
    }

    #[test]
    fn at_grazing_angles_everything_is_mirrored() {
        assert_eq!([schlick(1.0_f32), schlick(0.0), schlick(-0.5)], [0.0, 1.0, 1.0]);
        assert!((schlick(0.5_f32) - 1.0 / 32.0).abs() < 1e-7);
        let (l, v) = (unit([1.0, 0.0, 1e-4]), unit([-1.0, 0.0, 1e-4]));
        let got = respond(l, v, 0.25);
        assert!(got.specular < 1e-3 * got.grazing && got.diffuse < 1e-7);
    }

    #[test]
    fn no_more_comes_back_than_arrives_and_none_from_below() {
        // The lobe over all directions of light, where everything is mirrored.
        for (v, a2) in [(0.3, 0.1_f32), (0.9, 0.5), (0.05, 1.0), (1.0, 0.02)] {
            let v = [f64::sqrt(1.0 - v * v), 0.0, v];
            const STEPS: u32 = 300;
            let sum: f64 = (0..STEPS * STEPS)
                .map(|i| {
                    let [z, turn] = [i % STEPS, i / STEPS].map(|s| (f64::from(s) + 0.5) / f64::from(STEPS));
                    let (s, c) = (2.0 * PI * turn).sin_cos();
                    let r = (1.0 - z * z).sqrt();
                    let got = respond([r * c, r * s, z], v, a2);
                    f64::from(got.specular + got.grazing) * 2.0 * PI / f64::from(STEPS * STEPS)
                })
                .sum();
            assert!(sum > 0.3 && sum < 1.0 + 1e-3, "{v:?} {a2} {sum}");
        }
        assert_eq!(respond([1.0, 0.0, 0.0], [-0.6, 0.0, 0.8], 0.2).specular, 0.0);
        let down = V3::splat((), [0.0, 0.0, -1.0]);
        assert_eq!(lambert(V3::<f32>::splat((), [0.0, 0.0, 1.0]), down), 0.0);
        let behind = respond(unit([0.1, 0.0, 1.0]), unit([0.0, 0.3, -1.0]), 0.2);
        assert!(behind.specular.is_finite() && behind.grazing.is_finite());
    }
}
