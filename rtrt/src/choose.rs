//! Which backend renders, chosen when the program runs.
//!
//! ```
//! use rtrt::choose::{Choice, Options, choose};
//!
//! let chosen = choose(&Options { choice: Choice::Cpu, ..Options::default() })?;
//! assert_eq!(chosen.backend.describe().kind, "cpu");
//! # Ok::<(), rtrt::choose::ChooseError>(())
//! ```

#[cfg(feature = "gpu")]
mod fallback;
#[cfg(feature = "gpu")]
mod gpu;

#[cfg(feature = "gpu")]
pub use gpu::is_called;

use rtrt_core::backend::{Backend, RenderError};
use rtrt_cpu::Cpu;

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
    fn cpu(&self) -> rtrt_cpu::Options {
        rtrt_cpu::Options { lanes: self.lanes, threads: self.threads }
    }
}

/// A backend, ready to render.
pub struct Chosen {
    /// The backend.
    pub backend: Box<dyn Backend>,
    /// Why it is this one, in a line.
    pub why: String,
    /// Whether it is a GPU in name only: a driver that computes on the processor.
    pub is_software: bool,
}

/// Why no backend could be chosen.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChooseError {
    /// The CPU cannot render as asked.
    #[error(transparent)]
    Cpu(#[from] rtrt_cpu::Error),
    /// The program was built without the feature `gpu`.
    #[cfg(not(feature = "gpu"))]
    #[error("this program was built without GPU support")]
    NoGpu,
    /// Surfaces were to be drawn, and no GPU was chosen.
    #[error("hybrid frames are drawn by a GPU, and the CPU was chosen: {why}")]
    Hybrid {
        /// Why it was.
        why: String,
    },
    /// The GPU cannot.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] rtrt_gpu::Error),
    /// No adapter that has the name can be used.
    #[error("no GPU adapter called {wanted:?} can be used: {}", tried.join("; "))]
    Adapter {
        /// The part of a name that was asked for.
        wanted: String,
        /// What there is, and why it was not taken.
        tried: Vec<String>,
    },
}

/// Chooses a backend, and opens it.
///
/// # Errors
/// None is available; the error says what was tried.
pub fn choose(options: &Options) -> Result<Chosen, ChooseError> {
    match options.choice {
        Choice::Cpu => cpu(options, "asked for".into()),
        #[cfg(feature = "gpu")]
        Choice::Auto => gpu::auto(options),
        #[cfg(feature = "gpu")]
        Choice::Gpu => gpu::gpu(options),
        #[cfg(not(feature = "gpu"))]
        Choice::Auto if options.adapter.is_none() => cpu(options, "this program knows no GPU".into()),
        #[cfg(not(feature = "gpu"))]
        Choice::Auto | Choice::Gpu => Err(ChooseError::NoGpu),
    }
}

fn cpu(options: &Options, why: String) -> Result<Chosen, ChooseError> {
    if options.hybrid {
        return Err(ChooseError::Hybrid { why });
    }
    let cpu = Cpu::new(options.cpu())?;
    Ok(Chosen { backend: Box::new(cpu), why, is_software: false })
}
