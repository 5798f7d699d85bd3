//! `rtrt render`: pictures of scenes.

use super::Error;
use super::clipped::clipped;
use super::compare::{self, compare};
use super::console::Console;
use super::exr;
use super::job::{Opened, RenderJob, open};
use super::memory::peak_rss_bytes;
use super::names::{self, filled, has_camera, is_numbered};
use super::npy::{Array, npz};
use super::options::RenderOptions;
use super::output::{self, png};
use super::parse::{Background, Exposure, Stream, ends_in, is_standard};
use super::report::{Machine, PerStage, buffer_hashes};
use super::run_report::{RunReport, Shot};
use super::sinks::Sinks;
use super::views::{View, are_many, is_all, views};
use bytemuck::cast_slice;
use glam::DVec3;
use image::ExtendedColorType::{Rgba8, Rgba16};
use rtrt::hash;
use rtrt::layers::Layers;
use rtrt::motion::{Before, motion};
use rtrt::poses::{self, Pose};
use rtrt_core::backend::{Backend, Picture, little_endian};
use rtrt_core::layout::Backdrop;
use rtrt_core::schedule::Stage;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The default of sub-rays per pixel.
pub const SAMPLES: u32 = 4;

/// The output of `--json`.
#[derive(serde::Serialize)]
struct RenderReport<'a> {
    #[serde(flatten)]
    machine: Machine,
    scene: &'a Path,
    #[serde(flatten)]
    shot: &'a Shot,
    size: [u32; 2],
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

/// A run: what is the same for all of its pictures.
struct Run<'a> {
    options: &'a RenderOptions,
    console: &'a Console,
    began: Instant,
    sinks: Sinks,
    /// Whether a scene has several views, or may.
    has_views: bool,
    /// The names of the files so far.
    written: BTreeSet<PathBuf>,
    picture: Picture,
}

/// A frame of a view.
struct Frame<'a> {
    scene: &'a Path,
    view: &'a View,
    /// What `{frame}` becomes.
    number: u32,
    /// Whether it is the first of the run.
    is_first: bool,
    /// The time of the animation, seconds.
    time: Option<f64>,
    /// The frame before it, of the same view.
    before: Option<&'a Before>,
}

/// Renders.
pub fn run(options: &RenderOptions) -> Result<(), Error> {
    let began = Instant::now();
    let poses = options.cameras.as_deref().map(|path| poses::read(path, options.common.size)).transpose()?;
    let (poses, warnings) = poses.map_or_else(Default::default, |poses| (poses.poses, poses.warnings));
    let scenes: Vec<&Path> =
        std::iter::once(&options.common.scene).chain(&options.more).map(PathBuf::as_path).collect();
    check(options, &poses, &scenes)?;
    let pictures = poses.len().max(options.orbit.map_or(1, |count| count as usize)) as u64;
    let steps = 2 + 3 * u64::from(options.frames) * pictures;
    let console = Console::new(options.common.talk, steps * scenes.len() as u64);
    warnings.into_iter().try_for_each(|warning| console.warn(3, warning))?;
    let mut run = Run {
        options,
        console: &console,
        began,
        sinks: Sinks::new(options.stream, options.fps),
        has_views: are_many(options, &poses),
        written: BTreeSet::new(),
        picture: Picture::default(),
    };
    let (mut opened, mut report) = (None, None);
    for scene in scenes {
        let mut job = load(options, scene, &poses, &console)?;
        let Opened { backend, machine, .. } = match &mut opened {
            Some(opened) => opened,
            None => opened.insert(open(&options.common.backend, options.hybrid, &console)?),
        };
        if options.report.is_some() {
            report.get_or_insert_with(|| RunReport::new(machine)).add_scene(scene, &job);
        }
        run.scene(scene, &mut job, &poses, (&mut **backend, machine), report.as_mut())?;
    }
    run.sinks.finish()?;
    if let (Some(path), Some(report)) = (&options.report, report) {
        output::write(path, output::json(&report.finished(began))?.as_bytes())?;
    }
    Ok(())
}

/// Loads a scene, as the options say.
fn load(
    options: &RenderOptions,
    scene: &Path,
    poses: &[Pose],
    console: &Console,
) -> Result<RenderJob, Error> {
    let mut common = options.common.clone();
    common.scene = scene.to_owned();
    if is_all(options) {
        common.camera.camera = None;
    }
    let mut job = RenderJob::load(&common, SAMPLES, keeps_buffers(options), start(options, poses), console)?;
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
    Ok(job)
}

