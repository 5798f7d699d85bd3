//! A device that flushes denormals, for tests.

use crate::lane::{Lane, Word};
use core::ops::{Add, Mul, Neg, Sub};

/// A lane of width 1 whose arithmetic takes denormals for 0 and gives 0 for them, as some GPUs do.
/// Bits pass as they are: a load, a selection or a reinterpretation is no arithmetic.
///
/// With `COMPARES`, comparisons take denormals for 0 as well. The specifications of Vulkan and
/// WebGPU allow each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flushing<const COMPARES: bool>(pub f32);

/// `x`, or the zero of its sign for a denormal.
fn flushed(x: f32) -> f32 {
    if x.is_subnormal() { f32::from_bits(x.to_bits() & 0x8000_0000) } else { x }
}

macro_rules! flushing_operator {
    ($($operator:ident $name:ident $symbol:tt;)*) => {$(
        impl<const COMPARES: bool> $operator for Flushing<COMPARES> {
            type Output = Self;
            // A kernel of calls compiles in a fraction of the time.
            #[inline(never)]
            fn $name(self, other: Self) -> Self {
                Self(flushed(flushed(self.0) $symbol flushed(other.0)))
            }
        }
        impl<const COMPARES: bool> $operator<f32> for Flushing<COMPARES> {
            type Output = Self;
            fn $name(self, other: f32) -> Self {
                self $symbol Self(other)
            }
        }
    )*};
}
flushing_operator! {
    Add add +;
    Sub sub -;
    Mul mul *;
}

impl<const COMPARES: bool> Neg for Flushing<COMPARES> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-flushed(self.0))
    }
}

impl<const COMPARES: bool> Flushing<COMPARES> {
    /// What a comparison sees.
    fn compared(self) -> f32 {
        if COMPARES { flushed(self.0) } else { self.0 }
    }
}

impl<const COMPARES: bool> Lane for Flushing<COMPARES> {
    type Token = ();
    type Mask = bool;
    type Bits = Word;
    type Row = [f32; 1];

    const WIDTH: usize = 1;

    fn splat((): (), value: f32) -> Self {
        Self(value)
    }
    fn gather<const N: usize>((): (), f: impl Fn(usize) -> [f32; N]) -> [Self; N] {
        f(0).map(Self)
    }
    fn gather_fours<const N: usize>((): (), f: impl Fn(usize) -> [[f32; 4]; N]) -> [[Self; 4]; N] {
        f(0).map(|four| four.map(Self))
    }
    fn bits_from_fn((): (), f: impl Fn(usize) -> u32) -> Word {
        Word(f(0))
    }
    fn gather_bits((): (), f: impl Fn(usize) -> [u32; 4]) -> [Word; 4] {
        f(0).map(Word)
    }
    fn token(self) {}
    fn row(self) -> [f32; 1] {
        [self.0]
    }
    fn lt(self, other: Self) -> bool {
        self.compared() < other.compared()
    }
    fn le(self, other: Self) -> bool {
        self.compared() <= other.compared()
    }
    fn to_bits(self) -> Word {
        Word(self.0.to_bits())
    }
    fn from_bits(bits: Word) -> Self {
        Self(f32::from_bits(bits.0))
    }
}

/// Asserts that a function generic over [`Lane`] gives the same words on both kinds of device as on
/// one that keeps denormals.
macro_rules! assert_flushing_changes_nothing {
    ($function:ident($($argument:expr),*), $what:expr) => {{
        use $crate::lane::flushing::Flushing;
        let kept = $function::<f32>($($argument),*);
        for flushed in [$function::<Flushing<true>>($($argument),*), $function::<Flushing<false>>($($argument),*)] {
            assert_eq!(flushed, kept, "{}", $what);
        }
    }};
}
pub(crate) use assert_flushing_changes_nothing;

#[test]
fn denormals_count_for_nothing() {
    let (tiny, least) = (Flushing::<true>(1e-40), Flushing::<true>(f32::MIN_POSITIVE));
    assert_eq!(
        [(tiny + tiny).0, (tiny * 1e30).0, (least * 0.5).0, (least - tiny).0],
        [0.0, 0.0, 0.0, least.0]
    );
    assert!(!tiny.gt(Flushing(0.0)) && Flushing::<false>(1e-40).gt(Flushing(0.0)));
    assert_eq!((-tiny).0.to_bits(), 0x8000_0000);
    assert_eq!((Flushing::<true>(3.0) * 0.25 - 1.0).0, -0.25);
}
