//! `rtrt render`: a picture of a scene.

use super::Error;
use super::clipped::clipped;
use super::compare::{self, compare};
use super::console::Console;
use super::exr;
use super::job::{RenderJob, open};
use super::memory::peak_rss_bytes;
use super::names::{self, filled, is_numbered};
use super::options::RenderOptions;
use super::output::{self, png};
use super::parse::Background;
use super::parse::{ends_in, is_standard};
use super::report::{Machine, PerStage, buffer_hashes};
use bytemuck::cast_slice;
use image::ExtendedColorType::{Rgba8, Rgba16};
use rtrt::hash;
use rtrt::layers::Layers;
use rtrt_core::backend::{Backend, Picture};
use rtrt_core::layout::Backdrop;
use rtrt_core::schedule::Stage;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The default of sub-rays per pixel.
pub const SAMPLES: u32 = 4;

/// The output of `--json`.
#[derive(serde::Serialize)]
struct RenderReport<'a> {
    #[serde(flatten)]
    machine: Machine,
    size: [u32; 2],
    samples: u32,
    stages_ms: PerStage<f64>,
    /// Wall-clock time of the frame, including the upload of the scene.
    frame_ms: f64,
    bvh_build_ms: f64,
    load_ms: f64,
    /// Wall-clock time since the command began.
    total_ms: f64,
    /// The bytes of the scene.
    scene_bytes: usize,
    /// The peak memory of the process; null on systems without that figure.
    peak_rss_bytes: Option<u64>,
    /// Stops by which light was raised.
    exposure: f32,
    triangles: u64,
    drawn_triangles: u64,
    objects: usize,
    /// SHA-256 of the pixels.
    hash: String,
    /// SHA-256 of each deferred buffer, with `--hash`.
    buffers: Option<BTreeMap<&'static str, String>>,
    output: Option<&'a Path>,
}

/// Renders.
pub fn run(options: &RenderOptions) -> Result<(), Error> {
    let began = Instant::now();
    check(options)?;
    let console = Console::new(options.common.talk, 2 + 3 * u64::from(options.frames));
    let start = options.common.start().or((options.frames > 1).then_some(0.0));
    let mut job = RenderJob::load(&options.common, SAMPLES, keeps_buffers(options), start, &console)?;
    match options.background {
        Some(Background::Color(color)) => {
            (job.scene.background, job.scene.backdrop) = (color.into(), Backdrop::Color);
        }
        Some(Background::Transparent) => job.scene.backdrop = Backdrop::Nothing,
        Some(Background::Environment) if !job.surrounded.has_environment => {
            return Err(Error::Usage("--background env needs an --environment"));
        }
        Some(Background::Environment) | None => {}
    }
    let (mut backend, machine) = open(&options.common.backend, options.hybrid, &console)?;
    job.expose(&mut *backend, &console)?;
    let mut picture = Picture::default();
    for frame in 0..options.frames {
        if let Some(start) = start.filter(|_| frame > 0) {
            job.play(start + f64::from(frame) / options.fps)?;
        }
        console.step(format_args!("rendering frame {frame} on {machine}"));
        render(options, &job, frame, (&mut *backend, &machine), &mut picture, &console, began)?;
    }
    Ok(())
}

/// Renders a frame, writes its files, and prints its results.
fn render(
    options: &RenderOptions,
    job: &RenderJob,
    frame: u32,
    (backend, machine): (&mut dyn Backend, &Machine),
    picture: &mut Picture,
    console: &Console,
    began: Instant,
) -> Result<(), Error> {
    let is_first = frame == 0 && options.debug.is_none();
    let start = Instant::now();
    job.render(backend, &job.request(keeps_buffers(options)), picture)?;
    let frame_ms = start.elapsed().as_secs_f64() * 1e3;
    console.detail(format_args!("frame {frame}: {frame_ms:.1} ms, in {}", stages(picture)));
    let name = |path: &PathBuf| filled(path, &options.common.scene, frame);
    let (output, aov) = (options.output.as_ref().map(name), options.aov.as_ref().map(name));
    write(options, output.as_deref(), aov.as_deref(), job, picture, console)?;
    if let Some(line) = is_first.then(|| clipped(&job.scene, picture)).flatten() {
        console.say(line);
    }
    if let Some(reference) = options.compare.as_ref().map(name) {
        compare(&reference, picture.bytes(), job.size, options.tolerance)?;
        console.say(format_args!("equal to {}", reference.display()));
    }
    let (hash, buffers) = (hash::pixels(picture), buffer_hashes(picture).filter(|_| options.hash));
    if options.common.json {
        return console.print(output::json(&RenderReport {
            machine: machine.clone(),
            size: job.size,
            samples: job.samples,
            stages_ms: PerStage(picture.stages_ms),
            frame_ms,
            bvh_build_ms: job.bvh_build_ms,
            load_ms: job.load_ms,
            total_ms: began.elapsed().as_secs_f64() * 1e3,
            scene_bytes: job.scene.bytes(),
            peak_rss_bytes: peak_rss_bytes(),
            exposure: job.exposure,
            triangles: job.scene.triangles(),
            drawn_triangles: job.scene.drawn_triangles(),
            objects: job.scene.instances().len(),
            hash,
            buffers,
            output: output.as_deref(),
        })?);
    }
    if options.hash { console.print_hashes(&hash, buffers) } else { Ok(()) }
}

