//! The backends of this workspace, in every way that they run.

#[cfg(feature = "gpu")]
mod gpu;
#[cfg(not(feature = "gpu"))]
#[path = "variants/no_gpu.rs"]
mod gpu;

pub use gpu::gpu;
pub(crate) use gpu::{driver, shaders};
use rtrt_core::backend::Backend;
use rtrt_cpu::Cpu;

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
/// where the processor has AVX-512. Threads and eight lanes are missing where they are not compiled in.
///
/// # Panics
/// One of the others is missing.
pub fn cpu() -> Vec<Variant> {
    let variant = |name, lanes, threads| {
        let backend = match Cpu::new(rtrt_cpu::Options { lanes: Some(lanes), threads: Some(threads) }) {
            Ok(cpu) => Ok(Box::new(cpu) as Box<dyn Backend>),
            Err(error @ (rtrt_cpu::Error::NoThreads { .. } | rtrt_cpu::Error::NoSimd { .. })) => {
                Err(Missing { reason: error.to_string(), is_required: false })
            }
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

/// All variants but the reference.
pub fn all() -> Vec<Variant> {
    cpu().into_iter().chain(gpu()).collect()
}
