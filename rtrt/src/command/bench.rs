//! `rtrt bench`: how fast a scene renders.

use super::Error;
use super::console::Console;
use super::job::{Opened, RenderJob, open};
use super::memory::peak_rss_bytes;
use super::options::BenchOptions;
use super::output;
use super::report::{Machine, PerStage, counted};
use rtrt::hash;
use rtrt_core::backend::{Backend, Picture, Shadows};
use rtrt_core::scene::Structure;
use rtrt_core::schedule::Stage;
use std::fmt;
use std::time::Instant;

/// The default of sub-rays per pixel; figures of other ray tracers are for one.
const SAMPLES: u32 = 1;
/// Frames before the measurement, which allocate memory and upload the scene.
const WARM_UP: u32 = 2;
/// The stages of primary rays.
const PRIMARY: [Stage; 3] = [Stage::Prepare, Stage::Bin, Stage::Visibility];
/// The stages that trace rays.
const TRACED: [Stage; 4] = [Stage::Prepare, Stage::Bin, Stage::Visibility, Stage::Occlusion];
/// The stages up to incoming light, without detail, which reads normal maps.
const LIT: [Stage; 6] =
    [Stage::Prepare, Stage::Bin, Stage::Visibility, Stage::Surface, Stage::Occlusion, Stage::Light];

/// The results; `--json` prints them.
#[derive(serde::Serialize)]
struct BenchReport {
    #[serde(flatten)]
    machine: Machine,
    /// Width and height.
    size: [u32; 2],
    samples: u32,
    stages_ms: PerStage<Times>,
    /// Rays from the camera per second of the median times of prepare, bin and visibility.
    primary_rays_per_second: f64,
    /// Rays from the camera and to lights per second of the median times of prepare, bin, visibility and
    /// occlusion. A surface casts a ray to each light that it faces and that is in reach; none without shadows.
    traced_rays_per_second: f64,
    /// The same rays per second of the median times of those stages, surface and light.
    primary_and_shadow_rays_per_second: f64,
    /// Median wall-clock time of a frame.
    frame_ms: f64,
    /// The time in which the host sets up a frame and submits it to a GPU; null for the CPU backend.
    host_ms: Option<Times>,
    bvh_build_ms: f64,
    load_ms: f64,
    /// The bytes of the scene without its texels.
    scene_bytes: usize,
    /// The bytes of vertices and indices as imported.
    source_bytes: usize,
    /// The peak memory of the process up to the last measured frame; null on systems without that figure.
    peak_rss_bytes: Option<u64>,
    triangles: u64,
    drawn_triangles: u64,
    objects: usize,
    /// SHA-256 of the pixels.
    hash: String,
}

/// Milliseconds over all frames.
#[derive(Debug, Clone, Copy, serde::Serialize)]
struct Times {
    median: f64,
    min: f64,
}

/// Measures, and prints the results.
pub fn run(options: &BenchOptions) -> Result<(), Error> {
    let console = Console::new(
        options.common.talk,
        u64::from(options.frames + WARM_UP) + 3 + u64::from(options.common.structure != Structure::Blocks),
    );
    let mut job = RenderJob::load(&options.common, SAMPLES, true, options.common.start(), &console)?;
    let Opened { mut backend, machine, .. } = open(&options.common.backend, options.hybrid, &console)?;
    job.expose(&mut *backend, &console)?;
    let mut picture = Picture::default();
    let mut frames: Vec<[f64; Stage::COUNT]> = Vec::new();
    let (mut frame_ms, mut host_ms) = (Vec::new(), Vec::new());
    for frame in 0..WARM_UP + options.frames {
        console.step(format_args!("frame {}", frame + 1));
        let start = Instant::now();
        job.render(&mut *backend, &job.request(false), &mut picture)?;
        if frame >= WARM_UP {
            frame_ms.push(start.elapsed().as_secs_f64() * 1e3);
            frames.push(picture.stages_ms);
            host_ms.extend(picture.host_ms);
        }
    }
    let peak_rss_bytes = peak_rss_bytes();
    if options.common.structure != Structure::Blocks {
        console.step("comparing with lists of objects");
        job.scene.structure = Structure::Objects;
        let mut usual = Picture::default();
        job.render(&mut *backend, &job.request(false), &mut usual)?;
        if usual.pixels != picture.pixels {
            return Err(Error::Structure { scene: options.common.scene.clone() });
        }
    }
    console.step("counting rays");
    let shadow_rays = shadow_rays(&job, &mut *backend)?;
    drop(console);

    let stages: [Times; Stage::COUNT] =
        core::array::from_fn(|stage| times(frames.iter().map(|frame| frame[stage]).collect()));
    let seconds = |of: &[Stage]| of.iter().map(|&stage| stages[stage as usize].median).sum::<f64>() * 1e-3;
    let rays = (job.rays + shadow_rays) as f64;
    let scene = &job.scene;
    let report = BenchReport {
        machine,
        size: job.size,
        samples: job.samples,
        primary_rays_per_second: job.rays as f64 / seconds(&PRIMARY),
        traced_rays_per_second: rays / seconds(&TRACED),
        primary_and_shadow_rays_per_second: rays / seconds(&LIT),
        stages_ms: PerStage(stages),
        frame_ms: times(frame_ms).median,
        host_ms: (!host_ms.is_empty()).then(|| times(host_ms)),
        bvh_build_ms: job.bvh_build_ms,
        load_ms: job.load_ms,
        scene_bytes: scene.bytes() - size_of_val(scene.texels()),
        source_bytes: scene.source_bytes(),
        peak_rss_bytes,
        triangles: scene.triangles(),
        drawn_triangles: scene.drawn_triangles(),
        objects: scene.instances().len(),
        hash: hash::pixels(&picture),
    };
    if options.common.json { output::print_json(&report) } else { output::print(report) }
}

