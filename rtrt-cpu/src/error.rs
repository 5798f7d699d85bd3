//! Why the backend cannot run.

/// Why the backend cannot run as asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Not a number of lanes that exists.
    #[error("{lanes} lanes; only 1, 8 and 16 are possible")]
    Lanes {
        /// What was asked for.
        lanes: u32,
    },
    /// The processor lacks the instructions.
    #[error("this processor has no {needed}, which {lanes} lanes need")]
    Unsupported {
        /// What was asked for.
        lanes: u32,
        /// The instruction set.
        needed: &'static str,
    },
    /// Threads could not be started.
    #[error("{threads} threads could not be started")]
    Threads {
        /// What was asked for.
        threads: usize,
        /// Why.
        source: rayon::ThreadPoolBuildError,
    },
}
