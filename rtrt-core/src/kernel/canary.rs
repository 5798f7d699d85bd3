//! A sample of every kernel that decides what a frame looks like, as words: what a device
//! is asked when it is opened, and what the CPU compares the answer with.

use crate::kernel::ray::Ray;
use crate::kernel::slab::{Around, meets, slab};
use crate::kernel::triangle::{Triangle, meet};
use crate::lane::V3;
use crate::num;

/// How many words [`canary`] gives.
pub const OUTPUTS: usize = 17;

/// What each word of [`canary`] is.
pub const NAMES: [&str; OUTPUTS] = [
    "recip",
    "rsqrt",
    "sqrt",
    "exp2",
    "log2",
    "pow",
    "srgb_encode",
    "srgb_decode",
    "floor",
    "round",
    "slab near",
    "slab far",
    "box met",
    "triangle met",
    "t",
    "u",
    "v",
];

/// Words that one case reads, from its own on: a ray's origin and direction, and the three
/// corners of a triangle.
pub const INPUTS: u32 = 15;

/// The kernels' answers to the words from `index` on, read as numbers and wrapping at the
/// end of `words`; see [`NAMES`].
///
/// Functions of one number get word `index`; [`num::pow`] gets its exponent from the next
/// one. The ray and the triangle are made of 15 words, put in range as a mesh's positions
/// are. Results that are NaN become one and the same NaN: devices choose different ones.
#[inline(always)]
pub fn canary(words: &[u32], index: u32) -> [u32; OUTPUTS] {
    let count = words.len() as u32;
    if count == 0 {
        return [0; OUTPUTS];
    }
    let number = |offset: u32| f32::from_bits(words[((index + offset) % count) as usize]);
    let corner = |offset: u32| {
        [coordinate(number(offset)), coordinate(number(offset + 1)), coordinate(number(offset + 2))]
    };
    let x = number(0);
    // Whole numbers are asked for of nothing that a device may flush.
    let whole = num::flush(x);
    let ray: Ray<f32> = Ray::new(V3::splat((), corner(0)), V3::splat((), corner(3)));
    let triangle = Triangle::new(corner(6), corner(9), corner(12));
    let (low, high) = triangle.bounds();
    let around = Around::new(ray.origin, &low, &high);
    let (near, far) = slab(&ray, &around);
    let met = meet(&ray, &triangle, &triangle.seen_from(ray.origin), f32::MAX);
    let of_hit = |value: f32| if met.mask { bits(value) } else { 0 };
    [
        bits(num::recip(x)),
        bits(num::rsqrt(x)),
        bits(num::sqrt(x)),
        bits(num::exp2(x)),
        bits(num::log2(x)),
        bits(num::pow(x, number(1))),
        bits(num::srgb_encode(x)),
        bits(num::srgb_decode(x)),
        bits(num::floor(whole)),
        bits(num::round(whole)),
        bits(near),
        bits(far),
        meets(&ray, &around, f32::MAX) as u32,
        met.mask as u32,
        of_hit(met.t),
        of_hit(met.u),
        of_hit(met.v),
    ]
}

/// The number's bits; one word for every NaN.
#[inline(always)]
fn bits(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits & 0x7fff_ffff > 0x7f80_0000 { 0x7fc0_0000 } else { bits }
}

/// A coordinate as a mesh may have it: 0 or of a magnitude within 2⁻⁶⁰ ..= 2³⁰; NaN is 0.
#[inline(always)]
fn coordinate(value: f32) -> f32 {
    let bits = value.to_bits();
    let size = bits & 0x7fff_ffff;
    let (tiny, nan) = (size < (127 - 60) << 23, size > 0x7f80_0000);
    if tiny || nan {
        0.0
    } else if size > (127 + 30) << 23 {
        f32::from_bits((127 + 30) << 23 | bits & 0x8000_0000)
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_whatever_the_words_are() {
        assert_eq!(canary(&[], 3), [0; OUTPUTS]);
        let words = [f32::NAN, 0.0, f32::INFINITY, 1e-40, -3.5].map(f32::to_bits);
        for index in [0, 1, 4, 900] {
            assert_ne!(canary(&words, index), [0; OUTPUTS]);
        }
    }

    #[test]
    fn a_triangle_ahead_is_met() {
        let ray_and_triangle =
            [0.2, 0.3, -2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32];
        let found = canary(&ray_and_triangle.map(f32::to_bits), 0);
        assert_eq!(found[13], 1);
        for (got, exact) in found[14..].iter().zip([2.0_f32, 0.2, 0.3]) {
            // Two roundings of the reciprocal and one of the product.
            assert!(got.abs_diff(exact.to_bits()) <= 3, "{} is not {exact}", f32::from_bits(*got));
        }
    }
}
