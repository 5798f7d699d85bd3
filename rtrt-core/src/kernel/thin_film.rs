//! The colors of a thin film on a surface (KHR_materials_iridescence).
//!
//! Light that the film's upper side mirrors meets light that the surface below it mirrors, later by the way through
//! the film. Which wavelengths the two strengthen depends on the angle and on the film's thickness:
//!
//! ```text
//! R₁₂ = Schlick(((n − 1) / (n + 1))², cos θ₁)                      outside to film
//! R₂₃ = Schlick(((n₃ − n) / (n₃ + n))², cos θ₂)                    film to surface, a channel
//! cos θ₂ = √(1 − (1 − cos² θ₁) / n²)
//! Rₛ  = (1 − R₁₂)² R₂₃ / (1 − R₁₂ R₂₃)
//! R   = R₁₂ + Rₛ + 2 Σₘ (Rₛ − (1 − R₁₂)) (R₁₂ R₂₃)^(m/2) · S(m · 2 n d cos θ₂, m φ),   m = 1, 2
//! ```
//!
//! `S` is what eyes make of a spectrum that varies as a cosine, as Gaussians in XYZ, then linear RGB; `φ` are the half
//! waves that are lost where light is mirrored by what is denser. Belcour and Barla, "A Practical Extension to
//! Microfacet Theory for the Modeling of Varying Iridescence", 2017, with Schlick's approximation and the numbers
//! of the extension.

use crate::kernel::microfacet::schlick;
use crate::lane::{Lane, Select, V3};
use crate::num::{clamp, exp2, flush, recip, round, sine_and_cosine, sqrt};

/// What the color matching functions are as a sum of Gaussians, one for x, y, z and a second one for x: amplitude
/// of its transform, place in waves a nanometer of the way, and width, log₂ of what is lost for a way of one
/// nanometer, squared.
///
/// ```text
/// amplitude = value · √(2π · variance) / 1.0685·10⁻⁷
/// waves     = position · 10⁻⁹
/// narrowing = variance · (2π · 10⁻⁹)² / ln 2
/// ```
const GAUSSIANS: [[f32; 3]; 4] = [
    [0.846_59, 1.681e-3, 2.464_912e-7],
    [1.000_222, 1.795_3e-3, 5.299_464e-7],
    [1.001_122_5, 2.208_4e-3, 3.765_942_5e-7],
    [0.153_868_3, 2.239_9e-3, 2.579_050_7e-7],
];

