//! Traversal: a packet of rays through the BVH of one mesh.

use crate::kernel::geometry::Geometry;
use crate::kernel::hit_filter::{Bounded, Faces, HitFilter};
use crate::kernel::packet::{Packet, PacketHits, first_tile, groups_of_tile};
use crate::kernel::sphere::{Chord, ENTRY, EXIT};
use crate::kernel::triangle::{RelativeTriangle, intersect};
use crate::lane::{Lane, Mask};
use crate::layout::{Instance, Node};
use core::ops::Mul;

/// How many nodes can wait on the way down: one a level, so BVHs are built no deeper.
pub(crate) const STACK: usize = 64;

/// Tests the active tiles of a packet against an instance, or a part of one: `hits` takes what its filters
/// accept.
///
/// The rays are in the instance's own space. The result is a function of the set of triangles: the
/// BVH, its order and the packet's shape only decide how soon it is found. A node is culled when, for
/// every ray, its box, widened by how far rays may pass from triangles, is missed, behind the origin, or beyond
/// the ray's limit; nested boxes have nested intervals, and a hit lies in its triangle's (see [`intersect`]), so
/// no hit is lost.
#[inline(always)]
pub fn traverse<L: Lane + Mul<O, Output = L>, O: Lane, F: HitFilter<L>, const G: usize>(
    geometry: &Geometry<'_>,
    instance: u32,
    packet: &Packet<'_, L, O, G>,
    active: u32,
    hits: &mut PacketHits<L, G>,
    filters: &mut [F; G],
) {
    let mesh = Mesh::new(geometry, instance);
    // The sign of the first ray's direction decides for all of them which child is nearer.
    let direction = packet.first_active(active).direction.lane(0);
    let root = &geometry.nodes[mesh.instance.start as usize];
    let passing = packet.passing(&root.low, &root.high, active);
    let mut stack = [0_u32; STACK];
    let mut stack_active = [0_u32; STACK];
    let mut waiting = 0_usize;
    // So many of the nodes that wait were tested before the last hit was found.
    let mut stale = 0_usize;
    let mut index = mesh.instance.start;
    let mut active = active;
    loop {
        let node = geometry.nodes[index as usize];
        let mut near_active = 0;
        if node.is_leaf() {
            if mesh.leaf(&node, packet, active, hits, filters) {
                if F::TERMINATES && hits.limit() < 0.0 {
                    return;
                }
                stale = waiting;
            }
        } else {
            // Near child first: the lower one when the packet's first ray goes up.
            let far_first = (direction[node.kind as usize] < 0.0) as u32;
            let children = mesh.instance.root + node.first;
            let (near, far) = (children + far_first, children + 1 - far_first);
            near_active = node_hit_mask(geometry, near, passing, packet, active, hits, filters);
            let far_active = node_hit_mask(geometry, far, passing, packet, active, hits, filters);
            index = near;
            active = near_active;
            if near_active == 0 {
                index = far;
                active = far_active;
                near_active = far_active;
            } else if far_active != 0 {
                stack[waiting] = far;
                if G > 1 {
                    stack_active[waiting] = far_active;
                }
                waiting += 1;
            }
        }
        while near_active == 0 {
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            index = stack[waiting];
            active = if G > 1 { stack_active[waiting] } else { 1 };
            if waiting < stale {
                stale = waiting;
                active = node_hit_mask(geometry, index, passing, packet, active, hits, filters);
            }
            near_active = active;
        }
    }
}

/// The tiles of `active` that may hit a node's box, widened by `passing`.
#[inline(always)]
fn node_hit_mask<L: Lane + Mul<O, Output = L>, O: Lane, F: HitFilter<L>, const G: usize>(
    geometry: &Geometry<'_>,
    node: u32,
    passing: f32,
    packet: &Packet<'_, L, O, G>,
    active: u32,
    hits: &PacketHits<L, G>,
    filters: &mut [F; G],
) -> u32 {
    filters[0].test_box(Bounded::Node);
    let node = geometry.nodes[node as usize];
    let (low, high) = node.widened(passing);
    packet.hit_mask(&low, &high, active, hits)
}

