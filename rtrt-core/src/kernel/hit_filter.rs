//! Hit filters: which hits count, and whether they end a ray.

use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::geometry::Geometry;
use crate::kernel::transparency::alpha_mode;
use crate::kernel::triangle::Intersection;
use crate::lane::{Lane, Select};
use crate::layout::AlphaKind;

/// What a box is around that rays are tested against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounded {
    /// An instance in a list.
    Instance,
    /// A node of a BVH.
    Node,
}

/// Which faces count of instances that are not double-sided: those that are seen from their front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Faces {
    /// All.
    Both,
    /// Whose front is toward the origin: rays of a camera.
    TowardOrigin,
    /// Whose front is toward the end of the ray: rays to a light, which sees a surface as a camera does.
    TowardEnd,
}

/// What a traversal does with the triangles that a group of rays hits.
pub trait HitFilter<L: Lane>: Copy {
    /// Whether a ray may end before all of its hits are found: it then has the limit −1.
    const TERMINATES: bool;
    /// Which faces count, unless the instance is double-sided.
    const FACES: Faces;

    /// Whether an instance has to be tested after its copy `before`: one with the same triangles in the same place,
    /// sides, material and list, and a lower number. A filter for which every surface counts always says so.
    #[inline(always)]
    fn needs_copy(&self, _before: u32, _number: u32) -> bool {
        true
    }

    /// Takes notice that a packet is tested against a box: the first filter of a packet, for counting.
    #[inline(always)]
    fn test_box(&mut self, _: Bounded) {}

    /// Takes notice that a group is tested against a triangle.
    #[inline(always)]
    fn test_triangle(&mut self) {}

    /// Takes an intersection with a triangle, in at least one lane, into `closest` or into the filter itself. Returns
    /// whether the limit of a ray has changed.
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool;
}

/// Accepts the least hit by `(t, instance, triangle)`, for camera rays.
#[derive(Clone, Copy)]
pub struct Closest;

impl<L: Lane> HitFilter<L> for Closest {
    const TERMINATES: bool = false;
    const FACES: Faces = Faces::TowardOrigin;

    #[inline(always)]
    fn needs_copy(&self, _: u32, _: u32) -> bool {
        false
    }

    #[inline(always)]
    fn accept(
        &mut self,
        _: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool {
        closest.keep_closest(intersection, intersection.mask, instance, triangle);
        true
    }
}

/// Whether anything is hit that the end of the ray sees.
#[derive(Clone, Copy)]
pub struct Any;

impl<L: Lane> HitFilter<L> for Any {
    const TERMINATES: bool = true;
    const FACES: Faces = Faces::TowardEnd;

    #[inline(always)]
    fn needs_copy(&self, _: u32, _: u32) -> bool {
        false
    }

    #[inline(always)]
    fn accept(
        &mut self,
        _: &Geometry<'_>,
        _: u32,
        _: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool {
        closest.t = intersection.mask.select(closest.t.broadcast(-1.0), closest.t);
        true
    }
}

/// Finds how far the nearest opaque surface is, whichever side it shows.
#[derive(Clone, Copy)]
pub struct Opaque;

impl<L: Lane> HitFilter<L> for Opaque {
    const TERMINATES: bool = false;
    const FACES: Faces = Faces::Both;

    #[inline(always)]
    fn needs_copy(&self, _: u32, _: u32) -> bool {
        false
    }

    #[inline(always)]
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        _: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool {
        let placed = &geometry.instances[instance as usize];
        if alpha_mode(placed, geometry.mesh_data) != AlphaKind::Opaque as u32 {
            return false;
        }
        closest.t = intersection.mask.select(closest.t.min(intersection.t), closest.t);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::NONE;

    const NOTHING: Geometry<'_> =
        Geometry { instances: &[], nodes: &[], mesh_data: &[], positions: &[], texels: &[], magnitude: 0.0 };

    /// Whether a limit has changed, what it is then, and the instance.
    fn accepted(mut filter: impl HitFilter<f32>) -> (bool, f32, u32) {
        let mut closest = ClosestHit::none(9.0);
        let intersection = Intersection { mask: true, t: 2.0, u: 0.0, v: 0.0 };
        let changed = filter.accept(&NOTHING, 5, 0, &intersection, &mut closest);
        (changed, closest.t, closest.instance.0)
    }

    #[test]
    fn closest_lowers_the_limit_and_any_ends_the_ray() {
        assert_eq!(accepted(Closest), (true, 2.0, 5));
        assert_eq!(accepted(Any), (true, -1.0, NONE));
    }
}
