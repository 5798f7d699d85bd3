//! Inspect: what it takes to find the closest hit of one ray, counted. For pictures of how the
//! lists work, never for frames.

use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::geometry::Geometry;
use crate::kernel::hit_filter::{Bounded, Closest, Faces, HitFilter};
use crate::kernel::packet::PacketHits;
use crate::kernel::ray::Ray;
use crate::kernel::triangle::Intersection;
use crate::lane::V3;
use crate::layout::{Frame, Hit, Instance};
use crate::stage::context::Context;
use crate::stage::visibility::trace;

/// What it took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inspection {
    /// Entries in the list of the ray's block.
    pub entries: u32,
    /// Those that the ray was tested against before nothing nearer could follow.
    pub tested: u32,
    /// Boxes tested, of instances and of nodes.
    pub boxes: u32,
    /// Triangles tested, and sides of spheres. Triangles that turn away from the camera are culled
    /// before, unless their instance is double-sided.
    pub triangles: u32,
    /// Whether the ray hits the bounding sphere of an entry.
    pub sphere: bool,
    /// The closest hit: that of the stage `visibility`, bit for bit.
    pub hit: Hit,
}

/// Traces one ray of the camera through the list of its block, as an invocation of a GPU does.
/// (A packet tests fewer boxes, for all of its rays at once, and more triangles.)
pub fn inspect(context: &Context<'_>, block: u32, ray: &Ray<f32>) -> Inspection {
    let [first, last] = context.lists.range(block);
    let instance = |entry| &context.geometry.instances[context.lists.entry(entry).instance as usize];
    let Frame { near, far, .. } = *context.frame;
    let mut hits = PacketHits::new([ClosestHit::none(far)]);
    let mut filters = [Counting { near, instances: 0, nodes: 0, triangles: 0 }];
    trace(context, block, &[*ray], &mut [*ray], &mut hits, &mut filters);
    let [Counting { instances, nodes, triangles, .. }] = filters;
    Inspection {
        entries: last - first,
        tested: instances,
        boxes: instances + nodes,
        triangles,
        sphere: (first..last).any(|entry| hits_sphere(ray, instance(entry))),
        hit: hits.closest[0].rows().hit(0),
    }
}

/// [`Closest`], counting.
#[derive(Clone, Copy)]
struct Counting {
    /// Hits up to here do not count, as those before the near plane.
    near: f32,
    /// Boxes of instances.
    instances: u32,
    /// Boxes of nodes.
    nodes: u32,
    triangles: u32,
}

impl HitFilter<f32> for Counting {
    const TERMINATES: bool = <Closest as HitFilter<f32>>::TERMINATES;
    const FACES: Faces = <Closest as HitFilter<f32>>::FACES;

    fn test_box(&mut self, bounded: Bounded) {
        match bounded {
            Bounded::Instance => self.instances += 1,
            Bounded::Node => self.nodes += 1,
        }
    }

    fn test_triangle(&mut self) {
        self.triangles += 1;
    }

    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &Intersection<f32>,
        closest: &mut ClosestHit<f32>,
    ) -> bool {
        intersection.t > self.near && Closest.accept(geometry, instance, triangle, intersection, closest)
    }
}

/// Whether the ray's line passes within the radius of the instance's bounding sphere:
/// `|(c − o) × d|² ≤ r² · |d|²`.
fn hits_sphere(ray: &Ray<f32>, instance: &Instance) -> bool {
    let across = (V3::splat((), instance.center) - ray.origin).cross(ray.direction);
    across.dot(across) <= instance.radius * instance.radius * ray.direction.dot(ray.direction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::lists::BlockLists;
    use crate::layout::{Attribute, NONE};
    use crate::scene::{Bvh, Material, Mesh, Scene, Sequential};
    use bytemuck::Zeroable;
    use std::vec;

    /// What is found on a ray that goes along −z from this height, with lists that hold instance 0.
    fn found(scene: &Scene, from: [f32; 3]) -> Inspection {
        let geometry = Geometry {
            instances: scene.instances(),
            nodes: scene.nodes(),
            mesh_data: scene.mesh_data(),
            positions: scene.positions(),
            texels: scene.texels(),
            magnitude: 1.0,
        };
        let lists = BlockLists { data: &[0, 1, 0, 0], blocks: 1 };
        let frame = Frame { far: f32::MAX, ..Frame::zeroed() };
        let context = Context { frame: &frame, views: &[], lists, geometry };
        inspect(&context, 0, &Ray::new(V3::splat((), from), V3::splat((), [0.0, 0.0, -1.0])))
    }

    /// A triangle that faces +z, and its material.
    fn triangle(double_sided: bool, to_world: glam::Mat4) -> Scene {
        let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(corners, vec![Attribute::zeroed(); 3], vec![0, 1, 2]).unwrap();
        let mut scene = Scene::new();
        let white = Material::default().double_sided(double_sided);
        let white = scene.add_material(white).unwrap();
        let stored = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
        scene.add_instance(stored, white, to_world).unwrap();
        scene
    }

    #[test]
    fn a_ray_past_a_triangle_meets_its_sphere_only() {
        let scene = triangle(true, glam::Mat4::IDENTITY);
        let hit = found(&scene, [0.25, 0.25, 1.0]);
        assert_eq!((hit.hit.instance, hit.entries, hit.tested), (0, 1, 1));
        assert_eq!((hit.boxes, hit.triangles, hit.sphere), (1, 1, true));
        let past = found(&scene, [0.9, 0.9, 1.0]);
        assert_eq!((past.hit.instance, past.boxes, past.triangles, past.sphere), (NONE, 1, 1, true));
        let far = found(&scene, [3.0, 3.0, 1.0]);
        assert_eq!((far.boxes, far.triangles, far.sphere), (1, 0, false));
    }

    #[test]
    fn a_back_is_met_if_both_sides_are_to_be_seen() {
        let turned = glam::Mat4::from_rotation_y(core::f32::consts::PI);
        for (double_sided, to_world, instance) in
            [(false, glam::Mat4::IDENTITY, 0), (false, turned, NONE), (true, turned, 0)]
        {
            let scene = triangle(double_sided, to_world);
            let x = if to_world == turned { -0.25 } else { 0.25 };
            assert_eq!(found(&scene, [x, 0.25, 1.0]).hit.instance, instance);
        }
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default().double_sided(false)).unwrap();
        scene.add_sphere(white, glam::Mat4::IDENTITY).unwrap();
        assert_eq!(found(&scene, [0.0, 0.0, 2.0]).hit.instance, 0);
        assert_eq!(found(&scene, [0.0; 3]).hit.instance, NONE);
    }
}
