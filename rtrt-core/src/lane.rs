//! Numbers that kernels compute with: one `f32`, or several side by side.
//!
//! A kernel is written once, generic over [`Lane`]. `f32` is the lane of width 1 and is
//! what a GPU invocation runs; a CPU backend instantiates wider ones. Every operation is
//! the IEEE 754 operation on each lane, rounded on its own, so widths agree by
//! construction. There is no division, no square root and no fused multiply-add here:
//! devices do not agree on them (see [`crate::num`]).

#[cfg(test)]
pub(crate) mod flushing;
#[cfg(any(test, feature = "alloc"))]
pub(crate) mod plain;

use core::ops::{Add, BitAnd, BitOr, Mul, Neg, Not, Shl, Shr, Sub};

/// One truth value per lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Whether any lane is true.
    fn any(self) -> bool;
    /// Bit `i` is 1 where lane `i` is true.
    fn bits(self) -> u32;
}

/// Picks between two values, lane by lane.
pub trait Select<T>: Copy {
    /// `if_true` where the mask is true, `if_false` elsewhere.
    fn select(self, if_true: T, if_false: T) -> T;
}

/// The numbers of a lane one by one, in memory.
pub trait Row<T>: Copy {
    /// The number in lane `index`; `index` is below the lane's width.
    fn at(&self, index: usize) -> T;
}

impl<T: Copy, const WIDTH: usize> Row<T> for [T; WIDTH] {
    #[inline(always)]
    fn at(&self, index: usize) -> T {
        self[index]
    }
}

/// The bits of a [`Lane`], as unsigned 32-bit integers. Arithmetic wraps.
pub trait Bits:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// The mask that comparisons give.
    type Mask: Mask;
    /// The numbers one by one.
    type Row: Row<u32>;

    /// The same number in every lane, shaped like `self`.
    fn broadcast(self, value: u32) -> Self;
    /// Exclusive or.
    fn xor(self, other: Self) -> Self;
    /// Equality, lane by lane.
    fn eq(self, other: Self) -> Self::Mask;
    /// Unsigned less-than, lane by lane.
    fn lt(self, other: Self) -> Self::Mask;
    /// Unsigned greater-than, lane by lane.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// The numbers one by one. Take them out once, before a loop over lanes.
    fn row(self) -> Self::Row;
    /// The number in lane `index`; `index` is below the lane's width.
    #[inline(always)]
    fn lane(self, index: usize) -> u32 {
        self.row().at(index)
    }
}

