//! Visibility: the closest surface on each ray of the camera.

use crate::grid::RayIndex;
use crate::kernel::lists::Lists;
use crate::kernel::ray::Ray;
use crate::kernel::slab::meets;
use crate::kernel::span::Span;
use crate::kernel::traverse::{Best, Geometry, traverse, widest};
use crate::kernel::view::camera_ray;
use crate::lane::{Lane, Mask, groups};
use crate::layout::{Frame, Hit, NONE, View};

/// The rays numbered from `first` on: group after group, lane after lane.
#[inline(always)]
pub fn rays<L: Lane, const G: usize>(
    token: L::Token,
    frame: &Frame,
    camera: &View,
    first: RayIndex,
) -> [Ray<L>; G] {
    let grid = frame.grid();
    let at = |group: usize, lane: usize| grid.ray(RayIndex(first.0 + (group * L::WIDTH + lane) as u32));
    groups(
        #[inline(always)]
        |group| {
            let x = L::from_fn(
                token,
                #[inline(always)]
                |lane| at(group, lane)[0] as f32,
            );
            let y = L::from_fn(
                token,
                #[inline(always)]
                |lane| at(group, lane)[1] as f32,
            );
            camera_ray(camera, x, y)
        },
    )
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
    let rays = rays::<L, G>(token, frame, camera, first);
    let mut best: [Best<L>; G] = groups(
        #[inline(always)]
        |group| {
            let limit = L::from_fn(
                token,
                #[inline(always)]
                |lane| {
                    let ray = grid.ray(RayIndex(first.0 + (group * L::WIDTH + lane) as u32));
                    if grid.contains(ray) { f32::MAX } else { -1.0 }
                },
            );
            let none = limit.bits_like(NONE);
            Best { t: limit, object: none, triangle: none, u: limit.like(0.0), v: limit.like(0.0) }
        },
    );
    closest::<L, G, false>(lists, geometry, camera.first_block + grid.block(first).0, &rays, &mut best);
    best
}

/// Meets a packet with the objects of one block's list, near to far, until nothing nearer
/// can follow. With `ANY`, rays end at the first hit (see [`traverse`]).
#[inline(always)]
pub fn closest<L: Lane, const G: usize, const ANY: bool>(
    lists: &Lists<'_>,
    geometry: &Geometry<'_>,
    block: u32,
    rays: &[Ray<L>; G],
    best: &mut [Best<L>; G],
) {
    let limits = groups(
        #[inline(always)]
        |g| best[g].t,
    );
    let world = Span::of(rays, &limits);
    // Not `*rays`: copying an array through memory is beyond naga.
    let mut local = groups(
        #[inline(always)]
        |g| rays[g],
    );
    let mut span = world;
    let mut in_world = true;
    let [mut next, last] = lists.range(block);
    while next < last {
        let entry = lists.entry(next);
        next += 1;
        // Keys are depths, and so is a camera ray's t. Light lists have keys of 0.
        let limit = widest(best);
        if limit < f32::from_bits(entry.key) {
            return;
        }
        let object = &geometry.objects[entry.object as usize];
        if object.is_identity == 1 {
            if !in_world {
                local = *rays;
                span = world;
                in_world = true;
            }
        } else {
            let (low, high) = object.widened(geometry.magnitude);
            let missed = if G > 1 {
                world.misses(&low, &high, limit)
            } else {
                !meets(&rays[0], &low, &high, best[0].t).any()
            };
            if missed {
                continue;
            }
            let limits = groups(
                #[inline(always)]
                |g| best[g].t,
            );
            let mut g = 0;
            while g < G {
                local[g] = rays[g].to_object(object);
                g += 1;
            }
            span = Span::of(&local, &limits);
            in_world = false;
        }
        traverse::<L, G, ANY>(geometry, entry.object, &local, &span, best);
    }
}

/// The deferred record of one lane.
#[inline(always)]
pub fn hit<L: Lane>(best: &Best<L>, lane: usize) -> Hit {
    best.rows().hit(lane)
}
