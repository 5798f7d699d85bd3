//! Several lanes in arrays, which compilers turn into the target's vectors: four for single rays, and as many as
//! tests of packets want. Backends bring their own.

use crate::lane::{Bits, Lane, Mask, Select};
use core::ops::{Add, BitAnd, BitOr, Mul, Neg, Not, Shl, Shr, Sub};

/// Numbers side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain<const N: usize>(pub [f32; N]);
/// Their bits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlainBits<const N: usize>(pub [u32; N]);
/// What comparing them gives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlainMask<const N: usize>(pub [bool; N]);

/// `f` of each lane of two values.
#[inline(always)]
fn zip<A: Copy, B: Copy, R, const N: usize>(a: [A; N], b: [B; N], f: impl Fn(A, B) -> R) -> [R; N] {
    core::array::from_fn(|lane| f(a[lane], b[lane]))
}

/// Implements an operator of two values lane by lane.
macro_rules! lanewise {
    ($($kind:ident $operator:ident $name:ident, $a:ident $b:ident => $result:expr;)*) => {$(
        impl<const N: usize> $operator for $kind<N> {
            type Output = Self;
            // Tests of stages compile in a fraction of the time where operators are calls.
            #[cfg_attr(test, inline(never))]
            fn $name(self, other: Self) -> Self {
                Self(zip(self.0, other.0, |$a, $b| $result))
            }
        }
    )*};
}
lanewise! {
    Plain Add add, a b => a + b;
    Plain Sub sub, a b => a - b;
    Plain Mul mul, a b => a * b;
    PlainBits Add add, a b => a.wrapping_add(b);
    PlainBits Sub sub, a b => a.wrapping_sub(b);
    PlainBits Mul mul, a b => a.wrapping_mul(b);
    PlainBits BitAnd bitand, a b => a & b;
    PlainBits BitOr bitor, a b => a | b;
    PlainMask BitAnd bitand, a b => a && b;
    PlainMask BitOr bitor, a b => a || b;
}

/// Implements an operator of each lane and one number.
macro_rules! with_one {
    ($($kind:ident $operator:ident $name:ident $one:ty, $a:ident $b:ident => $result:expr;)*) => {$(
        impl<const N: usize> $operator<$one> for $kind<N> {
            type Output = Self;
            #[cfg_attr(test, inline(never))]
            fn $name(self, $b: $one) -> Self {
                Self(self.0.map(|$a| $result))
            }
        }
    )*};
}
with_one! {
    Plain Add add f32, a b => a + b;
    Plain Sub sub f32, a b => a - b;
    Plain Mul mul f32, a b => a * b;
    PlainBits Shl shl u32, a b => a << b;
    PlainBits Shr shr u32, a b => a >> b;
}

impl<const N: usize> Neg for Plain<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<const N: usize> Not for PlainMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|is_true| !is_true))
    }
}

impl<const N: usize> Mask for PlainMask<N> {
    #[inline(always)]
    fn any(self) -> bool {
        self.0.contains(&true)
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..N).map(|lane| u32::from(self.0[lane]) << lane).sum()
    }
}

impl<const N: usize> Select<Plain<N>> for PlainMask<N> {
    #[cfg_attr(test, inline(never))]
    #[cfg_attr(not(test), inline(always))]
    fn select(self, a: Plain<N>, b: Plain<N>) -> Plain<N> {
        Plain(core::array::from_fn(|lane| if self.0[lane] { a.0[lane] } else { b.0[lane] }))
    }
}

impl<const N: usize> Select<PlainBits<N>> for PlainMask<N> {
    #[cfg_attr(test, inline(never))]
    #[cfg_attr(not(test), inline(always))]
    fn select(self, a: PlainBits<N>, b: PlainBits<N>) -> PlainBits<N> {
        PlainBits(core::array::from_fn(|lane| if self.0[lane] { a.0[lane] } else { b.0[lane] }))
    }
}

impl<const N: usize> Bits for PlainBits<N> {
    type Mask = PlainMask<N>;
    type Row = [u32; N];

    #[inline(always)]
    fn broadcast(self, value: u32) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Self(zip(self.0, other.0, |a, b| a ^ b))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> PlainMask<N> {
        PlainMask(zip(self.0, other.0, |a, b| a == b))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> PlainMask<N> {
        PlainMask(zip(self.0, other.0, |a, b| a < b))
    }
    #[inline(always)]
    fn row(self) -> [u32; N] {
        self.0
    }
}

impl<const N: usize> Lane for Plain<N> {
    type Token = ();
    type Mask = PlainMask<N>;
    type Bits = PlainBits<N>;
    type Row = [f32; N];

    const WIDTH: usize = N;

    #[inline(always)]
    fn splat((): (), value: f32) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn gather<const M: usize>((): (), f: impl Fn(usize) -> [f32; M]) -> [Self; M] {
        core::array::from_fn(|number| Self(core::array::from_fn(|lane| f(lane)[number])))
    }
    #[inline(always)]
    fn gather_fours<const M: usize>((): (), f: impl Fn(usize) -> [[f32; 4]; M]) -> [[Self; 4]; M] {
        core::array::from_fn(|four| Self::gather((), |lane| f(lane)[four]))
    }
    #[inline(always)]
    fn bits_from_fn((): (), f: impl Fn(usize) -> u32) -> PlainBits<N> {
        PlainBits(core::array::from_fn(f))
    }
    #[inline(always)]
    fn gather_bits((): (), f: impl Fn(usize) -> [u32; 4]) -> [PlainBits<N>; 4] {
        core::array::from_fn(|number| PlainBits(core::array::from_fn(|lane| f(lane)[number])))
    }
    #[inline(always)]
    fn token(self) {}
    #[inline(always)]
    fn row(self) -> [f32; N] {
        self.0
    }
    #[inline(always)]
    fn lt(self, other: Self) -> PlainMask<N> {
        PlainMask(zip(self.0, other.0, |a, b| a < b))
    }
    #[inline(always)]
    fn le(self, other: Self) -> PlainMask<N> {
        PlainMask(zip(self.0, other.0, |a, b| a <= b))
    }
    #[inline(always)]
    fn to_bits(self) -> PlainBits<N> {
        PlainBits(self.0.map(f32::to_bits))
    }
    #[inline(always)]
    fn from_bits(bits: PlainBits<N>) -> Self {
        Self(bits.0.map(f32::from_bits))
    }
}
