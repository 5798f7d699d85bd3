//! Colors of vertices: words of two channels, 16 bits each.

use crate::kernel::interpolate::Weights;
use crate::lane::{Bits, Lane, Mask, Select};
use crate::num::{floor, from_integer, to_integer};

/// One step of a channel.
pub(crate) const STEP: f32 = 1.0 / 65_535.0;

/// The lower and the upper channel of a word, within 0 ..= 1.
#[inline(always)]
pub(crate) fn channels<L: Lane>(word: L::Bits) -> [L; 2] {
    [steps::<L>(word) * STEP, steps::<L>(word >> 16) * STEP]
}

/// The steps of the lower channel of a word.
#[inline(always)]
fn steps<L: Lane>(word: L::Bits) -> L {
    from_integer::<L>(word & word.broadcast(0xffff))
}

/// The word between those of three corners, each channel rounded.
#[inline(always)]
pub(crate) fn mixed<L: Lane>(weights: &Weights<L>, [a, b, c, _]: [L::Bits; 4]) -> L::Bits {
    let same = a.eq(b) & b.eq(c);
    if !(!same).any() {
        return a;
    }
    let channel = |shift: u32| {
        let part = |word: L::Bits| steps::<L>(word >> shift);
        let mixed = floor(weights.mix(part(a), part(b), part(c)) + 0.5);
        (to_integer(mixed) & a.broadcast(0xffff)) << shift
    };
    same.select(a, channel(0) | channel(16))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::Word;
    use crate::layout::Attribute;
    use std::vec::Vec;

    #[test]
    fn colors_have_16_bits_a_channel() {
        let [red_green, blue_alpha] = Attribute::pack_color([1.0, 0.0, 0.25, f32::NAN]);
        assert_eq!(channels::<f32>(Word(red_green)), [1.0, 0.0]);
        assert_eq!(channels::<f32>(Word(blue_alpha)), [16_384.0 / 65_535.0, 1.0]);
        assert_eq!(Attribute::pack_color([2.0, -1.0, 1.0, 9.0]), [0xffff, u32::MAX]);
        // A byte x is 257 x steps: 255 · 257 = 65535.
        let bytes = [51, 0, 128, 255].map(|byte: u16| f32::from(byte) / 255.0);
        assert_eq!(Attribute::pack_color(bytes), [51 * 257, 0xffff_0000 + 128 * 257]);
    }

    #[test]
    fn the_steps_of_a_dark_ramp_stay_apart() {
        // The bytes 0 to 63 of sRGB, by its formula (IEC 61966-2-1).
        let linear = |byte: u16| {
            let x = f32::from(byte) / 255.0;
            if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
        };
        let steps: Vec<u32> =
            (0..64).map(|byte| Attribute::pack_color([linear(byte); 4])[0] & 0xffff).collect();
        assert!(steps.windows(2).all(|pair| pair[1] >= pair[0] + 19), "{steps:?}");
    }

    #[test]
    fn corners_are_mixed_by_their_weights() {
        let corner = |low: u32| Word(low | 65_535 << 16);
        let corners = [corner(0), corner(1000), corner(3000), Word(7)];
        // 0.5 times 0, a quarter of 1000, a quarter of 3000.
        assert_eq!(mixed::<f32>(&Weights::new(0.25, 0.25), corners).0, corner(1000).0);
        assert_eq!(mixed::<f32>(&Weights::new(0.3, 0.6), [corners[1]; 4]).0, corners[1].0);
    }
}
