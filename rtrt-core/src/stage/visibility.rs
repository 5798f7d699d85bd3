//! Visibility: the closest surface on each ray of the camera.

use crate::grid::{RayIndex, place};
use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::hit_filter::{Bounded, Closest, HitFilter};
use crate::kernel::packet::{Packet, PacketHits};
use crate::kernel::ray::Ray;
use crate::kernel::tiles::Tiles;
use crate::kernel::traverse::{intersect_sphere, traverse};
use crate::kernel::view::{camera_direction, camera_ray, central_ray};
use crate::lane::{Lane, Select, V3, groups};
use crate::layout::{Frame, Hit, NONE, View};
use crate::stage::context::Context;
use core::ops::Mul;

/// The rays numbered from `first` on: group after group, lane after lane.
#[inline(always)]
pub fn rays<L: Lane, const G: usize>(
    token: L::Token,
    frame: &Frame,
    camera: &View,
    first: RayIndex,
) -> [Ray<L>; G] {
    let (corner, inside) = frame.grid().corner(first);
    groups(
        #[inline(always)]
        |group| {
            let [x, y] = places(token, corner, inside + (group * L::WIDTH) as u32);
            camera_ray(camera, x, y)
        },
    )
}

/// The directions of the rays numbered from `first` on.
#[inline(always)]
pub fn directions<L: Lane, const G: usize>(
    token: L::Token,
    frame: &Frame,
    camera: &View,
    first: RayIndex,
) -> [V3<L>; G] {
    let (corner, inside) = frame.grid().corner(first);
    groups(
        #[inline(always)]
        |group| {
            let [x, y] = places(token, corner, inside + (group * L::WIDTH) as u32);
            camera_direction(camera, x, y)
        },
    )
}

/// Columns and rows, counted in rays, of the group of rays of a block from `number` on; `corner`
/// is that of the block.
///
/// A group is part of a tile, so its lanes lie in each as in the first: the compiler knows where.
#[inline(always)]
fn places<L: Lane>(token: L::Token, corner: [u32; 2], number: u32) -> [L; 2] {
    let [x, y] = L::gather(
        token,
        #[inline(always)]
        |lane| {
            let [x, y] = place(lane as u32);
            [x as f32, y as f32]
        },
    );
    let [left, top] = place(number);
    [x + (corner[0] + left) as f32, y + (corner[1] + top) as f32]
}

/// The closest hits of the rays numbered from `first` on, all in one block; a ray outside
/// the frame hits nothing.
#[inline(always)]
pub fn visibility<L: Lane, const G: usize>(
    token: L::Token,
    context: &Context<'_>,
    first: RayIndex,
) -> [ClosestHit<L>; G] {
    let (frame, camera) = (context.frame, context.camera());
    let (corner, inside) = frame.grid().corner(first);
    let none = unfound::<L, G>(token, frame, first);
    let block = camera.list(frame.grid().block(first));
    if context.lists.is_empty(block) {
        return none;
    }
    let mut hits = PacketHits::new(none);
    if G > 1 && camera.w_offset == 0.0 {
        let rays: [Ray<L, f32>; G] = groups(
            #[inline(always)]
            |group| {
                let [x, y] = places(token, corner, inside + (group * L::WIDTH) as u32);
                central_ray(camera, x, y)
            },
        );
        trace(context, block, &rays, &mut { rays }, &mut hits, &mut [Closest; G]);
    } else {
        let rays = rays::<L, G>(token, frame, camera, first);
        trace(context, block, &rays, &mut { rays }, &mut hits, &mut [Closest; G]);
    }
    hits.closest
}

/// No hits yet, of the rays numbered from `first` on, all in one block, up to the frame's far plane. A ray outside the
/// frame is not traced.
#[inline(always)]
pub(crate) fn unfound<L: Lane, const G: usize>(
    token: L::Token,
    frame: &Frame,
    first: RayIndex,
) -> [ClosestHit<L>; G] {
    let grid = frame.grid();
    let (corner, inside) = grid.corner(first);
    groups(
        #[inline(always)]
        |group| {
            let [x, y] = places::<L>(token, corner, inside + (group * L::WIDTH) as u32);
            let [width, height] = grid.rays_across();
            let is_inside = x.lt(x.broadcast(width as f32)) & y.lt(y.broadcast(height as f32));
            let limit = is_inside.select(x.broadcast(frame.far), x.broadcast(-1.0));
            ClosestHit::none(limit)
        },
    )
}