/// The median and the minimum of times, of which there is at least one.
fn times(mut of: Vec<f64>) -> Times {
    of.sort_by(f64::total_cmp);
    let middle = of.len() / 2;
    let median = if of.len().is_multiple_of(2) { (of[middle - 1] + of[middle]) * 0.5 } else { of[middle] };
    Times { median, min: of[0] }
}

/// The number of rays to lights in a frame. Without shadows a light reaches every surface that would cast
/// a shadow ray, so each bit of the masks stands for one ray.
fn shadow_rays(job: &RenderJob, backend: &mut dyn Backend) -> Result<u64, Error> {
    if job.shadows == Shadows::Off {
        return Ok(0);
    }
    let mut picture = Picture::default();
    job.render(backend, &job.request(true).shadows(Shadows::Off), &mut picture)?;
    let masks = picture.deferred.map(|deferred| deferred.masks).unwrap_or_default();
    Ok(masks.iter().map(|word| u64::from(word.count_ones())).sum())
}

impl fmt::Display for BenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MEGA: f64 = 1e-6;
        let [width, height] = self.size;
        writeln!(f, "{}: {width}x{height}, {}", self.machine, counted(self.samples, "sample"))?;
        let Self { triangles, drawn_triangles, objects, .. } = self;
        let [objects, triangles] = [counted(*objects as u64, "object"), counted(*triangles, "triangle")];
        writeln!(f, "{objects}, {triangles}, {drawn_triangles} drawn")?;
        for (stage, Times { median, min }) in Stage::ALL.iter().zip(self.stages_ms.0) {
            writeln!(f, "{:>12} {median:9.3} ms (min {min:.3})", stage.name())?;
        }
        writeln!(f, "{:>12} {:9.3} ms", "frame", self.frame_ms)?;
        if let Some(Times { median, min }) = self.host_ms {
            writeln!(f, "{:>12} {median:9.3} ms (min {min:.3})", "of it, host")?;
        }
        writeln!(f, "{:>12} {:9.3} ms", "tree build", self.bvh_build_ms)?;
        writeln!(f, "primary rays: {:.2} million a second", self.primary_rays_per_second * MEGA)?;
        let [traced, both] =
            [self.traced_rays_per_second, self.primary_and_shadow_rays_per_second].map(|rays| rays * MEGA);
        writeln!(
            f,
            "primary and shadow rays: {traced:.2} million a second, {both:.2} with surfaces and light"
        )?;
        let [scene, source] = [self.scene_bytes, self.source_bytes].map(|bytes| bytes as f64 * MEGA);
        writeln!(f, "memory: scene {scene:.1} MB, {source:.1} MB of it imported")?;
        if let Some(peak) = self.peak_rss_bytes {
            writeln!(f, "peak memory of the process: {:.1} MB", peak as f64 * MEGA)?;
        }
        write!(f, "{}  pixels", self.hash)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        let Times { median, min } = times(vec![4.0, 1.0, 9.0]);
        assert_eq!((median, min), (4.0, 1.0));
        assert_eq!(times(vec![4.0, 1.0, 9.0, 5.0]).median, 4.5);
    }
}