/// Tests the active tiles of a packet against a sphere, as [`traverse`] does against a mesh. The rays are
/// in world space.
#[inline(always)]
pub(crate) fn intersect_sphere<L: Lane + Mul<O, Output = L>, O: Lane, F: HitFilter<L>, const G: usize>(
    geometry: &Geometry<'_>,
    instance: u32,
    packet: &Packet<'_, L, O, G>,
    active: u32,
    hits: &mut PacketHits<L, G>,
    filters: &mut [F; G],
) {
    let sphere = Mesh::new(geometry, instance);
    let first = if sphere.is_one_sided::<L, F>() && F::FACES == Faces::TowardEnd { EXIT } else { ENTRY };
    let last = if sphere.is_one_sided::<L, F>() && F::FACES == Faces::TowardOrigin { ENTRY } else { EXIT };
    let mut changed = 0;
    let mut remaining = active;
    while remaining != 0 {
        let tile = first_tile::<G>(remaining);
        remaining &= remaining - 1;
        let (mut g, end) = groups_of_tile::<L, G>(tile);
        let mut is_changed = false;
        while g < end {
            let is_identity = sphere.instance.is_identity == 1;
            let ray = if is_identity { packet.rays[g] } else { packet.rays[g].to_object(sphere.instance) };
            let chord = Chord::new(&ray);
            let mut side = first;
            while side <= last {
                let closest = &mut hits.closest[g];
                filters[g].test_triangle();
                let intersection = chord.side(ray.direction, side, closest.t);
                if intersection.mask.any() {
                    hits.has_met = true;
                    is_changed |= filters[g].accept(geometry, sphere.source, side, &intersection, closest);
                }
                side += 1;
            }
            g += 1;
        }
        changed |= (is_changed as u32) << tile;
    }
    hits.update_limits(changed);
}

/// An instance among the geometry.
struct Mesh<'a> {
    geometry: &'a Geometry<'a>,
    instance: &'a Instance,
    /// The number that hits get: of the instance that this is a part of, if it is one.
    source: u32,
}

impl<'a> Mesh<'a> {
    #[inline(always)]
    fn new(geometry: &'a Geometry<'a>, number: u32) -> Self {
        let instance = &geometry.instances[number as usize];
        Self { geometry, instance, source: instance.source_instance(number) }
    }

    /// Whether one of its sides is culled.
    #[inline(always)]
    fn is_one_sided<L: Lane, F: HitFilter<L>>(&self) -> bool {
        F::FACES != Faces::Both && self.instance.double_sided == 0
    }

    /// Tests the active tiles against every triangle of a leaf. Returns whether any limit has changed.
    #[inline(always)]
    fn leaf<L: Lane + Mul<O, Output = L>, O: Lane, F: HitFilter<L>, const G: usize>(
        &self,
        node: &Node,
        packet: &Packet<'_, L, O, G>,
        active: u32,
        hits: &mut PacketHits<L, G>,
        filters: &mut [F; G],
    ) -> bool {
        let one_sided = self.is_one_sided::<L, F>();
        let mut changed = 0_u32;
        let mut id = node.first;
        let end = id + node.triangles();
        while id < end {
            let triangle = self.geometry.triangle(self.instance, id);
            let shared = triangle.relative_to(packet.first_active(active).origin);
            let is_of_all = G == 1 || O::WIDTH < L::WIDTH;
            let turns_away = one_sided && is_of_all && !counts::<L, F, O>(&shared, hits.closest[0].t).any();
            let mut remaining = if turns_away { 0 } else { active };
            while remaining != 0 {
                let tile = first_tile::<G>(remaining);
                remaining &= remaining - 1;
                let (mut g, end) = groups_of_tile::<L, G>(tile);
                let mut is_changed = false;
                while g < end {
                    let (ray, closest) = (&packet.rays[g], &mut hits.closest[g]);
                    let relative =
                        if O::WIDTH < L::WIDTH { shared } else { triangle.relative_to(ray.origin) };
                    filters[g].test_triangle();
                    let mut intersection = intersect(ray, &relative, closest.t);
                    if one_sided && intersection.mask.any() {
                        intersection.mask = intersection.mask & counts::<L, F, O>(&relative, closest.t);
                    }
                    if intersection.mask.any() {
                        hits.has_met = true;
                        is_changed |=
                            filters[g].accept(self.geometry, self.source, id, &intersection, closest);
                    }
                    g += 1;
                }
                changed |= (is_changed as u32) << tile;
            }
            id += 1;
        }
        hits.update_limits(changed);
        changed != 0
    }
}