/// A packet reads the boxes of so many entries at once. Those of many instances are in no cache, and come at the same
/// time.
const BOXES: usize = 8;

/// Traces a packet through the instances of one block's list, near to far, until none that follows can
/// be nearer. `local_rays` is room for the rays in an instance's space; what it holds does not matter.
///
/// Instances whose boxes no tile hits are culled before any ray is transformed.
#[inline(always)]
pub fn trace<L: Lane + Mul<O, Output = L>, O: Lane, F: HitFilter<L>, const G: usize>(
    context: &Context<'_>,
    block: u32,
    rays: &[Ray<L, O>; G],
    local_rays: &mut [Ray<L, O>; G],
    hits: &mut PacketHits<L, G>,
    filters: &mut [F; G],
) {
    let Context { lists, geometry, .. } = context;
    if lists.is_empty(block) {
        return;
    }
    let active = hits.active();
    if active == 0 {
        return;
    }
    let tiles = Tiles::of(rays, &hits.closest, active);
    // The last entry's instance, and the number that its hits get.
    let (mut before, mut before_number) = (NONE, NONE);
    let packet = Packet { rays, tiles: &tiles };
    let [mut next, last] = lists.range(block);
    let (mut boxes, mut read) = ([([0.0; 3], [0.0; 3]); BOXES], next);
    while next < last {
        if G > 1 && next == read {
            read = read_boxes(context, next, last, &mut boxes);
        }
        let (entry, place) = (lists.entry(next), next as usize % BOXES);
        next += 1;
        // Keys are depths, and so is a camera ray's t. Light lists have keys of 0, and a
        // packet that is done has a negative limit.
        if hits.limit() < f32::from_bits(entry.key) {
            return;
        }
        let instance = &geometry.instances[entry.instance as usize];
        let number = instance.source_instance(entry.instance);
        let is_copy = before_number < number && instance.is_copy_of(&geometry.instances[before as usize]);
        if is_copy && !(hits.has_met && needs_copy(filters, before_number, number)) {
            (before, before_number) = (entry.instance, number);
            continue;
        }
        (before, before_number) = (entry.instance, number);
        hits.has_met &= is_copy;
        let (low, high) = if G > 1 { boxes[place] } else { instance.padded_aabb(geometry.magnitude) };
        filters[0].test_box(Bounded::Instance);
        let hit_mask = packet.tile_hit_mask(&low, &high, active, hits);
        if hit_mask == 0 {
            continue;
        }
        if instance.is_sphere() {
            intersect_sphere(geometry, entry.instance, &packet, hit_mask, hits, filters);
            continue;
        }
        let is_identity = instance.is_identity == 1;
        let local_tiles;
        let local = if G > 1 && is_identity {
            packet
        } else {
            packet.place(instance, hit_mask, local_rays);
            local_tiles = Tiles::of(local_rays, &hits.closest, hit_mask);
            Packet { rays: local_rays, tiles: &local_tiles }
        };
        traverse(geometry, entry.instance, &local, hit_mask, hits, filters);
    }
}

/// Reads the padded boxes of up to [`BOXES`] entries from `next` on, that of entry `i` to `i % BOXES`. Returns the
/// first entry that is not read.
#[inline(always)]
fn read_boxes(context: &Context<'_>, next: u32, last: u32, boxes: &mut [([f32; 3], [f32; 3]); BOXES]) -> u32 {
    let Context { lists, geometry, .. } = context;
    let end = if last - next > BOXES as u32 { next + BOXES as u32 } else { last };
    let mut number = next;
    while number < end {
        let instance = &geometry.instances[lists.entry(number).instance as usize];
        boxes[number as usize % BOXES] = instance.padded_aabb(geometry.magnitude);
        number += 1;
    }
    end
}

