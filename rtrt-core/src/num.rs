//! Reciprocals, roots, powers and the curve of sRGB, with the same bits on every device.
//!
//! On a GPU only `+ − ×`, comparisons and integer operations are exact; division, square
//! root and everything transcendental are not. So each function here is built from that
//! exact subset: a seed from the number's bits and a fixed number of Newton steps, or a
//! fixed polynomial, evaluated in the written order. Nothing else divides.
//!
//! | function | error against f64 (tested below) | domain, and what lies outside |
//! |---|---|---|
//! | [`recip`] | 2 ULP | 2⁻⁹⁰ ≤ abs(x) ≤ 2⁹⁰; clamped into it, sign kept; NaN as 2⁹⁰ |
//! | [`rsqrt`] | 3 ULP | 2⁻⁹⁰ ≤ x ≤ 2⁹⁰; clamped into it; NaN as 2⁹⁰ |
//! | [`sqrt`] | 3 ULP | 2⁻⁹⁰ ≤ x ≤ 2⁹⁰; 0 below (NaN too) |
//! | [`exp2`] | relative 2⁻²² | −126 ≤ x ≤ 127; clamped into it; NaN as −126 |
//! | [`log2`] | 2⁻²¹ · max(1, abs(log2 x)), and relative 2⁻²¹ within 0.75 ..= 1.4 | 2⁻⁹⁰ ≤ x ≤ 2⁹⁰; clamped into it |
//! | [`pow`] | relative 2⁻¹⁹ · max(1, abs(y · log2 x)) | x ≥ 0; 0 for x < 2⁻⁹⁰ |
//! | [`atan2`] | absolute 2⁻²⁰ | any but NaN; 0 for (0, 0) |
//! | [`sine_and_cosine`] | absolute 2⁻²² | −1 ≤ x ≤ 1 |
//! | [`srgb_encode`], [`srgb_decode`] | absolute 2⁻²⁰ | 0 ..= 1; clamped into it, NaN as 0 |
//! | [`srgb_byte_decode`] | absolute 2⁻¹⁷, and 1/300 of the step to the next byte | 0 ..= 255 |
//!
//! A device that flushes denormals gives the same bits for any argument of these functions:
//! numbers below [`FLOOR`] count as 0 where their size would show. [`floor`] and [`clamp`] leave
//! that to their callers, who give them no denormals or [`flush`] the result.

mod srgb;

pub use srgb::{srgb_byte_decode, srgb_byte_encode, srgb_decode, srgb_encode};

use crate::lane::{Bits, Lane, Select, V3};

/// Numbers smaller than this in magnitude decide nothing: some devices flush
/// denormals (below 2⁻¹²⁶), and above 2⁻¹⁰⁰ a flushed term can no longer change the
/// rounding of a sum.
pub const FLOOR: f32 = f32::from_bits((127 - 100) << 23);

/// 2⁻⁹⁰, the smallest magnitude that has its own reciprocal.
pub const TINY: f32 = f32::from_bits((127 - 90) << 23);
/// 2⁹⁰, the largest magnitude that has its own reciprocal.
pub const HUGE: f32 = f32::from_bits((127 + 90) << 23);

/// 1.5 · 2²³: adding it rounds to the nearest integer, ties to even.
const ROUND: f32 = 12_582_912.0;

/// `x`, or 0 where `|x| <` [`FLOOR`].
#[inline(always)]
pub fn flush<L: Lane>(x: L) -> L {
    x.abs().lt(x.broadcast(FLOOR)).select(x.broadcast(0.0), x)
}

/// [`flush`] of each component.
#[inline(always)]
pub fn flush3<L: Lane>(v: V3<L>) -> V3<L> {
    V3 { x: flush(v.x), y: flush(v.y), z: flush(v.z) }
}

/// `x` clamped to `low ..= high`; NaN gives `high`.
#[inline(always)]
pub fn clamp<L: Lane>(x: L, low: f32, high: f32) -> L {
    x.broadcast(low).max(x.min(x.broadcast(high)))
}