/// The lanes in which a triangle that is not double-sided counts.
#[inline(always)]
fn counts<L: Lane + Mul<O, Output = L>, F: HitFilter<L>, O: Lane>(
    triangle: &RelativeTriangle<O>,
    like: L,
) -> L::Mask {
    let front = triangle.front(like);
    if F::FACES == Faces::TowardEnd { !front } else { front }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::closest_hit::ClosestHit;
    use crate::kernel::hit_filter::{Any, Closest};
    use crate::kernel::ray::Ray;
    use crate::kernel::tiles::Tiles;
    use crate::lane::V3;
    use crate::layout::{Attribute, Hit};
    use crate::scene::{Bvh, Material, Mesh, Scene, Sequential};
    use bytemuck::Zeroable;
    use std::vec::Vec;

    /// Numbers within −1 .. 1 that look random.
    fn random(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// Triangles strewn over a cube.
    fn heap(double_sided: bool) -> Scene {
        let mut seed = 5;
        let mut positions: Vec<[f32; 3]> = Vec::new();
        for _ in 0..300 {
            let center = [0; 3].map(|_| random(&mut seed));
            positions.extend([0; 3].map(|_| center.map(|c| c + random(&mut seed) * 0.3)));
        }
        let indices = (0..positions.len() as u32).collect();
        let attributes = std::vec![Attribute::zeroed(); positions.len()];
        let mesh = Mesh::new(positions, attributes, indices).unwrap();
        let mut scene = Scene::new();
        let material = scene.add_material(Material::default().double_sided(double_sided)).unwrap();
        let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
        scene.add_instance(mesh, material, glam::Mat4::IDENTITY).unwrap();
        scene
    }

    fn geometry(scene: &Scene) -> Geometry<'_> {
        Geometry {
            instances: scene.instances(),
            nodes: scene.nodes(),
            mesh_data: scene.mesh_data(),
            positions: scene.positions(),
            texels: &[],
            magnitude: 2.0,
        }
    }

    fn found<F: HitFilter<f32>>(
        geometry: &Geometry<'_>,
        ray: Ray<f32>,
        limit: f32,
        filter: F,
    ) -> ClosestHit<f32> {
        let mut hits = PacketHits::new([ClosestHit::none(limit)]);
        let tiles = Tiles::of(&[ray], &hits.closest, 1);
        traverse(geometry, 0, &Packet { rays: &[ray], tiles: &tiles }, 1, &mut hits, &mut [filter]);
        hits.closest[0]
    }

    #[test]
    fn finds_the_least_of_all_triangles() {
        for double_sided in [true, false] {
            let scene = heap(double_sided);
            let geometry = geometry(&scene);
            let (mut seed, mut count) = (1, 0);
            for _ in 0..2000 {
                let mut point = |size: f32| V3::splat((), [0; 3].map(|_| random(&mut seed) * size));
                let ray = Ray::<f32>::new(point(2.0), point(1.0));
                let mut least = ClosestHit::none(3.0);
                let mut is_any = false;
                for id in 0..scene.instances()[0].triangles {
                    let triangle = geometry.triangle(&scene.instances()[0], id);
                    let relative = triangle.relative_to(ray.origin);
                    let hit = intersect(&ray, &relative, 3.0);
                    is_any |= hit.mask && (double_sided || !relative.front(0.0_f32));
                    let counts = hit.mask && (double_sided || relative.front(0.0_f32));
                    least.keep_closest(&hit, counts, 0, id);
                }
                let least = least.rows().hit(0);
                assert_eq!(found(&geometry, ray, 3.0, Closest).rows().hit(0), least);
                // A light, at the other end, sees the other faces.
                assert_eq!(found(&geometry, ray, 3.0, Any).t < 0.0, is_any);
                count += usize::from(least != Hit::MISS);
            }
            assert!(count > 150, "{count}");
        }
    }

    #[test]
    fn a_ray_that_is_not_traced_finds_nothing() {
        let scene = heap(true);
        let ray = Ray::<f32>::new(V3::splat((), [0.0; 3]), V3::splat((), [0.3, 0.1, 1.0]));
        assert_eq!(found(&geometry(&scene), ray, -1.0, Closest).rows().hit(0), Hit::MISS);
        assert_ne!(found(&geometry(&scene), ray, 9.0, Closest).rows().hit(0), Hit::MISS);
    }

    #[test]
    fn a_sphere_is_entered_and_left() {
        for (double_sided, from_within) in [(true, 1), (false, crate::layout::NONE)] {
            let mut scene = Scene::new();
            let material = scene.add_material(Material::default().double_sided(double_sided)).unwrap();
            scene.add_sphere(material, glam::Mat4::from_scale(glam::Vec3::splat(2.0))).unwrap();
            let triangle = |z: f32| {
                let ray = Ray::<f32>::new(V3::splat((), [0.0, 0.0, z]), V3::splat((), [0.0, 0.0, -1.0]));
                let mut hits = PacketHits::new([ClosestHit::none(9.0)]);
                let tiles = Tiles::of(&[ray], &hits.closest, 1);
                let packet = Packet { rays: &[ray], tiles: &tiles };
                intersect_sphere(&geometry(&scene), 0, &packet, 1, &mut hits, &mut [Closest]);
                let hit = hits.closest[0].rows().hit(0);
                if hit == Hit::MISS { crate::layout::NONE } else { hit.triangle }
            };
            assert_eq!([triangle(4.0), triangle(0.0), triangle(-4.0)], [0, from_within, crate::layout::NONE]);
        }
    }
}
