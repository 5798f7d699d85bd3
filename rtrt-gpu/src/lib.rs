//! Renders on a GPU what [`rtrt_core`] describes, with the same bits as a CPU.
//!
//! ```no_run
//! use rtrt_core::backend::Backend;
//! # fn main() -> Result<(), rtrt_gpu::Error> {
//! let gpu = rtrt_gpu::Gpu::new(rtrt_gpu::Options::default())?;
//! println!("{}", gpu.describe().adapter);
//! # Ok(())
//! # }
//! ```
//!
//! The device runs the stages of [`rtrt_core::stage`], compiled to SPIR-V by `rtrt-shaders`. Before it is
//! trusted, it is asked what the kernels make of some thousand numbers; a device that answers otherwise than the
//! CPU is refused ([`Error::Canary`]). Scenes stay on the device, and only what changed is uploaded. A frame
//! whose buffers would be too large for the device is rendered in bands, which no pixel depends on.

mod adapter;
mod barriers;
mod buffers;
mod canary;
mod device;
mod error;
mod frame;
mod pipeline;
mod timer;

pub use adapter::{AdapterReport, Kind, adapters};
pub use error::Error;

use frame::Renderer;
use rtrt_core::backend::{Backend, Description, Picture, RenderError, Request};
use rtrt_core::kernel::canary::OUTPUTS;
use rtrt_core::layout::PROBES;
use rtrt_core::scene::{Scene, Setup};

/// How the compiled module gets to the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Route {
    /// [`Route::Passthrough`] where the adapter has it, else [`Route::Naga`].
    #[default]
    Auto,
    /// As it is, by Vulkan: no compiler but the driver's touches it.
    Passthrough,
    /// Translated by naga, to whatever the adapter takes. naga drops what forbids the driver to reorder sums, so
    /// every float operation gets a barrier first; the device takes longer.
    Naga,
}

/// Which adapter to open, and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// A part of the adapter's name, in any case, or its number among [`adapters`]; `None` for the first that
    /// can be used.
    pub adapter: Option<String>,
    /// How the module gets to it.
    pub route: Route,
    /// The most bytes that a buffer of per-ray results may have, if that is to be less than what the device
    /// allows.
    pub band_bytes: Option<u64>,
}

/// An opened GPU.
pub struct Gpu {
    renderer: Renderer,
    setup: Setup,
}

impl Gpu {
    /// Opens an adapter, asks it the canary, and compiles the stages.
    ///
    /// # Errors
    /// No adapter is there or can be used, or the one that was asked for cannot; see [`Error`].
    pub fn new(options: Options) -> Result<Self, Error> {
        let device = adapter::choose(&options)?;
        Ok(Self { renderer: Renderer::new(device, options.band_bytes)?, setup: Setup::default() })
    }

    /// What the adapter is.
    pub fn kind(&self) -> Kind {
        self.renderer.device.kind
    }

    /// The route that was taken.
    pub fn route(&self) -> Route {
        self.renderer.device.route
    }

    /// The device's answers to [`rtrt_core::kernel::canary::canary`] for every index of `words`.
    ///
    /// # Errors
    /// The device failed.
    pub fn kernels(&self, words: &[u32]) -> Result<Vec<[u32; OUTPUTS]>, Error> {
        canary::kernels(&self.renderer.device, words)
    }

    /// The device's answer to [`rtrt_core::layout::probe`], where every word of every value tells its place:
    /// [`Gpu::expected_layout`], if the device looks where the compiler puts things.
    ///
    /// # Errors
    /// The device failed.
    pub fn layout(&self) -> Result<[u32; PROBES], Error> {
        canary::layout(&self.renderer.device)
    }

    /// The CPU's answer to the same.
    pub fn expected_layout() -> [u32; PROBES] {
        canary::expected_layout()
    }
}

impl Backend for Gpu {
    fn describe(&self) -> Description {
        let adapter = self.renderer.device.name.clone();
        Description { kind: "gpu".into(), adapter, lanes: 1, threads: 0 }
    }

    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        self.setup.prepare(
            scene,
            request.camera,
            request.size,
            request.samples,
            request.shadows,
            request.layers,
        )?;
        self.renderer
            .render(scene, &self.setup, request.deferred, picture)
            .map_err(|source| RenderError::Backend { backend: "gpu", source: Box::new(source) })
    }
}