/// The time of the first frame, if anything may move.
fn start(options: &RenderOptions, poses: &[Pose]) -> Option<f64> {
    let moves = options.frames > 1 || poses.iter().any(|pose| pose.time.is_some());
    options.common.start().or(moves.then_some(0.0))
}

impl Run<'_> {
    /// Renders all views of a scene.
    fn scene(
        &mut self,
        scene: &Path,
        job: &mut RenderJob,
        poses: &[Pose],
        (backend, machine): (&mut dyn Backend, &Machine),
        mut report: Option<&mut RunReport>,
    ) -> Result<(), Error> {
        let options = self.options;
        let usual = start(options, poses);
        let mut shown = usual;
        let views = views(options, poses, job)?;
        for (place, view) in views.iter().enumerate() {
            job.look(view, keeps_buffers(options))?;
            let mut before = None;
            for frame in 0..options.frames {
                let start = view.time.or(usual);
                let time = start.map(|start| start + f64::from(frame) / options.fps);
                if let Some(time) = time.filter(|_| time != shown) {
                    job.play(time)?;
                    shown = Some(time);
                }
                if place == 0 && frame == 0 {
                    job.expose(backend, self.console)?;
                }
                let number = if options.frames > 1 { frame } else { place as u32 };
                self.console.step(format_args!("rendering frame {number} on {machine}"));
                let is_first = self.written.is_empty() && frame == 0 && place == 0;
                let now = Frame { scene, view, number, is_first, time, before: before.as_ref() };
                self.frame(&now, job, (backend, machine), report.as_deref_mut())?;
                let moves = options.aov.is_some() && options.frames > 1;
                before = moves.then(|| Before::new(&job.scene, &job.camera));
            }
        }
        Ok(())
    }

    /// Renders a frame, writes its files, and prints its results.
    fn frame(
        &mut self,
        frame: &Frame<'_>,
        job: &RenderJob,
        (backend, machine): (&mut dyn Backend, &Machine),
        report: Option<&mut RunReport>,
    ) -> Result<(), Error> {
        let (options, console) = (self.options, self.console);
        let (number, view) = (frame.number, frame.view);
        let name = |path: &PathBuf| filled(path, frame.scene, &view.name, number);
        let (output, aov) = (options.output.as_ref().map(name), options.aov.as_ref().map(name));
        self.claim([output.as_deref(), aov.as_deref()])?;
        let start = Instant::now();
        job.render(backend, &job.request(keeps_buffers(options)), &mut self.picture)?;
        let frame_ms = start.elapsed().as_secs_f64() * 1e3;
        let stages_ms = stages(&self.picture);
        console.detail(format_args!("frame {number} of {}: {frame_ms:.1} ms, in {stages_ms}", view.name));
        let shot = Shot::new(job, &view.name, number, frame.time);
        let layers =
            needs_layers(options).then(|| Layers::new(&job.scene, &job.request(true), &self.picture));
        // What needs them has asked for the deferred buffers.
        let layers = layers.flatten().unwrap_or_default();
        if let Some(path) = &aov {
            console.step(format_args!("writing {}", path.display()));
            let still = || vec![[0.0; 2]; layers.object.len()];
            let moved = frame.before.map(|before| motion(&job.scene, &job.camera, &layers, before));
            let moved = (options.frames > 1).then(|| moved.unwrap_or_else(still));
            let placed = (job.origin != DVec3::ZERO).then(|| layers.clone().moved(job.origin));
            let placed = placed.as_ref().unwrap_or(&layers);
            output::write(path, &all_layers(path, placed, moved.as_deref(), &shot)?)?;
        }
        if let Some(path) = &output {
            console.step(format_args!("writing {}", path.display()));
            self.write(path, job, &layers, &shot)?;
        }
        let picture = &self.picture;
        let is_metered = options.common.exposure == Exposure::Auto;
        let is_asked = frame.is_first && options.debug.is_none() && !is_metered;
        if let Some(line) = is_asked.then(|| clipped(&job.scene, picture)).flatten() {
            console.say(line);
        }
        if let Some(reference) = options.compare.as_ref().map(name) {
            let (pixels, tolerance) = (picture.bytes(), options.tolerance);
            compare(&reference, output.as_deref(), &pixels, job.size, tolerance, console)?;
            console.say(format_args!("equal to {}", reference.display()));
        }
        if let Some(report) = report {
            report.add_frame(
                shot.clone(),
                [output.as_deref(), aov.as_deref()],
                job,
                picture,
                &layers,
                frame_ms,
            );
        }
        if !options.common.json && !options.hash {
            return Ok(());
        }
        let hash = hash::pixels(picture);
        let buffers = options.hash.then(|| buffer_hashes(picture)).flatten();
        if !options.common.json {
            return console.print_hashes(&hash, buffers, self.called(frame).as_deref());
        }
        console.print(output::json(&RenderReport {
            machine: machine.clone(),
            scene: frame.scene,
            shot: &shot,
            size: job.size,
            stages_ms: PerStage(picture.stages_ms),
            frame_ms,
            bvh_build_ms: job.bvh_build_ms,
            load_ms: job.load_ms,
            total_ms: self.began.elapsed().as_secs_f64() * 1e3,
            scene_bytes: job.scene.bytes(),
            peak_rss_bytes: peak_rss_bytes(),
            exposure: job.exposure,
            triangles: job.scene.triangles(),
            drawn_triangles: job.scene.drawn_triangles(),
            objects: job.scene.instances().len(),
            hash,
            buffers,
            output: output.as_deref(),
        })?)
    }

    /// What tells a frame from the others of the run: its scene, its view and its number, as far as there are several.
    fn called(&self, frame: &Frame<'_>) -> Option<String> {
        let scene = (!self.options.more.is_empty()).then(|| frame.scene.display().to_string());
        let view = self.has_views.then(|| frame.view.name.clone());
        let number = (self.options.frames > 1).then(|| format!("frame {}", frame.number));
        let parts: Vec<String> = [scene, view, number].into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// Takes names of files for a frame; no two frames have the same. Streams and films have many.
    fn claim(&mut self, files: [Option<&Path>; 2]) -> Result<(), Error> {
        for path in files.into_iter().flatten().filter(|path| !is_standard(path) && !ends_in(path, "mp4")) {
            if !self.written.insert(path.to_owned()) {
                return Err(Error::SameName { path: path.to_owned() });
            }
        }
        Ok(())
    }

    /// Writes the picture.
    fn write(&mut self, path: &Path, job: &RenderJob, layers: &Layers, shot: &Shot) -> Result<(), Error> {
        let (options, picture) = (self.options, &self.picture);
        let shown = options.debug.map(|view| job.show(view, picture)).transpose()?;
        if let Some(legend) = shown.as_ref().and_then(|shown| shown.legend.as_ref()) {
            self.console.say(legend);
        }
        let pixels = shown.as_ref().map_or_else(|| picture.bytes(), |shown| little_endian(&shown.pixels));
        let bytes = if self.sinks.takes_pixels(path) {
            Cow::Borrowed(&pixels[..])
        } else if ends_in(path, "exr") {
            exr::color(layers, shot).map_err(encode(path))?.into()
        } else if ends_in(path, "npy") {
            Array::floats("color", layers, &layers.color).npy().into()
        } else if options.bits == 16 {
            let encoded = layers.encoded16(&job.request(true));
            png(cast_slice(&encoded), job.size, Rgba16).map_err(encode(path))?.into()
        } else {
            png(&pixels, job.size, Rgba8).map_err(encode(path))?.into()
        };
        self.sinks.write(path, &bytes, job.size)
    }
}

