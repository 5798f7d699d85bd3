//! Blocks of frames in which sub-rays that meet one triangle are shaded as one: few rays of a block are shaded, so those of
//! several blocks fill packets together.

use crate::block::{Block, RAYS, resolve_block};
use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instant::Instant;
use crate::instruction_set::LaneTask;
use crate::packet::{Found, HIT, PacketState, Rays};
use crate::shadows::Shadows;
use crate::wide::Wide;
use rtrt_core::kernel::tiles::TILE;
use rtrt_core::layout::{Frame, NONE};
use rtrt_core::schedule::{Pass, Step};
use rtrt_core::stage::share;

/// Blocks that fill packets together.
pub const BLOCKS: usize = 4;

/// Runs the steps behind the lists on blocks.
pub struct RunShared<'a> {
    pub context: &'a FrameContext<'a>,
    pub steps: &'a [Step],
    /// The index of the first.
    pub first: u32,
    /// At most [`BLOCKS`].
    pub blocks: &'a mut [Block],
}

/// Rays that wait for others to be shaded with.
struct Waiting {
    found: Found,
    /// Where they are: a block's rays, then the next one's.
    places: [u16; RAYS],
    count: usize,
}

impl LaneTask for RunShared<'_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { context, steps, first, blocks } = self;
        let (mut clock, mut start) = (Clock::default(), Instant::now());
        let is_last = |step: &Step| step.pass == Pass::Resolve;
        let split = steps.iter().position(|step| step.pass == Pass::Share).unwrap_or(0);
        let (search, shading) = (&steps[..split], &steps[split + 1..]);
        let shading = shading.split(is_last).next().unwrap_or_default();

        let mut shaded = [[0; RAYS]; BLOCKS];
        let mut waiting = Waiting { found: [[0; RAYS]; HIT + 3], places: [0; RAYS], count: 0 };
        let mut found: Found = [[0; RAYS]; HIT + 3];
        let mut to =
            Shading { shadows: core::mem::take(&mut blocks[0].shadows), colors: [[0.0; 4]; BLOCKS * RAYS] };
        let last = blocks.len();
        for (block, shaded) in (0..last).zip(&mut shaded) {
            for ray in (0..RAYS).step_by(L::WIDTH * G) {
                let mut packet = PacketState::<L, G>::new(token, context, first + block as u32, ray);
                let mut nothing = Rays::nothing(&mut to.shadows);
                packet.run_all(search, &mut nothing, None, &mut clock, &mut start);
                packet.leave(&mut found);
            }
            share(context.trace.frame, &found, shaded);
            clock.lap(steps[split].stage(), &mut start);
            for (ray, leader) in shaded.iter().enumerate() {
                if ray == usize::from(*leader) {
                    waiting.push(&found, ray, block * RAYS + ray);
                }
                let is_last = (block + 1, ray + 1) == (last, RAYS);
                if waiting.count == L::WIDTH * G || is_last && waiting.count > 0 {
                    waiting.shade::<L, G>(token, context, shading, &mut to, &mut clock, &mut start);
                }
            }
        }
        for (block, (colors, shaded)) in blocks.iter_mut().zip(to.colors.chunks(RAYS).zip(&shaded)) {
            resolve_block::<L>(token, context.trace.frame, colors, shaded, &mut block.tile);
        }
        if let Some(resolve) = steps.iter().find(|step| is_last(step)) {
            clock.lap(resolve.stage(), &mut start);
        }
        blocks[0].shadows = to.shadows;
        clock
    }
}

/// What packets leave: shadows of the lights, and the colors of all blocks' rays.
struct Shading {
    shadows: Shadows,
    colors: [[f32; 4]; BLOCKS * RAYS],
}

impl Waiting {
    /// Adds a ray of a block, and where it is.
    #[inline(always)]
    fn push(&mut self, found: &Found, ray: usize, place: usize) {
        for (to, from) in self.found.iter_mut().zip(found) {
            to[self.count] = from[ray];
        }
        self.places[self.count] = place as u16;
        self.count += 1;
    }

    /// Shades what waits.
    #[inline(always)]
    fn shade<L: Wide, const G: usize>(
        &mut self,
        token: L::Token,
        context: &FrameContext<'_>,
        steps: &[Step],
        to: &mut Shading,
        clock: &mut Clock,
        start: &mut Instant,
    ) {
        let count = core::mem::take(&mut self.count);
        for plane in &mut self.found {
            // Behind the last is nothing.
            plane[count..].fill(NONE);
        }
        let mut colors = [[0.0; 4]; RAYS];
        let mut packet = PacketState::<L, G>::of(token, context, &self.found, count);
        let mut rays = Rays { colors: &mut colors, ..Rays::nothing(&mut to.shadows) };
        packet.run_steps(steps.iter().copied(), &mut rays, None, clock, start);
        for (color, place) in colors[..count].iter().zip(&self.places) {
            to.colors[usize::from(*place)] = *color;
        }
    }
}

/// The ray whose color each ray of a block takes.
#[inline(always)]
fn share(frame: &Frame, found: &Found, shaded: &mut [u8; RAYS]) {
    let [_, instances, triangles, ..] = found.each_ref().map(|plane| plane.as_chunks().0);
    for (tile, shaded) in shaded.as_chunks_mut::<TILE>().0.iter_mut().enumerate() {
        let first = (tile * TILE) as u8;
        *shaded = share::tile(frame, &instances[tile], &triangles[tile]).map(|ray| first + ray);
    }
}
