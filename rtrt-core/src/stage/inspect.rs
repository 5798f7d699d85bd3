//! Inspect: what it takes to find the closest hit of one ray, counted. For pictures of how the
//! lists work, never for frames.

use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::geometry::Geometry;
use crate::kernel::lists::BlockLists;
use crate::kernel::ray::Ray;
use crate::kernel::slab::{RelativeBox, intersects};
use crate::kernel::sphere::{Chord, ENTRY, EXIT};
use crate::kernel::traverse::STACK;
use crate::kernel::triangle::{Intersection, intersect};
use crate::lane::{V3, Word};
use crate::layout::{Hit, Instance, Node};

/// What it took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inspection {
    /// Entries in the list of the ray's block.
    pub entries: u32,
    /// Those that the ray was asked for before nothing nearer could follow.
    pub asked: u32,
    /// Boxes asked, of instances and of nodes.
    pub boxes: u32,
    /// Triangles asked, and spheres.
    pub triangles: u32,
    /// Whether the ray meets the bounding sphere of an entry.
    pub sphere: bool,
    /// The closest hit: that of the stage `visibility`, bit for bit.
    pub hit: Hit,
}

/// Follows one ray of the camera through the list of its block, as an invocation of a GPU does.
/// (A packet asks fewer boxes, for all of its rays at once, and more triangles.)
pub fn inspect(lists: &BlockLists<'_>, geometry: &Geometry<'_>, block: u32, ray: &Ray<f32>) -> Inspection {
    let mut best = ClosestHit::new(&Hit::MISS);
    let [first, last] = lists.range(block);
    let mut found =
        Inspection { entries: last - first, asked: 0, boxes: 0, triangles: 0, sphere: false, hit: Hit::MISS };
    for entry in first..last {
        let entry = lists.entry(entry);
        let instance = &geometry.instances[entry.instance as usize];
        found.sphere |= meets_sphere(ray, instance);
        if best.t < f32::from_bits(entry.key) {
            continue;
        }
        found.asked += 1;
        found.boxes += 1;
        let (low, high) = instance.padded_aabb(geometry.magnitude);
        if intersects(ray, &RelativeBox::new(ray.origin, &low, &high), best.t) {
            let ray = if instance.is_identity == 1 { *ray } else { ray.to_object(instance) };
            if instance.is_sphere() {
                found.triangles += 1;
                let chord = Chord::new(&ray);
                for side in if instance.double_sided == 1 { ENTRY..=EXIT } else { ENTRY..=ENTRY } {
                    let met = chord.side(ray.direction, side, best.t);
                    keep(instance.source_instance(entry.instance), side, &met, &mut best);
                }
            } else {
                descend(geometry, entry.instance, &ray, &mut best, &mut found);
            }
        }
    }
    found.hit = best.rows().hit(0);
    found
}

/// Whether the ray's line passes within the radius of the instance's bounding sphere:
/// `|(c − o) × d|² ≤ r² · |d|²`.
fn meets_sphere(ray: &Ray<f32>, instance: &Instance) -> bool {
    let across = (V3::splat((), instance.center) - ray.origin).cross(ray.direction);
    across.dot(across) <= instance.radius * instance.radius * ray.direction.dot(ray.direction)
}

/// [`traverse`](crate::kernel::traverse::traverse) for one ray, counting.
fn descend(
    geometry: &Geometry<'_>,
    instance_index: u32,
    ray: &Ray<f32>,
    best: &mut ClosestHit<f32>,
    found: &mut Inspection,
) {
    let instance = &geometry.instances[instance_index as usize];
    let rising = [ray.direction.x, ray.direction.y, ray.direction.z];
    let asked = |index: u32, best: &ClosestHit<f32>, found: &mut Inspection| {
        let node = &geometry.nodes[index as usize];
        found.boxes += 1;
        intersects(ray, &RelativeBox::new(ray.origin, &node.low, &node.high), best.t)
    };
    let mut stack = [0_u32; STACK];
    let (mut waiting, mut stale) = (0_usize, 0_usize);
    let instance_index = instance.source_instance(instance_index);
    let mut index = instance.start;
    loop {
        let node = geometry.nodes[index as usize];
        if node.is_leaf() {
            if leaf(geometry, instance_index, &node, ray, best, found) {
                stale = waiting;
            }
        } else {
            let far_first = u32::from(rising[node.kind as usize] < 0.0);
            let children = instance.root + node.first;
            let (near, far) = (children + far_first, children + 1 - far_first);
            let (meets_near, meets_far) = (asked(near, best, found), asked(far, best, found));
            if meets_near && meets_far {
                stack[waiting] = far;
                waiting += 1;
            }
            if meets_near || meets_far {
                index = if meets_near { near } else { far };
                continue;
            }
        }
        loop {
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            index = stack[waiting];
            if waiting >= stale {
                break;
            }
            stale = waiting;
            if asked(index, best, found) {
                break;
            }
        }
    }
}

/// Asks the triangles of a leaf; whether one is the closest so far.
fn leaf(
    geometry: &Geometry<'_>,
    instance_index: u32,
    node: &Node,
    ray: &Ray<f32>,
    best: &mut ClosestHit<f32>,
    found: &mut Inspection,
) -> bool {
    let instance = &geometry.instances[instance_index as usize];
    let mut is_met = false;
    for id in node.first..node.first + node.triangles() {
        found.triangles += 1;
        let triangle = geometry.triangle(instance, id);
        let seen = triangle.relative_to(ray.origin);
        let mut met = intersect(ray, &triangle, &seen, best.t);
        met.mask &= instance.double_sided == 1 || seen.front(best.t);
        keep(instance_index, id, &met, best);
        is_met |= met.mask;
    }
    is_met
}

/// Keeps the closest.
fn keep(instance: u32, id: u32, met: &Intersection<f32>, best: &mut ClosestHit<f32>) {
    let is_earlier = (instance, id) < (best.instance.0, best.triangle.0);
    if met.mask && (met.t < best.t || (met.t <= best.t && is_earlier)) {
        *best = ClosestHit { t: met.t, instance: Word(instance), triangle: Word(id), u: met.u, v: met.v };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        inspect(&lists, &geometry, 0, &Ray::new(V3::splat((), from), V3::splat((), [0.0, 0.0, -1.0])))
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
        assert_eq!((hit.hit.instance, hit.entries, hit.asked), (0, 1, 1));
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
