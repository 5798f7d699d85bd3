//! Cloth: light that fibers scatter at grazing angles (KHR_materials_sheen).
//!
//! ```text
//! f = color · D · V
//!
//! D = (2 + 1/α) · (sin θₕ)^(1/α) / 2π           "Charlie"
//! V = 1 / ((1 + Λ(n·v) + Λ(n·l)) · 4 (n·v) (n·l)), at most 1
//! α = roughness²
//! ```
//!
//! Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF", 2017; `Λ` is their fit. What a sheen scatters does
//! not reach the surface below: that keeps the share `1 − max(color) · E(n·v)` (the albedo scaling of the
//! extension, by the viewer's cosine alone, which the extension allows).

use crate::lane::{Lane, Select, V3};
use crate::num::{TINY, clamp, exp2, flush, log2, normalize, recip};
use core::f32::consts::{FRAC_1_PI, LOG2_E};

/// The least roughness. Smoother fibers scatter nothing that could be seen.
const LEAST_ROUGHNESS: f32 = 0.07;

/// The least cosine, by which light and viewer are divided.
const LEAST_COSINE: f32 = 1.0 / 128.0;

/// A sheen, and where it is seen from.
#[derive(Clone, Copy)]
pub struct Sheen<L> {
    normal: V3<L>,
    to_viewer: V3<L>,
    /// Of normal and viewer, at least 1/128.
    cosine: L,
    alpha: L,
    /// 1/α.
    inverse: L,
    /// `Λ(n·v)`.
    shadowing: L,
}

impl<L: Lane> Sheen<L> {
    /// A sheen of this roughness, 0 ..= 1, on a surface with this normal, seen from this direction, both of unit
    /// length.
    #[inline(always)]
    pub fn new(normal: V3<L>, to_viewer: V3<L>, roughness: L) -> Self {
        let roughness = clamp(roughness, LEAST_ROUGHNESS, 1.0);
        let alpha = roughness * roughness;
        let cosine = clamp(normal.dot(to_viewer), LEAST_COSINE, 1.0);
        Self { normal, to_viewer, cosine, alpha, inverse: recip(alpha), shadowing: shadowing(cosine, alpha) }
    }

    /// `D · V · (n·l)` for light from this direction, of unit length, at this cosine.
    #[inline(always)]
    pub fn respond(&self, to_light: V3<L>, cosine: L) -> L {
        let one = cosine.broadcast(1.0);
        let half = normalize(to_light + self.to_viewer);
        let apart = self.normal - half;
        let x = apart.dot(apart).min(one.broadcast(2.0));
        // (sin θₕ)^(1/α) from sin², as in a microfacet.
        let sine_squared = (x - x * x * 0.25).max(one.broadcast(TINY));
        let power = exp2(log2(sine_squared) * self.inverse * 0.5);
        let distribution = (self.inverse + 2.0) * power * (0.5 * FRAC_1_PI);
        let lit = clamp(cosine, LEAST_COSINE, 1.0);
        let masking = (one + self.shadowing + shadowing(lit, self.alpha)) * self.cosine * lit * 4.0;
        let visibility = recip(masking).min(one);
        flush(distribution * visibility * cosine)
    }

    /// The share of light from all around that a white sheen scatters toward the viewer: see [`albedo`].
    #[inline(always)]
    pub fn albedo(&self, roughness: L) -> L {
        albedo(self.cosine, roughness)
    }
}

/// Estevez and Kulla's `Λ`, with their numbers for α = 0 and α = 1, mixed by (1 − α)².
#[inline(always)]
fn shadowing<L: Lane>(cosine: L, alpha: L) -> L {
    let one = cosine.broadcast(1.0);
    let rest = one - alpha;
    let share = rest * rest;
    let mixed = |rough: f32, smooth: f32| share * (smooth - rough) + rough;
    let (a, b, c) = (mixed(21.5473, 25.3245), mixed(3.829_87, 3.324_35), mixed(0.198_23, 0.168_01));
    let (d, e) = (mixed(-1.977_6, -1.273_93), mixed(-4.320_54, -4.859_67));
    let numbers = [a, b, c, d, e];
    let is_flat = cosine.lt(one.broadcast(0.5));
    let x = is_flat.select(cosine, (one - cosine).max(one.broadcast(TINY)));
    let near = exponent(x, numbers);
    exp2(is_flat.select(near, exponent(one.broadcast(0.5), numbers) * 2.0 - near) * LOG2_E)
}

/// The exponent of `Λ` at a cosine, more than 0.
#[inline(always)]
fn exponent<L: Lane>(x: L, [a, b, c, d, e]: [L; 5]) -> L {
    a * recip(b * exp2(log2(x) * c) + 1.0) + d * x + e
}

