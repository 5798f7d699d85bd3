//! `rtrt render`: a picture of a scene.

use super::Error;
use super::console::Console;
use super::job::{Job, open};
use super::options::Render;
use super::output;
use super::report::{Machine, PerStage, buffer_hashes, pixel_hash};
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
    if let Some(path) = &options.output {
        output::check(path)?;
    }
    let job = Job::load(&options.common, SAMPLES, options.hash, &console)?;
    let (mut backend, machine) = open(&options.common.backend, &console)?;

    console.step(format_args!("rendering on {machine}"));
    let mut picture = Picture::default();
    let start = Instant::now();
    job.render(&mut *backend, &job.request(options.hash), &mut picture)?;
    let frame_ms = start.elapsed().as_secs_f64() * 1e3;

    if let Some(path) = &options.output {
        console.step(format_args!("writing {}", path.display()));
        output::write_png(path, &picture)?;
    }
    drop(console);
    let (hash, buffers) = (pixel_hash(&picture), buffer_hashes(&picture));
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
