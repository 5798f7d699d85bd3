//! Which backend renders, chosen when the program runs.
//!
//! ```
//! use rtrt::choose::{Choice, Options, choose};
//!
//! let chosen = choose(&Options { choice: Choice::Cpu, ..Options::default() })?;
//! assert_eq!(chosen.backend.describe().kind, "cpu");
//! # Ok::<(), rtrt::choose::ChooseError>(())
//! ```

use rtrt_core::backend::Backend;
use rtrt_cpu::Cpu;
use rtrt_gpu::{AdapterReport, Gpu, Kind, Route};

/// Which kind of backend is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// The first that works of: discrete, integrated, virtual GPU, CPU, software Vulkan.
    #[default]
    Auto,
    /// The CPU backend.
    Cpu,
    /// A GPU, a software one if there is no other.
    Gpu,
}

/// What to choose from.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Which kind.
    pub choice: Choice,
    /// Part of the GPU adapter's name, whatever its case, or its number among
    /// [`rtrt_gpu::adapters`]. [`Choice::Auto`] then takes no other.
    pub adapter: Option<String>,
    /// Lanes of the CPU backend; see [`rtrt_cpu::Options`].
    pub lanes: Option<u32>,
    /// Threads of the CPU backend; see [`rtrt_cpu::Options`].
    pub threads: Option<usize>,
}

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
    /// The GPU cannot.
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

/// Chooses a backend, and opens it.
///
/// # Errors
/// None is available; the error says what was tried.
pub fn choose(options: &Options) -> Result<Chosen, ChooseError> {
    match options.choice {
        Choice::Auto => auto(options),
        Choice::Cpu => cpu(options, "asked for".into()),
        Choice::Gpu => {
            let gpu = rtrt_gpu::Options { adapter: options.adapter.clone(), ..Default::default() };
            Ok(opened(Gpu::new(gpu)?, "asked for"))
        }
    }
}

/// The first that works. A software adapter is never better than the CPU, which is always
/// there, so it is taken only where it is asked for by name.
fn auto(options: &Options) -> Result<Chosen, ChooseError> {
    let mut passed_over = Vec::new();
    for (number, report) in rtrt_gpu::adapters().into_iter().enumerate() {
        let name = &report.name;
        let wanted = options.adapter.as_ref();
        let is_wanted = wanted.is_some_and(|wanted| is_called(&report, number, wanted));
        if wanted.is_some() && !is_wanted {
            passed_over.push(format!("{name} has another name"));
            continue;
        }
        if !is_wanted && report.kind > Kind::Virtual {
            passed_over.push(format!("{name} is {}", report.kind));
            continue;
        }
        let adapter = Some(number.to_string());
        let gpu = report.canary.and_then(|()| Gpu::new(rtrt_gpu::Options { adapter, ..Default::default() }));
        match gpu {
            Ok(gpu) if is_wanted => return Ok(opened(gpu, "its adapter was asked for")),
            Ok(gpu) => return Ok(opened(gpu, &and("the first GPU that works", &passed_over))),
            Err(error) => passed_over.push(error.to_string()),
        }
    }
    if passed_over.is_empty() {
        passed_over.push("there is no adapter".into());
    }
    match &options.adapter {
        Some(wanted) => Err(ChooseError::Adapter { wanted: wanted.clone(), tried: passed_over }),
        None => cpu(options, and("no GPU is better", &passed_over)),
    }
}

/// Whether an adapter is the one that [`rtrt_gpu::Options::adapter`] would name.
pub fn is_called(report: &AdapterReport, number: usize, wanted: &str) -> bool {
    let label = format!("{} ({})", report.name, report.api).to_lowercase();
    label.contains(&wanted.to_lowercase()) || wanted.parse() == Ok(number)
}

fn cpu(options: &Options, why: String) -> Result<Chosen, ChooseError> {
    let cpu = Cpu::new(rtrt_cpu::Options { lanes: options.lanes, threads: options.threads })?;
    Ok(Chosen { backend: Box::new(cpu), why, is_software: false })
}

fn opened(gpu: Gpu, why: &str) -> Chosen {
    let route = match gpu.route() {
        Route::Naga => "naga",
        Route::Auto | Route::Passthrough => "SPIR-V passthrough",
    };
    let why = format!("{why} ({} adapter, {route}, canary equal)", gpu.kind());
    Chosen { is_software: gpu.kind() == Kind::Software, backend: Box::new(gpu), why }
}

/// The reason, then what was passed over.
fn and(why: &str, passed_over: &[String]) -> String {
    if passed_over.is_empty() { why.into() } else { format!("{why} ({})", passed_over.join("; ")) }
}