/// `∫ D V (n·l) dl`: the share of light from all around that a white sheen of this roughness scatters toward the
/// viewer, 0 ..= 1.
///
/// ```text
/// 2 ^ P(x, 0.1 / (roughness + 0.1)),   x = n·v, at least 0.05          within 0.02
/// ```
///
/// a polynomial of degree 3, derived here as that of [`split_sum`](crate::kernel::split_sum).
#[inline(always)]
pub fn albedo<L: Lane>(cosine: L, roughness: L) -> L {
    let x = clamp(cosine, 0.05, 1.0);
    let y = recip(clamp(roughness, LEAST_ROUGHNESS, 1.0) + 0.1) * 0.1;
    let mut p = x * -0.583_153_8 - y * 19.748_09 + 2.732_866;
    p = p * x + ((y * -58.219_07 - 0.770_666_5) * y - 1.983_658);
    p = p * x + (((y * -28.936_05 + 34.206_58) * y - 8.793_357) * y + 0.218_104_9);
    exp2(p).min(x.broadcast(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    fn exact_shadowing(cosine: f64, alpha: f64) -> f64 {
        let share = (1.0 - alpha).powi(2);
        let mixed = |rough: f64, smooth: f64| share * smooth + (1.0 - share) * rough;
        let [a, b, c] = [mixed(21.5473, 25.3245), mixed(3.82987, 3.32435), mixed(0.19823, 0.16801)];
        let [d, e] = [mixed(-1.9776, -1.27393), mixed(-4.32054, -4.85967)];
        let at = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
        if cosine < 0.5 { at(cosine).exp() } else { (2.0 * at(0.5) - at(1.0 - cosine)).exp() }
    }

    /// The formula, with n = +z.
    fn exact(l: [f64; 3], v: [f64; 3], roughness: f64) -> f64 {
        let alpha = roughness * roughness;
        let h = [l[0] + v[0], l[1] + v[1], l[2] + v[2]];
        let cos2 = h[2] * h[2] / (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
        let distribution = (2.0 + 1.0 / alpha) * (1.0 - cos2).powf(0.5 / alpha) / (2.0 * PI);
        let masking = 1.0 + exact_shadowing(v[2], alpha) + exact_shadowing(l[2], alpha);
        distribution * (1.0 / (masking * 4.0 * v[2] * l[2])).min(1.0) * l[2]
    }

    fn at(z: f64, turn: f64) -> [f64; 3] {
        let r = (1.0 - z * z).sqrt();
        [r * turn.cos(), r * turn.sin(), z]
    }

    #[test]
    fn is_the_formula() {
        let up = V3::<f32>::splat((), [0.0, 0.0, 1.0]);
        let single = |v: [f64; 3]| V3::<f32>::splat((), v.map(|c| c as f32));
        for roughness in [0.1_f32, 0.3, 0.6, 1.0] {
            for v in [at(0.9, 0.0), at(0.4, 1.0), at(0.05, 2.0)] {
                let sheen = Sheen::new(up, single(v), roughness);
                for i in 1..20_u32 {
                    let l = at(f64::from(i) / 20.0, f64::from(i) * 0.7);
                    let (got, expected) =
                        (f64::from(sheen.respond(single(l), l[2] as f32)), exact(l, v, roughness.into()));
                    assert!((got - expected).abs() < 2e-3 * expected + 1e-6, "{roughness} {got} {expected}");
                }
            }
        }
    }

    #[test]
    fn the_albedo_is_within_its_error() {
        const STEPS: u32 = 100;
        for roughness in [0.1_f32, 0.25, 0.5, 0.75, 1.0] {
            for x in [0.05_f32, 0.1, 0.3, 0.6, 1.0] {
                let v = at(x.into(), 0.0);
                let sum: f64 = (0..STEPS * STEPS)
                    .map(|i| {
                        let [s, turn] =
                            [i % STEPS, i / STEPS].map(|i| (f64::from(i) + 0.5) / f64::from(STEPS));
                        exact(at(s * s, PI * turn), v, roughness.into()) * 2.0 * s
                    })
                    .sum();
                let expected = (sum * 2.0 * PI / f64::from(STEPS * STEPS)).min(1.0);
                let got = f64::from(albedo(x, roughness));
                assert!((got - expected).abs() < 0.02, "{x} {roughness}: {got} {expected}");
            }
        }
    }

    #[test]
    fn head_on_nothing_is_scattered_and_all_numbers_are_finite() {
        let up = V3::<f32>::splat((), [0.0, 0.0, 1.0]);
        assert_eq!(Sheen::new(up, up, 0.2).respond(up, 1.0), 0.0);
        for v in [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [f32::NAN; 3]] {
            let sheen = Sheen::new(up, V3::splat((), v), 0.5);
            assert!(sheen.respond(up, 1.0).is_finite() && sheen.albedo(0.5).is_finite());
        }
    }
}
