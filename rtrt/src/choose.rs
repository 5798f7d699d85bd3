//! The choice of a backend at run time.
//!
//! ```
//! use rtrt::choose::{Choice, Options, choose};
//!
//! let chosen = choose(&Options { choice: Choice::Cpu, ..Options::default() })?;
//! assert_eq!(chosen.backend.describe().kind, "cpu");
//! # Ok::<(), rtrt::choose::ChooseError>(())
//! ```

mod chosen;
#[cfg(feature = "gpu")]
mod fallback;
#[cfg(feature = "gpu")]
mod gpu;
mod options;

#[cfg(feature = "gpu")]
pub use gpu::is_called;

pub use chosen::{ChooseError, Chosen};
pub use options::{Choice, Options, Tell};

use chosen::cpu;

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