/// A number type that kernels are generic over.
///
/// Comparisons with NaN are false, as in IEEE 754.
pub trait Lane:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// Proof that the machine can run this lane; `()` where none is needed.
    type Token: Copy;
    /// What comparisons give.
    type Mask: Mask + Select<Self> + Select<Self::Bits>;
    /// The bits of the number.
    type Bits: Bits<Mask = Self::Mask>;
    /// The numbers one by one.
    type Row: Row<f32>;

    /// How many numbers there are side by side.
    const WIDTH: usize;

    /// Runs `work` with the lanes' instructions, as a function of its own: what is inlined in many places takes the
    /// compiler far longer.
    #[inline(never)]
    fn outlined<R>(_: Self::Token, work: impl FnOnce() -> R) -> R {
        work()
    }

    /// `value` in every lane.
    fn splat(token: Self::Token, value: f32) -> Self;
    /// `N` numbers whose lanes 0, 1, … are `f(0)`, `f(1)`, ….
    fn gather<const N: usize>(token: Self::Token, f: impl Fn(usize) -> [f32; N]) -> [Self; N];
    /// `N` times four numbers whose lanes 0, 1, … are `f(0)`, `f(1)`, …; for what lies in memory
    /// by fours.
    fn gather_fours<const N: usize>(token: Self::Token, f: impl Fn(usize) -> [[f32; 4]; N])
    -> [[Self; 4]; N];
    /// `f(0)`, `f(1)`, … in lanes 0, 1, …, as bits.
    fn bits_from_fn(token: Self::Token, f: impl Fn(usize) -> u32) -> Self::Bits;
    /// Four words whose lanes 0, 1, … are `f(0)`, `f(1)`, ….
    fn gather_bits(token: Self::Token, f: impl Fn(usize) -> [u32; 4]) -> [Self::Bits; 4];
    /// The token that made this number.
    fn token(self) -> Self::Token;
    /// The numbers one by one. Take them out once, before a loop over lanes.
    fn row(self) -> Self::Row;
    /// The number in lane `index`; `index` is below [`Lane::WIDTH`].
    #[inline(always)]
    fn lane(self, index: usize) -> f32 {
        self.row().at(index)
    }

    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self ≤ other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self ≥ other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// The IEEE 754 bits.
    fn to_bits(self) -> Self::Bits;
    /// The number with these IEEE 754 bits.
    fn from_bits(bits: Self::Bits) -> Self;

    /// `f(0)`, `f(1)`, … in lanes 0, 1, ….
    #[inline(always)]
    fn from_fn(token: Self::Token, f: impl Fn(usize) -> f32) -> Self {
        Self::gather(
            token,
            #[inline(always)]
            |lane| [f(lane)],
        )[0]
    }
    /// `value` in every lane, shaped like `self`.
    #[inline(always)]
    fn broadcast(self, value: f32) -> Self {
        Self::splat(self.token(), value)
    }
    /// `value` in every lane, as bits, shaped like `self`.
    #[inline(always)]
    fn broadcast_bits(self, value: u32) -> Self::Bits {
        self.to_bits().broadcast(value)
    }
    /// The smaller; `other` where the comparison fails, as for NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }
    /// The larger; `other` where the comparison fails, as for NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.gt(other).select(self, other)
    }
    /// What is set in any lane of `bits`.
    #[inline(always)]
    fn union(bits: Self::Bits) -> u32 {
        let row = bits.row();
        let mut union = row.at(0);
        let mut lane = 1;
        while lane < Self::WIDTH {
            union |= row.at(lane);
            lane += 1;
        }
        union
    }
    /// The smallest of the lanes, none of which may be NaN.
    #[inline(always)]
    fn smallest(self) -> f32 {
        -(-self).largest()
    }
    /// The largest of the lanes, none of which may be NaN.
    #[inline(always)]
    fn largest(self) -> f32 {
        let row = self.row();
        let mut largest = row.at(0);
        let mut lane = 1;
        while lane < Self::WIDTH {
            largest = <f32 as Lane>::max(largest, row.at(lane));
            lane += 1;
        }
        largest
    }
    /// The number without its sign.
    #[inline(always)]
    fn abs(self) -> Self {
        Self::from_bits(self.to_bits() & self.broadcast_bits(0x7fff_ffff))
    }
    /// The sign bit alone.
    #[inline(always)]
    fn sign_bit(self) -> Self::Bits {
        self.to_bits() & self.broadcast_bits(0x8000_0000)
    }
    /// `self`, negated where `sign` has its top bit set.
    #[inline(always)]
    fn flip_sign(self, sign: Self::Bits) -> Self {
        Self::from_bits(self.to_bits().xor(sign))
    }
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self as u32
    }
}

impl<T> Select<T> for bool {
    #[inline(always)]
    fn select(self, if_true: T, if_false: T) -> T {
        if self { if_true } else { if_false }
    }
}

/// `u32` as [`Bits`], wrapping: plain `u32` would panic on overflow in a debug build.
#[derive(Clone, Copy)]
pub struct Word(pub u32);

macro_rules! word_operator {
    ($($operator:ident $name:ident $right:ty, $a:ident $b:ident => $result:expr;)*) => {$(
        impl $operator<$right> for Word {
            type Output = Self;
            #[inline(always)]
            fn $name(self, $b: $right) -> Self {
                let $a = self.0;
                Self($result)
            }
        }
    )*};
}
word_operator! {
    Add add Word, a b => a.wrapping_add(b.0);
    Sub sub Word, a b => a.wrapping_sub(b.0);
    Mul mul Word, a b => a.wrapping_mul(b.0);
    BitAnd bitand Word, a b => a & b.0;
    BitOr bitor Word, a b => a | b.0;
    Shl shl u32, a b => a << b;
    Shr shr u32, a b => a >> b;
}

impl Bits for Word {
    type Mask = bool;
    type Row = [u32; 1];

    #[inline(always)]
    fn broadcast(self, value: u32) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Self(self.0 ^ other.0)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self.0 == other.0
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self.0 < other.0
    }
    #[inline(always)]
    fn row(self) -> [u32; 1] {
        [self.0]
    }
}

