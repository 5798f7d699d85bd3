//! Which backend is wanted.

use rtrt_core::backend::RenderError;

/// Which kind of backend is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// The first that works of: discrete, integrated, virtual GPU, CPU, software Vulkan.
    #[default]
    Auto,
    /// The CPU backend.
    Cpu,
    /// A GPU, a software one if there is no other.
    Gpu,
}

/// What to choose from.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Which kind.
    pub choice: Choice,
    /// Part of the GPU adapter's name, whatever its case, or its number among
    /// [`rtrt_gpu::adapters`]. [`Choice::Auto`] then takes no other.
    pub adapter: Option<String>,
    /// Lanes of the CPU backend; see [`rtrt_cpu::Options`].
    pub lanes: Option<u32>,
    /// Threads of the CPU backend; see [`rtrt_cpu::Options`].
    pub threads: Option<usize>,
    /// Whether the closest surfaces are to be drawn, not traced; see [`rtrt_gpu::Gpu::set_hybrid`]. Only a
    /// GPU can, and nothing takes its place when it fails.
    pub hybrid: bool,
    /// Is told why, when a GPU that [`Choice::Auto`] took fails at a frame. The CPU renders that frame
    /// and the following ones, unless it refuses. A GPU that was asked for by kind or name has no such
    /// substitute.
    pub tell: Option<Tell>,
}

/// Is told why a GPU failed, and says whether the CPU may take its place.
pub type Tell = fn(&RenderError) -> bool;

impl Options {
    pub(super) fn cpu(&self) -> rtrt_cpu::Options {
        rtrt_cpu::Options { lanes: self.lanes, threads: self.threads }
    }
}
