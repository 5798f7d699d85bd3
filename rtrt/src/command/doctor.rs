//! `rtrt doctor`: the backends of this machine.

use super::Error;
use super::output::print;
use super::report::Machine;
use rtrt::choose::{Options, choose};
use rtrt_cpu::Cpu;
use rtrt_gpu::Adapter;

/// Lists the backends, and the choice of `auto`.
pub fn run() -> Result<(), Error> {
    for lanes in [1, 8, 16] {
        match Cpu::new(rtrt_cpu::Options { lanes: Some(lanes), threads: None }) {
            Ok(cpu) => print(Machine::from(rtrt_core::backend::Backend::describe(&cpu)))?,
            Err(error) => print(format_args!("cpu, not available: {error}"))?,
        }
    }
    let (adapters, left_out) = (rtrt_gpu::adapters(), rtrt_gpu::left_out());
    if adapters.is_empty() && left_out.is_empty() {
        print("gpu, not available: there is no adapter")?;
    }
    left_out.iter().try_for_each(|why| print(format_args!("gpu, not available: {why}")))?;
    for (number, adapter) in adapters.iter().enumerate() {
        print_adapter(number, adapter)?;
    }
    let chosen = choose(&Options::default())?;
    print(format_args!("auto chooses {}: {}", Machine::from(chosen.backend.describe()), chosen.why))
}

fn print_adapter(number: usize, adapter: &Adapter) -> Result<(), Error> {
    let Adapter { name, api, kind, driver, passthrough, .. } = adapter;
    print(format_args!("gpu, adapter {number}, {name}: {kind}, {api}, {driver}"))?;
    let route = if *passthrough { "available" } else { "not available, naga translates" };
    print(format_args!("    SPIR-V passthrough: {route}"))?;
    match adapter.open() {
        Ok(_) => print("    canary: equal to the CPU"),
        Err(error) => print(format_args!("    canary: refused: {error}")),
    }
}
