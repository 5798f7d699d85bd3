//! The curve of sRGB (IEC 61966-2-1), both ways.

use super::{FLOOR, ROUND, exp2_within, log2_within, to_integer};
use crate::lane::{Bits, Lane, Select};

const DECODE_SCALE: f32 = 1.0 / 1.055;
const DECODE_SLOPE: f32 = 1.0 / 12.92;
const BYTE_SLOPE: f32 = DECODE_SLOPE / 255.0;

/// The sRGB encoding of linear light (IEC 61966-2-1).
///
/// ```text
/// 12.92 c                     for c ≤ 0.0031308
/// 1.055 c^(1/2.4) − 0.055     above
/// ```
#[inline(always)]
pub fn srgb_encode<L: Lane>(linear: L) -> L {
    // NaN would be white through `clamp`; it is black.
    let c = linear.gt(linear.broadcast(FLOOR)).select(linear, linear.broadcast(0.0));
    encode_up_to_white(c).min(c.broadcast(1.0))
}

/// The encoding of light from 0 on; of more than 1 that of 1, which may be 2⁻²² above 1.
#[inline(always)]
fn encode_up_to_white<L: Lane>(linear: L) -> L {
    let (c, least) = (linear.min(linear.broadcast(1.0)), linear.broadcast(0.003_130_8));
    let curve = encode_power(c.max(least)) - 0.055;
    c.le(least).select(c * 12.92, curve)
}

/// The byte that stands for linear light in sRGB: the nearest step of [`srgb_encode`]; in the middle between two, the even
/// one.
#[inline(always)]
pub fn srgb_byte_encode<L: Lane>(linear: L) -> L::Bits {
    // As in `srgb_encode`, but for what the nearest byte does not show: denormals, and what is above white. NaN is black.
    to_integer(encode_up_to_white(linear.max(linear.broadcast(0.0))) * 255.0)
}

/// `1.055 c^(1/2.4)` of a number within 2⁻⁹ ..= 1.
///
/// The power of its mantissa `m`, from 1 to 2, is a polynomial in `2 − m`, which is fitted to it and in floating
/// point never falls where `m` rises; that of its exponent is a factor for each of the lowest four bits that is
/// not set.
#[inline(always)]
fn encode_power<L: Lane>(c: L) -> L {
    let bits = c.to_bits();
    let mantissa = (bits & bits.broadcast(0x007f_ffff)) | bits.broadcast(0x3f80_0000);
    let z = c.broadcast(2.0) - L::from_bits(mantissa);
    let mut p = z * 2.952_582_5e-3 - 3.332_288e-3;
    p = p * z + 7.392_072e-3;
    p = p * z + 9.821_874e-3;
    p = p * z + 4.305_273_7e-2;
    p = p * z + 2.933_686_7e-1;
    p = c.broadcast(1.408_255_8) - p * z;
    let factor = |bit: u32, unset: f32| {
        let is_unset = (bits & bits.broadcast(bit << 23)).eq(bits.broadcast(0));
        is_unset.select(c.broadcast(unset), c.broadcast(1.0))
    };
    // 2^(−5/12), 2^(−10/12), 2^(−20/12), 2^(−40/12)
    p * (factor(1, 0.749_153_55) * factor(2, 0.561_231) * factor(4, 0.314_980_27) * factor(8, 0.099_212_57))
}

/// The linear light that `encoded` stands for in sRGB (IEC 61966-2-1).
///
/// ```text
/// c / 12.92                   for c ≤ 0.04045
/// ((c + 0.055) / 1.055)^2.4   above
/// ```
#[inline(always)]
pub fn srgb_decode<L: Lane>(encoded: L) -> L {
    let c = encoded.gt(encoded.broadcast(FLOOR)).select(encoded, encoded.broadcast(0.0));
    let c = c.min(c.broadcast(1.0));
    let curve = exp2_within(log2_within((c + 0.055) * DECODE_SCALE) * 2.4);
    c.le(c.broadcast(0.040_45)).select(c * DECODE_SLOPE, curve).min(c.broadcast(1.0))
}

/// The linear light that a byte stands for in sRGB, as [`srgb_decode`] of `byte / 255`, by a polynomial without a
/// power. 0 and 255 are exact.
#[inline(always)]
pub fn srgb_byte_decode<L: Lane>(byte: L::Bits) -> L {
    // Counted from white.
    let z = L::from_bits(byte + byte.broadcast(ROUND.to_bits())) - (ROUND + 255.0);
    // Fitted to the bytes from 11 on, errors weighted by the root of the step to the next byte.
    let mut p = z * 1.066_112_7e-18 + 7.283_928_5e-16;
    p = p * z + 2.234_518_2e-13;
    p = p * z + 2.535_26e-11;
    p = p * z + 1.391_685_8e-8;
    p = p * z + 2.329_839_7e-5;
    p = p * z + 8.922_139e-3;
    p = p * z + 1.0;
    z.lt(z.broadcast(11.0 - 255.0)).select(z * BYTE_SLOPE + 255.0 * BYTE_SLOPE, p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::Word;

    #[test]
    fn srgb_is_within_its_error_and_every_byte_survives() {
        for i in 0..=255_u32 {
            let encoded = i as f32 / 255.0;
            let c = f64::from(encoded);
            let exact = if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) };
            let linear = srgb_decode(encoded);
            assert!((f64::from(linear) - exact).abs() < 2f64.powi(-20), "{i}");
            assert_eq!(srgb_byte_encode(linear).0, i);
        }
        assert_eq!([srgb_encode(-1.0_f32), srgb_encode(f32::NAN)], [0.0; 2]);
        assert_eq!(srgb_encode(2.0_f32), srgb_encode(1.0));
        assert!((1.0 - srgb_encode(1.0_f32)).abs() < 2f32.powi(-20));
    }

    #[test]
    fn light_is_encoded_within_its_error_and_more_light_never_as_less() {
        let mut last = 0.0;
        for i in 0..=1 << 20 {
            let linear = i as f32 / 1_048_576.0;
            let c = f64::from(linear);
            let exact = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * libm::pow(c, 1.0 / 2.4) - 0.055 };
            let encoded = srgb_encode(linear);
            assert!((f64::from(encoded) - exact).abs() < 2f64.powi(-20), "{linear}");
            assert!(encoded >= last, "{linear}");
            last = encoded;
        }
    }

    #[test]
    fn a_byte_is_the_nearest_to_the_encoding() {
        let numbers = (0..1 << 16).map(|high| f32::from_bits(high << 16 | 0x5a5a));
        for linear in numbers.chain([f32::INFINITY, -0.0, 1.0, 0.003_130_8]) {
            let nearest = libm::rint(f64::from(srgb_encode(linear)) * 255.0);
            assert_eq!(f64::from(srgb_byte_encode(linear).0), nearest, "{linear:e}");
        }
    }

    #[test]
    fn bytes_are_decoded_within_their_error() {
        let exact = |byte: u32| {
            let c = f64::from(byte) / 255.0;
            if byte <= 10 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
        };
        for byte in 0..=255 {
            let light = srgb_byte_decode::<f32>(Word(byte));
            let error = (f64::from(light) - exact(byte)).abs();
            assert!(
                error <= 2f64.powi(-17) && error <= (exact(byte + 1) - exact(byte)) / 300.0,
                "{byte} {error:e}"
            );
            assert_eq!(srgb_byte_encode(light).0, byte);
        }
        assert_eq!(
            [0, 255].map(|byte| srgb_byte_decode::<f32>(Word(byte)).to_bits()),
            [0.0, 1.0].map(f32::to_bits)
        );
    }
}
