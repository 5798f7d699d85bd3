//! Tone mapping: from light of any strength to what a display can show.

use crate::lane::{Lane, Mask, Select, V3};
use crate::layout::ToneMap;
use crate::num::{clamp, exp2, flush, log2, pow, recip, sqrt};

/// The brightest channel that an operator tells apart from a brighter one (2³²): its square has a
/// reciprocal.
const BRIGHTEST: f32 = 4_294_967_296.0;

/// Linear light as a display shows it, by the [`ToneMap`] of this number. Negative light and NaN
/// count as 0. Results are within 0 ..= 1 up to rounding; [`srgb_encode`](crate::num::srgb_encode)
/// cuts off what is beyond.
#[inline(always)]
pub fn tone_map<L: Lane>(operator: u32, light: V3<L>) -> V3<L> {
    if operator == ToneMap::None as u32 {
        return light;
    }
    let light = V3 { x: usable(light.x), y: usable(light.y), z: usable(light.z) };
    if operator == ToneMap::Neutral as u32 {
        neutral(light)
    } else if operator == ToneMap::Agx as u32 {
        agx(light)
    } else {
        aces(light)
    }
}

/// A channel within 0 ..= 2³².
#[inline(always)]
fn usable<L: Lane>(channel: L) -> L {
    flush(channel.max(channel.broadcast(0.0)).min(channel.broadcast(BRIGHTEST)))
}

/// What a surface of an index of refraction of 1.5 reflects head-on, and what this operator takes
/// off.
const F90: f32 = 0.04;
/// Where compression starts.
const KS: f32 = 0.8 - F90;
/// How fast colors fade.
const KD: f32 = 0.15;

/// Khronos PBR Neutral, by its specification:
///
/// ```text
/// x   = min(R, G, B)
/// f   = x − x² / (4 F90)   for x ≤ 2 F90,   F90 above
/// p   = max(R, G, B) − f
/// pn  = 1 − (1 − Ks)² / (p + 1 − 2 Ks)
/// g   = 1 / (Kd (p − pn) + 1)
/// out = c − f                             for p ≤ Ks
///       (c − f) pn/p g + pn (1 − g)       above
/// ```
///
/// with F90 = 0.04, Ks = 0.8 − F90, Kd = 0.15.
#[inline(always)]
fn neutral<L: Lane>(light: V3<L>) -> V3<L> {
    let least = light.x.min(light.y).min(light.z);
    let one = least.broadcast(1.0);
    const BEND: f32 = 0.25 / F90;
    let toe = least - least * least * BEND;
    let offset = least.le(one.broadcast(2.0 * F90)).select(toe, one.broadcast(F90));
    let light = V3 { x: light.x - offset, y: light.y - offset, z: light.z - offset };
    let peak = light.x.max(light.y).max(light.z);
    let is_plain = peak.le(one.broadcast(KS));
    if !(!is_plain).any() {
        return light;
    }
    let compressed = one - recip(peak + (1.0 - 2.0 * KS)) * ((1.0 - KS) * (1.0 - KS));
    let kept = recip((peak - compressed) * KD + 1.0);
    let scale = compressed * recip(peak) * kept;
    let white = compressed * (one - kept);
    let shown = light.scale(scale);
    V3::select(is_plain, light, V3 { x: shown.x + white, y: shown.y + white, z: shown.z + white })
}

/// From linear BT.709 to BT.2020 (ITU-R BT.2087), then AgX's inset.
const INSET: [[f32; 3]; 3] = [
    [0.54481475, 0.373_787_4, 0.08139786],
    [0.14041695, 0.754_137_6, 0.105_445_5],
    [0.08881042, 0.17887176, 0.732_317_8],
];
/// AgX's outset undone, then from linear BT.2020 to BT.709.
const OUTSET: [[f32; 3]; 3] = [
    [1.964_887_4, -0.855_988_5, -0.10889892],
    [-0.29931336, 1.326_398, -0.027_084_6],
    [-0.16435274, -0.23818397, 1.402_536_7],
];
/// The stops that the curve spans, around middle gray.
const STOPS: [f32; 2] = [-10.0, 6.5];
/// log₂ of middle gray, 0.18.
const GRAY: f32 = -2.473_931_2;
/// Where middle gray is on the curve, 10 / 16.5, and how bright it is there, 0.18^(1/2.4).
const PIVOT: [f32; 2] = [0.606_060_6, 0.489_437_1];
/// The curve's slope there.
const SLOPE: f32 = 2.4;
/// The scales of toe and shoulder; they follow from the curve's ends, (0, 0) and (1, 1).
const SCALES: [f32; 2] = [-0.565_675_6, 0.715_198_3];

