//! `rtrt doctor`: the backends of this machine.

use super::options::DoctorOptions;
use super::report::Machine;
use super::{Error, defaults, gpus, output};
use rtrt::choose::{Options, choose};
use rtrt_core::backend::Backend;
use rtrt_cpu::Cpu;
use std::fmt;
use std::path::PathBuf;

/// The output of `--json`.
#[derive(serde::Serialize)]
struct DoctorReport {
    version: &'static str,
    /// SHA-256 of the shaders; null without the feature `gpu`.
    shaders: Option<String>,
    /// The file with defaults, if there is one.
    defaults: Option<PathBuf>,
    cpu: Vec<Offer>,
    adapters: Vec<AdapterReport>,
    /// Adapters that are left out, each with why.
    left_out: Vec<String>,
    /// The choice of `--backend auto`.
    auto: Choice,
}

/// An instruction set, or why it is not available.
#[derive(serde::Serialize)]
#[serde(untagged)]
enum Offer {
    Available(Machine),
    Missing { lanes: u32, error: String },
}

/// A GPU.
#[derive(serde::Serialize)]
pub struct AdapterReport {
    pub number: usize,
    pub name: String,
    pub kind: String,
    pub api: String,
    pub driver: String,
    /// Whether it takes unchanged SPIR-V.
    pub passthrough: bool,
    /// Why it is refused; null if it computes what the CPU does.
    pub refused: Option<String>,
}

/// A backend, and the reason for it.
#[derive(serde::Serialize)]
struct Choice {
    #[serde(flatten)]
    machine: Machine,
    why: String,
}

/// Lists the backends, and the choice of `auto`.
pub fn run(options: &DoctorOptions) -> Result<(), Error> {
    let report = report()?;
    if options.json { output::print_json(&report) } else { output::print(report) }
}

fn report() -> Result<DoctorReport, Error> {
    let cpu =
        [1, 8, 16].map(|lanes| match Cpu::new(rtrt_cpu::Options { lanes: Some(lanes), threads: None }) {
            Ok(cpu) => Offer::Available(Machine::from(cpu.describe())),
            Err(error) => Offer::Missing { lanes, error: error.to_string() },
        });
    let chosen = choose(&Options::default())?;
    Ok(DoctorReport {
        version: env!("CARGO_PKG_VERSION"),
        shaders: gpus::shaders(),
        defaults: defaults::path(),
        cpu: cpu.into(),
        adapters: gpus::adapters(),
        left_out: gpus::left_out(),
        auto: Choice { machine: Machine::from(chosen.backend.describe()), why: chosen.why },
    })
}

impl fmt::Display for DoctorReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for offer in &self.cpu {
            match offer {
                Offer::Available(machine) => writeln!(f, "{machine}")?,
                Offer::Missing { error, .. } => writeln!(f, "cpu, not available: {error}")?,
            }
        }
        if self.adapters.is_empty() && self.left_out.is_empty() {
            writeln!(f, "gpu, not available: there is no adapter")?;
        }
        self.left_out.iter().try_for_each(|why| writeln!(f, "gpu, not available: {why}"))?;
        for AdapterReport { number, name, kind, api, driver, passthrough, refused } in &self.adapters {
            writeln!(f, "gpu, adapter {number}, {name}: {kind}, {api}, {driver}")?;
            let route = if *passthrough { "available" } else { "not available, naga translates" };
            writeln!(f, "    SPIR-V passthrough: {route}")?;
            match refused {
                None => writeln!(f, "    canary: equal to the CPU")?,
                Some(error) => writeln!(f, "    canary: refused: {error}")?,
            }
        }
        if let Some(path) = &self.defaults {
            writeln!(f, "defaults of options: {}", path.display())?;
        }
        write!(f, "auto chooses {}: {}", self.auto.machine, self.auto.why)
    }
}
