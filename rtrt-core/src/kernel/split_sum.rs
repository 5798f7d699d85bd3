//! How much of the light from all around a surface of microfacets mirrors toward the viewer.
//!
//! Under light of one radiance from everywhere, the lobe of [`crate::kernel::microfacet`] gives
//!
//! ```text
//! ∫ D V F (n·l) dl = F₀ · A + F₉₀ · B
//!
//! A = ∫ D V (1 − (1 − v·h)⁵) (n·l) dl,    B = ∫ D V (1 − v·h)⁵ (n·l) dl
//! ```
//!
//! which an environment, blurred by the lobe, is multiplied with (the split sum; Karis, "Real Shading in
//! Unreal Engine 4", 2013). `A` and `B` depend on n·v and the roughness alone.
//!
//! A microfacet hides part of the light that another one mirrors: a rough surface that mirrors everything gives
//! back `A + B < 1`. What is hidden goes on to the next microfacet, and most of it comes out:
//! [`Albedo::reflectance`] adds it.

use crate::lane::Lane;
use crate::num::{clamp, recip, rsqrt};

/// A surface seen at a smaller n·v counts as one at this: 1.1° from its plane. The fit below is not made for
/// less.
pub const LEAST_COSINE: f32 = 0.02;

/// A smoother surface counts as one of this roughness, 2^(−9/2), that of the
/// [`LEAST_ALPHA_SQUARED`](crate::kernel::microfacet::LEAST_ALPHA_SQUARED).
const LEAST_ROUGHNESS: f32 = 0.044_194_174;

/// The mean of `(1 − n·v)⁵` over all angles, weighted by the cosine.
const FRESNEL_MEAN: f32 = 1.0 / 21.0;

/// The parts of what is mirrored; see the module.
#[derive(Clone, Copy)]
pub struct Albedo<L> {
    /// `A + B`: for a surface that mirrors everything, 0.3 ..= 1.
    pub sum: L,
    /// `B`, 0 ..= `sum`.
    pub grazing: L,
    /// `(1 − n·v)⁵`.
    pub rise: L,
    /// `1 − roughness`.
    pub smoothness: L,
}

/// The albedo of a surface of this roughness, 0 ..= 1, seen at this n·v.
///
/// Polynomials, derived here: the least largest error against integrals in `f64`, found by reweighted least
/// squares.
///
/// ```text
/// A + B = P(x / √(x² + α²), α)                 within 0.009
/// B     = (1 − x)⁵ · Q(x / (x + α), roughness)     within 0.005
///
/// x = n·v, at least 0.02;   α = roughness²
/// ```
///
/// Both arguments of the first kind are 1 where facets hide nothing, and fall toward 0 where n·v is less than
/// the slopes of the facets.
#[inline(always)]
pub fn albedo<L: Lane>(cosine: L, roughness: L) -> Albedo<L> {
    let x = clamp(cosine, LEAST_COSINE, 1.0);
    let r = clamp(roughness, LEAST_ROUGHNESS, 1.0);
    let a = r * r;
    let t = x * rsqrt(x * x + a * a);
    let u = x * recip(x + a);
    let mut p = t * 2.044_759_5 - 3.435_261 - a * 1.291_521_2;
    p = p * t + ((a * 0.266_079_6 + 2.001_886) * a + 1.950_303_9);
    p = p * t + (((a * 0.757_837_2 - 1.835_156_2) * a - 0.609_635_95) * a - 0.584_689_56);
    p = p * t
        + ((((a * 0.116_587_35 - 0.233_603_58) * a + 0.070_481_07) * a - 0.021_140_223) * a + 1.024_463_8);
    let mut q = u * -2.492_788_6 + 5.969_524 + r * 0.812_839_57;
    q = q * u + ((r * 1.849_470_3 + 2.588_973) * r - 4.968_022_3);
    q = q * u + (((r * 2.675_008 - 3.759_106_9) * r - 0.594_311_7) * r + 1.622_843_3);
    q = q * u
        + ((((r * -0.479_521_27 - 0.016_223_975) * r + 1.988_457_2) * r - 2.289_558_2) * r + 0.836_573_7);
    let sum = clamp(p, 0.25, 1.0);
    let away = x.broadcast(1.0) - x;
    let square = away * away;
    let rise = square * square * away;
    Albedo { sum, grazing: clamp(q, 0.0, 1.0) * rise, rise, smoothness: x.broadcast(1.0) - r }
}