/// AgX (Troy Sobotka, 2022), as Blender 4.0's `AgX Base sRGB` has it (Eary Chow), but for two
/// things: negative light is cut off, and channels are not mixed with their hue before the curve.
///
/// ```text
/// x   = (log₂(inset · c) − log₂ 0.18 + 10) / 16.5, within 0 ..= 1
/// t   = 2.4 (x − 10/16.5) / s
/// y   = s t / (1 + t^1.5)^(2/3) + 0.18^(1/2.4)      (Jed Smith's sigmoid)
/// out = outset⁻¹ · y^2.4
/// ```
///
/// `s` is a number for the toe, and one for the shoulder, such that the curve ends at 0 and at 1.
#[inline(always)]
fn agx<L: Lane>(light: V3<L>) -> V3<L> {
    // The logarithm is of what is not 0.
    const DARKEST: f32 = 1.0 / BRIGHTEST;
    let floor = light.x.broadcast(DARKEST);
    let light = V3 { x: light.x.max(floor), y: light.y.max(floor), z: light.z.max(floor) };
    let light = transformed(&INSET, light);
    let shown = V3 { x: curve(light.x), y: curve(light.y), z: curve(light.z) };
    transformed(&OUTSET, shown)
}

/// AgX's curve, decoded.
#[inline(always)]
fn curve<L: Lane>(light: L) -> L {
    const WIDTH: f32 = 1.0 / (STOPS[1] - STOPS[0]);
    const BEND: f32 = -2.0 / 3.0;
    let x = clamp((log2(light) - (GRAY + STOPS[0])) * WIDTH, 0.0, 1.0);
    let off = x - PIVOT[0];
    let is_toe = off.lt(off.broadcast(0.0));
    let scale = is_toe.select(off.broadcast(SCALES[0]), off.broadcast(SCALES[1]));
    let t = off * SLOPE * recip(scale);
    let bend = exp2(log2(t * sqrt(t) + 1.0) * BEND);
    pow(scale * t * bend + PIVOT[1], t.broadcast(SLOPE))
}

/// From linear BT.709 to the rendering transform's space, desaturated.
const INPUT: [[f32; 3]; 3] =
    [[0.597_19, 0.354_58, 0.048_23], [0.076, 0.908_34, 0.015_66], [0.0284, 0.133_83, 0.837_77]];
/// From the output transform's space to linear BT.709.
const OUTPUT: [[f32; 3]; 3] =
    [[1.604_75, -0.531_08, -0.073_67], [-0.102_08, 1.108_13, -0.006_05], [-0.003_27, -0.072_76, 1.076_02]];

/// ACES: the reference rendering transform and the output transform for sRGB, in the fit by Stephen
/// Hill (published in MJP's and David Neubelt's Baking Lab, 2016).
///
/// ```text
/// v   = input · c
/// out = output · (v (v + 0.0245786) − 0.000090537) / (v (0.983729 v + 0.4329510) + 0.238081)
/// ```
#[inline(always)]
fn aces<L: Lane>(light: V3<L>) -> V3<L> {
    let v = transformed(&INPUT, light);
    transformed(&OUTPUT, V3 { x: fit(v.x), y: fit(v.y), z: fit(v.z) })
}

/// The curve of [`aces`].
#[inline(always)]
fn fit<L: Lane>(v: L) -> L {
    let above = v * (v + 0.024_578_6) - 0.000_090_537;
    let below = v * (v * 0.983_729 + 0.432_951) + 0.238_081;
    above * recip(below)
}

