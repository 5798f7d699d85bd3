//! A block, on one thread: the steps from one barrier of the frame to the next, so that what a step
//! leaves for another stays in the first-level cache.

use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instant::Instant;
use crate::instruction_set::LaneTask;
use crate::packet::{HIT, PacketState, Rays};
use crate::records::Records;
use crate::shadows::{NO_PENUMBRA, Shadows};
use crate::wide::Wide;
use alloc::vec::Vec;
use rtrt_core::grid::{BLOCK_RAYS, Grid, RayIndex, first_rays, number};
use rtrt_core::layout::{Frame, ShadowKind};
use rtrt_core::schedule::{Pass, Step, Unit};
use rtrt_core::stage::ambient::Record;
use rtrt_core::stage::penumbra_blocks::{PenumbraSummary, common};
use rtrt_core::stage::resolve::{average, resolve};

/// Rays in a block.
pub const RAYS: usize = BLOCK_RAYS as usize;
/// Planes of places: the origins of shadow rays, then the normals there.
pub const PLACES: usize = 6;

/// What a block leaves from one barrier to the next. Words of rays are plane after plane: the first word
/// of all of its rays, then the second.
#[derive(Debug, Default)]
pub struct Block {
    /// Its pixels.
    pub tile: Vec<u32>,
    /// Where they are not bits.
    pub shadows: Shadows,
    /// In frames with penumbras, the hits of the last layer, the records of rays, and [`PLACES`].
    hits: Vec<u32>,
    colors: Vec<[f32; 4]>,
    pub places: Vec<u32>,
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
        self.shadows.begin(frame);
        let penumbras = usize::from(frame.shadow_kind() == ShadowKind::Penumbra);
        self.hits.resize(penumbras * RAYS * HIT, 0);
        self.colors.resize(penumbras * Frame::RECORDS * RAYS, [0.0; 4]);
        self.places.resize(penumbras * RAYS * PLACES, 0);
        self.summaries.resize(penumbras * frame.lights as usize, PenumbraSummary::NONE);
        self.is_done = false;
    }
}

/// What steps leave for others between the same barriers. Blocks that follow one another on a thread use the same.
pub struct Scratch {
    colors: [[f32; 4]; Frame::RECORDS * RAYS],
    ambient: [Record; RAYS],
    shaded: [u8; RAYS],
}

impl Scratch {
    pub const EMPTY: Self =
        Self { colors: [[0.0; 4]; Frame::RECORDS * RAYS], ambient: [[0.0; 8]; RAYS], shaded: [0; RAYS] };
}

/// Runs steps on a block.
pub struct RunBlock<'a, 'b> {
    pub context: &'a FrameContext<'a>,
    /// They follow one another up to a barrier.
    pub steps: &'a [Step],
    pub index: u32,
    pub block: &'a mut Block,
    pub scratch: &'a mut Scratch,
    pub records: Option<&'a mut Records<'b>>,
}

/// Whether packets run it one after another.
fn is_of_packet(step: &Step) -> bool {
    match step.pass {
        Pass::Share => true,
        _ => matches!(step.unit(), Unit::Ray | Unit::RayAndLight),
    }
}

impl LaneTask for RunBlock<'_, '_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { context, steps, index, block, scratch, mut records } = self;
        let Block { tile, shadows, hits, colors, places, summaries, is_done } = block;
        let Scratch { colors: local, ambient, shaded } = scratch;
        // Where no step waits for other blocks, colors need no memory of their own.
        let colors = if colors.is_empty() { &mut local[..] } else { colors };
        let mut rays = Rays { colors, shadows, hits, places, ambient, shaded };
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
                Pass::SummarizePenumbras => {
                    summarize_penumbras(context.trace.frame.grid(), index, rays.shadows, summaries);
                    if let Some(records) = records.as_mut().filter(|_| step.layer == 0) {
                        records.raw_shadows(rays.shadows);
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

/// Summarizes the penumbras of each light in a block.
#[inline(always)]
fn summarize_penumbras(grid: Grid, index: u32, shadows: &Shadows, summaries: &mut [PenumbraSummary]) {
    for (light, summary) in (0..).zip(summaries) {
        if !shadows.is_reached(light) {
            *summary = PenumbraSummary::of(0, NO_PENUMBRA);
            continue;
        }
        let planes = shadows.both(light);
        *summary = common(
            grid,
            RayIndex(index * BLOCK_RAYS),
            #[inline(always)]
            |ray| PenumbraSummary::of(planes[0][ray as usize], f32::from_bits(planes[1][ray as usize])),
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