/// From XYZ to linear RGB with the primaries of Rec. 709, row by row.
const RGB: [[f32; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// One over the thickness below which a film fades, 30 nm.
const INVERSE_FADE: f32 = 1.0 / 30.0;

/// A film.
#[derive(Clone, Copy)]
pub struct Film<L> {
    /// Its index of refraction, 1 or more. Thinner than 30 nm it fades to that of air.
    pub ior: L,
    /// Nanometers.
    pub thickness: L,
}

impl<L: Lane> Film<L> {
    /// What a surface that mirrors `below` head-on, linear RGB, each 0 ..= 1, mirrors under the film, seen at this
    /// cosine. Each is 0 or more, and may go a little beyond 1.
    #[inline(always)]
    pub fn reflectance(&self, cosine: L, below: V3<L>) -> V3<L> {
        let one = cosine.broadcast(1.0);
        let cosine = clamp(cosine, 0.0, 1.0);
        let thickness = clamp(self.thickness, 0.0, 65_536.0);
        let thin = clamp(thickness * INVERSE_FADE, 0.0, 1.0);
        let share = thin * thin * (one.broadcast(3.0) - thin * 2.0);
        let ior = one + (clamp(self.ior, 1.0, 8.0) - one) * share;
        let inverse = recip(ior);
        let inside = sqrt(one - (one - cosine * cosine) * inverse * inverse);
        let outer = mirrored(one, ior);
        let outer = outer + (one - outer) * schlick(cosine);
        let way = ior * thickness * inside * 2.0;
        let each = |below: L| channel_terms(ior, inside, outer, below);
        let (r, g, b) = (each(below.x), each(below.y), each(below.z));
        let x = V3 { x: r.mean, y: g.mean, z: b.mean };
        let first = swing(way, &[r, g, b], 1.0);
        let second = swing(way * 2.0, &[r, g, b], 2.0);
        let sum = x
            + V3 { x: r.first * first.x, y: g.first * first.y, z: b.first * first.z }
            + V3 { x: r.second * second.x, y: g.second * second.y, z: b.second * second.z };
        let positive = |c: L| flush(c.max(c.broadcast(0.0)));
        V3 { x: positive(sum.x), y: positive(sum.y), z: positive(sum.z) }
    }
}

/// `((b − a) / (b + a))²`.
#[inline(always)]
fn mirrored<L: Lane>(a: L, b: L) -> L {
    let ratio = (b - a) * recip(b + a);
    ratio * ratio
}

/// What does not depend on the way, of one channel.
#[derive(Clone, Copy)]
struct Terms<L> {
    mean: L,
    /// Twice the factors of the sum.
    first: L,
    second: L,
    /// The waves that are lost at both sides: 1/2 or 1.
    lost: L,
}

#[inline(always)]
fn channel_terms<L: Lane>(ior: L, inside: L, outer: L, below: L) -> Terms<L> {
    let one = ior.broadcast(1.0);
    // The index of refraction that mirrors this much.
    let root = sqrt(clamp(below, 0.0, 0.9999));
    let base = (one + root) * recip(one - root);
    let inner = mirrored(ior, base);
    let inner = inner + (one - inner) * schlick(inside);
    let both = clamp(outer * inner, 1e-5, 0.9999);
    let through = one - outer;
    let single = through * through * inner * recip(one - both);
    let swing = (single - through) * 2.0;
    let lost = base.lt(ior).select(one, one.broadcast(0.5));
    Terms { mean: outer + single, first: swing * sqrt(both), second: swing * both, lost }
}

/// `S`, each channel with its own waves lost, `order` times.
#[inline(always)]
fn swing<L: Lane>(way: L, terms: &[Terms<L>; 3], order: f32) -> V3<L> {
    let [x, y, z, far] = GAUSSIANS;
    let at = |gaussian: [f32; 3], lost: L| {
        let [amplitude, waves, narrowing] = gaussian;
        whole_cosine(way * waves + lost * order) * exp2(way * way * -narrowing) * amplitude
    };
    let x = at(x, terms[0].lost) + at(far, terms[0].lost);
    let (y, z) = (at(y, terms[1].lost), at(z, terms[2].lost));
    let row = |m: [f32; 3]| x * m[0] + y * m[1] + z * m[2];
    V3 { x: row(RGB[0]), y: row(RGB[1]), z: row(RGB[2]) }
}

/// The cosine of this many turns, 0 ..= 2²²: of an eighth of the rest, doubled twice.
#[inline(always)]
fn whole_cosine<L: Lane>(turns: L) -> L {
    let rest = turns - round(turns);
    let [_, quarter] = sine_and_cosine(rest * 2.0);
    let half = quarter * quarter * 2.0 - 1.0;
    half * half * 2.0 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the extension writes it, in `f64` and the wavelengths' own units.
    fn exact(cosine: f64, ior: f64, thickness: f64, below: [f64; 3]) -> [f64; 3] {
        use core::f64::consts::PI;
        let smooth = (thickness / 30.0).clamp(0.0, 1.0);
        let ior = 1.0 + (ior - 1.0) * smooth * smooth * (3.0 - 2.0 * smooth);
        let schlick = |r0: f64, c: f64| r0 + (1.0 - r0) * (1.0 - c).powi(5);
        let inside = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).sqrt();
        let r12 = schlick(((ior - 1.0) / (ior + 1.0)).powi(2), cosine);
        let base = below.map(|f: f64| (1.0 + f.min(0.9999).sqrt()) / (1.0 - f.min(0.9999).sqrt()));
        let r23 = base.map(|b| schlick(((b - ior) / (b + ior)).powi(2), inside));
        let phi = base.map(|b| PI + if b < ior { PI } else { 0.0 });
        let way = 2.0 * ior * thickness * inside;
        let sensitivity = |m: f64| {
            let phase = 2.0 * PI * m * way * 1e-9;
            let gauss = |value: f64, position: f64, variance: f64, shift: f64| {
                value
                    * (2.0 * PI * variance).sqrt()
                    * (position * phase + shift).cos()
                    * (-phase * phase * variance).exp()
            };
            let x = gauss(5.4856e-13, 1.681e6, 4.3278e9, m * phi[0])
                + gauss(9.747e-14, 2.2399e6, 4.5282e9, m * phi[0]);
            let y = gauss(4.4201e-13, 1.7953e6, 9.3046e9, m * phi[1]);
            let z = gauss(5.2481e-13, 2.2084e6, 6.6121e9, m * phi[2]);
            RGB.map(|row| (f64::from(row[0]) * x + f64::from(row[1]) * y + f64::from(row[2]) * z) / 1.0685e-7)
        };
        core::array::from_fn(|i| {
            let both = (r12 * r23[i]).clamp(1e-5, 0.9999);
            let single = (1.0 - r12).powi(2) * r23[i] / (1.0 - both);
            let mut sum = r12 + single;
            let mut factor = single - (1.0 - r12);
            for m in [1.0, 2.0] {
                factor *= both.sqrt();
                sum += factor * 2.0 * sensitivity(m)[i];
            }
            sum.max(0.0)
        })
    }

    #[test]
    fn is_the_formula() {
        for below in [[0.04; 3], [0.9, 0.6, 0.3], [1.0, 0.0, 0.5]] {
            for ior in [1.1_f32, 1.33, 1.8, 2.5] {
                for thickness in [5.0_f32, 100.0, 350.0, 700.0, 1500.0] {
                    for cosine in [0.0_f32, 0.2, 0.6, 1.0] {
                        let film = Film { ior, thickness };
                        let got = film.reflectance(cosine, V3::splat((), below.map(|b| b as f32))).lane(0);
                        let expected = exact(cosine.into(), ior.into(), thickness.into(), below);
                        for (a, b) in got.iter().zip(expected) {
                            assert!(
                                (f64::from(*a) - b).abs() < 3e-3,
                                "{ior} {thickness} {cosine}: {got:?} {expected:?}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn no_film_changes_nothing() {
        let film = Film { ior: 1.5, thickness: 0.0 };
        let got = film.reflectance(1.0, V3::<f32>::splat((), [0.04, 0.5, 0.9])).lane(0);
        for (a, b) in got.iter().zip([0.04, 0.5, 0.9]) {
            assert!((a - b).abs() < 0.02, "{got:?}");
        }
    }

    #[test]
    fn at_a_grazing_angle_everything_is_mirrored() {
        let film = Film { ior: 1.4, thickness: 400.0 };
        for c in film.reflectance(0.0, V3::<f32>::splat((), [0.1; 3])).lane(0) {
            assert!((c - 1.0).abs() < 1e-3, "{c}");
        }
        let broken = Film { ior: f32::NAN, thickness: f32::NAN };
        assert!(
            broken.reflectance(f32::NAN, V3::splat((), [f32::NAN; 3])).lane(0).iter().all(|c| c.is_finite())
        );
    }
}
