//! Which hits count, and what they do to a ray.

use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::geometry::Geometry;
use crate::kernel::triangle::Intersection;
use crate::lane::{Lane, Mask, Select};

/// What a traversal does with the triangles that a group of rays hits.
pub trait HitFilter<L: Lane>: Copy {
    /// Whether a ray may end before all of its hits are found: it then has the limit −1.
    const TERMINATES: bool;
    /// Whether only front faces count, unless the instance is double-sided.
    const CULLS_BACK_FACES: bool;

    /// Takes an intersection with a triangle into `closest` or into the filter itself. Returns whether the
    /// limit of a ray has changed.
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool;
}

/// The least hit, by `(t, instance, triangle)`, of what the camera sees.
#[derive(Clone, Copy)]
pub struct Closest;

impl<L: Lane> HitFilter<L> for Closest {
    const TERMINATES: bool = false;
    const CULLS_BACK_FACES: bool = true;

    #[inline(always)]
    fn accept(
        &mut self,
        _: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool {
        if !intersection.mask.any() {
            return false;
        }
        closest.keep_closest(intersection, intersection.mask, instance, triangle);
        true
    }
}

/// Whether there is any hit, from either side.
#[derive(Clone, Copy)]
pub struct Any;

impl<L: Lane> HitFilter<L> for Any {
    const TERMINATES: bool = true;
    const CULLS_BACK_FACES: bool = false;

    #[inline(always)]
    fn accept(
        &mut self,
        _: &Geometry<'_>,
        _: u32,
        _: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool {
        if !intersection.mask.any() {
            return false;
        }
        closest.t = intersection.mask.select(closest.t.broadcast(-1.0), closest.t);
        true
    }
}
