//! `rtrt verify`: every backend, lane width and thread count against one reference.

use super::Error;
use super::console::Console;
use super::gpus::GpuVariant;
use super::job::RenderJob;
use super::options::{BackendOptions, VerifyOptions};
use super::output;
use super::report::{buffer_hashes, counted};
use rtrt::choose::{Choice, ChooseError};
use rtrt::hash;
use rtrt_core::backend::{Backend, Picture};
use rtrt_core::compare::compare;
use rtrt_cpu::Cpu;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;

/// The default of sub-rays per pixel.
const SAMPLES: u32 = 1;

/// The output of `--json`.
#[derive(serde::Serialize)]
struct VerifyReport {
    /// The reference of all comparisons.
    reference: String,
    size: [u32; 2],
    samples: u32,
    /// SHA-256 of the reference's pixels.
    hash: String,
    /// SHA-256 of each of its deferred buffers.
    buffers: Option<BTreeMap<&'static str, String>>,
    /// Whether no variant differs.
    equal: bool,
    variants: Vec<Verdict>,
}

/// The result of a variant.
#[derive(serde::Serialize)]
struct Verdict {
    variant: String,
    result: Outcome,
    /// The first difference, or the reason for skipping it.
    detail: Option<String>,
    /// The GPU adapter.
    #[serde(skip)]
    gpu: Option<String>,
}

#[derive(Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
enum Outcome {
    Equal,
    Differs,
    Skipped,
}

/// A backend with its settings.
#[derive(PartialEq)]
enum Variant {
    Cpu { lanes: u32, threads: usize },
    Gpu(GpuVariant),
}

/// The reference of all comparisons.
const REFERENCE: Variant = Variant::Cpu { lanes: 1, threads: 1 };

/// Compares all variants with the reference.
pub fn run(options: &VerifyOptions) -> Result<(), Error> {
    let common = &options.common;
    let variants = variants(&common.backend)?;
    let console = Console::new(common.talk, variants.len() as u64 + 2);
    let mut job = RenderJob::load(common, SAMPLES, true, common.start(), &console)?;
    console.step(format_args!("rendering the reference: {REFERENCE}"));
    let mut expected = Picture::default();
    let mut reference = REFERENCE.open()?;
    job.expose(&mut *reference, &console)?;
    job.render(&mut *reference, &job.request(true), &mut expected)?;

    let (mut verdicts, mut actual) = (Vec::new(), Picture::default());
    for variant in &variants {
        console.step(format_args!("comparing {variant}"));
        let verdict = verdict(variant, &job, &expected, &mut actual)?;
        if !common.json {
            console.print(&verdict)?;
        }
        verdicts.push(verdict);
    }
    let failure = failure(&verdicts, &common.scene);
    let (hash, buffers) = (hash::pixels(&expected), buffer_hashes(&expected));
    if common.json {
        let equal = verdicts.iter().all(|verdict| verdict.result != Outcome::Differs);
        let (reference, size, samples) = (REFERENCE.to_string(), job.size, job.samples);
        console.print(output::json(&VerifyReport {
            reference,
            size,
            samples,
            hash,
            buffers,
            equal,
            variants: verdicts,
        })?)?;
    } else if options.hash {
        console.print_hashes(&hash, buffers, None)?;
    }
    failure.map_or(Ok(()), Err)
}

/// Renders with a variant, and compares the result with the reference.
fn verdict(
    variant: &Variant,
    job: &RenderJob,
    expected: &Picture,
    actual: &mut Picture,
) -> Result<Verdict, Error> {
    let (result, detail) = match variant.open() {
        Err(error) => (Outcome::Skipped, Some(error.to_string())),
        Ok(mut backend) => {
            job.render(&mut *backend, &job.request(true), actual)?;
            match compare(&job.request(true), expected, actual) {
                Ok(()) => (Outcome::Equal, None),
                Err(difference) => (Outcome::Differs, Some(difference.to_string())),
            }
        }
    };
    let gpu = match variant {
        Variant::Cpu { .. } => None,
        Variant::Gpu(gpu) => Some(gpu.name().into()),
    };
    Ok(Verdict { variant: variant.to_string(), result, detail, gpu })
}

/// The error for these verdicts, if any.
fn failure(verdicts: &[Verdict], scene: &Path) -> Option<Error> {
    let differ = verdicts.iter().filter(|verdict| verdict.result == Outcome::Differs).count();
    if differ > 0 {
        return Some(Error::Disagree { scene: scene.to_owned(), differ, variants: verdicts.len() });
    }
    let is_required = std::env::var_os("RTRT_REQUIRE_GPU").is_some_and(|value| value == "1");
    // One of the two routes of an adapter is enough.
    let is_compared =
        |gpu: &str| verdicts.iter().any(|v| v.gpu.as_deref() == Some(gpu) && v.result == Outcome::Equal);
    let skipped = verdicts.iter().find(|v| v.gpu.as_deref().is_some_and(|gpu| !is_compared(gpu)));
    if let Some(skipped) = skipped.filter(|_| is_required) {
        return Some(Error::GpuRequired { skipped: skipped.to_string() });
    }
    let is_nothing = verdicts.iter().all(|verdict| verdict.result == Outcome::Skipped);
    is_nothing.then_some(Error::NothingCompared)
}

/// The variants that match the options.
fn variants(options: &BackendOptions) -> Result<Vec<Variant>, ChooseError> {
    let cpu = if options.backend == Choice::Gpu { vec![] } else { cpu_variants(options) };
    let gpu = if options.backend == Choice::Cpu {
        vec![]
    } else {
        GpuVariant::all(options)?.into_iter().map(Variant::Gpu).collect()
    };
    Ok(cpu.into_iter().chain(gpu).collect())
}

fn cpu_variants(options: &BackendOptions) -> Vec<Variant> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = options.threads().map_or([1, 2, all].into(), |threads| BTreeSet::from([threads]));
    let lanes = options.lanes.map_or(vec![1, 8, 16], |lanes| vec![lanes]);
    let each = lanes.iter().flat_map(|&lanes| threads.iter().map(move |&threads| (lanes, threads)));
    each.map(|(lanes, threads)| Variant::Cpu { lanes, threads }).filter(|v| *v != REFERENCE).collect()
}

impl Variant {
    fn open(&self) -> Result<Box<dyn Backend>, ChooseError> {
        Ok(match self {
            &Self::Cpu { lanes, threads } => {
                Box::new(Cpu::new(rtrt_cpu::Options { lanes: Some(lanes), threads: Some(threads) })?)
            }
            Self::Gpu(gpu) => gpu.open()?,
        })
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cpu { lanes, threads } => {
                write!(f, "cpu, {}, {}", counted(*lanes, "lane"), counted(*threads as u32, "thread"))
            }
            Self::Gpu(gpu) => gpu.fmt(f),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let result = match self.result {
            Outcome::Equal => "equal",
            Outcome::Differs => "differs",
            Outcome::Skipped => "skipped",
        };
        write!(f, "{}: {result}", self.variant)?;
        self.detail.iter().try_for_each(|detail| write!(f, ": {detail}"))
    }
}
