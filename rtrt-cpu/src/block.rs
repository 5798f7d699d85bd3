//! A block, on one thread: the steps from one barrier of the frame to the next, so that what a step
//! leaves for another stays in the first-level cache.

use crate::cells::{self, RAYS};
use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instant::Instant;
use crate::instruction_set::LaneTask;
use crate::packet::{HIT, PacketState, Rays};
use crate::planes::{Planes, Rows};
use crate::records::Records;
use crate::wide::Wide;
use alloc::vec::Vec;
use rtrt_core::grid::{BLOCK, BLOCK_RAYS, Grid, RayIndex, first_rays, number};
use rtrt_core::lane::{Bits, Row};
use rtrt_core::layout::{Frame, ShadowKind};
use rtrt_core::schedule::{Pass, Step, Unit};
use rtrt_core::stage::context::Context;
use rtrt_core::stage::penumbra_blocks::{PenumbraSummary, common, edges_at};
use rtrt_core::stage::penumbra_filter::filter_penumbra;
use rtrt_core::stage::resolve::{average, resolve};

/// What a block leaves from one barrier to the next. Words of rays are plane after plane: the first word
/// of all of its rays, then the second.
#[derive(Debug, Default)]
pub struct Block {
    /// Its pixels.
    pub tile: Vec<u32>,
    /// A plane a light, where shadows are not bits.
    pub transmittance: Vec<u32>,
    /// In frames with penumbras, the hits of the last layer, and the records of rays.
    hits: Vec<u32>,
    colors: Vec<[f32; 4]>,
    /// What the penumbra filter reads: see [`cells`].
    pub cells: Vec<u32>,
    /// One a light.
    pub summaries: Vec<PenumbraSummary>,
    /// Whether all rays are done.
    pub is_done: bool,
}

impl Block {
    /// Makes room for a frame.
    pub fn begin(&mut self, frame: &Frame) {
        let pixels = frame.grid().block_pixels();
        self.tile.resize((pixels * pixels) as usize, 0);
        self.transmittance.resize(RAYS * frame.transmittance_words() as usize, 0);
        let penumbras = usize::from(frame.shadow_kind() == ShadowKind::Penumbra);
        self.hits.resize(penumbras * RAYS * HIT, 0);
        self.colors.resize(penumbras * Frame::RECORDS * RAYS, [0.0; 4]);
        self.cells.resize(penumbras * RAYS * cells::count(frame), 0);
        self.summaries.resize(penumbras * frame.lights as usize, PenumbraSummary::NONE);
        self.is_done = false;
    }
}

/// Runs steps on a block.
pub struct RunBlock<'a, 'b> {
    pub context: &'a FrameContext<'a>,
    /// They follow one another up to a barrier.
    pub steps: &'a [Step],
    pub index: u32,
    pub block: &'a mut Block,
    pub records: Option<&'a mut Records<'b>>,
    pub filter: PenumbraFilter<'a>,
}

/// What the penumbra filter reads.
#[derive(Clone, Copy)]
pub struct PenumbraFilter<'a> {
    pub planes: &'a Planes,
    /// Whether it may change the shadows of a block and light.
    pub blocks: &'a [u32],
}

/// Whether packets run it one after another.
fn is_of_packet(step: &Step) -> bool {
    match step.pass {
        Pass::Share => true,
        Pass::FilterPenumbra => false,
        _ => matches!(step.unit(), Unit::Ray | Unit::RayAndLight),
    }
}

impl LaneTask for RunBlock<'_, '_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { context, steps, index, block, mut records, filter } = self;
        let Block { tile, transmittance, hits, colors, cells, summaries, is_done } = block;
        let mut local = [[0.0; 4]; Frame::RECORDS * RAYS];
        // Where no step waits for other blocks, colors need no memory but the stack's.
        let colors = if colors.is_empty() { &mut local[..] } else { colors };
        // Rays ask and shade between the same barriers.
        let mut ambient = [[0.0; 8]; RAYS];
        let mut shaded = [0; RAYS];
        let mut rays =
            Rays { colors, transmittance, hits, cells, ambient: &mut ambient, shaded: &mut shaded };
        let was_done = *is_done;
        let (mut clock, mut start) = (Clock::default(), Instant::now());
        for steps in steps.chunk_by(|a, b| is_of_packet(a) && is_of_packet(b)) {
            let step = steps[0];
            match step.pass {
                Pass::Resolve => {
                    resolve_block::<L>(token, context.trace.frame, rays.colors, rays.shaded, tile);
                    if let Some(records) = &mut records {
                        records.colors.copy_from_slice(&rays.colors[..RAYS]);
                    }
                }
                _ if was_done => {}
                Pass::FilterPenumbra => {
                    let trace = Context { frame: &context.trace.frame.of_layer(step.layer), ..context.trace };
                    filter.run::<L>(token, &trace, index, rays.cells, rays.transmittance);
                }
                Pass::SummarizePenumbras => {
                    summarize_penumbras(context.trace.frame.grid(), index, rays.cells, summaries);
                    if let Some(records) = records.as_mut().filter(|_| step.layer == 0) {
                        records.raw_shadows(rays.cells);
                    }
                }
                _ => {
                    *is_done = true;
                    for first in (0..RAYS).step_by(L::WIDTH * G) {
                        let mut packet = PacketState::<L, G>::new(token, context, index, first);
                        packet.run_all(steps, &mut rays, records.as_deref_mut(), &mut clock, &mut start);
                        *is_done &= packet.is_done;
                    }
                    continue;
                }
            }
            clock.lap(step.stage(), &mut start);
        }
        clock
    }
}

