//! The closest hit of a group of rays.

use crate::kernel::triangle::Intersection;
use crate::lane::{Bits, Lane, Row, Select, Word};
use crate::layout::{Hit, NONE};

/// The closest hit so far of one group of rays, a ray a lane.
///
/// `t` is also how far a ray is still traced: a ray that is not traced has a negative one.
#[derive(Clone, Copy)]
pub struct ClosestHit<L: Lane> {
    /// Where on the ray.
    pub t: L,
    /// The instance.
    pub instance: L::Bits,
    /// The triangle of the instance's mesh.
    pub triangle: L::Bits,
    /// Barycentric weight of the second corner.
    pub u: L,
    /// Barycentric weight of the third corner.
    pub v: L,
}

/// A [`ClosestHit`] whose lanes are in memory, one after another.
#[derive(Clone, Copy)]
pub struct ClosestHitRows<L: Lane> {
    t: L::Row,
    instance: <L::Bits as Bits>::Row,
    triangle: <L::Bits as Bits>::Row,
    u: L::Row,
    v: L::Row,
}

impl<L: Lane> ClosestHit<L> {
    /// No hit yet, of rays that are traced up to `limit`.
    #[inline(always)]
    pub fn none(limit: L) -> Self {
        let (none, zero) = (limit.broadcast_bits(NONE), limit.broadcast(0.0));
        Self { t: limit, instance: none, triangle: none, u: zero, v: zero }
    }

    /// Takes over the intersection with a triangle in the lanes of `mask` in which it is the lesser by
    /// `(t, instance, triangle)`.
    #[inline(always)]
    pub(crate) fn keep_closest(
        &mut self,
        intersection: &Intersection<L>,
        mask: L::Mask,
        instance: u32,
        triangle: u32,
    ) {
        let (instance, triangle) = (self.instance.broadcast(instance), self.instance.broadcast(triangle));
        // Equal t: the lower instance, then the lower triangle.
        let earlier = instance.lt(self.instance) | (instance.eq(self.instance) & triangle.lt(self.triangle));
        let closer = mask & (intersection.t.lt(self.t) | (intersection.t.le(self.t) & earlier));
        self.t = closer.select(intersection.t, self.t);
        self.u = closer.select(intersection.u, self.u);
        self.v = closer.select(intersection.v, self.v);
        self.instance = closer.select(instance, self.instance);
        self.triangle = closer.select(triangle, self.triangle);
    }

    /// The hits `f(0)`, `f(1)`, … in lanes 0, 1, ….
    #[inline(always)]
    pub fn from_fn(token: L::Token, f: impl Fn(usize) -> Hit) -> Self {
        let [instance, triangle, _, _] = L::gather_bits(
            token,
            #[inline(always)]
            |lane| [f(lane).instance, f(lane).triangle, 0, 0],
        );
        let [t, u, v] = L::gather(
            token,
            #[inline(always)]
            |lane| [f(lane).t, f(lane).u, f(lane).v],
        );
        Self { t, instance, triangle, u, v }
    }

    /// The lanes one by one. Take them out once, before a loop over lanes.
    #[inline(always)]
    pub fn rows(&self) -> ClosestHitRows<L> {
        ClosestHitRows {
            t: self.t.row(),
            instance: self.instance.row(),
            triangle: self.triangle.row(),
            u: self.u.row(),
            v: self.v.row(),
        }
    }
}

impl<L: Lane> ClosestHitRows<L> {
    /// The instance in one lane.
    #[inline(always)]
    pub fn instance(&self, lane: usize) -> u32 {
        self.instance.at(lane)
    }
    /// The triangle in one lane.
    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> u32 {
        self.triangle.at(lane)
    }
    /// The record of one lane.
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> Hit {
        let instance = self.instance.at(lane);
        if instance == NONE {
            return Hit::MISS;
        }
        Hit {
            t: self.t.at(lane),
            instance,
            triangle: self.triangle.at(lane),
            u: self.u.at(lane),
            v: self.v.at(lane),
        }
    }
}

impl ClosestHit<f32> {
    /// A lane of width 1 from its record.
    #[inline(always)]
    pub fn new(hit: &Hit) -> Self {
        Self { t: hit.t, instance: Word(hit.instance), triangle: Word(hit.triangle), u: hit.u, v: hit.v }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(t: f32) -> Intersection<f32> {
        Intersection { mask: true, t, u: 0.25, v: 0.5 }
    }

    #[test]
    fn the_least_by_t_then_instance_then_triangle_is_kept_whatever_the_order() {
        let hits = [(2.0, 1, 1), (1.0, 4, 0), (1.0, 3, 7), (1.0, 3, 5), (3.0, 0, 0)];
        for first in 0..hits.len() {
            let mut closest = ClosestHit::none(9.0_f32);
            assert_eq!(closest.rows().hit(0), Hit::MISS);
            for i in 0..hits.len() {
                let (t, instance, triangle) = hits[(first + 2 * i) % hits.len()];
                closest.keep_closest(&at(t), true, instance, triangle);
            }
            let expected = Hit { t: 1.0, instance: 3, triangle: 5, u: 0.25, v: 0.5 };
            assert_eq!(closest.rows().hit(0), expected);
            assert_eq!(ClosestHit::new(&expected).rows().hit(0), expected);
        }
    }

    #[test]
    fn what_is_masked_or_beyond_the_limit_is_not_kept() {
        let mut closest = ClosestHit::none(2.0_f32);
        closest.keep_closest(&at(1.0), false, 0, 0);
        closest.keep_closest(&at(2.5), true, 0, 0);
        assert_eq!((closest.t, closest.instance.0), (2.0, NONE));
    }
}