/// `1 / x`. Three Newton steps, `y ← y (2 − x y)`, from a seed within 13 % (the exponent
/// negated by an integer subtraction).
#[inline(always)]
pub fn recip<L: Lane>(x: L) -> L {
    recip_within(clamp(x.abs(), TINY, HUGE)).flip_sign(x.sign_bit())
}

/// [`recip`] of a number within [`TINY`] ..= [`HUGE`].
#[inline(always)]
fn recip_within<L: Lane>(a: L) -> L {
    let mut y = L::from_bits(a.broadcast_bits(0x7ef3_11c7) - a.to_bits());
    y = y * (y.broadcast(2.0) - a * y);
    y = y * (y.broadcast(2.0) - a * y);
    y * (y.broadcast(2.0) - a * y)
}

/// `1 / √x`. Three Newton steps, `y ← y (3/2 − x/2 y²)`, from a seed within 4 % (the
/// exponent halved and negated by a shift and a subtraction).
#[inline(always)]
pub fn rsqrt<L: Lane>(x: L) -> L {
    let a = clamp(x, TINY, HUGE);
    let half = a * 0.5;
    let mut y = L::from_bits(a.broadcast_bits(0x5f37_5a86) - (a.to_bits() >> 1));
    y = y * (y.broadcast(1.5) - half * y * y);
    y = y * (y.broadcast(1.5) - half * y * y);
    y = y * (y.broadcast(1.5) - half * y * y);
    y
}

/// `√x`, as `x · rsqrt(x)`.
#[inline(always)]
pub fn sqrt<L: Lane>(x: L) -> L {
    x.ge(x.broadcast(TINY)).select(clamp(x, TINY, HUGE) * rsqrt(x), x.broadcast(0.0))
}

/// `x` rounded to the nearest integer, ties to even. For `|x| < 2²²`.
#[inline(always)]
pub fn round<L: Lane>(x: L) -> L {
    (x + ROUND) - ROUND
}

/// The largest integer not above `x`. For `|x| < 2²²`, and no negative denormal, whose floor some
/// devices take for −1 and others for 0.
#[inline(always)]
pub fn floor<L: Lane>(x: L) -> L {
    let nearest = round(x);
    nearest - x.lt(nearest).select(x.broadcast(1.0), x.broadcast(0.0))
}

/// The integer nearest to `x`, as two's complement bits; of two the even one. For `|x| < 2²²`.
#[inline(always)]
pub fn to_integer<L: Lane>(x: L) -> L::Bits {
    (x + ROUND).to_bits() - x.broadcast_bits(ROUND.to_bits())
}

/// The number that the two's complement `bits` are. For `|bits| < 2²²`.
#[inline(always)]
pub fn from_integer<L: Lane>(bits: L::Bits) -> L {
    L::from_bits(bits + bits.broadcast(ROUND.to_bits())) - ROUND
}

/// `2ˣ`: the nearest integer goes into the exponent, the rest (within ±½) through the
/// Taylor polynomial of degree 7, whose remainder is below 2⁻²⁷.
#[inline(always)]
pub fn exp2<L: Lane>(x: L) -> L {
    // NaN becomes the lower end.
    exp2_within(x.max(x.broadcast(-126.0)).min(x.broadcast(127.0)))
}

/// [`exp2`] of a number within −126 ..= 127.
#[inline(always)]
fn exp2_within<L: Lane>(x: L) -> L {
    let whole = round(x);
    let f = x - whole;
    // (ln 2)ⁿ / n!
    let mut p = f * 1.525_273_4e-5 + 1.540_353e-4;
    p = p * f + 1.333_355_8e-3;
    p = p * f + 9.618_129e-3;
    p = p * f + 5.550_411e-2;
    p = p * f + 2.402_265e-1;
    p = p * f + core::f32::consts::LN_2;
    p = p * f + 1.0;
    p * L::from_bits((to_integer(whole) + x.broadcast_bits(127)) << 23)
}

