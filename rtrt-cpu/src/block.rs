//! All stages of one block, on one thread: what a stage leaves for the next stays in the
//! first-level cache.

use crate::clock::{Clock, LAYERS};
use crate::context::FrameContext;
use crate::instruction_set::LaneTask;
use crate::records::{Found, Records};
use crate::shadows::Shadows;
use crate::wide::Wide;
use rayon::prelude::*;
use rtrt_core::grid::{BLOCK_RAYS, BlockIndex, Grid, RayIndex};
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::lane::{Bits, Lane, Mask, Row, Select, groups};
use rtrt_core::layout::NONE;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::peel::is_covered;
use rtrt_core::stage::resolve::resolve;
use rtrt_core::stage::visibility::directions;
use std::time::Instant;

/// A block to be rendered, packet after packet, into its pixels and, if wanted, its records.
pub struct Block<'a> {
    pub context: &'a FrameContext<'a>,
    pub index: u32,
    pub tile: &'a mut [u32],
    /// See [`crate::shadows::transmittance_words`].
    pub transmittance: &'a mut [u32],
    pub records: Option<Records<'a>>,
}

impl LaneTask for Block<'_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { context, index, tile, transmittance, mut records } = self;
        let mut clock = Clock::default();
        let mut colors = [[0.0; 4]; BLOCK_RAYS as usize];
        let packet = L::WIDTH * G;
        for first in (0..BLOCK_RAYS as usize).step_by(packet) {
            let ray = RayIndex(index * BLOCK_RAYS + first as u32);
            // Where none are kept, a block has one word.
            let kept = first.min(transmittance.len());
            let transmittance = &mut transmittance[kept..];
            packet_colors::<L, G>(
                token,
                context,
                ray,
                &mut colors,
                transmittance,
                records.as_mut(),
                &mut clock,
            );
        }
        let mut start = Instant::now();
        resolved::<L>(token, context, index, &colors, tile);
        clock.lap(9, &mut start);
        clock
    }
}

/// The pixels of a block of these colors.
#[inline(always)]
pub fn resolved<L: Wide>(
    token: L::Token,
    context: &FrameContext<'_>,
    index: u32,
    colors: &[[f32; 4]],
    tile: &mut [u32],
) {
    let grid = context.trace.frame.grid();
    // A power of two.
    let side = grid.block_pixels();
    let (across, down) = (side - 1, side.trailing_zeros());
    let [left, top] = grid.ray(RayIndex(index * BLOCK_RAYS)).map(|ray| ray / grid.side);
    for (first, pixels) in (0..).step_by(L::WIDTH).zip(tile.chunks_mut(L::WIDTH)) {
        let bits = resolve::<L>(
            token,
            grid,
            #[inline(always)]
            |lane| [left + ((first + lane as u32) & across), top + ((first + lane as u32) >> down)],
            #[inline(always)]
            |ray| colors[(ray.0 % BLOCK_RAYS) as usize],
        );
        let bits = bits.row();
        for (lane, pixel) in pixels.iter_mut().enumerate() {
            *pixel = bits.at(lane);
        }
    }
}

/// The colors of one packet: the first layer of surfaces, and those behind it that can be seen.
#[inline(always)]
fn packet_colors<L: Wide, const G: usize>(
    token: L::Token,
    context: &FrameContext<'_>,
    ray: RayIndex,
    colors: &mut [[f32; 4]],
    transmittance: &mut [u32],
    mut records: Option<&mut Records<'_>>,
    clock: &mut Clock,
) {
    let mut frame = *context.trace.frame;
    let camera = context.trace.camera();
    let first = (ray.0 % BLOCK_RAYS) as usize;
    let mut start = Instant::now();
    let zero = L::splat(token, 0.0);
    let none = zero.broadcast_bits(0);
    let mut best: [ClosestHit<L>; G] = groups(
        #[inline(always)]
        |_| ClosestHit { t: zero, instance: none, triangle: none, u: zero, v: zero },
    );
    let mut sums = [[zero; 4]; G];
    for number in 0.. {
        // The stages of a layer have the names of the first one's, the time does not.
        let stage = |stage: usize| if number == 0 { stage } else { LAYERS };
        best = context.seen(token, &frame, ray, &best);
        clock.lap(stage(2), &mut start);
        let directions = directions::<L, G>(token, &frame, camera, ray);
        let mut surfaces = context.surfaces(token, &directions, &best);
        clock.lap(stage(3), &mut start);
        context.detail(token, &best, &mut surfaces);
        clock.lap(stage(4), &mut start);
        let shadows = Shadows::<L, G>::new(
            token,
            &Context { frame: &frame, ..context.trace },
            ray,
            &surfaces,
            transmittance,
        );
        clock.lap(stage(5), &mut start);
        let arriving = context.arriving(token, &frame, ray, &directions, &surfaces, &shadows);
        clock.lap(stage(6), &mut start);
        context.shade(token, &frame, &directions, &surfaces, &arriving, &mut sums);
        clock.lap(stage(7), &mut start);
        if let Some(records) = &mut records {
            let found = Found { closest: &best, surfaces: &surfaces, shadows: &shadows, light: &arriving };
            records.keep(context.trace.frame, number, first, &found);
        }
        if frame.layers <= 1 {
            break;
        }
        frame.layers -= 1;
        // What nothing shines through looks for nothing more.
        let mut is_done = true;
        for g in 0..G {
            let missing = none.broadcast(NONE);
            best[g].instance = is_covered(sums[g][3]).select(missing, best[g].instance);
            is_done &= !(!best[g].instance.eq(missing)).any();
        }
        if is_done {
            break;
        }
    }
    store(&sums, &mut colors[first..]);
    if let Some(records) = &mut records {
        let range = first..first + G * L::WIDTH;
        records.colors[range.clone()].copy_from_slice(&colors[range]);
    }
    clock.lap(7, &mut start);
}

/// Writes colors lane after lane.
#[inline(always)]
pub fn store<L: Lane, const G: usize>(sums: &[[L; 4]; G], colors: &mut [[f32; 4]]) {
    for (g, sum) in sums.iter().enumerate() {
        let [red, green, blue, alpha] = groups(
            #[inline(always)]
            |channel| sum[channel].row(),
        );
        for lane in 0..L::WIDTH {
            colors[g * L::WIDTH + lane] = [red.at(lane), green.at(lane), blue.at(lane), alpha.at(lane)];
        }
    }
}

/// Copies tiles into rows.
pub fn untile(grid: Grid, tiles: &[u32], pixels: &mut Vec<u32>) {
    let side = grid.block_pixels() as usize;
    let width = grid.width as usize;
    pixels.resize(width * grid.height as usize, 0);
    pixels.par_chunks_mut(width).with_min_len(16).enumerate().for_each(|(y, row)| {
        for (column, part) in row.chunks_mut(side).enumerate() {
            let block = BlockIndex((y / side) as u32 * grid.blocks_x() + column as u32);
            let at = (block.0 as usize * side + y % side) * side;
            part.copy_from_slice(&tiles[at..at + part.len()]);
        }
    });
}
