//! The viewer without its window.

mod draw;

use super::controls::{Action, Controls, Free, Rig};
use super::engine::Engine;
use super::input::Event;
use super::pace::{Detail, Pace};
use super::reproduce::{self, EnvironmentShot, Shot};
use crate::command::Error;
use crate::command::arguments;
use crate::command::console::Console;
use crate::command::job::RenderJob;
use crate::command::names::{filled, is_numbered};
use crate::command::options::{self, Common};
use crate::command::output::{self, png};
use crate::command::parse::Exposure;
use crate::command::render::{SAMPLES, encode};
use crate::command::report::Machine;
use glam::DVec3;
use image::ExtendedColorType::Rgba8;
use rtrt::choose::Choice;
use rtrt::debug::{DebugImage, DebugView};
use rtrt_core::backend::{Picture, Shadows, ToneMap};
use rtrt_core::scene::Camera;
use rtrt_core::schedule::Stage;
use std::path::{Path, PathBuf};

/// The time without a change after which a picture has full detail, seconds.
const SETTLE: f64 = 0.2;
/// The duration of a message, seconds.
const MESSAGE: f64 = 6.0;

/// The settings of the panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    pub samples: u32,
    pub shadows: Shadows,
    pub layers: u32,
    /// Stops.
    pub exposure: f32,
    pub tone_map: ToneMap,
    /// Whether a GPU rasterizes the first surfaces.
    pub hybrid: bool,
    /// The debug view in place of the picture.
    pub debug: Option<DebugView>,
    /// The frame rate for which detail is reduced.
    pub fps: f64,
    pub help: bool,
    pub timing: bool,
    pub panel: bool,
}

/// The inputs of a picture. The number of changes stands for the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    camera: Camera,
    pub detail: Detail,
    shadows: Shadows,
    layers: u32,
    exposure: f32,
    tone_map: ToneMap,
    hybrid: bool,
    debug: Option<DebugView>,
    backend: usize,
    changes: u64,
}

/// The rendering time of the current picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    pub detail: Detail,
    /// Wall-clock time including readback, milliseconds.
    pub frame_ms: f64,
    pub stages_ms: [f64; Stage::COUNT],
}

/// The output of `--json` for a screenshot.
#[derive(serde::Serialize)]
struct ScreenshotReport<'a> {
    #[serde(flatten)]
    machine: Machine,
    size: [u32; 2],
    /// The command that renders the same picture.
    command: String,
    output: &'a Path,
}

/// A viewer.
pub struct Viewer {
    pub job: RenderJob,
    pub settings: Settings,
    pub timing: Option<Timing>,
    /// Whether the panel has changed the lights.
    pub has_own_lights: bool,
    /// Whether the panel has changed the ambient light or the background.
    pub has_own_colors: bool,
    options: Common,
    /// The options that the command of a screenshot repeats.
    passed_on: Vec<String>,
    output: PathBuf,
    console: Console,
    backends: Vec<Engine>,
    current: usize,
    /// The window's device.
    window: Option<(wgpu::Device, wgpu::Queue)>,
    controls: Controls,
    start: Camera,
    /// Whether the camera is that of the scene.
    is_at_start: bool,
    /// The time of the animation, seconds; none at rest.
    time: Option<f64>,
    is_playing: bool,
    size: [u32; 2],
    pace: Pace,
    /// Whether every picture has full detail.
    is_exact: bool,
    changes: u64,
    /// The time since the last change, seconds.
    still: f64,
    before: Option<Wanted>,
    /// The inputs of the current picture, and of the last requested one.
    drawn: Option<Wanted>,
    given: Option<Wanted>,
    picture: Picture,
    shown: Option<DebugImage>,
    message: Option<(String, f64)>,
    failure: Option<Error>,
    pub is_closed: bool,
}

