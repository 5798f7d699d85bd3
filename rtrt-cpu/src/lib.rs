//! The native CPU backend of rtrt: rayon over blocks, SIMD lanes chosen at run time.
//!
//! It decides where and when the functions of `rtrt-core` run, and computes nothing itself.
//! Whatever the number of lanes and threads, a picture has the same bits.
//!
//! ```
//! use rtrt_core::backend::{Backend, Picture, Request};
//! use rtrt_core::scene::{Camera, Projection, Scene};
//!
//! let camera = Camera {
//!     eye: [0.0, 0.0, 3.0].into(),
//!     look_at: [0.0; 3].into(),
//!     up: [0.0, 1.0, 0.0].into(),
//!     projection: Projection::Perspective { fov_y: 1.0 },
//! };
//! let request = Request::new(&camera, [32, 20]);
//! let mut picture = Picture::default();
//! let mut cpu = rtrt_cpu::Cpu::new(rtrt_cpu::Options::default())?;
//! cpu.render(&Scene::new(), &request, &mut picture)?;
//! assert_eq!(picture.pixels.len(), 32 * 20);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | feature | without it |
//! |---|---|
//! | `threads` | all runs on the caller's thread: for targets without threads, as WebAssembly |
//! | `simd` | one lane |
//! | `sse4_2` | one lane on x86-64 without AVX2; the crate compiles in two thirds of the time |
//! | `std` | `no_std` with `alloc`, and stages take no time; the others need it |
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

extern crate alloc;

mod bin;
mod block;
mod blocks;
mod clock;
mod context;
mod error;
mod instant;
mod instruction_set;
mod packet;
mod parallel;
mod penumbras;
mod planes;
mod prepare;
mod rays;
mod records;
mod shadows;
mod share;
mod wide;

pub use error::Error;
pub use instruction_set::{InstructionSet, LaneTask};
pub use rays::Caster;
pub use wide::Wide;

use crate::bin::Binning;
use crate::blocks::Blocks;
use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instant::Instant;
use crate::parallel::Pool;
use crate::records::block_records;
use alloc::vec::Vec;
use core::sync::atomic::AtomicBool;
use rtrt_core::backend::{Backend, Deferred, Description, Picture, RenderError, Request};
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::scene::{Join, Scene, Setup};
use rtrt_core::schedule::{Pass, Stage, Step, steps};
use rtrt_core::stage::context::Context;

/// How the backend runs. The picture does not depend on it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// Numbers side by side: 1, 8 or 16; `None` for the widest that is fast here.
    pub lanes: Option<u32>,
    /// Threads; `None` for as many as the machine runs at once, or the one of the caller without the feature `threads`.
    pub threads: Option<usize>,
}

/// The CPU backend. Keeps its memory from frame to frame.
#[derive(Debug)]
pub struct Cpu {
    pool: Pool,
    level: InstructionSet,
    memory: Memory,
}

/// The flag of frames that nobody stops.
static NEVER: AtomicBool = AtomicBool::new(false);

/// What a frame is built in.
#[derive(Debug, Default)]
struct Memory {
    setup: Setup,
    steps: Vec<Step>,
    screen_bounds: Vec<ScreenBounds>,
    bins: bin::Bins,
    blocks: Blocks,
}

impl Cpu {
    /// A backend with these options.
    ///
    /// # Errors
    /// The processor or the system cannot; see [`Error`].
    pub fn new(options: Options) -> Result<Self, Error> {
        let level = InstructionSet::new(options.lanes)?;
        Ok(Self { pool: Pool::new(options.threads)?, level, memory: Memory::default() })
    }

    /// Runs `work` on the backend's threads.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }
}

impl Memory {
    /// Fills the tiles of blocks, and the deferred buffers if requested, until `stop` is true. Not inlined: what counts
    /// the instructions of a frame finds it by its name.
    #[inline(never)]
    fn frame(
        &mut self,
        level: InstructionSet,
        scene: &Scene,
        deferred: Option<&mut Deferred>,
        clock: &mut Clock,
        stop: &AtomicBool,
    ) {
        let Self { setup, steps: all, screen_bounds, bins, blocks } = self;
        let (frame, views, instances) = (&setup.frame, &setup.views[..], setup.instances(scene));
        all.clear();
        all.extend(steps(frame));
        let keeps_lights = bins.keeps_lights(setup, scene);
        let is_of_lists = |step: &Step| matches!(step.pass, Pass::Prepare | Pass::Bin);
        let (of_lists, of_blocks) = all.split_at(all.partition_point(is_of_lists));
        for step in of_lists {
            let start = Instant::now();
            if step.pass == Pass::Prepare {
                prepare::prepare(frame, views, instances, screen_bounds, keeps_lights);
            } else {
                bins.fill(&Binning { frame, views, instances, screen_bounds }, keeps_lights);
            }
            clock.add(step.stage(), start);
        }
        let lists = BlockLists { data: &bins.lists, blocks: frame.blocks };
        let context = FrameContext {
            trace: Context { frame, views, lists, geometry: setup.geometry(scene) },
            attributes: scene.attributes(),
            maps: scene.maps(),
        };
        let start = Instant::now();
        let mut records = deferred.map(|deferred| {
            deferred.lists.clone_from(&bins.lists);
            block_records(deferred, frame)
        });
        let records = records.as_deref_mut().unwrap_or_default();
        let busy = blocks.run(level, &context, of_blocks, records, stop);
        // The steps of a block follow one another on one thread, so a stage's share of
        // the time that passed is its share of the threads' time.
        clock.spread(start.elapsed(), &busy);
    }
}

impl Backend for Cpu {
    fn describe(&self) -> Description {
        Description {
            kind: "cpu".into(),
            adapter: self.level.name().into(),
            lanes: self.level.lanes(),
            threads: self.pool.threads(),
        }
    }

    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        let Self { pool, level, memory } = self;
        memory.setup.prepare(scene, request)?;
        let mut deferred = request.deferred.then(|| picture.deferred.take().unwrap_or_default());
        let mut clock = Clock::default();
        let stop = request.stop.unwrap_or(&NEVER);
        pool.install(|| {
            memory.frame(*level, scene, deferred.as_mut(), &mut clock, stop);
            let start = Instant::now();
            memory.blocks.untile(memory.setup.frame.grid(), &mut picture.pixels);
            clock.add(Stage::Resolve, start);
        });
        picture.deferred = deferred;
        [picture.width, picture.height] = request.size;
        picture.stages_ms = clock.milliseconds();
        picture.host_ms = None;
        if request.is_stopped() { Err(RenderError::Stopped) } else { Ok(()) }
    }
}

/// Builds both halves at once on the current rayon threads, where there are any.
#[derive(Debug, Clone, Copy, Default)]
pub struct Parallel;

impl Join for Parallel {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        parallel::join(a, b)
    }
}
