//! Lanes of 8 and 16 numbers.
//!
//! `fearless_simd` keeps proof of the instruction set (its token) inside every number, so
//! no unsafe code is needed to use it.

use super::Wide;
use core::ops::{Add, BitAnd, BitOr, Mul, Neg, Not, Shl, Shr, Sub};
use fearless_simd::{
    Bytes, ExtractToken, Select as _, Simd, SimdBase, SimdMask, SimdSplit, f32x8, mask32x8, u32x8,
};
#[cfg(target_arch = "x86_64")]
use fearless_simd::{f32x16, mask32x16, u32x16};
use rtrt_core::lane::{Bits, Lane, Mask, Select};

/// Work that runs as a function of its own. As a method of the work, it is compiled in the unit of the module
/// where the work is written: a function of this module would have all stages in one unit.
trait Outline<R> {
    /// Runs it with these instructions.
    fn outline<S: Simd>(self, token: S) -> R;
}

impl<R, W: FnOnce() -> R> Outline<R> for W {
    #[inline(never)]
    fn outline<S: Simd>(self, token: S) -> R {
        token.vectorize(self)
    }
}

/// Implements an operator by the same operator of the inner type.
macro_rules! pass {
    ($type:ident: $($operator:ident $name:ident $($right:ident)?;)*) => {$(
        pass!(@ $type $operator $name $($right)?);
    )*};
    (@ $type:ident Neg neg) => { pass!(@@ $type Neg neg); };
    (@ $type:ident Not not) => { pass!(@@ $type Not not); };
    (@@ $type:ident $operator:ident $name:ident) => {
        impl<S: Simd> $operator for $type<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self) -> Self {
                Self($operator::$name(self.0))
            }
        }
    };
    (@ $type:ident $operator:ident $name:ident) => {
        impl<S: Simd> $operator for $type<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self($operator::$name(self.0, other.0))
            }
        }
    };
    (@ $type:ident $operator:ident $name:ident $right:ident) => {
        impl<S: Simd> $operator<$right> for $type<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: $right) -> Self {
                Self($operator::$name(self.0, other))
            }
        }
    };
}

/// The larger half of a vector, again and again; then of four numbers.
macro_rules! largest {
    ($v:expr, 16) => {{
        let (low, high) = $v.split();
        largest!(low.max(high), 8)
    }};
    ($v:expr, 8) => {{
        let (low, high) = $v.split();
        let [a, b, c, d]: [f32; 4] = low.max(high).into();
        let (a, c) = (if a < b { b } else { a }, if c < d { d } else { c });
        if a < c { c } else { a }
    }};
}

/// The columns of a matrix of as many rows as there are lanes.
macro_rules! columns {
    ($lane:path, $vector:ident, $token:ident, $rows:expr, $width:tt) => {{
        let (first, last) = $rows.as_flattened().split_at(2 * $width);
        let ((a, b), (c, d)) = (first.split_at($width), last.split_at($width));
        let (a, b) = ($vector::from_slice($token, a), $vector::from_slice($token, b));
        let (c, d) = ($vector::from_slice($token, c), $vector::from_slice($token, d));
        let (upper, lower) = (a.deinterleave(b), c.deinterleave(d));
        let (x, z) = upper.0.deinterleave(lower.0);
        let (y, w) = upper.1.deinterleave(lower.1);
        [$lane(x), $lane(y), $lane(z), $lane(w)]
    }};
}