impl Viewer {
    /// Loads the scene and opens the backend.
    pub fn new(options: &options::ViewOptions) -> Result<Self, Error> {
        let common = options.common.clone();
        let console = Console::new(common.talk, 2);
        let mut job = RenderJob::load(&common, SAMPLES, false, common.start(), &console)?;
        let mut backend = Engine::open(&common.backend, options.hybrid, &console)?;
        job.expose(backend.backend(), &console)?;
        console.finish();
        Ok(Self {
            settings: Settings {
                samples: job.samples,
                shadows: job.shadows,
                layers: job.layers,
                exposure: job.exposure,
                tone_map: job.tone_map,
                hybrid: options.hybrid,
                debug: None,
                fps: options.fps,
                help: false,
                timing: false,
                panel: false,
            },
            timing: None,
            has_own_lights: false,
            has_own_colors: false,
            output: options.output.clone(),
            console,
            backends: vec![backend],
            current: 0,
            window: None,
            controls: Controls::default(),
            start: job.camera,
            is_at_start: true,
            time: common.start(),
            is_playing: false,
            size: job.size,
            pace: Pace::default(),
            is_exact: options.replay.is_some(),
            changes: 0,
            still: 0.0,
            before: None,
            drawn: None,
            given: None,
            picture: Picture::default(),
            shown: None,
            message: None,
            failure: None,
            is_closed: false,
            options: common,
            passed_on: reproduce::passed_on(arguments::expanded(std::env::args_os())?),
            job,
        })
    }

    /// The error that ends the viewer.
    pub fn failure(&mut self) -> Option<Error> {
        self.failure.take()
    }

    /// Prints a message.
    pub fn announce(&self, line: impl std::fmt::Display) {
        self.console.say(line);
    }

    /// Prints a warning about the window.
    pub fn warn(&self, warning: impl std::fmt::Display) -> Result<(), Error> {
        self.console.warn(4, warning)
    }

    /// The backend that renders.
    pub fn machine(&self) -> &Machine {
        self.engine().machine()
    }

    /// Whether a GPU renders.
    pub fn is_gpu(&self) -> bool {
        self.engine().is_gpu()
    }

    /// Whether the next picture takes longer than later ones, because shaders are compiled.
    pub fn is_cold(&self) -> bool {
        self.is_gpu() && !self.engine().is_warm
    }

    fn engine(&self) -> &Engine {
        &self.backends[self.current]
    }

    /// The path of the scene.
    pub fn scene(&self) -> &Path {
        &self.options.scene
    }

    /// The current message.
    pub fn message(&self) -> Option<&str> {
        self.message.as_ref().map(|(text, _)| text.as_str())
    }

    /// The legend of a debug view.
    pub fn legend(&self) -> Option<&str> {
        self.shown.as_ref().and_then(|shown| shown.legend.as_deref())
    }

    /// The time of the animation, and its end.
    pub fn time(&self) -> Option<(f64, f64)> {
        self.time.zip(self.job.end())
    }

    /// Shares the device of the window.
    pub fn share(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) {
        self.backends.iter_mut().for_each(|backend| backend.share(device, queue, &self.console));
        self.window = Some((device.clone(), queue.clone()));
    }

