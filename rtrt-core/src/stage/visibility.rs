//! Visibility: the closest surface on each ray of the camera.

use crate::grid::{RayIndex, place};
use crate::kernel::lists::Lists;
use crate::kernel::ray::Ray;
use crate::kernel::tiles::{TILES, Tiles};
use crate::kernel::traverse::{Best, Closest, Geometry, Search, meet_sphere, met_by_rays, traverse};
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
    lists: &Lists<'_>,
    geometry: &Geometry<'_>,
    first: RayIndex,
) -> [Best<L>; G] {
    let camera = &views[Frame::CAMERA as usize];
    let (corner, inside) = frame.grid().corner(first);
    let mut best = unfound::<L, G>(token, frame, first);
    let mut searches = [Closest; G];
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
        closest(lists, geometry, block, &rays, &mut searches, &mut best);
    } else {
        let rays = rays::<L, G>(token, frame, camera, first);
        closest(lists, geometry, block, &rays, &mut searches, &mut best);
    }
    best
}

/// What the rays numbered from `first` on, all in one block, have found before they search:
/// nothing. A ray outside the frame looks for nothing.
#[inline(always)]
pub fn unfound<L: Lane, const G: usize>(token: L::Token, frame: &Frame, first: RayIndex) -> [Best<L>; G] {
    let grid = frame.grid();
    let (corner, inside) = grid.corner(first);
    groups(
        #[inline(always)]
        |group| {
            let [x, y] = places::<L>(token, corner, inside + (group * L::WIDTH) as u32);
            let [width, height] = grid.rays_across();
            let is_inside = x.less_than(x.like(width as f32)) & y.less_than(y.like(height as f32));
            let limit = is_inside.select(x.like(f32::MAX), x.like(-1.0));
            let none = limit.bits_like(NONE);
            Best { t: limit, object: none, triangle: none, u: limit.like(0.0), v: limit.like(0.0) }
        },
    )
}

/// Meets a packet with the objects of one block's list, near to far, until nothing nearer
/// can follow.
///
/// A packet passes by the objects whose boxes none of its tiles may meet, before any ray is
/// transformed.
#[inline(always)]
pub fn closest<L: Lane + Mul<O, Output = L>, O: Lane, S: Search<L>, const G: usize>(
    lists: &Lists<'_>,
    geometry: &Geometry<'_>,
    block: u32,
    rays: &[Ray<L, O>; G],
    searches: &mut [S; G],
    best: &mut [Best<L>; G],
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
        let object = &geometry.objects[entry.object as usize];
        let (low, high) = object.widened(geometry.magnitude);
        let met = if G == 1 {
            met_by_rays(rays, &low, &high, 1, best)
        } else {
            tiles.meets::<O>(&low, &high, &limits, searching)
        };
        if met == 0 {
            continue;
        }
        if object.is_sphere() {
            meet_sphere(geometry, object.whole(entry.object), rays, met, &mut limits, searches, best);
            continue;
        }
        let is_identity = object.is_identity == 1;
        let (local_rays, local_tiles);
        let (here, here_tiles) = if G > 1 && is_identity {
            (rays, &tiles)
        } else {
            local_rays = groups(
                #[inline(always)]
                |g| {
                    let is_met = G == 1 || met >> Tiles::<L, G>::tile(g) & 1 == 1;
                    if is_met && !is_identity { rays[g].to_object(object) } else { rays[g] }
                },
            );
            local_tiles = Tiles::of(&local_rays, best, met);
            (&local_rays, &local_tiles)
        };
        traverse(geometry, entry.object, here, here_tiles, met, &mut limits, searches, best);
    }
}

/// The deferred record of one lane.
#[inline(always)]
pub fn hit<L: Lane>(best: &Best<L>, lane: usize) -> Hit {
    best.rows().hit(lane)
}
