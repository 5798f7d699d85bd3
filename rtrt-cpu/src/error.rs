//! Why the backend cannot run.

/// Why the backend cannot run with the given options.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Not a number of lanes that exists.
    #[error("{lanes} lanes; only 1, 8 and 16 are possible")]
    Lanes {
        /// The requested value.
        lanes: u32,
    },
    /// The processor lacks the instructions.
    #[error("this processor has no {needed}, which {lanes} lanes need")]
    Unsupported {
        /// The requested value.
        lanes: u32,
        /// The instruction set.
        needed: &'static str,
    },
    /// Lanes side by side are not compiled in.
    #[error("{lanes} lanes need the feature `simd`, which is not compiled in")]
    NoSimd {
        /// The requested value.
        lanes: u32,
    },
    /// Threads are not compiled in.
    #[error("{threads} threads need the feature `threads`, which is not compiled in")]
    NoThreads {
        /// The requested value.
        threads: usize,
    },
    /// Threads could not be started.
    #[cfg(feature = "threads")]
    #[error("{threads} threads could not be started")]
    Threads {
        /// The requested value.
        threads: usize,
        /// Why.
        source: rayon::ThreadPoolBuildError,
    },
}