/// The stages that took time, with their times.
fn stages(picture: &Picture) -> String {
    let all = Stage::ALL.iter().zip(picture.stages_ms).filter(|(_, ms)| *ms > 0.0);
    all.map(|(stage, ms)| format!("{} {ms:.1}", stage.name())).collect::<Vec<_>>().join(", ")
}

/// The file of all layers.
fn all_layers(
    path: &Path,
    layers: &Layers,
    motion: Option<&[[f32; 2]]>,
    shot: &Shot,
) -> Result<Vec<u8>, Error> {
    if ends_in(path, "exr") {
        return exr::all(layers, motion, shot).map_err(encode(path));
    }
    let mut arrays = vec![
        Array::floats("color", layers, &layers.color),
        Array::plane("depth", layers, &layers.depth),
        Array::floats("normal", layers, &layers.normal),
        Array::floats("albedo", layers, &layers.albedo),
        Array::numbers("object", layers, &layers.object),
        Array::numbers("material", layers, &layers.material),
        Array::numbers("triangle", layers, &layers.triangle),
        Array::numbers("source", layers, &layers.source),
        Array::floats("barycentrics", layers, &layers.barycentrics),
        Array::floats("uv", layers, &layers.uv),
        Array::floats("position", layers, &layers.position),
        Array::plane("shadow", layers, &layers.shadow),
    ];
    arrays.extend(motion.map(|motion| Array::floats("motion", layers, motion)));
    npz(&arrays).map_err(encode(path))
}