impl<L: Lane> Albedo<L> {
    /// The share of the light that a surface mirrors head-on as `normal` and at grazing angles as `grazing`
    /// gives back in the end:
    ///
    /// ```text
    /// (F · A + F₉₀ · B) / (1 − F̄ · (1 − A − B))
    ///
    /// F = F₀ + max(F₉₀ · (1 − roughness) − F₀, 0) · (1 − n·v)⁵
    /// F̄ = F₀ + (F₉₀ − F₀) / 21,   the mean of Schlick's F over all angles
    /// ```
    ///
    /// which is 1 where both are: what is hidden is mirrored again and again, `1 + x + x² + …` with
    /// `x = F̄ (1 − A − B)` (Fdez-Agüera, "A Multiple-Scattering Microfacet Model for Real-Time Image-based Lighting",
    /// 2019). `F` in place of `F₀` is his too, and the Khronos renderer's, whose pictures people expect: at grazing
    /// angles smooth surfaces mirror more than the integral says. At most 1 for shares within 0 ..= 1.
    #[inline(always)]
    pub fn reflectance(&self, normal: L, grazing: L) -> L {
        let more = (grazing * self.smoothness - normal).max(normal.broadcast(0.0));
        let once = (normal + more * self.rise) * (self.sum - self.grazing) + grazing * self.grazing;
        let mean = normal + (grazing - normal) * FRESNEL_MEAN;
        let one = normal.broadcast(1.0);
        once * recip(one - mean * (one - self.sum))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    /// `A` and `B` by the midpoint rule over half vectors, distributed as the facets' normals are, and closer
    /// toward the horizon.
    fn integral(x: f64, roughness: f64) -> [f64; 2] {
        const STEPS: u32 = 100;
        let a2 = roughness.powi(4);
        let sum = (0..STEPS * STEPS).fold([0.0; 2], |sum, i| {
            let [s, turn] = [i % STEPS, i / STEPS].map(|step| (f64::from(step) + 0.5) / f64::from(STEPS));
            let cube = s * s * s;
            let cos2 = cube / (cube + a2 * (1.0 - cube));
            let (cos, sin) = (cos2.sqrt(), (1.0 - cos2).sqrt());
            let vh = sin * (PI * turn).cos() * (1.0 - x * x).sqrt() + cos * x;
            let nl = 2.0 * vh * cos - x;
            if nl <= 0.0 || vh <= 0.0 {
                return sum;
            }
            let root = |c: f64| (c * c * (1.0 - a2) + a2).sqrt();
            let share = 6.0 * s * s * nl * vh / (cos * (nl * root(x) + x * root(nl)));
            let grazing = share * (1.0 - vh).powi(5);
            [sum[0] + share - grazing, sum[1] + grazing]
        });
        sum.map(|sum| sum / f64::from(STEPS * STEPS))
    }

    #[test]
    fn the_fit_is_within_its_error() {
        for x in [0.02_f32, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0] {
            for roughness in [0.05_f32, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 1.0] {
                let [a, b] = integral(x.into(), roughness.into());
                let Albedo { sum, grazing, .. } = albedo(x, roughness);
                assert!((f64::from(sum) - a - b).abs() < 0.009, "{x} {roughness}: {sum} {}", a + b);
                assert!((f64::from(grazing) - b).abs() < 0.005, "{x} {roughness}: {grazing} {b}");
            }
        }
    }

    #[test]
    fn a_matte_mirror_head_on_is_known_in_closed_form() {
        // With α = 1, ∫ (n·l) / (π (n·l + 1)) dl over half of it, which is 1 − ln 2.
        let exact = 1.0 - core::f64::consts::LN_2;
        let [a, b] = integral(1.0, 1.0);
        assert!((a + b - exact).abs() < 1e-3);
        assert!((f64::from(albedo(1.0_f32, 1.0).sum) - exact).abs() < 0.009);
    }

    #[test]
    fn white_metal_is_white_and_nothing_gives_back_more_than_arrives() {
        for x in 0..=50 {
            for roughness in 0..=50 {
                let albedo = albedo(x as f32 / 50.0, roughness as f32 / 50.0);
                assert!((albedo.reflectance(1.0, 1.0) - 1.0).abs() < 1e-5);
                assert!(albedo.grazing <= albedo.sum);
                for normal in [0.0, 0.04, 0.3, 0.9] {
                    let back = albedo.reflectance(normal, 1.0);
                    assert!((0.0..=1.0 + 1e-6).contains(&back), "{x} {roughness} {normal} {back}");
                }
            }
        }
    }

    #[test]
    fn a_rough_metal_gives_back_less_than_its_color() {
        // Head-on, α = 1: A + B = 1 − ln 2, of which B is the part that facets at grazing angles mirror.
        let albedo = albedo(1.0_f32, 1.0);
        assert_eq!(albedo.grazing, 0.0);
        let once = 0.5 * (1.0 - core::f64::consts::LN_2);
        // What is hidden and mirrored, again and again.
        let again = (0.5 + 0.5 / 21.0) * core::f64::consts::LN_2;
        let series: f64 = (0..200).map(|n| once * again.powi(n)).sum();
        assert!((f64::from(albedo.reflectance(0.5, 1.0)) - series).abs() < 0.01, "{series}");
    }

    #[test]
    fn a_smooth_surface_mirrors_fresnels_share_and_once_more_of_the_rest() {
        for cosine in [0.1_f32, 0.5, 1.0] {
            let albedo = albedo(cosine, 0.0);
            let rise = (1.0 - cosine).powi(5);
            let fresnel = 0.04 + 0.96 * rise;
            let expected = fresnel * (1.0 - rise) + rise;
            assert!((albedo.reflectance(0.04, 1.0) - expected).abs() < 0.05);
        }
    }
}
