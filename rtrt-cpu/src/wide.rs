//! Lanes that slices of words are read into and written from: 1 number, and with the feature `simd` 8 and 16.

#[cfg(feature = "simd")]
mod simd;

use rtrt_core::lane::{Lane, Word};
#[cfg(feature = "simd")]
pub use simd::Float8;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
pub use simd::Float16;

/// Lanes that slices of words are read into and written from.
pub trait Wide: Lane {
    /// The words that a slice begins with.
    fn load(token: Self::Token, words: &[u32]) -> Self::Bits;
    /// Makes a slice begin with these words.
    fn store(words: Self::Bits, to: &mut [u32]);
}

impl Wide for f32 {
    #[inline(always)]
    fn load((): (), words: &[u32]) -> Word {
        Word(words[0])
    }
    #[inline(always)]
    fn store(word: Word, to: &mut [u32]) {
        to[0] = word.0;
    }
}