/// Checks that the options do not contradict each other, and that the files can be written.
fn check(options: &RenderOptions, poses: &[Pose], scenes: &[&Path]) -> Result<(), Error> {
    let output = options.output.as_deref();
    let ends = |ending| output.is_some_and(|path| ends_in(path, ending));
    let results = [options.aov.is_some(), options.compare.is_some(), options.hash, options.common.json];
    if output.is_none() && options.report.is_none() && !results.contains(&true) {
        return Err(Error::Usage(
            "no result is asked for: add -o FILE, --hash, --json, --aov FILE, --report FILE or --compare FILE",
        ));
    }
    if output.is_none() && (options.debug.is_some() || options.bits != 8) {
        return Err(Error::Usage(
            "--debug and --bits are for a picture, and no file is named for it (-o FILE)",
        ));
    }
    let is_stream = output.is_some_and(is_standard);
    if is_stream && (options.hash || options.common.json) {
        return Err(Error::Usage(
            "the picture (-o -) and results (--hash, --json) both go to standard output",
        ));
    }
    if options.stream != Stream::Png && !is_stream {
        return Err(Error::Usage("--stream is for pictures on standard output (-o -)"));
    }
    if ends("exr") || ends("npy") {
        if options.debug.is_some() {
            return Err(Error::Usage("--debug is for PNG, but the picture is linear light"));
        }
        if options.bits != 8 {
            return Err(Error::Usage("--bits is for PNG, but the picture is linear light"));
        }
    }
    if options.bits != 8 && (ends("mp4") || options.stream != Stream::Png) {
        return Err(Error::Usage("--bits is for PNG; films and raw pixels have 8 bits a channel"));
    }
    if options.debug.is_some() && options.bits != 8 {
        return Err(Error::Usage("--debug has 8 bits a channel"));
    }
    if options.background.is_some() && options.debug.is_some() {
        return Err(Error::Usage("--debug has no background"));
    }
    if is_all(options) && options.orbit.is_some() {
        return Err(Error::Usage("--orbit goes around one camera, and --camera all are many"));
    }
    let named = [output, options.aov.as_deref(), options.compare.as_deref(), options.report.as_deref()];
    named.into_iter().flatten().try_for_each(names::check)?;
    let files = output.into_iter().chain(options.aov.as_deref());
    let singles = || files.clone().filter(|path| !is_standard(path) && !ends_in(path, "mp4"));
    let many = are_many(options, poses);
    if options.frames > 1 && !singles().all(is_numbered) {
        return Err(Error::Usage("every frame needs a file of its own: add {frame} or {n} to the names"));
    }
    if many && !singles().all(|path| has_camera(path) || (options.frames == 1 && is_numbered(path))) {
        return Err(Error::Usage(if options.frames == 1 {
            "every view needs a file of its own: add {camera}, {frame} or {n} to the names"
        } else {
            "every view needs a file of its own for each frame: add {camera} to the names"
        }));
    }
    let name = |path: &Path, scene: &Path| filled(path, scene, "camera", 0);
    for path in singles() {
        let mut known = BTreeSet::new();
        if let Some(path) =
            scenes.iter().map(|scene| name(path, scene)).find(|path| !known.insert(path.clone()))
        {
            return Err(Error::SameName { path });
        }
    }
    if output.is_some_and(|output| options.aov.as_deref() == Some(output)) {
        return Err(Error::Usage("the picture and the deferred buffers go to the same file"));
    }
    for scene in scenes {
        if let Some(reference) = &options.compare {
            if files.clone().any(|path| name(path, scene) == name(reference, scene)) {
                return Err(Error::Usage("the picture would replace the file of --compare"));
            }
            if !many && !has_camera(reference) {
                compare::check(&name(reference, scene), options.common.size)?;
            }
        }
        files.clone().try_for_each(|path| output::check(&name(path, scene)))?;
    }
    options.report.as_deref().map_or(Ok(()), output::check)
}

/// Whether the outputs need the deferred buffers.
fn keeps_buffers(options: &RenderOptions) -> bool {
    options.hash || options.debug.is_some() || needs_layers(options)
}

/// Whether the outputs need layers.
fn needs_layers(options: &RenderOptions) -> bool {
    let is_light = options.output.as_deref().is_some_and(|path| ends_in(path, "exr") || ends_in(path, "npy"));
    is_light || options.aov.is_some() || options.bits != 8 || options.report.is_some()
}

/// The error for a file that could not be encoded.
pub fn encode<E: Into<Box<dyn std::error::Error + Send + Sync>>>(path: &Path) -> impl FnOnce(E) -> Error {
    |source| Error::Encode { path: path.to_owned(), source: source.into() }
}
