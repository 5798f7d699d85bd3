//! The choice among GPUs.

use super::chosen::{ChooseError, Chosen, cpu};
use super::fallback::Fallback;
use super::options::Options;
use rtrt_gpu::{Adapter, Gpu, Kind, Route};

/// The wanted GPU.
pub(super) fn gpu(options: &Options) -> Result<Chosen, ChooseError> {
    let gpu = rtrt_gpu::Options { adapter: options.adapter.clone(), ..Default::default() };
    opened(Gpu::new(gpu)?, options, "asked for")
}

/// The first usable GPU, else the CPU. A software adapter is never better than the CPU, so only its name
/// chooses it.
pub(super) fn auto(options: &Options) -> Result<Chosen, ChooseError> {
    let mut passed_over = Vec::new();
    for (number, adapter) in rtrt_gpu::adapters().iter().enumerate() {
        let name = &adapter.name;
        let wanted = options.adapter.as_ref();
        let is_wanted = wanted.is_some_and(|wanted| is_called(adapter, number, wanted));
        if wanted.is_some() && !is_wanted {
            passed_over.push(format!("{name} has another name"));
            continue;
        }
        if !is_wanted && adapter.kind > Kind::Virtual {
            passed_over.push(format!("{name} is {}", adapter.kind));
            continue;
        }
        match adapter.open() {
            Ok(gpu) if is_wanted => return opened(gpu, options, "its adapter was asked for"),
            Ok(gpu) => {
                let mut chosen = opened(gpu, options, &and("the first GPU that works", &passed_over))?;
                if !options.hybrid {
                    chosen.backend = Box::new(Fallback::new(chosen.backend, options.cpu(), options.tell));
                }
                return Ok(chosen);
            }
            Err(error) => passed_over.push(error.to_string()),
        }
    }
    passed_over.extend(rtrt_gpu::left_out());
    if passed_over.is_empty() {
        passed_over.push("there is no adapter".into());
    }
    match &options.adapter {
        Some(wanted) => Err(ChooseError::Adapter { wanted: wanted.clone(), tried: passed_over }),
        None => cpu(options, and("no GPU is better", &passed_over)),
    }
}

/// Whether [`rtrt_gpu::Options::adapter`] `wanted` means this adapter.
pub fn is_called(adapter: &Adapter, number: usize, wanted: &str) -> bool {
    let label = format!("{} ({})", adapter.name, adapter.api).to_lowercase();
    label.contains(&wanted.to_lowercase()) || wanted.parse() == Ok(number)
}

fn opened(mut gpu: Gpu, options: &Options, why: &str) -> Result<Chosen, ChooseError> {
    gpu.set_hybrid(options.hybrid)?;
    let route = match gpu.route() {
        Route::Naga => "naga",
        Route::Auto | Route::Passthrough => "SPIR-V passthrough",
    };
    let hybrid = if options.hybrid { ", surfaces drawn" } else { "" };
    let why = format!("{why} ({} adapter, {route}, canary equal{hybrid})", gpu.kind());
    Ok(Chosen { is_software: gpu.kind() == Kind::Software, backend: Box::new(gpu), why })
}

/// The reason, then the skipped adapters.
fn and(why: &str, passed_over: &[String]) -> String {
    if passed_over.is_empty() { why.into() } else { format!("{why} ({})", passed_over.join("; ")) }
}
