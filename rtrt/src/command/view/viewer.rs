//! What is looked at, and how: everything about a viewer but its window.

mod draw;

use super::controls::{Action, Controls, Free, Rig};
use super::engine::Engine;
use super::input::Event;
use super::pace::{Detail, Pace};
use super::reproduce::{self, Shot};
use crate::command::Error;
use crate::command::console::Console;
use crate::command::job::RenderJob;
use crate::command::names::{filled, is_numbered};
use crate::command::options::{self, Common};
use crate::command::output::{self, png};
use crate::command::render::{SAMPLES, encode};
use crate::command::report::Machine;
use glam::DVec3;
use image::ExtendedColorType::Rgba8;
use rtrt::choose::Choice;
use rtrt::debug::{DebugImage, DebugView};
use rtrt_core::backend::{Picture, STAGES, Shadows};
use rtrt_core::scene::Camera;
use std::path::{Path, PathBuf};

/// How long nothing must change before a picture is rendered as fine as it gets, seconds.
const SETTLE: f64 = 0.2;
/// How long a message is shown, seconds.
const MESSAGE: f64 = 6.0;

/// What a person chooses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    pub samples: u32,
    pub shadows: Shadows,
    pub layers: u32,
    /// Whether a GPU draws what the camera sees.
    pub hybrid: bool,
    /// What is shown instead of the picture.
    pub debug: Option<DebugView>,
    /// Frames a second that are worth fewer rays.
    pub fps: f64,
    pub help: bool,
    pub timing: bool,
    pub panel: bool,
}

/// All that a picture depends on, the scene by the number of its changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    camera: Camera,
    pub detail: Detail,
    shadows: Shadows,
    layers: u32,
    hybrid: bool,
    debug: Option<DebugView>,
    backend: usize,
    changes: u64,
}

/// How long the picture on the screen took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    pub detail: Detail,
    /// Wall clock, milliseconds, readback included where there is one.
    pub frame_ms: f64,
    pub stages_ms: [f64; STAGES.len()],
}

/// What `--json` prints of a screenshot.
#[derive(serde::Serialize)]
struct ScreenshotReport<'a> {
    #[serde(flatten)]
    machine: Machine,
    size: [u32; 2],
    /// What renders the same without a window.
    command: String,
    output: &'a Path,
}

/// A viewer.
pub struct Viewer {
    pub job: RenderJob,
    pub settings: Settings,
    pub timing: Option<Timing>,
    /// The lights are no longer those that the scene and the options give.
    pub has_own_lights: bool,
    /// Neither are the ambient light and the background.
    pub has_own_colors: bool,
    options: Common,
    /// Options for a command that renders the same.
    passed_on: Vec<String>,
    output: PathBuf,
    console: Console,
    backends: Vec<Engine>,
    current: usize,
    /// The window's device.
    window: Option<(wgpu::Device, wgpu::Queue)>,
    controls: Controls,
    start: Camera,
    /// Whether the camera is where the scene has it.
    is_at_start: bool,
    /// When, of the animation, if it was played; seconds.
    time: Option<f64>,
    is_playing: bool,
    size: [u32; 2],
    pace: Pace,
    /// Whether every picture has full detail, however long it takes.
    is_exact: bool,
    changes: u64,
    /// Since when nothing has changed, seconds.
    still: f64,
    before: Option<Wanted>,
    /// What the picture is of, and the one that was given out last.
    drawn: Option<Wanted>,
    given: Option<Wanted>,
    picture: Picture,
    shown: Option<DebugImage>,
    message: Option<(String, f64)>,
    failure: Option<Error>,
    pub is_closed: bool,
}

impl Viewer {
    /// Loads the scene, and opens the backend.
    pub fn new(options: &options::ViewOptions) -> Result<Self, Error> {
        let common = options.common.clone();
        let console = Console::new(common.talk, 2);
        let job = RenderJob::load(&common, SAMPLES, false, common.start(), &console)?;
        let backend = Engine::open(&common.backend, options.hybrid, &console)?;
        console.finish();
        Ok(Self {
            settings: Settings {
                samples: job.samples,
                shadows: job.shadows,
                layers: job.layers,
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
            passed_on: reproduce::passed_on(std::env::args_os()),
            job,
        })
    }

    /// What failed, and ends the viewer.
    pub fn failure(&mut self) -> Option<Error> {
        self.failure.take()
    }

    /// Says something that is no result.
    pub fn announce(&self, line: impl std::fmt::Display) {
        self.console.say(line);
    }

    /// Says what is not as it should be with what the window needs.
    pub fn warn(&self, warning: impl std::fmt::Display) -> Result<(), Error> {
        self.console.warn(4, warning)
    }

    /// The backend that renders.
    pub fn machine(&self) -> &Machine {
        self.engine().machine()
    }

    /// Whether a GPU renders, which can draw.
    pub fn is_gpu(&self) -> bool {
        self.engine().is_gpu()
    }

    /// Whether a picture takes longer to come than the following ones.
    pub fn is_cold(&self) -> bool {
        self.is_gpu() && !self.engine().is_warm
    }

    fn engine(&self) -> &Engine {
        &self.backends[self.current]
    }

    /// The scene that was loaded last.
    pub fn scene(&self) -> &Path {
        &self.options.scene
    }

    /// What is to be said at the moment.
    pub fn message(&self) -> Option<&str> {
        self.message.as_ref().map(|(text, _)| text.as_str())
    }

    /// What the colors of a debug view stand for.
    pub fn legend(&self) -> Option<&str> {
        self.shown.as_ref().and_then(|shown| shown.legend.as_deref())
    }

    /// When, of the animation, and when it ends.
    pub fn time(&self) -> Option<(f64, f64)> {
        self.time.zip(self.job.end())
    }

    /// There is a window, on this device.
    pub fn share(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) {
        self.backends.iter_mut().for_each(|backend| backend.share(device, queue, &self.console));
        self.window = Some((device.clone(), queue.clone()));
    }

    /// The picture has another size.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.size = size;
    }