/// Sine and cosine of π/4 · `x`, for `x` within ±1: Taylor polynomials of degree 9 and 8, whose
/// remainders are below 2⁻²⁴.
#[inline(always)]
pub fn sine_and_cosine<L: Lane>(x: L) -> [L; 2] {
    let x = flush(x);
    let square = x * x;
    // (π/4)ⁿ / n!
    let mut sine = square * 3.133_616_9e-7 - 3.657_620_4e-5;
    sine = sine * square + 2.490_394_6e-3;
    sine = sine * square - 8.074_551e-2;
    sine = sine * square + core::f32::consts::FRAC_PI_4;
    let mut cosine = square * 3.590_860_5e-6 - 3.259_919e-4;
    cosine = cosine * square + 1.585_434_4e-2;
    cosine = cosine * square - 3.084_251_5e-1;
    cosine = cosine * square + 1.0;
    [sine * x, cosine]
}

/// `log₂ x`: the exponent, plus the mantissa `m` (within √½ ..= √2) through
/// `2/ln 2 · artanh(s)`, `s = (m − 1)/(m + 1)`, as a series up to `s⁹`.
#[inline(always)]
pub fn log2<L: Lane>(x: L) -> L {
    log2_within(clamp(x, TINY, HUGE))
}

/// [`log2`] of a number within [`TINY`] ..= [`HUGE`].
#[inline(always)]
fn log2_within<L: Lane>(x: L) -> L {
    let bits = x.to_bits();
    // Counted from √½, so that m straddles 1.
    let offset = bits - bits.broadcast(0x3f35_04f3);
    let exponent = (offset >> 23).xor(bits.broadcast(0x100)) - bits.broadcast(0x100);
    let m = L::from_bits(bits - (exponent << 23));
    let s = (m - 1.0) * recip_within(m + 1.0);
    let s2 = s * s;
    // 2 / (n ln 2)
    let mut p = s2 * 0.320_598_9 + 0.412_198_6;
    p = p * s2 + 0.577_078;
    p = p * s2 + 0.961_796_7;
    p = p * s2 + 2.885_39;
    p * s + from_integer::<L>(exponent)
}

/// `xʸ`, as `exp2(y · log2 x)`.
#[inline(always)]
pub fn pow<L: Lane>(x: L, y: L) -> L {
    x.ge(x.broadcast(TINY)).select(exp2(y * log2(x)), x.broadcast(0.0))
}

/// The angle of the point `(x, y)`, within −π ..= π, counted from the `x` axis toward `y`.
///
/// The arc tangent of the lesser coordinate by the greater, through the polynomial of
/// Abramowitz and Stegun, 4.4.49 (error below 2·10⁻⁸ within 0 ..= 1), then mirrored into its
/// octant.
#[inline(always)]
pub fn atan2<L: Lane>(y: L, x: L) -> L {
    let (x, y) = (flush(x), flush(y));
    let (width, height) = (x.abs(), y.abs());
    let steep = height.gt(width);
    let slope = flush(width.min(height) * recip(width.max(height)));
    let square = slope * slope;
    let mut p = square * 2.866_225_7e-3 - 1.616_573_7e-2;
    p = p * square + 4.290_961_4e-2;
    p = p * square - 7.528_964e-2;
    p = p * square + 1.065_626_4e-1;
    p = p * square - 1.420_89e-1;
    p = p * square + 1.999_355_1e-1;
    p = p * square - 3.333_314_5e-1;
    p = p * square + 1.0;
    let angle = p * slope;
    let angle = steep.select(angle.broadcast(core::f32::consts::FRAC_PI_2) - angle, angle);
    let behind = x.lt(x.broadcast(0.0));
    let angle = behind.select(angle.broadcast(core::f32::consts::PI) - angle, angle);
    y.lt(y.broadcast(0.0)).select(-angle, angle)
}