impl Lane for f32 {
    type Token = ();
    type Mask = bool;
    type Bits = Word;
    type Row = [f32; 1];

    const WIDTH: usize = 1;

    #[inline(always)]
    fn splat(_: (), value: f32) -> Self {
        value
    }
    #[inline(always)]
    fn gather<const N: usize>(_: (), f: impl Fn(usize) -> [f32; N]) -> [Self; N] {
        f(0)
    }
    #[inline(always)]
    fn gather_fours<const N: usize>(_: (), f: impl Fn(usize) -> [[f32; 4]; N]) -> [[Self; 4]; N] {
        f(0)
    }
    #[inline(always)]
    fn bits_from_fn(_: (), f: impl Fn(usize) -> u32) -> Word {
        Word(f(0))
    }
    #[inline(always)]
    fn gather_bits(_: (), f: impl Fn(usize) -> [u32; 4]) -> [Word; 4] {
        let [a, b, c, d] = f(0);
        [Word(a), Word(b), Word(c), Word(d)]
    }
    #[inline(always)]
    fn token(self) {}
    #[inline(always)]
    fn row(self) -> [f32; 1] {
        [self]
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn to_bits(self) -> Word {
        Word(f32::to_bits(self))
    }
    #[inline(always)]
    fn from_bits(bits: Word) -> Self {
        f32::from_bits(bits.0)
    }
}

/// Three numbers: a point, a direction, a normal.
#[derive(Clone, Copy)]
pub struct V3<L> {
    /// First component.
    pub x: L,
    /// Second component.
    pub y: L,
    /// Third component.
    pub z: L,
}

impl<L: Lane> V3<L> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(token: L::Token, v: [f32; 3]) -> Self {
        Self { x: L::splat(token, v[0]), y: L::splat(token, v[1]), z: L::splat(token, v[2]) }
    }
    /// `f(0)`, `f(1)`, … in lanes 0, 1, ….
    #[inline(always)]
    pub fn from_fn(token: L::Token, f: impl Fn(usize) -> [f32; 3]) -> Self {
        let [x, y, z] = L::gather(token, f);
        Self { x, y, z }
    }
    /// The vector in lane `index`.
    #[inline(always)]
    pub fn lane(self, index: usize) -> [f32; 3] {
        self.row().at(index)
    }
    /// The components one lane after another. Take them out once, before a loop over lanes.
    #[inline(always)]
    pub fn row(self) -> V3<L::Row> {
        V3 { x: self.x.row(), y: self.y.row(), z: self.z.row() }
    }
    /// `x·x' + y·y' + z·z'`, summed from left to right.
    #[inline(always)]
    pub fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
    /// The cross product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }
    /// Every component multiplied by `factor`.
    #[inline(always)]
    pub fn scale(self, factor: L) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
    /// The smaller of each component.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { x: self.x.min(other.x), y: self.y.min(other.y), z: self.z.min(other.z) }
    }
    /// The larger of each component.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }
    /// `if_true` where `mask` is true, `if_false` elsewhere.
    #[inline(always)]
    pub fn select(mask: L::Mask, if_true: Self, if_false: Self) -> Self {
        Self {
            x: mask.select(if_true.x, if_false.x),
            y: mask.select(if_true.y, if_false.y),
            z: mask.select(if_true.z, if_false.z),
        }
    }
}

impl<R: Row<f32>> V3<R> {
    /// The vector in lane `index`.
    #[inline(always)]
    pub fn at(&self, index: usize) -> [f32; 3] {
        [self.x.at(index), self.y.at(index), self.z.at(index)]
    }
}

impl<L: Lane> Add for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<L: Lane> Sub for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<L: Lane> Neg for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

/// The product of each component.
#[inline(always)]
pub fn times<L: Lane>(a: V3<L>, b: V3<L>) -> V3<L> {
    V3 { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z }
}

/// `[f(0), f(1), …]`; `core::array::from_fn` does not compile for GPUs.
#[inline(always)]
pub fn groups<T: Copy, const G: usize>(f: impl Fn(usize) -> T) -> [T; G] {
    let mut all = [f(0); G];
    let mut group = 1;
    while group < G {
        all[group] = f(group);
        group += 1;
    }
    all
}
