//! What `doctor` and `verify` say of GPUs where the command was built without the feature `gpu`.

use super::doctor::AdapterReport;
use super::options::BackendOptions;
use rtrt::choose::{Choice, ChooseError};
use rtrt_core::backend::Backend;
use std::fmt;

/// The name of the feature, in `--version`: it is not there.
pub const FEATURE: &str = "";

/// There are no shaders.
pub fn shaders() -> Option<String> {
    None
}

/// There is no adapter.
pub fn adapters() -> Vec<AdapterReport> {
    vec![]
}

/// Why there is none.
pub fn left_out() -> Vec<String> {
    vec![ChooseError::NoGpu.to_string()]
}

/// There is none.
#[derive(PartialEq)]
pub enum GpuVariant {}

impl GpuVariant {
    /// None; an error if a GPU is asked for.
    pub fn all(options: &BackendOptions) -> Result<Vec<Self>, ChooseError> {
        let is_asked = options.backend == Choice::Gpu || options.adapter.is_some();
        if is_asked { Err(ChooseError::NoGpu) } else { Ok(vec![]) }
    }

    /// The name of the adapter.
    pub fn name(&self) -> &str {
        match *self {}
    }

    /// Opens it.
    pub fn open(&self) -> Result<Box<dyn Backend>, ChooseError> {
        match *self {}
    }
}

impl fmt::Display for GpuVariant {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {}
    }
}
