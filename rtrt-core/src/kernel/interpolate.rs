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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_have_their_own_values_and_a_point_between_has_its_share_of_each() {
        let at = |u: f32, v: f32| Weights::new(u, v).mix(8.0, 16.0, -4.0);
        assert_eq!([at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)], [8.0, 16.0, -4.0]);
        // 1/4 · 8 + 1/4 · 16 − 1/2 · 4
        assert_eq!(at(0.25, 0.5), 4.0);
        let v = |x: f32| V3 { x, y: 2.0 * x, z: -x };
        let mixed = Weights::new(0.25, 0.5).mix3(v(8.0), v(16.0), v(-4.0));
        assert_eq!(mixed.lane(0), [4.0, 8.0, -4.0]);
    }
}
