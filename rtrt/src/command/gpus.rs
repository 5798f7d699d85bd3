//! The GPUs of this machine, as `doctor` and `verify` ask them.

use super::doctor::AdapterReport;
use super::options::BackendOptions;
use rtrt::choose::{ChooseError, is_called};
use rtrt::hash;
use rtrt_core::backend::Backend;
use rtrt_gpu::{Gpu, Route};
use std::fmt;

/// The name of the feature, in `--version`.
pub const FEATURE: &str = "gpu, ";

/// SHA-256 of the shaders.
pub fn shaders() -> Option<String> {
    Some(hash::of(rtrt_gpu::SHADERS))
}

/// The adapters, each with its verdict.
pub fn adapters() -> Vec<AdapterReport> {
    let adapters = rtrt_gpu::adapters().into_iter().enumerate().map(|(number, adapter)| AdapterReport {
        number,
        kind: adapter.kind.to_string(),
        passthrough: adapter.passthrough,
        refused: adapter.open().err().map(|error| error.to_string()),
        name: adapter.name,
        api: adapter.api,
        driver: adapter.driver,
    });
    adapters.collect()
}

/// Adapters that are left out, each with why.
pub fn left_out() -> Vec<String> {
    rtrt_gpu::left_out()
}

/// An adapter, by one of the routes of its shaders.
#[derive(PartialEq)]
pub struct GpuVariant {
    /// Its number; none for the first usable one.
    adapter: Option<usize>,
    name: String,
    route: Route,
}

impl GpuVariant {
    /// Those that match the options: both routes of each adapter.
    pub fn all(options: &BackendOptions) -> Result<Vec<Self>, ChooseError> {
        let adapters = rtrt_gpu::adapters().into_iter().enumerate();
        let (wanted, other): (Vec<_>, Vec<_>) = adapters.partition(|(number, report)| {
            options.adapter.as_ref().is_none_or(|name| is_called(report, *number, name))
        });
        if let Some(wanted) = options.adapter.clone().filter(|_| wanted.is_empty()) {
            let tried = other.into_iter().map(|(_, report)| report.name).collect();
            return Err(ChooseError::Adapter { wanted, tried });
        }
        let mut names: Vec<_> = wanted
            .into_iter()
            .map(|(number, report)| (Some(number), format!("adapter {number}, {}", report.name)))
            .collect();
        if names.is_empty() {
            // Opening it gives the reason for the absence.
            names.push((None, "any adapter".into()));
        }
        let both = |(adapter, name): (Option<usize>, String)| {
            [Route::Passthrough, Route::Naga].map(|route| Self { adapter, name: name.clone(), route })
        };
        Ok(names.into_iter().flat_map(both).collect())
    }

    /// The name of the adapter.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Opens it.
    pub fn open(&self) -> Result<Box<dyn Backend>, ChooseError> {
        let adapter = self.adapter.map(|number| number.to_string());
        Ok(Box::new(Gpu::new(rtrt_gpu::Options { adapter, route: self.route, ..Default::default() })?))
    }
}

impl fmt::Display for GpuVariant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let route = if self.route == Route::Naga { "naga" } else { "passthrough" };
        write!(f, "gpu, {}, {route}", self.name)
    }
}
