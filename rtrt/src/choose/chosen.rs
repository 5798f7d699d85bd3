//! The result of the choice.

use super::options::Options;
use rtrt_core::backend::Backend;
use rtrt_cpu::Cpu;

/// A backend, ready to render.
pub struct Chosen {
    /// The backend.
    pub backend: Box<dyn Backend>,
    /// The reason for the choice, in a line.
    pub why: String,
    /// Whether it is a software adapter: a driver that computes on the processor.
    pub is_software: bool,
}

/// Why no backend could be chosen.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChooseError {
    /// The CPU cannot render with these options.
    #[error(transparent)]
    Cpu(#[from] rtrt_cpu::Error),
    /// The program was built without the feature `gpu`.
    #[cfg(not(feature = "gpu"))]
    #[error("this program was built without the feature `gpu`")]
    NoGpu,
    /// Hybrid frames need a GPU, but the CPU was chosen.
    #[error("hybrid frames are drawn by a GPU, but the CPU was chosen: {why}")]
    Hybrid {
        /// The reason for the choice.
        why: String,
    },
    /// The GPU cannot render with these options.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] rtrt_gpu::Error),
    /// No adapter with this name is usable.
    #[error("no GPU adapter called {wanted:?} can be used: {}", tried.join("; "))]
    Adapter {
        /// The wanted part of a name.
        wanted: String,
        /// The existing adapters, and the reasons against them.
        tried: Vec<String>,
    },
}

/// The CPU backend, with the reason for the choice.
pub(super) fn cpu(options: &Options, why: String) -> Result<Chosen, ChooseError> {
    if options.hybrid {
        return Err(ChooseError::Hybrid { why });
    }
    let cpu = Cpu::new(options.cpu())?;
    Ok(Chosen { backend: Box::new(cpu), why, is_software: false })
}