/// A color times a matrix, given by its rows.
#[inline(always)]
fn transformed<L: Lane>(rows: &[[f32; 3]; 3], color: V3<L>) -> V3<L> {
    let [a, b, c] = rows;
    V3 { x: weighted(a, color), y: weighted(b, color), z: weighted(c, color) }
}

/// A sum of channels by these weights.
#[inline(always)]
fn weighted<L: Lane>(weights: &[f32; 3], color: V3<L>) -> L {
    color.x * weights[0] + color.y * weights[1] + color.z * weights[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use libm::{exp2, log2, pow};
    use std::vec::Vec;

    type Color = [f64; 3];

    /// Colors from black to far beyond white, gray and not.
    fn lights() -> impl Iterator<Item = [f32; 3]> {
        let channels: Vec<f32> =
            [0.0].into_iter().chain((-40..=32).map(|i| exp2(f64::from(i) * 0.5) as f32)).collect();
        let pick = move |i: usize| channels[i % channels.len()];
        (0..40_000_usize).map(move |i| [pick(i), pick(i / 7 + i * i), pick(i / 31 + 5 * i)])
    }

    fn mapped(operator: ToneMap, light: [f32; 3]) -> Color {
        let V3 { x, y, z } = tone_map::<f32>(operator as u32, V3::splat((), light));
        [x, y, z].map(f64::from)
    }

    fn product(rows: &[Color; 3], c: Color) -> Color {
        rows.map(|r| r[0] * c[0] + r[1] * c[1] + r[2] * c[2])
    }

    fn inverse(m: &[Color; 3]) -> [Color; 3] {
        let minor = |i: usize, j: usize| {
            let at = |a: usize, b: usize| m[(i + a) % 3][(j + b) % 3];
            at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
        };
        let determinant: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
        core::array::from_fn(|i| core::array::from_fn(|j| minor(j, i) / determinant))
    }

    /// The largest difference from a published formula, cut off at 0 and 1 as displays do.
    fn worst(operator: ToneMap, formula: impl Fn(Color) -> Color) -> f64 {
        let difference = |light: [f32; 3]| {
            let (is, exact) = (mapped(operator, light), formula(light.map(f64::from)));
            (0..3).map(|i| (is[i].clamp(0.0, 1.0) - exact[i].clamp(0.0, 1.0)).abs()).fold(0.0, f64::max)
        };
        lights().map(difference).fold(0.0, f64::max)
    }

    #[test]
    fn neutral_is_the_specification_of_khronos() {
        let formula = |c: Color| {
            let (f90, kd) = (0.04, 0.15);
            let ks = 0.8 - f90;
            let x = c[0].min(c[1]).min(c[2]);
            let f = if x <= 2.0 * f90 { x - x * x / (4.0 * f90) } else { f90 };
            let p = c.map(|c| c - f).into_iter().fold(f64::MIN, f64::max);
            if p <= ks {
                return c.map(|c| c - f);
            }
            let pn = 1.0 - (1.0 - ks) * (1.0 - ks) / (p + 1.0 - 2.0 * ks);
            let g = 1.0 / (kd * (p - pn) + 1.0);
            c.map(|c| (c - f) * pn / p * g + pn * (1.0 - g))
        };
        assert!(worst(ToneMap::Neutral, formula) < 1e-6);
    }

    #[test]
    fn neutral_keeps_base_colors_that_a_surface_reflects_with_its_gloss() {
        // Lit by white, a dielectric adds 0.04 to its base color, which the operator takes off.
        for color in [[0.1, 0.5, 0.7], [0.2, 0.2, 0.2], [0.75, 0.3, 0.1]] {
            let shown = mapped(ToneMap::Neutral, color.map(|c: f32| c + 0.04));
            assert!((0..3).all(|i| (shown[i] - f64::from(color[i])).abs() < 1e-6), "{shown:?}");
        }
    }

    #[test]
    fn agx_is_the_curve_between_the_matrices_of_blender() {
        // Of ITU-R BT.2087, and those of AgX for BT.2020 primaries.
        let to_2020 = [
            [0.627403896, 0.329283038, 0.043313066],
            [0.069097289, 0.919540395, 0.011362316],
            [0.016391439, 0.088013308, 0.895595253],
        ];
        let inset = [
            [0.856_627_153_315_983, 0.095_121_240_538_158_8, 0.048_251_606_145_858_3],
            [0.137_318_972_929_847, 0.761_241_990_602_591, 0.101_439_036_467_562],
            [0.111_898_212_999_95, 0.076_799_418_603_190_3, 0.811_302_368_396_859],
        ];
        let outset = [
            [1.127_100_581_814_436_8, -0.110_606_643_096_603_23, -0.016_493_938_717_834_573],
            [-0.141_329_763_498_438_3, 1.157_823_702_216_272, -0.016_493_938_717_834_257],
            [-0.141_329_763_498_438_26, -0.110_606_643_096_602_94, 1.251_936_406_595_040_5],
        ];
        let scale = |x: f64, y: f64| {
            let (slope, power) = (2.4, 1.5);
            pow(pow(slope * x, -power) * (pow(slope * x / y, power) - 1.0), -1.0 / power)
        };
        let (px, py) = (10.0 / 16.5, pow(0.18, 1.0 / 2.4));
        let curve = |light: f64| {
            let x = ((log2(light.max(1e-10) / 0.18) + 10.0) / 16.5).clamp(0.0, 1.0);
            let s = if x < px { -scale(px, py) } else { scale(1.0 - px, 1.0 - py) };
            let t = 2.4 * (x - px) / s;
            pow(s * t / pow(1.0 + pow(t, 1.5), 1.0 / 1.5) + py, 2.4)
        };
        let formula = |c: Color| {
            let shown = product(&inset, product(&to_2020, c)).map(curve);
            product(&inverse(&to_2020), product(&outset, shown))
        };
        let worst = worst(ToneMap::Agx, formula);
        assert!(worst < 1e-5, "{worst}");
        let gray = mapped(ToneMap::Agx, [0.18; 3]);
        assert!(gray.iter().all(|c| (c - 0.18).abs() < 1e-5), "{gray:?}");
        let exact = mapped(ToneMap::Agx, [0.5; 3])[0];
        assert!((exact - curve(0.5)).abs() < 1e-5, "{exact} {}", curve(0.5));
    }

    #[test]
    fn aces_is_the_fit_of_hill() {
        let input = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
        let output =
            [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
        let fit = |v: f64| (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
        let formula = |c: Color| product(&output, product(&input, c).map(fit));
        assert!(worst(ToneMap::Aces, formula) < 2e-6);
    }

    #[test]
    fn more_light_is_never_darker_and_never_beyond_white() {
        for (name, operator) in ToneMap::ALL {
            let mut before = -1.0;
            for i in -3000..=3000 {
                let [r, g, b] = mapped(operator, [exp2(f64::from(i) * 0.01) as f32; 3]);
                let r = r.clamp(0.0, 1.0);
                assert!(
                    r >= before - 1e-6 && (r - g).abs() < 2e-3 && (r - b).abs() < 2e-3 || r == 1.0,
                    "{name} {i}"
                );
                before = r;
            }
            assert!(before > 0.99, "{name}");
        }
    }

    #[test]
    fn what_is_no_light_is_black_and_nothing_is_no_number() {
        for (name, operator) in ToneMap::ALL.into_iter().filter(|(name, _)| *name != "none") {
            let black = mapped(operator, [0.0; 3]);
            assert!(black.iter().all(|c| *c < 1e-4), "{name} {black:?}");
            assert_eq!(mapped(operator, [f32::NAN, -5.0, -0.0]), black, "{name}");
            for extreme in [[f32::MAX; 3], [f32::INFINITY, 0.0, 1e-45], [1e-30, 1e-38, f32::MAX]] {
                assert!(mapped(operator, extreme).iter().all(|c| c.is_finite()), "{name}");
            }
        }
        let as_it_is = [0.25, 3.0, -1.0];
        assert_eq!(mapped(ToneMap::None, as_it_is), as_it_is.map(f64::from));
    }
}