    /// Changes the size of the picture.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.size = size;
    }

    /// Notes a change of the scene.
    pub fn touch(&mut self) {
        self.changes += 1;
    }

    /// Handles an event.
    pub fn handle(&mut self, event: &Event, free: Free) {
        let mut rig = self.rig();
        let action = self.controls.handle(event, free, &mut rig);
        self.look(rig.camera);
        if let Some(action) = action {
            let done = self.act(action);
            self.note(done);
        }
    }

    /// Advances the time.
    pub fn advance(&mut self, seconds: f64) {
        let mut rig = self.rig();
        self.controls.advance(seconds, &mut rig);
        self.look(rig.camera);
        if let (true, Some(end)) = (self.is_playing, self.job.end()) {
            let time = self.time.map_or(0.0, |time| time + seconds);
            let played = self.play(if time > end { 0.0 } else { time });
            self.note(played);
        }
        self.message =
            self.message.take().filter(|(_, rest)| *rest > 0.0).map(|(text, rest)| (text, rest - seconds));
        let now = Some(self.wanted(self.full()));
        self.still = if now == self.before { self.still + seconds } else { 0.0 };
        self.before = now;
    }

    /// Whether the picture may change without an event.
    pub fn is_busy(&self) -> bool {
        self.is_playing || self.controls.is_busy() || self.still < SETTLE || self.message.is_some()
    }

    /// The next picture, if it differs from the last requested one.
    pub fn next(&mut self) -> Option<Wanted> {
        let full = self.full();
        let detail = if self.is_exact || self.still >= SETTLE {
            full
        } else {
            self.pace.detail(full, 1e3 / self.settings.fps)
        };
        let wanted = self.wanted(detail);
        // A failed picture is not tried again.
        (self.given.replace(wanted) != Some(wanted)).then_some(wanted)
    }

    /// Loads the scene again, or another one. On a failure the scene does not change.
    pub fn load(&mut self, scene: Option<PathBuf>) {
        let is_other = scene.is_some();
        let mut options = self.options.clone();
        if let Some(scene) = scene {
            options.scene = scene;
            // These options belong to the previous scene.
            options.camera = options::CameraOptions::default();
            (options.time, options.animation) = (None, None);
        }
        let engine = &mut self.backends[self.current];
        let job = RenderJob::load(&options, SAMPLES, false, options.start(), &self.console);
        let job = job.and_then(|mut job| job.expose(engine.backend(), &self.console).map(|()| job));
        self.console.finish();
        match job {
            Ok(job) => {
                let camera = self.job.camera;
                self.start = job.camera;
                if options.exposure == Exposure::Auto {
                    self.settings.exposure = job.exposure;
                }
                self.job = job;
                self.options = options;
                (self.time, self.is_playing) = (self.options.start(), false);
                (self.has_own_lights, self.has_own_colors) = (false, false);
                self.is_at_start |= is_other;
                if !self.is_at_start {
                    self.job.camera = camera;
                }
                self.touch();
                self.say(format!("loaded {}", self.scene().display()));
            }
            Err(error) => self.note(Err(error)),
        }
    }

    fn act(&mut self, action: Action) -> Result<(), Error> {
        let settings = &mut self.settings;
        match action {
            Action::Help => settings.help = !settings.help,
            Action::Timing => settings.timing = !settings.timing,
            Action::Panel => settings.panel = !settings.panel,
            Action::Debug(view) => settings.debug = view,
            Action::Play => match self.job.end() {
                Some(_) => self.is_playing = !self.is_playing,
                None => self.say("nothing in the scene is animated".into()),
            },
            Action::Reset => {
                self.is_playing = false;
                if self.time.is_some() {
                    self.play(self.options.time.unwrap_or(0.0))?;
                }
                self.job.camera = self.start;
                self.is_at_start = true;
            }
            Action::Backend => self.switch()?,
            Action::Screenshot => self.screenshot()?,
            Action::Open(path) => self.load(Some(path)),
            Action::Close => self.is_closed = true,
        }
        Ok(())
    }

    /// Shows the scene at a time of its animation.
    fn play(&mut self, time: f64) -> Result<(), Error> {
        let camera = self.job.camera;
        self.time = Some(time);
        let played = self.job.play(time);
        // The animation moves the camera until a person does.
        let leads = self.is_at_start && self.job.has_cameras();
        if !leads {
            self.job.camera = camera;
        }
        self.touch();
        if played.is_err() {
            self.is_playing = false;
        }
        played
    }

    /// Switches to the other backend, and opens it the first time.
    fn switch(&mut self) -> Result<(), Error> {
        if self.backends.len() == 1 {
            let mut options = self.options.backend.clone();
            options.backend = if self.machine().kind() == "cpu" { Choice::Gpu } else { Choice::Cpu };
            let hybrid = options.backend == Choice::Gpu && self.settings.hybrid;
            let mut backend = Engine::open(&options, hybrid, &self.console)?;
            if let Some((device, queue)) = &self.window {
                backend.share(device, queue, &self.console);
            }
            self.backends.push(backend);
        }
        self.current = (self.current + 1) % self.backends.len();
        self.pace = Pace::default();
        self.say(format!("backend: {}", self.machine()));
        Ok(())
    }

    /// Writes the picture at full detail, and prints the command that renders it.
    fn screenshot(&mut self) -> Result<(), Error> {
        let path = self.free_name();
        output::check(&path)?;
        let full = self.full();
        self.draw(self.wanted(full))?;
        let bytes = png(&self.pixels(), full.size, Rgba8).map_err(encode(&path))?;
        output::write(&path, &bytes)?;
        let shot = Shot {
            common: &self.options,
            passed_on: &self.passed_on,
            request: self.job.request(self.settings.debug.is_some()),
            origin: self.job.origin,
            time: self.time,
            hybrid: self.is_hybrid(),
            debug: self.settings.debug,
            lights: self.has_own_lights.then(|| self.job.scene.lights()),
            colors: self.has_own_colors.then_some((self.job.scene.ambient, self.job.scene.background)),
            environment: self.job.surrounded.has_environment.then(|| EnvironmentShot::new(&self.job)),
        };
        let command = reproduce::command(&shot, &path);
        if self.options.json {
            let machine = self.machine().clone();
            self.console.print(output::json(&ScreenshotReport {
                machine,
                size: full.size,
                command,
                output: &path,
            })?)?;
        } else {
            self.console.print(command)?;
        }
        self.say(format!("written: {}", path.display()));
        Ok(())
    }

    /// The first unused name for a picture, if the name has a number.
    fn free_name(&self) -> PathBuf {
        if !is_numbered(&self.output) {
            return filled(&self.output, &self.options.scene, "camera", 0);
        }
        let mut names = (0..10_000).map(|number| filled(&self.output, &self.options.scene, "camera", number));
        names.find(|name| !name.exists()).unwrap_or_else(|| self.output.clone())
    }

    /// Exposes the picture as the scene wants to be from here.
    pub fn meter(&mut self) {
        let metered = self.job.meter(self.backends[self.current].backend());
        self.settings.exposure = self.job.exposure;
        self.note(metered);
    }

    fn look(&mut self, camera: Camera) {
        if camera != self.job.camera {
            self.job.camera = camera;
            self.is_at_start = false;
        }
    }

    fn rig(&self) -> Rig {
        let (low, high) = self.job.scene.extent().unwrap_or_default();
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let radius = ((high - low) * 0.5).length();
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let center: DVec3 = (low + high) * 0.5;
        Rig { camera: self.job.camera, scene: (center, radius), size: self.size }
    }

    fn full(&self) -> Detail {
        Detail { size: self.size, samples: self.settings.samples }
    }

    fn wanted(&self, detail: Detail) -> Wanted {
        let Settings { shadows, layers, exposure, tone_map, debug, .. } = self.settings;
        Wanted {
            camera: self.job.camera,
            detail,
            shadows,
            layers,
            exposure,
            tone_map,
            hybrid: self.is_hybrid(),
            debug,
            backend: self.current,
            changes: self.changes,
        }
    }

    fn is_hybrid(&self) -> bool {
        self.settings.hybrid && self.is_gpu()
    }

    /// Notes an error: a replay ends, otherwise a message shows it.
    fn note(&mut self, done: Result<(), Error>) {
        let Err(error) = done else { return };
        if self.is_exact {
            self.failure.get_or_insert(error);
            return;
        }
        self.console.say(format_args!("error: {error}"));
        self.say(format!("error: {error}"));
    }

    fn say(&mut self, text: String) {
        self.message = Some((text, MESSAGE));
    }
}
