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
#![forbid(unsafe_code)]

mod bin;
mod block;
mod canary;
mod clock;
mod context;
mod error;
mod instruction_set;
mod planes;
mod prepare;
mod records;
mod shadows;
mod soft;
mod wide;

pub use canary::kernels;
pub use error::Error;

use crate::bin::Binning;
use crate::block::Block;
use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instruction_set::InstructionSet;
use crate::records::{block_records, deferred_room};
use rayon::prelude::*;
use rtrt_core::backend::{Backend, Deferred, Description, Picture, RenderError, Request, STAGES};
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::scene::{Join, Scene, Setup};
use rtrt_core::stage::context::Context;
use std::time::Instant;

/// How the backend runs. The picture does not depend on it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// Numbers side by side: 1, 8 or 16; `None` for the widest that is fast here.
    pub lanes: Option<u32>,
    /// Threads; `None` for as many as the machine runs at once.
    pub threads: Option<usize>,
}

/// The CPU backend. Keeps its memory from frame to frame.
#[derive(Debug)]
pub struct Cpu {
    pool: rayon::ThreadPool,
    level: InstructionSet,
    memory: Memory,
}

/// What a frame is built in.
#[derive(Debug, Default)]
struct Memory {
    setup: Setup,
    screen_bounds: Vec<ScreenBounds>,
    bins: bin::Bins,
    /// Pixels, block after block.
    tiles: Vec<u32>,
    /// What is left of lights, block after block, where hard shadows are not bits.
    transmittance: Vec<u32>,
    soft: soft::Soft,
}

impl Cpu {
    /// A backend that runs as asked.
    ///
    /// # Errors
    /// The processor or the system cannot; see [`Error`].
    pub fn new(options: Options) -> Result<Self, Error> {
        let level = InstructionSet::new(options.lanes)?;
        let threads = options.threads.unwrap_or(0);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|source| Error::Threads { threads, source })?;
        Ok(Self { pool, level, memory: Memory::default() })
    }

    /// Runs `work` on the backend's threads.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }
}

impl Memory {
    /// Fills the tiles, and the deferred buffers if asked to.
    fn frame(
        &mut self,
        level: InstructionSet,
        scene: &Scene,
        deferred: Option<&mut Deferred>,
        clock: &mut Clock,
    ) {
        let frame = self.setup.frame;
        let views = &self.setup.views[..];
        let start = Instant::now();
        let instances = self.setup.instances(scene);
        let keeps_lights = self.bins.keeps_lights(&self.setup, scene);
        prepare::prepare(&frame, views, instances, &mut self.screen_bounds, keeps_lights);
        clock.add(0, start);
        let start = Instant::now();
        self.bins.fill(
            &Binning { frame: &frame, views, instances, screen_bounds: &self.screen_bounds },
            keeps_lights,
        );
        clock.add(1, start);

        let geometry = Geometry {
            instances,
            nodes: scene.nodes(),
            mesh_data: scene.mesh_data(),
            positions: scene.positions(),
            texels: scene.texels(),
            magnitude: frame.magnitude,
        };
        let lists = BlockLists { data: &self.bins.lists, blocks: frame.blocks };
        let context = FrameContext {
            trace: Context { frame: &frame, views, lists, geometry },
            attributes: scene.attributes(),
            maps: Maps { materials: scene.materials(), texels: scene.texels() },
        };
        let grid = frame.grid();
        let tile = (grid.block_pixels() * grid.block_pixels()) as usize;
        self.tiles.clear();
        self.tiles.resize(grid.blocks() as usize * tile, 0);
        let tint = shadows::transmittance_words(&frame);
        self.transmittance.resize(grid.blocks() as usize * tint, 0);
        let start = Instant::now();
        let tiles = self.tiles.par_chunks_mut(tile);
        let block = |(index, ((tile, transmittance), records)): (usize, ((_, _), _))| {
            level.run(Block { context: &context, index: index as u32, tile, transmittance, records })
        };
        let none = || rayon::iter::repeat_n((), grid.blocks() as usize).map(|()| None);
        let deferred = deferred.map(|deferred| {
            deferred_room(deferred, &frame, &self.bins.lists);
            block_records(deferred, &frame)
        });
        let busy = match (deferred, frame.penumbra_window) {
            (None, 0) => {
                let tiles = tiles.zip(self.transmittance.par_chunks_mut(tint)).zip(none());
                tiles.enumerate().map(block).reduce(Clock::default, Clock::plus)
            }
            (Some((records, _)), 0) => {
                let tiles = tiles.zip(self.transmittance.par_chunks_mut(tint)).zip(records);
                tiles.enumerate().map(block).reduce(Clock::default, Clock::plus)
            }
            (None, _) => self.soft.frame(level, &context, tiles, &mut [], None),
            (Some((mut records, kept)), _) => {
                self.soft.frame(level, &context, tiles, &mut records, Some(kept))
            }
        };
        // The stages of a block follow one another on one thread, so a stage's share of
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
            threads: self.pool.current_num_threads() as u32,
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
        pool.install(|| {
            memory.frame(*level, scene, deferred.as_mut(), &mut clock);
            let start = Instant::now();
            block::untile(memory.setup.frame.grid(), &memory.tiles, &mut picture.pixels);
            clock.add(STAGES.len() - 1, start);
        });
        picture.deferred = deferred;
        [picture.width, picture.height] = request.size;
        picture.stages_ms = clock.milliseconds();
        picture.host_ms = None;
        Ok(())
    }
}

/// Builds both halves at once on the current rayon threads.
#[derive(Debug, Clone, Copy, Default)]
pub struct Parallel;

impl Join for Parallel {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        rayon::join(a, b)
    }
}
