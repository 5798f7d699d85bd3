//! Values between the corners of a triangle.

use crate::lane::{Lane, V3};

/// The weights of a triangle's corners at a hit. They sum to 1, up to rounding.
#[derive(Clone, Copy)]
pub struct Weights<L> {
    a: L,
    b: L,
    c: L,
}

impl<L: Lane> Weights<L> {
    /// `(1 − u − v, u, v)`.
    #[inline(always)]
    pub fn new(u: L, v: L) -> Self {
        Self { a: (u.broadcast(1.0) - u) - v, b: u, c: v }
    }
    /// `a · x + b · y + c · z`, from left to right.
    #[inline(always)]
    pub fn mix(&self, x: L, y: L, z: L) -> L {
        self.a * x + self.b * y + self.c * z
    }
    /// [`Weights::mix`] of each component.
    #[inline(always)]
    pub fn mix3(&self, x: V3<L>, y: V3<L>, z: V3<L>) -> V3<L> {
        V3 { x: self.mix(x.x, y.x, z.x), y: self.mix(x.y, y.y, z.y), z: self.mix(x.z, y.z, z.z) }
    }
}
