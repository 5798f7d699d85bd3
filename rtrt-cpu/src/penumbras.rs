//! Soft shadows: the blocks whose shadows the penumbra filter may change, and the filter, light after
//! light.

use crate::block::Block;
use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instant::Instant;
use crate::instruction_set::{InstructionSet, LaneTask};
use crate::parallel;
use crate::planes::{Planes, Rows};
use crate::wide::Wide;
use alloc::vec::Vec;
use core::sync::atomic::{AtomicBool, Ordering};
use rtrt_core::grid::{BLOCK, BLOCK_RAYS, RayIndex, number};
use rtrt_core::lane::{Bits, Row};
use rtrt_core::layout::Frame;
use rtrt_core::schedule::Step;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::penumbra_blocks::{PenumbraSummary, are_soft, span};
use rtrt_core::stage::penumbra_filter::filter_penumbra;

/// What the filter knows of a layer of a frame.
#[derive(Debug, Default)]
pub struct Penumbras {
    planes: Planes,
    /// Of each block and light: see [`edges_at`](rtrt_core::stage::penumbra_blocks::edges_at).
    summaries: Vec<PenumbraSummary>,
    /// Whether the filter changes its shadows: all blocks of a light, then those of the next.
    are_filtered: Vec<bool>,
    /// Whether the filter reads a block for a light.
    is_read: Vec<bool>,
}

impl Penumbras {
    /// Finds the blocks whose shadows the filter may change.
    pub fn select(&mut self, frame: &Frame, blocks: &[Block]) {
        self.summaries.clear();
        self.summaries.extend(blocks.iter().flat_map(|block| &block.summaries));
        self.are_filtered.resize(self.summaries.len(), false);
        let summaries = &self.summaries[..];
        parallel::each(&mut self.are_filtered, 256, |at, is_filtered| {
            let (light, index) = ((at / blocks.len()) as u32, at % blocks.len());
            let block = &blocks[index];
            // A light that reaches no ray of the block leaves nothing to filter.
            *is_filtered = !block.is_done
                && block.shadows.is_reached(light)
                && are_soft(frame, summaries, index as u32, light) == 1;
        });
    }

    /// Filters the shadows of these blocks in a layer, until `stop` is true.
    pub fn filter(
        &mut self,
        level: InstructionSet,
        context: &FrameContext<'_>,
        step: Step,
        blocks: &mut [Block],
        stop: &AtomicBool,
    ) -> Clock {
        let frame = &context.trace.frame.of_layer(step.layer);
        let context = &Context { frame, ..context.trace };
        let Self { planes, are_filtered, is_read, .. } = self;
        let (mut clock, mut start) = (Clock::default(), Instant::now());
        planes.begin(frame);
        for (light, are_filtered) in (0..).zip(are_filtered.chunks(blocks.len())) {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            if !are_filtered.contains(&true) {
                continue;
            }
            find_read(frame, are_filtered, is_read);
            planes.fill(frame, blocks, light, is_read);
            clock.lap_of_all(step.stage(), &mut start);
            let filter = |_: &mut (), index, block: &mut Block, _: Option<&mut ()>| {
                let (mut clock, start) = (Clock::default(), Instant::now());
                if are_filtered[index] && !stop.load(Ordering::Relaxed) {
                    level.run(FilterBlock { context, planes, light, index: index as u32, block });
                    clock.add(step.stage(), start);
                }
                clock
            };
            clock = clock.plus(parallel::sum(blocks, &mut [], || (), filter, Clock::plus));
            start = Instant::now();
        }
        clock
    }
}

/// Finds the blocks that are read where these are filtered.
fn find_read(frame: &Frame, are_filtered: &[bool], is_read: &mut Vec<bool>) {
    let columns = frame.grid().blocks_x();
    let rows = are_filtered.len() as u32 / columns;
    is_read.clear();
    is_read.resize(are_filtered.len(), false);
    for (block, _) in (0..).zip(are_filtered).filter(|(_, is_filtered)| **is_filtered) {
        let [left, right] = span(frame, block % columns, columns);
        let [top, bottom] = span(frame, block / columns, rows);
        for y in top..bottom {
            is_read[(y * columns + left) as usize..(y * columns + right) as usize].fill(true);
        }
    }
}

/// Filters the shadows of a light in a block.
struct FilterBlock<'a> {
    context: &'a Context<'a>,
    planes: &'a Planes,
    light: u32,
    index: u32,
    block: &'a mut Block,
}

impl LaneTask for FilterBlock<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) {
        let Self { context, planes, light, index, block } = self;
        let Context { frame, views, .. } = *context;
        let [left, top] = frame.grid().ray(RayIndex(index * BLOCK_RAYS));
        let transmittance = &mut block.shadows.planes_mut(light)[0];
        for y in 0..BLOCK {
            for x in (0..BLOCK).step_by(L::WIDTH) {
                let rows = Rows::new(token, planes, [left + x, top + y]);
                let words = L::outlined(
                    token,
                    #[inline(always)]
                    || filter_penumbra::<L, _>(frame, views, &rows, light),
                );
                let words = words.row();
                for lane in 0..L::WIDTH {
                    transmittance[number([x + lane as u32, y]) as usize] = words.at(lane);
                }
            }
        }
    }
}
