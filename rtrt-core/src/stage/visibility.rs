//! Visibility: the closest surface on each ray of the camera.

use crate::grid::{RayIndex, place};
use crate::kernel::lists::Lists;
use crate::kernel::ray::Ray;
use crate::kernel::slab::{Around, meets};
use crate::kernel::span::Span;
use crate::kernel::traverse::{Best, Geometry, traverse, widest};
use crate::kernel::view::{camera_ray, central_ray};
use crate::lane::{Lane, Mask, groups};
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

/// Columns and rows, counted in rays, of the rays of a block from `number` on; `corner` is
/// that of the block.
#[inline(always)]
fn places<L: Lane>(token: L::Token, corner: [u32; 2], number: u32) -> [L; 2] {
    let [x, y] = L::gather(
        token,
        #[inline(always)]
        |lane| {
            let [x, y] = place(number + lane as u32);
            [x as f32, y as f32]
        },
    );
    [x + corner[0] as f32, y + corner[1] as f32]
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
    let grid = frame.grid();
    let camera = &views[Frame::CAMERA as usize];
    let (corner, inside) = grid.corner(first);
    let mut best: [Best<L>; G] = groups(
        #[inline(always)]
        |group| {
            let number = inside + (group * L::WIDTH) as u32;
            let limit = L::from_fn(
                token,
                #[inline(always)]
                |lane| {
                    let [x, y] = place(number + lane as u32);
                    if grid.contains([corner[0] + x, corner[1] + y]) { f32::MAX } else { -1.0 }
                },
            );
            let none = limit.bits_like(NONE);
            Best { t: limit, object: none, triangle: none, u: limit.like(0.0), v: limit.like(0.0) }
        },
    );
    let block = camera.first_block + grid.block(first).0;
    if G > 1 && camera.w_offset == 0.0 {
        let rays: [Ray<L, f32>; G] = groups(
            #[inline(always)]
            |group| {
                let [x, y] = places(token, corner, inside + (group * L::WIDTH) as u32);
                central_ray(camera, x, y)
            },
        );
        closest::<L, f32, G, false>(lists, geometry, block, &rays, &mut best);
    } else {
        let rays = rays::<L, G>(token, frame, camera, first);
        closest::<L, L, G, false>(lists, geometry, block, &rays, &mut best);
    }
    best
}

/// Meets a packet with the objects of one block's list, near to far, until nothing nearer
/// can follow. With `ANY`, rays end at the first hit (see [`traverse`]).
///
/// Groups that look for nothing are left out first, and for an object with a space of its
/// own those that pass its box by, before any ray is transformed.
#[inline(always)]
pub fn closest<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize, const ANY: bool>(
    lists: &Lists<'_>,
    geometry: &Geometry<'_>,
    block: u32,
    rays: &[Ray<L, O>; G],
    best: &mut [Best<L>; G],
) {
    // Element by element: copying an array through memory is beyond naga.
    let mut world_rays: [Ray<L, O>; G] = groups(
        #[inline(always)]
        |g| rays[g],
    );
    let mut world_best: [Best<L>; G] = groups(
        #[inline(always)]
        |g| best[g],
    );
    let mut slots = [0_usize; G];
    let mut count = 0;
    let mut g = 0;
    while g < G {
        if best[g].t.like(0.0).less_equal(best[g].t).any() {
            world_rays[count] = rays[g];
            world_best[count] = best[g];
            slots[count] = g;
            count += 1;
        }
        g += 1;
    }
    if count == 0 {
        return;
    }
    let world = Span::of(&world_rays, &world_best, count);
    let mut local_rays = world_rays;
    let mut local_best = world_best;
    let mut local_slots = [0_usize; G];
    let [mut next, last] = lists.range(block);
    while next < last {
        let entry = lists.entry(next);
        next += 1;
        // Keys are depths, and so is a camera ray's t. Light lists have keys of 0, and a
        // packet that is done has a negative limit.
        let limit = widest(&world_best, count);
        if limit < f32::from_bits(entry.key) {
            break;
        }
        let object = &geometry.objects[entry.object as usize];
        let is_identity = object.is_identity == 1;
        if G > 1 && is_identity {
            traverse::<L, O, G, ANY>(geometry, entry.object, &world_rays, count, &world, &mut world_best);
            continue;
        }
        let (low, high) = object.widened(geometry.magnitude);
        if G > 1 && world.misses(&low, &high, limit) {
            continue;
        }
        let mut inside = 0;
        let mut g = 0;
        while g < count {
            let around = Around::new(world_rays[g].origin, &low, &high);
            if meets(&world_rays[g], &around, world_best[g].t).any() {
                local_rays[inside] =
                    if is_identity { world_rays[g] } else { world_rays[g].to_object(object) };
                local_best[inside] = world_best[g];
                local_slots[inside] = g;
                inside += 1;
            }
            g += 1;
        }
        if inside == 0 {
            continue;
        }
        let span = Span::of(&local_rays, &local_best, inside);
        traverse::<L, O, G, ANY>(geometry, entry.object, &local_rays, inside, &span, &mut local_best);
        let mut g = 0;
        while g < inside {
            world_best[local_slots[g]] = local_best[g];
            g += 1;
        }
    }
    let mut g = 0;
    while g < count {
        best[slots[g]] = world_best[g];
        g += 1;
    }
}

/// The deferred record of one lane.
#[inline(always)]
pub fn hit<L: Lane>(best: &Best<L>, lane: usize) -> Hit {
    best.rows().hit(lane)
}
