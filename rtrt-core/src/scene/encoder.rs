//! Light as sRGB bytes, by a table.

use crate::num::{srgb_byte_encode, srgb_decode};
use alloc::vec::Vec;

/// The bits of light that choose where a search begins: 2⁻⁷ of the light, or less.
const SHIFT: u32 = 16;
/// Where the search begins at byte 0: 2⁻¹³, which is darker than byte 1.
const DARK: u32 = (127 - 13) << (23 - SHIFT);
/// White.
const WHITE: u32 = 127 << (23 - SHIFT);

/// [`srgb_byte_encode`], without its polynomial.
pub(super) struct Encoder {
    /// The least light of each byte; behind the last one, none.
    least: [f32; 257],
    /// The byte of the least light with these leading bits.
    bytes: Vec<u8>,
}

impl Encoder {
    pub fn new() -> Self {
        let mut least = [0.0; 257];
        least[256] = f32::INFINITY;
        for byte in 1..=255 {
            least[byte as usize] = least_light(byte);
        }
        let start = |bits: u32| {
            let light = f32::from_bits(bits << SHIFT);
            (least.partition_point(|&least| least <= light) - 1) as u8
        };
        Self { least, bytes: (DARK..=WHITE).map(start).collect() }
    }

    /// The byte of light within 0 ..= 1.
    #[inline(always)]
    pub fn byte(&self, light: f32) -> u32 {
        let key = (light.to_bits() >> SHIFT).clamp(DARK, WHITE) - DARK;
        let mut byte = usize::from(self.bytes[key as usize]);
        while light >= self.least[byte + 1] {
            byte += 1;
        }
        byte as u32
    }
}

/// The least light whose byte is this one or more. It is near the light between two bytes.
fn least_light(byte: u32) -> f32 {
    let is_enough = |bits: u32| srgb_byte_encode(f32::from_bits(bits)).0 >= byte;
    let near = srgb_decode((byte as f32 - 0.5) / 255.0).to_bits();
    let (mut low, mut high, mut step) = (near, near, 1);
    while is_enough(low) {
        low -= step;
        step *= 2;
    }
    step = 1;
    while !is_enough(high) {
        high += step;
        step *= 2;
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if is_enough(middle) { high = middle } else { low = middle }
    }
    f32::from_bits(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ops::RangeInclusive;

    /// That the table has the bytes of the formula for all of these lights.
    fn assert_same(encoder: &Encoder, bits: RangeInclusive<u32>) {
        for light in bits.map(f32::from_bits) {
            assert_eq!(encoder.byte(light), srgb_byte_encode(light).0, "{light:e}");
        }
    }

    #[test]
    fn bytes_are_those_of_the_formula() {
        let encoder = Encoder::new();
        // The formula rounds, so other bytes would be around a byte's least light (docs/experiments.md has all numbers).
        for byte in 1..=255 {
            let least = encoder.least[byte].to_bits();
            assert_same(&encoder, least - 3000..=least + 3000);
        }
        for light in (0..1 << 20).map(|i| i as f32 / 1048576.0).chain([1.0, 1e-40, 1e-10]) {
            assert_eq!(encoder.byte(light), srgb_byte_encode(light).0, "{light:e}");
        }
    }
}