/// `v` at length 1; a vector shorter than 2⁻⁴⁵ keeps its direction but not that length.
#[inline(always)]
pub fn normalize<L: Lane>(v: V3<L>) -> V3<L> {
    v.scale(rsqrt(v.dot(v)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::Word;
    use crate::lane::flushing::assert_flushing_changes_nothing;

    /// Positive numbers spread over all exponents of the domain, dense within each.
    fn positive() -> impl Iterator<Item = f32> {
        (TINY.to_bits()..HUGE.to_bits()).step_by(10_007).map(f32::from_bits)
    }

    fn ulps(got: f32, exact: f64) -> f64 {
        let rounded = exact as f32;
        let ulp = f64::from(f32::from_bits(rounded.abs().to_bits() + 1)) - f64::from(rounded.abs());
        (f64::from(got) - exact).abs() / ulp
    }

    #[test]
    fn reciprocals_and_roots_are_within_their_ulps() {
        let mut worst = [0.0_f64; 3];
        for x in positive() {
            let wide = f64::from(x);
            worst[0] = worst[0].max(ulps(recip(x), 1.0 / wide)).max(ulps(recip(-x), -1.0 / wide));
            worst[1] = worst[1].max(ulps(rsqrt(x), 1.0 / libm::sqrt(wide)));
            worst[2] = worst[2].max(ulps(sqrt(x), libm::sqrt(wide)));
        }
        assert!(worst[0] <= 2.0 && worst[1] <= 3.0 && worst[2] <= 3.0, "{worst:?}");
    }

    #[test]
    fn reciprocals_of_zero_and_nan_are_finite() {
        assert_eq!(recip(0.0_f32), recip(TINY));
        assert_eq!(recip(-0.0_f32), -recip(TINY));
        assert_eq!(recip(f32::NAN).abs(), recip(HUGE));
        assert_eq!(recip(f32::INFINITY), recip(HUGE));
        assert_eq!(rsqrt(0.0_f32), rsqrt(TINY));
        assert_eq!([sqrt(0.0_f32), sqrt(-1.0), sqrt(f32::NAN)], [0.0; 3]);
    }

    #[test]
    fn exp2_is_within_its_error() {
        for i in -125_999..=126_999 {
            let x = i as f32 * 0.001;
            let exact = libm::exp2(f64::from(x));
            assert!((f64::from(exp2(x)) - exact).abs() <= exact * 2f64.powi(-22), "{x}");
        }
        assert_eq!([exp2(-1e9_f32), exp2(f32::NAN)], [f32::MIN_POSITIVE; 2]);
        assert_eq!([exp2(0.0_f32), exp2(10.0), exp2(-3.0)], [1.0, 1024.0, 0.125]);
    }

    #[test]
    fn sine_and_cosine_are_within_their_error() {
        for i in -10_000..=10_000 {
            let x = i as f32 * 1e-4;
            let angle = f64::from(x) * core::f64::consts::FRAC_PI_4;
            let [sine, cosine] = sine_and_cosine(x).map(f64::from);
            assert!((sine - libm::sin(angle)).abs() <= 2f64.powi(-22), "{x}");
            assert!((cosine - libm::cos(angle)).abs() <= 2f64.powi(-22), "{x}");
        }
    }

    #[test]
    fn log2_is_within_its_error() {
        for x in positive() {
            let exact = libm::log2(f64::from(x));
            let error = (f64::from(log2(x)) - exact).abs();
            // Near 1 the logarithm is small, and keeps its relative precision.
            let size = if (0.75..1.4).contains(&x) { exact.abs() } else { exact.abs().max(1.0) };
            assert!(error <= 2f64.powi(-21) * size, "{x} {error:e} {exact}");
        }
        assert_eq!([log2(1.0_f32), log2(8.0), log2(0.25)], [0.0, 3.0, -2.0]);
    }

    #[test]
    fn pow_is_within_its_error() {
        for i in 1..1000 {
            for y in [0.25_f32, 1.0 / 2.4, 2.4, 16.0, 900.0] {
                let x = i as f32 * 0.001;
                let exact = libm::pow(f64::from(x), f64::from(y));
                let scale = (f64::from(y) * libm::log2(f64::from(x))).abs().max(1.0);
                let bound = exact * 2f64.powi(-19) * scale + 2f64.powi(-120);
                assert!((f64::from(pow(x, y)) - exact).abs() <= bound, "{x} {y}");
            }
        }
        assert_eq!([pow(0.0_f32, 2.0), pow(-1.0, 2.0), pow(f32::NAN, 1.0)], [0.0; 3]);
    }

    #[test]
    fn atan2_is_within_its_error() {
        for i in 0..100_000 {
            let angle = f64::from(i) * 1e-4;
            for size in [1e-6, 1.0, 1e9] {
                let (y, x) = ((libm::sin(angle) * size) as f32, (libm::cos(angle) * size) as f32);
                let exact = libm::atan2(f64::from(y), f64::from(x));
                assert!((f64::from(atan2(y, x)) - exact).abs() <= 2f64.powi(-20), "{y} {x}");
            }
        }
        assert_eq!([atan2(0.0_f32, 0.0), atan2(0.0, 2.0)], [0.0; 2]);
        assert_eq!(
            [atan2(3.0_f32, 0.0), atan2(-3.0, 0.0)],
            [1.0, -1.0].map(|s| s * core::f32::consts::FRAC_PI_2)
        );
        assert_eq!(atan2(0.0_f32, -1.0), core::f32::consts::PI);
    }

    #[test]
    fn functions_give_the_same_bits_where_denormals_are_flushed() {
        let edges = edge_values();
        for &x in &edges {
            assert_flushing_changes_nothing!(of_one(x), x);
            for &y in &edges {
                assert_flushing_changes_nothing!(of_two(x, y), std::format!("{x:e}, {y:e}"));
            }
        }
    }

    fn of_one<L: Lane<Token = (), Bits = Word>>(x: f32) -> [u32; 11] {
        let x = L::splat((), x);
        let whole = flush(x);
        let [sine, cosine] = sine_and_cosine(clamp(x, -1.0, 1.0));
        [
            recip(x),
            rsqrt(x),
            sqrt(x),
            exp2(x),
            log2(x),
            srgb_encode(x),
            srgb_decode(x),
            round(whole),
            floor(whole),
            sine,
            cosine,
        ]
        .map(word)
    }

    fn of_two<L: Lane<Token = (), Bits = Word>>(x: f32, y: f32) -> [u32; 4] {
        let [x, y] = [x, y].map(|x| L::splat((), x));
        let unit = normalize(flush3(V3 { x, y, z: x }));
        [pow(x, y), atan2(y, x), flush(unit.x), flush(unit.y)].map(word)
    }

    /// The bits; one word for every NaN.
    fn word<L: Lane<Bits = Word>>(x: L) -> u32 {
        let bits = x.to_bits().0;
        if bits & 0x7fff_ffff > 0x7f80_0000 { f32::NAN.to_bits() } else { bits }
    }

    /// Zeros, denormals, all powers of two and their neighbors, infinities and NaN, of both signs.
    fn edge_values() -> std::vec::Vec<f32> {
        let powers = (0..=255_u32).flat_map(|e| [(e << 23).saturating_sub(1), e << 23, e << 23 | 1]);
        let denormals = (0..23).map(|bit| 3 << bit);
        powers.chain(denormals).flat_map(|bits| [bits, bits | 0x8000_0000]).map(f32::from_bits).collect()
    }

    #[test]
    fn floor_and_integers_round_trip() {
        for i in -5000..5000 {
            let x = i as f32 * 0.37;
            assert_eq!(floor(x), libm::floorf(x));
            assert_eq!(from_integer::<f32>(to_integer(floor(x))), floor(x));
        }
    }
}