macro_rules! lane {
    ($float:ident, $bits:ident, $mask:ident, $f:ident, $u:ident, $m:ident, $width:tt) => {
        #[doc = concat!(stringify!($width), " numbers side by side.")]
        #[derive(Clone, Copy)]
        pub struct $float<S: Simd>($f<S>);
        /// Their bits.
        #[derive(Clone, Copy)]
        pub struct $bits<S: Simd>($u<S>);
        /// What their comparisons give.
        #[derive(Clone, Copy)]
        pub struct $mask<S: Simd>($m<S>);

        pass!($float: Neg neg; Add add; Sub sub; Mul mul; Add add f32; Sub sub f32; Mul mul f32;);
        pass!($bits: Add add; Sub sub; Mul mul; BitAnd bitand; BitOr bitor; Shl shl u32; Shr shr u32;);
        pass!($mask: BitAnd bitand; BitOr bitor; Not not;);

        impl<S: Simd> Mask for $mask<S> {
            #[inline(always)]
            fn any(self) -> bool {
                self.0.any_true()
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                self.0.to_bitmask() as u32
            }
        }

        impl<S: Simd> Select<$float<S>> for $mask<S> {
            #[inline(always)]
            fn select(self, if_true: $float<S>, if_false: $float<S>) -> $float<S> {
                $float(self.0.select(if_true.0, if_false.0))
            }
        }

        impl<S: Simd> Select<$bits<S>> for $mask<S> {
            #[inline(always)]
            fn select(self, if_true: $bits<S>, if_false: $bits<S>) -> $bits<S> {
                $bits(self.0.select(if_true.0, if_false.0))
            }
        }

        impl<S: Simd> Bits for $bits<S> {
            type Mask = $mask<S>;
            type Row = [u32; $width];

            #[inline(always)]
            fn broadcast(self, value: u32) -> Self {
                Self($u::splat(self.0.token(), value))
            }
            #[inline(always)]
            fn xor(self, other: Self) -> Self {
                Self(self.0 ^ other.0)
            }
            #[inline(always)]
            fn eq(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_eq(other.0))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_lt(other.0))
            }
            #[inline(always)]
            fn row(self) -> [u32; $width] {
                self.0.into()
            }
        }

        impl<S: Simd> Wide for $float<S> {
            #[inline(always)]
            fn load(token: S, words: &[u32]) -> $bits<S> {
                $bits($u::from_slice(token, &words[..$width]))
            }
            #[inline(always)]
            fn store(words: $bits<S>, to: &mut [u32]) {
                to[..$width].copy_from_slice(&words.row());
            }
        }

        impl<S: Simd> Lane for $float<S> {
            type Token = S;
            type Mask = $mask<S>;
            type Bits = $bits<S>;
            type Row = [f32; $width];

            const WIDTH: usize = $width;

            #[inline(always)]
            fn outlined<R>(token: S, work: impl FnOnce() -> R) -> R {
                work.outline(token)
            }
            #[inline(always)]
            fn splat(token: S, value: f32) -> Self {
                Self($f::splat(token, value))
            }
            #[inline(always)]
            fn gather<const N: usize>(token: S, f: impl Fn(usize) -> [f32; N]) -> [Self; N] {
                let mut rows = [[0.0; $width]; N];
                for lane in 0..$width {
                    let values = f(lane);
                    for (row, value) in rows.iter_mut().zip(values) {
                        row[lane] = value;
                    }
                }
                let mut loaded = [Self::splat(token, 0.0); N];
                for (loaded, row) in loaded.iter_mut().zip(&rows) {
                    *loaded = Self($f::from_slice(token, row));
                }
                loaded
            }
            #[inline(always)]
            fn gather_fours<const N: usize>(
                token: S,
                f: impl Fn(usize) -> [[f32; 4]; N],
            ) -> [[Self; 4]; N] {
                let mut fours = [[[0.0; 4]; $width]; N];
                for lane in 0..$width {
                    let values = f(lane);
                    for (four, value) in fours.iter_mut().zip(values) {
                        four[lane] = value;
                    }
                }
                let mut loaded = [[Self::splat(token, 0.0); 4]; N];
                for (loaded, four) in loaded.iter_mut().zip(&fours) {
                    *loaded = columns!(Self, $f, token, four, $width);
                }
                loaded
            }
            #[inline(always)]
            fn bits_from_fn(token: S, f: impl Fn(usize) -> u32) -> $bits<S> {
                let mut row = [0; $width];
                for (lane, value) in row.iter_mut().enumerate() {
                    *value = f(lane);
                }
                $bits($u::from_slice(token, &row))
            }
            #[inline(always)]
            fn gather_bits(token: S, f: impl Fn(usize) -> [u32; 4]) -> [$bits<S>; 4] {
                let mut fours = [[0; 4]; $width];
                for (lane, four) in fours.iter_mut().enumerate() {
                    *four = f(lane);
                }
                columns!($bits, $u, token, fours, $width)
            }
            #[inline(always)]
            fn token(self) -> S {
                self.0.token()
            }
            #[inline(always)]
            fn row(self) -> [f32; $width] {
                self.0.into()
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_lt(other.0))
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_le(other.0))
            }
            // One instruction of x86 is the comparison and selection that `Lane` defines: the
            // second number where they are equal or either is NaN. Other machines' minimum
            // treats those otherwise.
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(self.0.min(other.0))
            }
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(self.0.max(other.0))
            }
            #[inline(always)]
            fn largest(self) -> f32 {
                largest!(self.0, $width)
            }
            #[inline(always)]
            fn to_bits(self) -> $bits<S> {
                $bits(self.0.bitcast())
            }
            #[inline(always)]
            fn from_bits(bits: $bits<S>) -> Self {
                Self(bits.0.bitcast())
            }
        }
    };
}

lane!(Float8, Bits8, Mask8, f32x8, u32x8, mask32x8, 8);
#[cfg(target_arch = "x86_64")]
lane!(Float16, Bits16, Mask16, f32x16, u32x16, mask32x16, 16);
