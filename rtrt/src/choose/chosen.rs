//! A backend that was chosen, or why there is none.

use super::options::Options;
use rtrt_core::backend::Backend;
use rtrt_cpu::Cpu;

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

/// The CPU backend. `why` is why it was chosen.
pub(super) fn cpu(options: &Options, why: String) -> Result<Chosen, ChooseError> {
    if options.hybrid {
        return Err(ChooseError::Hybrid { why });
    }
    let cpu = Cpu::new(options.cpu())?;
    Ok(Chosen { backend: Box::new(cpu), why, is_software: false })
}