impl PenumbraFilter<'_> {
    /// Filters the shadows of a block. Those of lights that the filter would not change are copied.
    #[inline(always)]
    fn run<L: Wide>(
        self,
        token: L::Token,
        context: &Context<'_>,
        index: u32,
        cells: &[u32],
        transmittance: &mut [u32],
    ) {
        let frame = context.frame;
        let [left, top] = frame.grid().ray(RayIndex(index * BLOCK_RAYS));
        for (light, transmittance) in transmittance.chunks_mut(RAYS).enumerate() {
            if self.blocks[edges_at(frame, index, light as u32)] == 0 {
                transmittance.copy_from_slice(&cells[cells::transmittance(light) * RAYS..][..RAYS]);
                continue;
            }
            for y in 0..BLOCK {
                for x in (0..BLOCK).step_by(L::WIDTH) {
                    let rows = Rows::new(token, self.planes, [left + x, top + y], light as u32);
                    let words = L::outlined(
                        token,
                        #[inline(always)]
                        || filter_penumbra::<L, _>(frame, context.views, &rows, light as u32),
                    );
                    let words = words.row();
                    for lane in 0..L::WIDTH {
                        transmittance[number([x + lane as u32, y]) as usize] = words.at(lane);
                    }
                }
            }
        }
    }
}

/// Summarizes the penumbras of each light in a block.
#[inline(always)]
fn summarize_penumbras(grid: Grid, index: u32, cells: &[u32], summaries: &mut [PenumbraSummary]) {
    for ((transmittance, radii), summary) in cells::lights(cells).zip(summaries) {
        *summary = common(
            grid,
            RayIndex(index * BLOCK_RAYS),
            #[inline(always)]
            |ray| PenumbraSummary::of(transmittance[ray as usize], f32::from_bits(radii[ray as usize])),
        );
    }
}

/// Those of pixels with 1, 4 and 16 sub-rays.
static FIRST_RAYS: [[u8; RAYS]; 3] = [first_rays(1), first_rays(2), first_rays(4)];

/// Makes the pixels of a block of these colors.
#[inline(always)]
pub fn resolve_block<L: Wide>(
    token: L::Token,
    frame: &Frame,
    colors: &[[f32; 4]],
    shaded: &[u8],
    tile: &mut [u32],
) {
    // Behind the colors is what goes through colored layers.
    let (colors, throughs) = colors.split_at(RAYS);
    let places = &FIRST_RAYS[frame.side.trailing_zeros() as usize];
    let first_ray = |pixel: usize| RayIndex(places[pixel % RAYS].into());
    let through = |pixel| {
        average(
            frame.side,
            first_ray(pixel),
            #[inline(always)]
            |ray| throughs[ray.0 as usize % RAYS],
        )
    };
    if frame.side == 1 && frame.is_shared == 0 {
        return resolve_pixels::<L>(
            token,
            frame,
            tile,
            // Lanes are pixels of a row, whose rays follow the first one's at the same distances everywhere.
            #[inline(always)]
            |first, lane| {
                let span = const { number([L::WIDTH as u32 - 1, 0]) as usize + 1 };
                let rays = &colors[first_ray(first).0 as usize..][..span];
                rays[number([lane as u32, 0]) as usize]
            },
            through,
        );
    }
    resolve_pixels::<L>(
        token,
        frame,
        tile,
        #[inline(always)]
        |first, lane| {
            average(
                frame.side,
                first_ray(first + lane),
                #[inline(always)]
                |ray| {
                    let ray = ray.0 as usize % RAYS;
                    colors[if frame.is_shared == 1 { shaded[ray].into() } else { ray }]
                },
            )
        },
        through,
    );
}

/// Makes the pixels of a block of the colors of each, given the first of its group and its lane, and of what goes through
/// its layers.
#[inline(always)]
fn resolve_pixels<L: Wide>(
    token: L::Token,
    frame: &Frame,
    tile: &mut [u32],
    color: impl Fn(usize, usize) -> [f32; 4],
    through: impl Fn(usize) -> [f32; 4],
) {
    debug_assert!(tile.len().is_multiple_of(L::WIDTH));
    for (first, pixels) in (0..).step_by(L::WIDTH).zip(tile.chunks_exact_mut(L::WIDTH)) {
        let bits = resolve::<L>(
            token,
            frame,
            #[inline(always)]
            |lane| color(first, lane),
            #[inline(always)]
            |lane| through(first + lane),
        );
        L::store(bits, pixels);
    }
}
