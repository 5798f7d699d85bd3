//! All blocks of a frame: from barrier to barrier in parallel.

use crate::block::{Block, RunBlock, Scratch};
use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instant::Instant;
use crate::instruction_set::InstructionSet;
use crate::parallel;
use crate::penumbras::Penumbras;
use crate::records::Records;
use crate::share::{BLOCKS, RunShared};
use alloc::vec::Vec;
use core::sync::atomic::{AtomicBool, Ordering};
use rtrt_core::grid::{BlockIndex, Grid};
use rtrt_core::schedule::{Pass, Step};

/// What blocks are rendered in.
#[derive(Debug, Default)]
pub struct Blocks {
    /// As many as the largest frame so far had.
    blocks: Vec<Block>,
    penumbras: Penumbras,
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
            if stop.load(Ordering::Relaxed) {
                break;
            }
            if !is_last && self.blocks[..count].iter().all(|block| block.is_done) {
                continue;
            }
            let step = steps[0];
            let steps = match step.pass {
                Pass::SelectFilterBlocks => {
                    let mut start = Instant::now();
                    self.penumbras.select(context.trace.frame, &self.blocks[..count]);
                    clock.lap_of_all(step.stage(), &mut start);
                    continue;
                }
                Pass::FilterPenumbra => {
                    let blocks = &mut self.blocks[..count];
                    clock = clock.plus(self.penumbras.filter(level, context, step, blocks, stop));
                    &steps[1..]
                }
                _ => steps,
            };
            clock = clock.plus(self.each(level, context, steps, records, stop));
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
        let blocks = &mut self.blocks;
        let run = |scratch: &mut Scratch, index, block: &mut Block, records: Option<&mut Records<'_>>| {
            if stop.load(Ordering::Relaxed) {
                return Clock::default();
            }
            level.run(RunBlock { context, steps, index: index as u32, block, scratch, records })
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
        parallel::sum(&mut blocks[..count], records, || Scratch::EMPTY, run, Clock::plus)
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
