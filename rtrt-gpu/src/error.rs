//! What can go wrong on a GPU.

use rtrt_core::backend::RenderError;

/// Why a GPU could not be opened, or a frame not be rendered on it.
///
/// The CPU is never substituted here; that choice is the caller's.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No adapter could be opened.
    #[error("no GPU adapter can be used ({})", none_if_empty(tried))]
    NoAdapter {
        /// Each adapter that was tried, and why it was not taken.
        tried: Vec<String>,
    },
    /// No adapter has the requested name or number.
    #[error("no GPU adapter is called {wanted:?}; there is: {}", none_if_empty(names))]
    AdapterNotFound {
        /// The requested name or number.
        wanted: String,
        /// What there is.
        names: Vec<String>,
    },
    /// The adapter does not take SPIR-V as it is.
    #[error("{adapter} has no shader passthrough")]
    NoPassthrough {
        /// The adapter.
        adapter: String,
    },
    /// The adapter has too few storage buffers a stage.
    #[error("{adapter} binds {limit} storage buffers a stage, {needed} are needed")]
    TooFewBindings {
        /// The adapter.
        adapter: String,
        /// What it allows.
        limit: u32,
        /// What the stages need.
        needed: u32,
    },
    /// The driver refused to open the adapter.
    #[error("{adapter} cannot be opened: {source}")]
    Open {
        /// The adapter.
        adapter: String,
        /// Why.
        source: wgpu::RequestDeviceError,
    },
    /// A buffer of the caller's is too short.
    #[error("a buffer has {bytes} bytes, {needed} are needed")]
    BufferTooShort {
        /// What is needed.
        needed: u64,
        /// What it has.
        bytes: u64,
    },
    /// The device computes other numbers than the CPU, so its frames would differ.
    #[error("{adapter} computes {what} of case {case} as {gpu:#010x}, the CPU as {cpu:#010x}")]
    Canary {
        /// The adapter.
        adapter: String,
        /// Which of [`rtrt_core::kernel::canary::NAMES`].
        what: &'static str,
        /// Which case of the start-up canary.
        case: usize,
        /// The CPU's word.
        cpu: u32,
        /// The device's word.
        gpu: u32,
    },
    /// A buffer would be larger than the device allows.
    #[error("the buffer of {buffer} needs {needed} bytes, the device allows {limit}")]
    BufferTooLarge {
        /// What the buffer holds.
        buffer: &'static str,
        /// How many bytes it needs.
        needed: u64,
        /// How many it may have.
        limit: u64,
    },
    /// A texture is not one that a frame can be rendered into.
    #[error("the texture has {is}, the frame needs {needed}")]
    Texture {
        /// What it has.
        is: String,
        /// What it should have.
        needed: String,
    },
    /// The device refused a command, or is out of memory.
    #[error(transparent)]
    Device(#[from] wgpu::Error),
    /// The device is gone.
    #[error("the device was lost: {reason}")]
    Lost {
        /// What the driver says.
        reason: String,
    },
    /// The flag of [`Request::until`](rtrt_core::backend::Request::until) was set.
    #[error("the frame was stopped")]
    Stopped,
    /// Results could not be read back.
    #[error("results cannot be read back: {source}")]
    ReadBack {
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl Error {
    /// [`Error::ReadBack`] because of `source`.
    pub(crate) fn read_back(source: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::ReadBack { source: Box::new(source) }
    }
}

impl From<Error> for RenderError {
    fn from(source: Error) -> Self {
        match source {
            Error::Stopped => Self::Stopped,
            source => Self::Backend { backend: "gpu", source: Box::new(source) },
        }
    }
}

fn none_if_empty(list: &[String]) -> String {
    if list.is_empty() { "none is there".into() } else { list.join("; ") }
}
