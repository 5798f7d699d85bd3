//! The GPU's variants.

use super::{Missing, Variant};
use rtrt_core::backend::Backend;
use rtrt_gpu::{Error, Gpu, Route};

/// The GPU's variants: SPIR-V as it is, the same in bands of a few blocks, and through naga.
///
/// All of them are required where a GPU is, with one exception. naga drops what forbids a
/// driver to reorder sums, so that route promises the same bits only where its canary shows
/// them: refusing the device keeps the promise. Where the other route is missing too
/// no variant ran, which is a failure.
pub fn gpu() -> Vec<Variant> {
    let direct = open(None, Route::Passthrough, None);
    // The same adapter by another route.
    let adapter = direct.as_ref().ok().map(|gpu| gpu.describe().adapter);
    let bands = open(adapter.clone(), Route::Passthrough, Some(BAND_BYTES));
    let naga = open(adapter, Route::Naga, None);
    let may_refuse = direct.is_ok();
    let variant = |name, gpu: Result<Gpu, Error>| Variant {
        name,
        backend: gpu.map(|gpu| Box::new(gpu) as Box<dyn Backend>).map_err(|error| Missing {
            is_required: !(may_refuse && matches!(error, Error::Canary { .. })),
            reason: error.to_string(),
        }),
    };
    vec![
        variant("gpu, passthrough", direct),
        variant("gpu, passthrough in bands", bands),
        variant("gpu, naga", naga),
    ]
}

fn open(adapter: Option<String>, route: Route, band_bytes: Option<u64>) -> Result<Gpu, Error> {
    Gpu::new(rtrt_gpu::Options { adapter, route, band_bytes })
}

/// A row of blocks of most cases takes more.
const BAND_BYTES: u64 = 64 * 1024;

/// The driver of the adapter that a backend describes by this text; empty if there is none.
pub(crate) fn driver(adapter: &str) -> String {
    let is_named = |found: &rtrt_gpu::Adapter| adapter == format!("{} ({})", found.name, found.api);
    rtrt_gpu::adapters().into_iter().find(is_named).map(|found| found.driver).unwrap_or_default()
}

/// SHA-256 of the shaders.
pub(crate) fn shaders() -> String {
    rtrt::hash::of(rtrt_gpu::SHADERS)
}
