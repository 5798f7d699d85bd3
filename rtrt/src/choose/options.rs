//! The options of the choice.

use rtrt_core::backend::RenderError;

/// The kind of backend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// The first usable one of: discrete, integrated, virtual GPU, CPU, software Vulkan.
    #[default]
    Auto,
    /// The CPU backend.
    Cpu,
    /// A GPU; a software adapter if there is no other.
    Gpu,
}

/// The options of [`choose`](super::choose()).
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The kind of backend.
    pub choice: Choice,
    /// Part of the GPU adapter's name, whatever its case, or its number among
    /// [`rtrt_gpu::adapters`]. [`Choice::Auto`] then takes no other.
    pub adapter: Option<String>,
    /// Lanes of the CPU backend; see [`rtrt_cpu::Options`].
    pub lanes: Option<u32>,
    /// Threads of the CPU backend; see [`rtrt_cpu::Options`].
    pub threads: Option<usize>,
    /// Whether the first surfaces are rasterized; see [`rtrt_gpu::Gpu::set_hybrid`]. Only a GPU does that, so the
    /// CPU does not replace one that fails.
    pub hybrid: bool,
    /// Called when a GPU of [`Choice::Auto`] fails at a frame. The CPU renders this frame and the following
    /// ones, unless the callback refuses. Nothing replaces a GPU that was chosen by kind or name.
    pub tell: Option<Tell>,
}

/// A callback with the error of a GPU. It returns whether the CPU may replace the GPU.
pub type Tell = fn(&RenderError) -> bool;

impl Options {
    pub(super) fn cpu(&self) -> rtrt_cpu::Options {
        rtrt_cpu::Options { lanes: self.lanes, threads: self.threads }
    }
}
