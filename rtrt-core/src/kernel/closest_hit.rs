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
