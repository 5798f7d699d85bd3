//! A sample of every kernel that decides what a frame looks like, as words: what a device
//! is asked when it is opened, and what the CPU compares the answer with.

use crate::kernel::area::disc;
use crate::kernel::ray::Ray;
use crate::kernel::slab::{RelativeBox, intersects, slab};
use crate::kernel::triangle::{Triangle, intersect};
use crate::lane::{Bits, Lane, Select, V3};
use crate::num;

/// How many words [`canary`] gives.
pub const OUTPUTS: usize = 19;

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
    "disc across",
    "disc up",
];

/// Words that one case reads, from its own on: a ray's origin and direction, and the three
/// corners of a triangle.
pub const INPUTS: u32 = 15;

/// The kernels' answers to the words from `index` on, read as numbers and wrapping at the
/// end of `words`, which are not none; see [`NAMES`]. Lane `i` is the case of the words from
/// `index + i` on.
///
/// Functions of one number get word `index`; [`num::pow`] gets its exponent from the next
/// one. The ray and the triangle are made of 15 words, put in range as a mesh's positions
/// are; a packet of rays is asked for the triangle of each lane in turn. Results that are NaN
/// become one and the same NaN: devices choose different ones.
#[inline(always)]
pub fn canary<L: Lane>(token: L::Token, words: &[u32], index: u32) -> [L::Bits; OUTPUTS] {
    let x = L::from_bits(L::bits_from_fn(
        token,
        #[inline(always)]
        |lane| word(words, index + lane as u32),
    ));
    let y = L::from_bits(L::bits_from_fn(
        token,
        #[inline(always)]
        |lane| word(words, index + 1 + lane as u32),
    ));
    let origin = V3::from_fn(
        token,
        #[inline(always)]
        |lane| corner(words, index + lane as u32),
    );
    let direction = V3::from_fn(
        token,
        #[inline(always)]
        |lane| corner(words, index + 3 + lane as u32),
    );
    // Whole numbers are asked for of nothing that a device may flush.
    let whole = num::flush(x);
    let found = rays::<L>(&Ray::new(origin, direction), words, index);
    let within = |number: L| num::clamp(num::flush(number), -1.0, 1.0);
    let [across, up] = disc(within(x), within(y));
    [
        bits(num::recip(x)),
        bits(num::rsqrt(x)),
        bits(num::sqrt(x)),
        bits(num::exp2(x)),
        bits(num::log2(x)),
        bits(num::pow(x, y)),
        bits(num::srgb_encode(x)),
        bits(num::srgb_decode(x)),
        bits(num::floor(whole)),
        bits(num::round(whole)),
        found.near,
        found.far,
        found.in_box,
        found.met,
        found.t,
        found.u,
        found.v,
        bits(num::flush(across)),
        bits(num::flush(up)),
    ]
}

/// What each ray of a packet makes of a triangle and of its box.
#[derive(Clone, Copy)]
struct Found<B> {
    near: B,
    far: B,
    in_box: B,
    met: B,
    t: B,
    u: B,
    v: B,
}

/// Each ray's answers for its own lane's triangle.
#[inline(always)]
fn rays<L: Lane>(ray: &Ray<L>, words: &[u32], index: u32) -> Found<L::Bits> {
    let (none, one) = (ray.origin.x.broadcast_bits(0), ray.origin.x.broadcast_bits(1));
    let mut found = Found { near: none, far: none, in_box: none, met: none, t: none, u: none, v: none };
    let numbers = L::bits_from_fn(
        ray.origin.x.token(),
        #[inline(always)]
        |lane| lane as u32,
    );
    let mut lane = 0;
    while lane < L::WIDTH as u32 {
        let at = index + lane;
        let triangle = Triangle::new(corner(words, at + 6), corner(words, at + 9), corner(words, at + 12));
        let (low, high) = triangle.bounds();
        let around = RelativeBox::new(ray.origin, &low, &high);
        let (near, far) = slab(ray, &around);
        let in_box = intersects(ray, &around, near.broadcast(f32::MAX));
        let hit = intersect(ray, &triangle, &triangle.relative_to(ray.origin), near.broadcast(f32::MAX));
        let here = numbers.eq(none.broadcast(lane));
        let met = here & hit.mask;
        found = Found {
            near: here.select(bits(near), found.near),
            far: here.select(bits(far), found.far),
            in_box: (here & in_box).select(one, found.in_box),
            met: met.select(one, found.met),
            t: met.select(bits(hit.t), found.t),
            u: met.select(bits(hit.u), found.u),
            v: met.select(bits(hit.v), found.v),
        };
        lane += 1;
    }
    found
}

/// A word; after the last comes the first.
#[inline(always)]
fn word(words: &[u32], index: u32) -> u32 {
    words[(index % words.len() as u32) as usize]
}

/// A point made of three words.
#[inline(always)]
fn corner(words: &[u32], index: u32) -> [f32; 3] {
    [
        coordinate(f32::from_bits(word(words, index))),
        coordinate(f32::from_bits(word(words, index + 1))),
        coordinate(f32::from_bits(word(words, index + 2))),
    ]
}

/// The number's bits; one word for every NaN.
#[inline(always)]
fn bits<L: Lane>(value: L) -> L::Bits {
    let bits = value.to_bits();
    let size = value.abs().to_bits();
    size.gt(bits.broadcast(0x7f80_0000)).select(bits.broadcast(0x7fc0_0000), bits)
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

    fn answers(words: &[u32], index: u32) -> [u32; OUTPUTS] {
        canary::<f32>((), words, index).map(|word| word.0)
    }

    #[test]
    fn answers_whatever_the_words_are() {
        let words = [f32::NAN, 0.0, f32::INFINITY, 1e-40, -3.5].map(f32::to_bits);
        for index in [0, 1, 4, 900] {
            assert_ne!(answers(&words, index), [0; OUTPUTS]);
        }
    }

    #[test]
    fn a_triangle_ahead_is_met() {
        let ray_and_triangle =
            [0.2, 0.3, -2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32];
        let found = answers(&ray_and_triangle.map(f32::to_bits), 0);
        assert_eq!(found[13], 1);
        for (got, exact) in found[14..17].iter().zip([2.0_f32, 0.2, 0.3]) {
            // Two roundings of the reciprocal and one of the product.
            assert!(got.abs_diff(exact.to_bits()) <= 3, "{} is not {exact}", f32::from_bits(*got));
        }
    }
}