    /// The scene has changed.
    pub fn touch(&mut self) {
        self.changes += 1;
    }

    /// Lets events happen.
    pub fn handle(&mut self, event: &Event, free: Free) {
        let mut rig = self.rig();
        let action = self.controls.handle(event, free, &mut rig);
        self.look(rig.camera);
        if let Some(action) = action {
            let done = self.act(action);
            self.note(done);
        }
    }

    /// Lets time pass.
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
            self.message.take().filter(|(_, left)| *left > 0.0).map(|(text, left)| (text, left - seconds));
        let now = Some(self.wanted(self.full()));
        self.still = if now == self.before { self.still + seconds } else { 0.0 };
        self.before = now;
    }

    /// Whether time has to go on for something to happen.
    pub fn is_busy(&self) -> bool {
        self.is_playing || self.controls.is_busy() || self.still < SETTLE || self.message.is_some()
    }

    /// The picture that is to be seen next, if it is another one.
    pub fn next(&mut self) -> Option<Wanted> {
        let full = self.full();
        let detail = if self.is_exact || self.still >= SETTLE {
            full
        } else {
            self.pace.detail(full, 1e3 / self.settings.fps)
        };
        let wanted = self.wanted(detail);
        // Once, whatever comes of it: what fails is not tried again and again.
        (self.given.replace(wanted) != Some(wanted)).then_some(wanted)
    }

    /// Loads the scene again, or another one. If that fails, the scene stays as it is.
    pub fn load(&mut self, scene: Option<PathBuf>) {
        let is_other = scene.is_some();
        let mut options = self.options.clone();
        if let Some(scene) = scene {
            options.scene = scene;
            // These were for the scene before.
            options.camera = options::CameraOptions::default();
            (options.time, options.animation) = (None, None);
        }
        let job = RenderJob::load(&options, SAMPLES, false, options.start(), &self.console);
        self.console.finish();
        match job {
            Ok(job) => {
                let camera = self.job.camera;
                self.start = job.camera;
                self.job = job;
                self.options = options;
                (self.time, self.is_playing) = (self.options.start(), false);
                (self.has_own_lights, self.has_own_colors) = (false, false);
                self.is_at_start |= is_other;
                if !self.is_at_start {
                    self.job.look(camera);
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
                self.job.look(self.start);
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
        // A camera that is part of the animation leads until it is moved by hand.
        let leads = self.is_at_start && self.job.has_cameras();
        self.job.look(if leads { self.job.camera } else { camera });
        self.touch();
        if played.is_err() {
            self.is_playing = false;
        }
        played
    }

    /// Goes on with the other backend, which is opened the first time.
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

    /// Writes what is seen, at full detail, and prints how to get the same without a window.
    fn screenshot(&mut self) -> Result<(), Error> {
        let path = self.free_name();
        output::check(&path)?;
        let full = self.full();
        self.draw(self.wanted(full))?;
        let bytes = png(self.pixels(), full.size, Rgba8).map_err(encode(&path))?;
        output::write(&path, &bytes)?;
        let shot = Shot {
            common: &self.options,
            passed_on: &self.passed_on,
            request: self.job.request(self.settings.debug.is_some()),
            time: self.time,
            hybrid: self.is_hybrid(),
            debug: self.settings.debug,
            lights: self.has_own_lights.then(|| self.job.scene.lights()),
            colors: self.has_own_colors.then_some((self.job.scene.ambient, self.job.scene.background)),
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

    /// The first name for a picture that no file has, if the name may change.
    fn free_name(&self) -> PathBuf {
        if !is_numbered(&self.output) {
            return filled(&self.output, &self.options.scene, 0);
        }
        let mut names = (0..10_000).map(|number| filled(&self.output, &self.options.scene, number));
        names.find(|name| !name.exists()).unwrap_or_else(|| self.output.clone())
    }

    fn look(&mut self, camera: Camera) {
        if camera != self.job.camera {
            self.job.look(camera);
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
        let Settings { shadows, layers, debug, .. } = self.settings;
        let (camera, backend, changes) = (self.job.camera, self.current, self.changes);
        Wanted { camera, detail, shadows, layers, hybrid: self.is_hybrid(), debug, backend, changes }
    }

    fn is_hybrid(&self) -> bool {
        self.settings.hybrid && self.is_gpu()
    }

    /// Takes note of what did not work: a person may go on, a replay ends.
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
