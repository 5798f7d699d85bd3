//! All blocks of a frame: from barrier to barrier in parallel.

use crate::block::{Block, PenumbraFilter, RunBlock};
use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instant::Instant;
use crate::instruction_set::InstructionSet;
use crate::parallel;
use crate::planes::Planes;
use crate::records::Records;
use crate::share::{BLOCKS, RunShared};
use alloc::vec::Vec;
use core::sync::atomic::{AtomicBool, Ordering};
use rtrt_core::grid::{BlockIndex, Grid};
use rtrt_core::layout::Frame;
use rtrt_core::schedule::{Pass, Step};
use rtrt_core::stage::penumbra_blocks::{PenumbraSummary, are_soft, edges_at, span};

/// What blocks are rendered in.
#[derive(Debug, Default)]
pub struct Blocks {
    /// As many as the largest frame so far had.
    blocks: Vec<Block>,
    planes: Planes,
    /// Of each block and light: see [`edges_at`].
    summaries: Vec<PenumbraSummary>,
    /// Whether the penumbra filter may change its shadows.
    filters: Vec<u32>,
    /// Whether the filter reads a block.
    is_read: Vec<bool>,
}

impl Blocks {
    /// Runs all steps behind the lists: fills the tiles, and the records of all blocks if there are any. Once `stop` is
    /// true, no further block is looked at, and the tiles hold nothing of use.
    pub fn run(
        &mut self,
        level: InstructionSet,
        context: &FrameContext<'_>,
        steps: &[Step],
        records: &mut [Records<'_>],
        stop: &AtomicBool,
    ) -> Clock {
        let count = context.trace.frame.grid().blocks() as usize;
        if self.blocks.len() < count {
            self.blocks.resize_with(count, Block::default);
        }
        parallel::each(&mut self.blocks[..count], 64, |_, block| block.begin(context.trace.frame));
        let mut clock = Clock::default();
        for steps in steps.chunk_by(|_, next| !next.has_barrier()) {
            let is_last = steps.iter().any(|step| step.pass == Pass::Resolve);
            if !is_last && self.blocks[..count].iter().all(|block| block.is_done) {
                continue;
            }
            clock = clock.plus(if steps[0].pass == Pass::SelectFilterBlocks {
                self.select_filter_blocks(context.trace.frame, steps[0])
            } else {
                self.each(level, context, steps, records, stop)
            });
        }
        clock
    }

    /// Runs steps on all blocks.
    fn each(
        &mut self,
        level: InstructionSet,
        context: &FrameContext<'_>,
        steps: &[Step],
        records: &mut [Records<'_>],
        stop: &AtomicBool,
    ) -> Clock {
        let Self { blocks, planes, filters, .. } = self;
        let filter = PenumbraFilter { planes, blocks: filters };
        let run = |index, block: &mut Block, records: Option<&mut Records<'_>>| {
            if stop.load(Ordering::Relaxed) {
                return Clock::default();
            }
            level.run(RunBlock { context, steps, index: index as u32, block, records, filter })
        };
        let count = context.trace.frame.grid().blocks() as usize;
        if steps.iter().any(|step| step.pass == Pass::Share) && records.is_empty() {
            let run = |part, blocks: &mut [Block]| {
                if stop.load(Ordering::Relaxed) {
                    return Clock::default();
                }
                level.run(RunShared { context, steps, first: (part * BLOCKS) as u32, blocks })
            };
            return parallel::sum_parts(&mut blocks[..count], BLOCKS, run, Clock::plus);
        }
        parallel::sum(&mut blocks[..count], records, run, Clock::plus)
    }

    /// Finds the blocks whose shadows the penumbra filter may change, and lays out what it reads there.
    fn select_filter_blocks(&mut self, frame: &Frame, step: Step) -> Clock {
        let (mut clock, start) = (Clock::default(), Instant::now());
        let [columns, rows] = [frame.grid().blocks_x(), frame.grid().blocks_y()];
        let (lights, count) = (frame.lights, columns * rows);
        let blocks = &self.blocks[..count as usize];
        self.summaries.clear();
        self.summaries.extend(blocks.iter().flat_map(|block| &block.summaries));
        self.filters.resize((count * lights) as usize, 0);
        self.is_read.clear();
        self.is_read.resize(count as usize, false);
        let summaries = &self.summaries[..];
        parallel::each(&mut self.filters, 256, |at, filters| {
            *filters = are_soft(frame, summaries, at as u32 / lights, at as u32 % lights);
        });
        for block in 0..count {
            let first = edges_at(frame, block, 0);
            if self.filters[first..first + lights as usize].contains(&1) {
                let [left, right] = span(frame, block % columns, columns);
                let [top, bottom] = span(frame, block / columns, rows);
                for y in top..bottom {
                    self.is_read[(y * columns + left) as usize..(y * columns + right) as usize].fill(true);
                }
            }
        }
        self.planes.fill(frame, |block| &blocks[block].cells, &self.is_read);
        clock.add(step.stage(), start);
        clock
    }

    /// Copies the tiles of blocks into rows of pixels.
    pub fn untile(&self, grid: Grid, pixels: &mut Vec<u32>) {
        let side = grid.block_pixels() as usize;
        let width = grid.width as usize;
        pixels.resize(width * grid.height as usize, 0);
        parallel::each_part(pixels, width, 16, |y, row| {
            for (column, part) in row.chunks_mut(side).enumerate() {
                let block = BlockIndex((y / side) as u32 * grid.blocks_x() + column as u32);
                let at = y % side * side;
                part.copy_from_slice(&self.blocks[block.0 as usize].tile[at..at + part.len()]);
            }
        });
    }
}