/// Whether a ray of the packet needs an instance that is a copy of another one (see [`HitFilter::needs_copy`]).
#[inline(always)]
fn needs_copy<L: Lane, F: HitFilter<L>, const G: usize>(filters: &[F; G], before: u32, number: u32) -> bool {
    let mut g = 0;
    while g < G {
        if filters[g].needs_copy(before, number) {
            return true;
        }
        g += 1;
    }
    false
}

/// The deferred record of one lane.
#[inline(always)]
pub fn hit<L: Lane>(best: &ClosestHit<L>, lane: usize) -> Hit {
    best.rows().hit(lane)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::plain::Plain;
    use crate::scene::{Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, closest, square_at};
    use glam::{Mat4, Vec3};
    use std::vec::Vec;

    /// The hits of all rays of the block, traced in packets.
    fn hits<L: Lane<Token = ()>, const G: usize>(prepared: &Prepared) -> Vec<Hit> {
        let rays = (L::WIDTH * G) as u32;
        let packets = (0..prepared.frame().rays).step_by(rays as usize);
        let all = packets.flat_map(|first| {
            let closest = closest::<L, G>(prepared, RayIndex(first));
            (0..rays as usize).map(move |ray| hit(&closest[ray / L::WIDTH], ray % L::WIDTH))
        });
        all.collect()
    }

    #[test]
    fn a_ray_hits_the_nearest_surface_in_its_way() {
        let mut scene = Scene::new();
        add_square(&mut scene, Material::default(), square_at(6.0, [0.0; 3]));
        add_square(&mut scene, Material::default(), square_at(2.0, [3.0, 0.0, 1.0]));
        let prepared = Prepared::new(scene, |request| request);
        for (number, hit) in (0..).zip(hits::<f32, 1>(&prepared)) {
            let [column, row] = prepared.frame().grid().ray(RayIndex(number));
            // The rays are a unit apart, and start at z = 4.
            let (x, y) = (column as f32 - 7.5, 7.5 - row as f32);
            let expected = if (x - 3.0).abs() < 2.0 && y.abs() < 2.0 {
                (1, 3.0)
            } else if x.abs() < 6.0 && y.abs() < 6.0 {
                (0, 4.0)
            } else {
                (NONE, Hit::MISS.t)
            };
            assert_eq!(hit.instance, expected.0, "{x} {y}");
            assert!((hit.t - expected.1).abs() <= 1e-5 * expected.1, "{x} {y}: {}", hit.t);
        }
    }

    #[test]
    fn packets_find_what_single_rays_find() {
        let mut scene = Scene::new();
        for i in 0..40 {
            let (place, turn) =
                ([(i % 7) as f32 * 2.0 - 6.0, (i % 5) as f32 * 2.5 - 5.0, 0.0], i as f32 * 0.7);
            let to_world = square_at(1.5, place) * Mat4::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), turn);
            add_square(&mut scene, Material::default().double_sided(i % 3 == 0), to_world);
        }
        let white = scene.add_material(Material::default()).unwrap();
        scene.add_sphere(white, square_at(3.0, [2.0, 1.0, 0.0])).unwrap();
        let prepared = Prepared::new(scene, |request| request);
        let single = hits::<f32, 1>(&prepared);
        assert!(single.iter().filter(|hit| hit.instance != NONE).count() > 100);
        assert_eq!(hits::<Plain<8>, 32>(&prepared), single);
        assert_eq!(hits::<Plain<16>, 16>(&prepared), single);
        assert_eq!(hits::<f32, 16>(&prepared), single);
        assert_eq!(hits::<Plain<16>, 16>(&prepared), single);
        assert_eq!(hits::<f32, 16>(&prepared), single);
    }

    #[test]
    fn rays_outside_the_frame_are_not_traced() {
        let frame = Frame { width: 5, height: 3, side: 1, far: 9.0, ..bytemuck::Zeroable::zeroed() };
        let limit = |number: u32| unfound::<f32, 1>((), &frame, RayIndex(number))[0].t;
        let inside = (0..256).filter(|&number| limit(number) > 0.0).count();
        assert_eq!((inside, limit(255)), (15, -1.0));
    }
}
