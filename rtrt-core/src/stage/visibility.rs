//! Visibility: the closest surface on each ray of the camera.

use crate::grid::{RayIndex, place};
use crate::kernel::lists::BlockLists;
use crate::kernel::ray::Ray;
use crate::kernel::tiles::{TILES, Tiles};
use crate::kernel::traverse::{
    Closest, ClosestHit, Geometry, HitFilter, intersect_sphere, ray_hit_mask, traverse,
};
use crate::kernel::view::{camera_direction, camera_ray, central_ray};
use crate::lane::{Lane, Select, V3, groups};
use crate::layout::{Frame, Hit, NONE, View};
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
    frame: &Frame,
    views: &[View],
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
    first: RayIndex,
) -> [ClosestHit<L>; G] {
    let camera = &views[Frame::CAMERA as usize];
    let (corner, inside) = frame.grid().corner(first);
    let mut best = unfound::<L, G>(token, frame, first);
    let mut filters = [Closest; G];
    let block = camera.list(frame.grid().block(first));
    if lists.is_empty(block) {
        return best;
    }
    if G > 1 && camera.w_offset == 0.0 {
        let rays: [Ray<L, f32>; G] = groups(
            #[inline(always)]
            |group| {
                let [x, y] = places(token, corner, inside + (group * L::WIDTH) as u32);
                central_ray(camera, x, y)
            },
        );
        closest(lists, geometry, block, &rays, &mut filters, &mut best);
    } else {
        let rays = rays::<L, G>(token, frame, camera, first);
        closest(lists, geometry, block, &rays, &mut filters, &mut best);
    }
    best
}

/// What the rays numbered from `first` on, all in one block, have found before they search:
/// nothing. A ray outside the frame looks for nothing.
#[inline(always)]
pub fn unfound<L: Lane, const G: usize>(
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
            let limit = is_inside.select(x.broadcast(f32::MAX), x.broadcast(-1.0));
            let none = limit.broadcast_bits(NONE);
            ClosestHit {
                t: limit,
                instance: none,
                triangle: none,
                u: limit.broadcast(0.0),
                v: limit.broadcast(0.0),
            }
        },
    )
}

/// Meets a packet with the instances of one block's list, near to far, until nothing nearer
/// can follow.
///
/// A packet passes by the instances whose boxes none of its tiles may meet, before any ray is
/// transformed.
#[inline(always)]
pub fn closest<L: Lane + Mul<O, Output = L>, O: Lane, S: HitFilter<L>, const G: usize>(
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
    block: u32,
    rays: &[Ray<L, O>; G],
    filters: &mut [S; G],
    best: &mut [ClosestHit<L>; G],
) {
    if lists.is_empty(block) {
        return;
    }
    let token = best[0].t.token();
    let mut limits = if G == 1 { [0.0; TILES] } else { Tiles::<L, G>::limits(best) };
    let searching = if G == 1 { 1 } else { Tiles::<L, G>::searching(token, &limits) };
    if searching == 0 {
        return;
    }
    let tiles = Tiles::of(rays, best, searching);
    let [mut next, last] = lists.range(block);
    while next < last {
        let entry = lists.entry(next);
        next += 1;
        // Keys are depths, and so is a camera ray's t. Light lists have keys of 0, and a
        // packet that is done has a negative limit.
        let limit = if G == 1 { best[0].t.largest() } else { Tiles::<L, G>::widest(token, &limits) };
        if limit < f32::from_bits(entry.key) {
            return;
        }
        let instance = &geometry.instances[entry.instance as usize];
        let (low, high) = instance.padded_aabb(geometry.magnitude);
        let hit_mask = if G == 1 {
            ray_hit_mask(rays, &low, &high, 1, best)
        } else {
            tiles.hit_mask::<O>(&low, &high, &limits, searching)
        };
        if hit_mask == 0 {
            continue;
        }
        if instance.is_sphere() {
            intersect_sphere(
                geometry,
                instance.source_instance(entry.instance),
                rays,
                hit_mask,
                &mut limits,
                filters,
                best,
            );
            continue;
        }
        let is_identity = instance.is_identity == 1;
        let (local_rays, local_tiles);
        let (here, here_tiles) = if G > 1 && is_identity {
            (rays, &tiles)
        } else {
            local_rays = groups(
                #[inline(always)]
                |g| {
                    let is_met = G == 1 || hit_mask >> Tiles::<L, G>::tile(g) & 1 == 1;
                    if is_met && !is_identity { rays[g].to_object(instance) } else { rays[g] }
                },
            );
            local_tiles = Tiles::of(&local_rays, best, hit_mask);
            (&local_rays, &local_tiles)
        };
        traverse(geometry, entry.instance, here, here_tiles, hit_mask, &mut limits, filters, best);
    }
}

/// The deferred record of one lane.
#[inline(always)]
pub fn hit<L: Lane>(best: &ClosestHit<L>, lane: usize) -> Hit {
    best.rows().hit(lane)
}