/// The stages that took time, with their times.
fn stages(picture: &Picture) -> String {
    let all = Stage::ALL.iter().zip(picture.stages_ms).filter(|(_, ms)| *ms > 0.0);
    all.map(|(stage, ms)| format!("{} {ms:.1}", stage.name())).collect::<Vec<_>>().join(", ")
}

/// Checks that the options do not contradict each other, and that the files can be written.
fn check(options: &RenderOptions) -> Result<(), Error> {
    let output = options.output.as_deref();
    if output.is_some_and(is_standard) && (options.hash || options.common.json) {
        return Err(Error::Usage(
            "the picture (-o -) and results (--hash, --json) both go to standard output",
        ));
    }
    if output.is_some_and(|path| ends_in(path, "exr")) && (options.debug.is_some() || options.bits != 8) {
        return Err(Error::Usage("--debug and --bits are for PNG, but the picture is an EXR file"));
    }
    if options.debug.is_some() && options.bits != 8 {
        return Err(Error::Usage("--debug has 8 bits a channel"));
    }
    if options.background.is_some() && options.debug.is_some() {
        return Err(Error::Usage("--debug has no background"));
    }
    let named = [output, options.aov.as_deref(), options.compare.as_deref()];
    named.into_iter().flatten().try_for_each(names::check)?;
    let mut files = output.into_iter().chain(options.aov.as_deref());
    if options.frames > 1 && !files.clone().all(is_numbered) {
        return Err(Error::Usage("every frame needs a file of its own: add {frame} or {n} to the names"));
    }
    let name = |path: &Path| filled(path, &options.common.scene, 0);
    if output.is_some_and(|output| options.aov.as_deref() == Some(output)) {
        return Err(Error::Usage("the picture and the deferred buffers go to the same file"));
    }
    if let Some(reference) = &options.compare {
        if files.clone().any(|path| name(path) == name(reference)) {
            return Err(Error::Usage("the picture would replace the file of --compare"));
        }
        compare::check(&name(reference), options.common.size)?;
    }
    files.try_for_each(|path| output::check(&name(path)))
}

/// Whether the outputs need the deferred buffers.
fn keeps_buffers(options: &RenderOptions) -> bool {
    let is_exr = options.output.as_deref().is_some_and(|path| ends_in(path, "exr"));
    options.hash || options.aov.is_some() || options.debug.is_some() || options.bits != 8 || is_exr
}

/// Writes the picture's files.
fn write(
    options: &RenderOptions,
    output: Option<&Path>,
    aov: Option<&Path>,
    job: &RenderJob,
    picture: &Picture,
    console: &Console,
) -> Result<(), Error> {
    let layers = || Layers::new(&job.scene, picture, job.samples).unwrap_or_default();
    if let Some(path) = aov {
        console.step(format_args!("writing {}", path.display()));
        output::write(path, &exr::all(&layers()).map_err(encode(path))?)?;
    }
    let Some(path) = output else { return Ok(()) };
    console.step(format_args!("writing {}", path.display()));
    let bytes = if ends_in(path, "exr") {
        exr::color(&layers()).map_err(encode(path))?
    } else if let Some(view) = options.debug {
        let shown = job.show(view, picture)?;
        if let Some(legend) = &shown.legend {
            console.say(legend);
        }
        png(cast_slice(&shown.pixels), job.size, Rgba8).map_err(encode(path))?
    } else if options.bits == 16 {
        png(cast_slice(&layers().encoded16(&job.request(true))), job.size, Rgba16).map_err(encode(path))?
    } else {
        png(picture.bytes(), job.size, Rgba8).map_err(encode(path))?
    };
    output::write(path, &bytes)
}

/// The error for a file that could not be encoded.
pub fn encode<E: Into<Box<dyn std::error::Error + Send + Sync>>>(path: &Path) -> impl FnOnce(E) -> Error {
    |source| Error::Encode { path: path.to_owned(), source: source.into() }
}
