//! The backends of this workspace, in every way that they run.

use rtrt_core::backend::Backend;
use rtrt_cpu::Cpu;
use rtrt_gpu::{Error, Gpu, Route};

/// A way to run, or why this machine does not have it.
pub struct Variant {
    /// What it is.
    pub name: &'static str,
    /// The backend, or why there is none.
    pub backend: Result<Box<dyn Backend>, Missing>,
}

/// Why a variant cannot run here.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// Why.
    pub reason: String,
    /// Whether that is a failure on a machine that must have a GPU.
    pub is_required: bool,
}

/// The variants that can run here.
pub struct Present {
    /// They, by name.
    pub backends: Vec<(&'static str, Box<dyn Backend>)>,
    /// How many are missing.
    pub skipped: usize,
    /// How many of the missing are required.
    pub failed: usize,
}

/// Those of the variants that can run here; prints why the others cannot. `requires_gpu`
/// says that the machine has a GPU.
pub fn present(variants: Vec<Variant>, requires_gpu: bool) -> Present {
    let mut present = Present { backends: Vec::new(), skipped: 0, failed: 0 };
    for Variant { name, backend } in variants {
        match backend {
            Ok(backend) => present.backends.push((name, backend)),
            Err(Missing { reason, is_required }) => {
                let is_failure = is_required && requires_gpu;
                println!("{name}: {}: {reason}", if is_failure { "MISSING" } else { "skipped" });
                present.skipped += 1;
                present.failed += usize::from(is_failure);
            }
        }
    }
    present
}

/// Whether this machine is said to have a GPU: `RTRT_REQUIRE_GPU` is `1`. Its absence is a
/// failure then.
pub fn requires_gpu() -> bool {
    std::env::var_os("RTRT_REQUIRE_GPU").is_some_and(|value| value == "1")
}

/// Threads of the variants that have many: more than there are cores on small machines, and
/// not a number that divides a frame evenly.
const MANY: usize = 5;

/// The CPU's variants. Sixteen lanes may be missing on any machine: they are only promised
/// where the processor has AVX-512.
///
/// # Panics
/// One of the others is missing.
pub fn cpu() -> Vec<Variant> {
    let variant = |name, lanes, threads| {
        let backend = match Cpu::new(rtrt_cpu::Options { lanes: Some(lanes), threads: Some(threads) }) {
            Ok(cpu) => Ok(Box::new(cpu) as Box<dyn Backend>),
            Err(error) if lanes == 16 => Err(Missing { reason: error.to_string(), is_required: false }),
            Err(error) => panic!("{name}: {error}"),
        };
        Variant { name, backend }
    };
    vec![
        variant("cpu, 1 lane, many threads", 1, MANY),
        variant("cpu, 8 lanes, 1 thread", 8, 1),
        variant("cpu, 8 lanes, many threads", 8, MANY),
        variant("cpu, 16 lanes, 1 thread", 16, 1),
        variant("cpu, 16 lanes, many threads", 16, MANY),
    ]
}

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

/// All variants but the reference.
pub fn all() -> Vec<Variant> {
    cpu().into_iter().chain(gpu()).collect()
}
