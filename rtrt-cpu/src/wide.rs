//! Lanes whose work can be compiled in parts: 1 number, and with the feature `simd` 8 and 16.

#[cfg(feature = "simd")]
mod simd;

use rtrt_core::lane::{Lane, Word};
#[cfg(feature = "simd")]
pub use simd::Float8;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
pub use simd::Float16;

/// Lanes whose work can be compiled in parts.
pub trait Wide: Lane {
    /// Runs `work` with the lanes' instructions, as a function of its own: one function of all
    /// stages takes the compiler far longer than one for each.
    fn outlined<R>(token: Self::Token, work: impl FnOnce() -> R) -> R;
    /// The words that a slice begins with.
    fn load(token: Self::Token, words: &[u32]) -> Self::Bits;
    /// Makes a slice begin with these words.
    fn store(words: Self::Bits, to: &mut [u32]);
}

impl Wide for f32 {
    #[inline(never)]
    fn outlined<R>((): (), work: impl FnOnce() -> R) -> R {
        work()
    }
    #[inline(always)]
    fn load((): (), words: &[u32]) -> Word {
        Word(words[0])
    }
    #[inline(always)]
    fn store(word: Word, to: &mut [u32]) {
        to[0] = word.0;
    }
}
