//! `rtrt render`: a picture of a scene.

use super::Error;
use super::console::Console;
use super::exr;
use super::job::{Job, open};
use super::options::{Render, ends_in, is_standard};
use super::output::{self, png};
use super::report::{Machine, PerStage, buffer_hashes, pixel_hash};
use bytemuck::cast_slice;
use image::ExtendedColorType::{Rgba8, Rgba16};
use rtrt::layers::Layers;
use rtrt_core::backend::Picture;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// Sub-rays a pixel if not given: a picture is looked at.
const SAMPLES: u32 = 4;

/// What `--json` prints.
#[derive(serde::Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    machine: Machine,
    size: [u32; 2],
    samples: u32,
    stages_ms: PerStage<f64>,
    /// Wall clock of the frame, the upload of the scene included.
    frame_ms: f64,
    tree_build_ms: f64,
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
pub fn run(options: &Render) -> Result<(), Error> {
    let console = Console::new(4);
    check(options)?;
    let keep = keeps_buffers(options);
    let job = Job::load(&options.common, SAMPLES, keep, &console)?;
    let (mut backend, machine) = open(&options.common.backend, &console)?;

    console.step(format_args!("rendering on {machine}"));
    let mut picture = Picture::default();
    let start = Instant::now();
    job.render(&mut *backend, &job.request(keep), &mut picture)?;
    let frame_ms = start.elapsed().as_secs_f64() * 1e3;
    write(options, &job, &picture, &console)?;
    drop(console);
    let (hash, buffers) = (pixel_hash(&picture), buffer_hashes(&picture).filter(|_| options.hash));
    if options.common.json {
        return output::print_json(&Report {
            machine,
            size: job.size,
            samples: job.samples,
            stages_ms: PerStage(picture.stages_ms),
            frame_ms,
            tree_build_ms: job.tree_build_ms,
            triangles: job.scene.triangles(),
            drawn_triangles: job.scene.drawn_triangles(),
            objects: job.scene.objects().len(),
            hash,
            buffers,
            output: options.output.as_deref(),
        });
    }
    if options.hash {
        output::print_hashes(&hash, buffers)?;
    }
    Ok(())
}

/// Whether the options go together, and files can be written where they say.
fn check(options: &Render) -> Result<(), Error> {
    let output = options.output.as_deref();
    if output.is_some_and(is_standard) && (options.hash || options.common.json) {
        return Err(Error::Usage(
            "the picture (-o -) and results (--hash, --json) both go to standard output",
        ));
    }
    if output.is_some_and(|path| ends_in(path, "exr")) && (options.debug.is_some() || options.bits != 8) {
        return Err(Error::Usage("--debug and --bits are for PNG, and the picture is to be an EXR file"));
    }
    if options.debug.is_some() && options.bits != 8 {
        return Err(Error::Usage("--debug has 8 bits a channel"));
    }
    output.into_iter().chain(options.aov.as_deref()).try_for_each(output::check)
}

/// Whether what is to be written is made from the deferred buffers.
fn keeps_buffers(options: &Render) -> bool {
    let is_exr = options.output.as_deref().is_some_and(|path| ends_in(path, "exr"));
    options.hash || options.aov.is_some() || options.debug.is_some() || options.bits != 8 || is_exr
}

/// Writes the picture's files.
fn write(options: &Render, job: &Job<'_>, picture: &Picture, console: &Console) -> Result<(), Error> {
    let layers = Layers::new(&job.scene, picture, job.samples).unwrap_or_default();
    if let Some(path) = &options.aov {
        console.step(format_args!("writing {}", path.display()));
        output::write(path, &exr::all(&layers).map_err(encode(path))?)?;
    }
    let Some(path) = &options.output else { return Ok(()) };
    console.step(format_args!("writing {}", path.display()));
    let bytes = if ends_in(path, "exr") {
        exr::color(&layers).map_err(encode(path))?
    } else if let Some(view) = options.debug {
        let shown = job.show(view, picture)?;
        if let Some(legend) = &shown.legend {
            console.say(legend);
        }
        png(cast_slice(&shown.pixels), job.size, Rgba8).map_err(encode(path))?
    } else if options.bits == 16 {
        png(cast_slice(&layers.encoded16()), job.size, Rgba16).map_err(encode(path))?
    } else {
        png(picture.bytes(), job.size, Rgba8).map_err(encode(path))?
    };
    output::write(path, &bytes)
}

/// What is said where a file could not be encoded.
fn encode<E: Into<Box<dyn std::error::Error + Send + Sync>>>(path: &Path) -> impl FnOnce(E) -> Error {
    |source| Error::Encode { path: path.to_owned(), source: source.into() }
}
