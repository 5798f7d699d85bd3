//! Queries: what a ray of a program's own meets, among all instances.

use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::geometry::Geometry;
use crate::kernel::hit_filter::{Faces, HitFilter};
use crate::kernel::packet::{Packet, PacketHits, ray_hit_mask};
use crate::kernel::ray::Ray;
use crate::kernel::sphere::ENTRY;
use crate::kernel::tiles::Tiles;
use crate::kernel::transparency::{alpha_mode, passes_mask, tint_and_alpha};
use crate::kernel::traverse::{STACK, intersect_sphere, traverse};
use crate::kernel::triangle::Intersection;
use crate::lane::{Lane, V3};
use crate::layout::{AlphaKind, Hit, QueryFrame, RayRecord};

/// Directions are within these lengths: 2⁻³², 2³².
const SHORTEST: f32 = f32::from_bits((127 - 32) << 23);
const LONGEST: f32 = f32::from_bits((127 + 32) << 23);
/// Starts are within this: 2³⁰.
const FARTHEST: f32 = f32::from_bits((127 + 30) << 23);

/// A scene, as rays search it. The geometry's nodes end with the tree over the instances: each of its leaves holds
/// the number of one instance.
#[derive(Clone, Copy)]
pub struct QueryWorld<'a> {
    /// Its numbers.
    pub frame: &'a QueryFrame,
    /// All instances with their meshes.
    pub geometry: Geometry<'a>,
    /// The groups of each instance; 0 if it is hidden.
    pub masks: &'a [u32],
}

/// The closest hit on a ray.
#[inline(always)]
pub fn closest(world: &QueryWorld<'_>, record: &RayRecord) -> Hit {
    search::<false>(world, record).rows().hit(0)
}

/// 1 if the ray hits anything, 0 if not.
#[inline(always)]
pub fn occluded(world: &QueryWorld<'_>, record: &RayRecord) -> u32 {
    (search::<true>(world, record).t < 0.0) as u32
}

/// The closest hit, or with `ANY` a hit at −1 if there is one.
#[inline(always)]
fn search<const ANY: bool>(world: &QueryWorld<'_>, record: &RayRecord) -> ClosestHit<f32> {
    let QueryWorld { frame, geometry, masks } = world;
    let none = ClosestHit::none(record.to);
    let is_long = largest(&record.direction) >= SHORTEST;
    if !is_long || !is_within(&record.direction, LONGEST) || !is_within(&record.origin, FARTHEST) {
        return none;
    }
    let magnitude = Lane::max(frame.magnitude, largest(&record.origin));
    let pad = frame.slack * magnitude;
    let ray = Ray::<f32>::new(V3::splat((), record.origin), V3::splat((), record.direction));
    let direction = ray.direction.lane(0);
    let mut hits = PacketHits::new([none]);
    let mut filters = [Asked::<ANY> { ray, from: record.from, options: record.options }];
    let mut stack = [0_u32; STACK];
    stack[0] = frame.root;
    let mut waiting = 1_usize;
    while waiting > 0 {
        waiting -= 1;
        let node = geometry.nodes[stack[waiting] as usize];
        let (low, high) = node.widened(pad);
        if ray_hit_mask(&[ray], &low, &high, 1, &hits.closest) == 0 {
            continue;
        }
        if !node.is_leaf() {
            // The near child is looked at first.
            let far_first = (direction[node.kind as usize] < 0.0) as u32;
            stack[waiting] = frame.root + node.first + 1 - far_first;
            stack[waiting + 1] = frame.root + node.first + far_first;
            waiting += 2;
            continue;
        }
        let number = node.first;
        if node.triangles() == 0 || number == record.skip || masks[number as usize] & record.mask == 0 {
            continue;
        }
        let instance = &geometry.instances[number as usize];
        let rays =
            if instance.is_identity == 1 || instance.is_sphere() { [ray] } else { [ray.to_object(instance)] };
        let tiles = Tiles::of(&rays, &hits.closest, 1);
        let packet = Packet { rays: &rays, tiles: &tiles };
        if instance.is_sphere() {
            intersect_sphere(geometry, number, &packet, 1, &mut hits, &mut filters);
        } else {
            traverse(geometry, number, &packet, 1, &mut hits, &mut filters);
        }
        if ANY && hits.closest[0].t < 0.0 {
            break;
        }
    }
    hits.closest[0]
}

/// The largest component, in magnitude.
#[inline(always)]
fn largest(v: &[f32; 3]) -> f32 {
    Lane::max(Lane::max(Lane::abs(v[0]), Lane::abs(v[1])), Lane::abs(v[2]))
}

/// Whether all components are numbers of up to this magnitude.
#[inline(always)]
fn is_within(v: &[f32; 3], limit: f32) -> bool {
    Lane::abs(v[0]) <= limit && Lane::abs(v[1]) <= limit && Lane::abs(v[2]) <= limit
}

/// Accepts what a ray asks for.
#[derive(Clone, Copy)]
struct Asked<const ANY: bool> {
    /// World space.
    ray: Ray<f32>,
    from: f32,
    options: u32,
}

impl<const ANY: bool> Asked<ANY> {
    /// Whether the ray counts the side of the triangle that it hits.
    #[inline(always)]
    fn counts_side(&self, geometry: &Geometry<'_>, number: u32, triangle: u32, t: f32) -> bool {
        let sides = self.options & 3;
        let instance = &geometry.instances[number as usize];
        if sides == RayRecord::BOTH || sides == RayRecord::DRAWN && instance.double_sided == 1 {
            return true;
        }
        let is_front = if instance.is_sphere() {
            triangle == ENTRY
        } else {
            let is_identity = instance.is_identity == 1;
            let local = if is_identity { self.ray } else { self.ray.to_object(instance) };
            geometry.triangle(instance, triangle).relative_to(local.origin).front(t)
        };
        is_front != (sides == RayRecord::BACKS)
    }

    /// Whether the ray passes a hole there.
    #[inline(always)]
    fn passes_hole(
        &self,
        geometry: &Geometry<'_>,
        number: u32,
        triangle: u32,
        intersection: &Intersection<f32>,
    ) -> bool {
        let instance = &geometry.instances[number as usize];
        if self.options & RayRecord::THROUGH_HOLES == 0
            || alpha_mode(instance, geometry.mesh_data) != AlphaKind::Mask as u32
        {
            return false;
        }
        let [_, _, _, alpha] = tint_and_alpha(geometry, number, triangle, intersection);
        !passes_mask(geometry, number, alpha)
    }
}

impl<const ANY: bool> HitFilter<f32> for Asked<ANY> {
    const TERMINATES: bool = ANY;
    const FACES: Faces = Faces::Both;

    #[inline(always)]
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &Intersection<f32>,
        closest: &mut ClosestHit<f32>,
    ) -> bool {
        let counts = intersection.mask
            && intersection.t >= self.from
            && self.counts_side(geometry, instance, triangle, intersection.t)
            && !self.passes_hole(geometry, instance, triangle, intersection);
        if counts && ANY {
            closest.t = -1.0;
        } else if counts {
            closest.keep_closest(intersection, true, instance, triangle);
        }
        counts
    }
}
