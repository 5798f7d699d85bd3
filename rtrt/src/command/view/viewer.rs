//! The viewer without its window.

mod draw;
mod engines;
mod files;
mod loader;
mod pick;
mod shot;
mod time;

use super::controls::{Action, Controls, DOUBLE, Free, Rig};
use super::engine::Engine;
use super::input::Event;
use super::motion::Mode;
use super::pace::{Detail, Pace};
use super::recent::Recent;
use super::reproduce;
use super::shots::Shots;
use crate::command::Error;
use crate::command::arguments;
use crate::command::console::Console;
use crate::command::job::RenderJob;
use crate::command::options::{self, Common};
use crate::command::parse::Environment;
use crate::command::render::SAMPLES;
use crate::command::report::Machine;
pub use draw::Rendered;
use engines::Engines;
pub use engines::Waker;
pub use files::named;
use glam::DVec3;
use loader::{Loading, Opening};
pub use pick::{Selection, textures};
use rtrt::debug::{DebugImage, DebugView};
use rtrt_core::backend::{Picture, Shadows, ToneMap};
use rtrt_core::query::Tree;
use rtrt_core::scene::{Camera, Material, Projection, Sequential, Setup};
use rtrt_core::schedule::Stage;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The time without a change after which a picture is refined, seconds.
const SETTLE: f64 = 0.08;
/// The longest time between steps while a message is shown, seconds.
const TICK: f64 = 0.1;
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
    /// The list of objects.
    pub objects: bool,
    pub axes: bool,
    pub grid: bool,
    pub full_screen: bool,
    /// The speed of the animation; 1 is that of the file.
    pub speed: f64,
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
    is_gpu: bool,
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

/// What lies over the picture, without figures, which change all the time.
#[derive(Debug, PartialEq)]
pub struct Over {
    settings: Settings,
    message: Option<String>,
    legend: Option<String>,
    selection: Option<Selection>,
    shows_selection: bool,
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
    /// What is selected.
    pub selection: Option<Selection>,
    /// For how long, seconds.
    selected_for: f64,
    /// The trees that find what a ray hits.
    tree: Tree,
    /// The scene of which there are trees: its [`Scene::id`](rtrt_core::scene::Scene::id).
    tree_of: Option<u32>,
    /// Materials that the panel has changed, as they were before.
    unpainted: BTreeMap<u32, Material>,
    /// The files that were opened last.
    recent: Recent,
    /// The scene that is being loaded, the one that is to follow, and the environment that waits to be opened.
    loading: Option<Loading>,
    opening: Option<Opening>,
    surrounding: Option<Environment>,
    options: Common,
    /// The options that the command of a screenshot repeats.
    passed_on: Vec<String>,
    output: PathBuf,
    console: Arc<Console>,
    engines: Engines,
    shots: Shots,
    /// Wakes the window.
    waker: Waker,
    controls: Controls,
    start: Camera,
    /// Whether the camera is that of the scene.
    is_at_start: bool,
    /// The time of the animation, seconds; none at rest.
    time: Option<f64>,
    is_playing: bool,
    size: [u32; 2],
    pace: Pace,
    /// Whether every picture has full detail at once: a replay has no clock.
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
    /// What draws the window, in words.
    pub drawn_by: String,
}

impl Viewer {
    /// Loads the scene and opens the backend.
    pub fn new(options: &options::ViewOptions, waker: Waker, shots: Shots) -> Result<Self, Error> {
        let is_exact = options.replay.is_some() && !options.live;
        let common = options.common.clone();
        let console = Arc::new(Console::new(common.talk, 2));
        let mut job = RenderJob::load(&common, SAMPLES, false, common.start(), &console)?;
        let mut tree = Tree::default();
        // While a backend opens, so that the first press finds them.
        let mut engines = std::thread::scope(|scope| {
            if !is_exact {
                scope.spawn(|| pick::grow(&mut tree, &job.scene, &console));
            }
            Engines::open(&common.backend, options.hybrid, !is_exact, &console)
        })?;
        job.expose(engines.drawing_mut().backend(), &console)?;
        console.finish();
        let mut viewer = Self {
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
                objects: false,
                axes: false,
                grid: false,
                full_screen: false,
                speed: 1.0,
            },
            timing: None,
            has_own_lights: false,
            has_own_colors: false,
            selection: None,
            selected_for: 0.0,
            tree,
            tree_of: (!is_exact).then(|| job.scene.id()),
            unpainted: BTreeMap::new(),
            recent: Recent::read(),
            loading: None,
            opening: None,
            surrounding: None,
            output: options.output.clone(),
            console,
            engines,
            shots,
            waker,
            controls: Controls::default(),
            start: job.camera,
            is_at_start: true,
            time: common.start(),
            is_playing: false,
            size: job.size,
            pace: Pace::default(),
            is_exact,
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
            drawn_by: String::new(),
            options: common,
            passed_on: reproduce::passed_on(arguments::expanded(std::env::args_os())?),
            job,
        };
        if !viewer.is_exact {
            viewer.say("H: keys".into());
        }
        viewer.remember();
        Ok(viewer)
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
        self.engines.drawing().machine()
    }

    /// Whether a GPU renders.
    pub fn is_gpu(&self) -> bool {
        self.engines.drawing().is_gpu()
    }

    fn engine(&mut self) -> &mut Engine {
        self.engines.drawing_mut()
    }

    /// The path of the scene.
    pub fn scene(&self) -> &Path {
        &self.options.scene
    }

    /// The current message.
    pub fn message(&self) -> Option<Cow<'_, str>> {
        let said = self.message.as_ref().map(|(text, _)| text.into());
        said.or_else(|| self.loading.as_ref().map(|loading| format!("opening {}", loading.name).into()))
            .or_else(|| self.shots.in_progress().map(|path| format!("rendering {}", path.display()).into()))
            .or_else(|| {
                let compiles = "a GPU compiles shaders; the CPU draws meanwhile";
                self.engines.is_getting_ready().then_some(compiles.into())
            })
    }

    /// The name of the debug view that is shown, and what its colors mean.
    pub fn legend(&self) -> Option<String> {
        let shown = self.shown.as_ref()?;
        let view = self.drawn?.debug?;
        let name = DebugView::ALL.iter().find(|(_, known)| *known == view).map_or("", |(name, _)| *name);
        let meaning = view.meaning();
        let scale = shown.legend.as_ref().map_or(String::new(), |scale| format!("; {scale}"));
        Some(format!("{name}: {meaning}{scale}"))
    }

    /// What is to lie over the picture.
    pub fn over(&self) -> Over {
        Over {
            settings: self.settings,
            message: self.message().map(Cow::into_owned),
            legend: self.legend(),
            selection: self.selection.clone(),
            shows_selection: self.shows_selection(),
        }
    }

    /// Shares the device of the window.
    pub fn share(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) {
        self.engines.share(device, queue, &self.console);
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
        let (camera, action) = self.with_rig(|controls, rig| controls.handle(event, free, rig));
        self.look(camera);
        if let Some(action) = action {
            let done = self.act(action);
            self.note(done);
        }
    }

    /// Advances the time. Returns whether the inputs of the picture have changed.
    pub fn advance(&mut self, seconds: f64) -> bool {
        let (camera, ()) = self.with_rig(|controls, rig| controls.advance(seconds, rig));
        self.look(camera);
        self.take_shots();
        self.take_loaded();
        if let (true, Some(end)) = (self.is_playing, self.job.end()) {
            let time = self.time.map_or(0.0, |time| time + seconds * self.settings.speed);
            let played = self.play(if time > end { 0.0 } else { time });
            self.note(played);
        }
        self.take_ready();
        self.selected_for += seconds;
        self.message =
            self.message.take().filter(|(_, rest)| *rest > 0.0).map(|(text, rest)| (text, rest - seconds));
        let now = Some(self.wanted(self.full()));
        let is_changed = now != self.before;
        self.still = if is_changed { 0.0 } else { self.still + seconds };
        self.before = now;
        is_changed
    }

    /// Switches to a GPU that has compiled its shaders, or has it begin to.
    fn take_ready(&mut self) {
        match self.engines.take_ready() {
            Ok(false) => {}
            Ok(true) => {
                self.pace = Pace::default();
                self.say(format!("backend: {}", self.machine()));
            }
            Err(source) => self.note(Err(Error::Render { scene: self.scene().to_owned(), source })),
        }
        if self.engines.is_cold() {
            let begun = self.switch();
            self.note(begun);
        }
    }

    /// The seconds until the picture may change without an event.
    pub fn due(&self) -> Option<f64> {
        let settles = (self.still < SETTLE).then_some(SETTLE - self.still);
        let ticks = self.message.as_ref().map(|_| TICK);
        let appears = self.selection.as_ref().map(|_| DOUBLE - self.selected_for);
        // No longer than a step may be.
        let appears = appears.filter(|rest| *rest > 0.0).map(|rest| rest.min(TICK));
        let moves = self.moves().then_some(0.0);
        // A thread wakes the window a moment before it ends.
        let arrives = (self.is_loading() || self.engines.is_getting_ready()).then_some(TICK);
        [moves, settles, ticks, appears, arrives].into_iter().flatten().reduce(f64::min)
    }

    /// Whether something moves without an event.
    pub fn moves(&self) -> bool {
        self.is_playing || self.controls.is_busy()
    }

    /// The next picture, if it differs from the last requested one.
    pub fn next(&mut self) -> Option<Wanted> {
        let full = self.full();
        let now = self.wanted(full);
        let shown = self.given.filter(|given| Wanted { detail: full, ..*given } == now);
        let detail = if self.is_exact {
            full
        } else if self.still < SETTLE {
            match shown {
                Some(shown) => shown.detail,
                None => self.pace.detail(full, 1e3 / self.settings.fps),
            }
        } else {
            self.pace.refined(full, shown.map(|shown| shown.detail))
        };
        let wanted = self.wanted(detail);
        // A failed picture is not tried again.
        (self.given.replace(wanted) != Some(wanted)).then_some(wanted)
    }

    /// Whether there is work for the time in which nothing is to be drawn.
    pub fn has_spare_work(&self) -> bool {
        !self.is_exact && self.is_settled() && !self.has_trees()
    }

    /// Whether the trees of the scene are there.
    fn has_trees(&self) -> bool {
        self.tree_of == Some(self.job.scene.id())
    }

    /// Builds the trees that find what a ray hits, until `stop` is true.
    pub fn work(&mut self, stop: &AtomicBool) {
        if self.tree.update_until(&*self.job.scene, &Sequential, stop) {
            self.tree_of = Some(self.job.scene.id());
        }
    }

    /// Whether nothing has changed for so long that pictures are refined.
    pub fn is_settled(&self) -> bool {
        self.still >= SETTLE
    }

    /// Whether a picture has all pixels.
    pub fn is_sharp(&self, wanted: &Wanted) -> bool {
        wanted.detail.size == self.size
    }

    /// Records the time of a frame outside of rendering, milliseconds.
    pub fn presented(&mut self, rest_ms: f64) {
        self.pace.presented(rest_ms);
    }

    fn act(&mut self, action: Action) -> Result<(), Error> {
        let settings = &mut self.settings;
        match action {
            Action::Help => settings.help = !settings.help,
            Action::Timing => settings.timing = !settings.timing,
            Action::Panel => settings.panel = !settings.panel,
            Action::Debug(view) => settings.debug = view,
            Action::Objects => settings.objects = !settings.objects,
            Action::Axes => settings.axes = !settings.axes,
            Action::Grid => settings.grid = !settings.grid,
            Action::FullScreen => settings.full_screen = !settings.full_screen,
            Action::Play => self.toggle_play(),
            Action::Step(seconds) => self.step(seconds)?,
            Action::Select(place) => self.select_at(place),
            Action::Frame => self.frame(),
            Action::Hide => self.hide_selection()?,
            Action::ShowAll => self.show_all()?,
            Action::File(places) => self.open_beside(places),
            Action::Say(text) => self.say(text),
            Action::Reset => {
                self.is_playing = false;
                if self.time.is_some() {
                    self.play(self.options.time.unwrap_or(0.0))?;
                }
                self.job.camera = self.start;
                (self.is_at_start, self.controls.pivot) = (true, None);
            }
            Action::Backend => self.switch()?,
            Action::Screenshot => self.screenshot()?,
            Action::Open(path) => self.open(path),
            Action::Close => self.is_closed = true,
        }
        Ok(())
    }

    /// Switches to the other backend, and opens it the first time. While a GPU compiles, the CPU draws on.
    fn switch(&mut self) -> Result<(), Error> {
        let hybrid = self.settings.hybrid;
        let switched = if self.is_exact {
            self.engines.switch(hybrid, &self.console).map(|()| true)
        } else {
            let mut setup = Setup::default();
            let prepared = setup.prepare(&self.job.scene, &self.job.request(self.settings.debug.is_some()));
            prepared
                .map_err(|source| Error::Render { scene: self.scene().to_owned(), source: source.into() })?;
            let waker = Waker::clone(&self.waker);
            self.engines.switch_when_ready(hybrid, &setup.frame, &self.console, waker)
        };
        if switched? {
            self.pace = Pace::default();
            self.say(format!("backend: {}", self.machine()));
        }
        Ok(())
    }

    /// Exposes the picture as the scene wants to be from here.
    pub fn meter(&mut self) {
        let metered = self.job.meter(self.engines.drawing_mut().backend());
        self.settings.exposure = self.job.exposure;
        self.note(metered);
    }

    fn look(&mut self, camera: Camera) {
        if camera != self.job.camera {
            self.job.camera = camera;
            self.is_at_start = false;
        }
    }

    /// Has controls move the camera. Returns where it then is.
    fn with_rig<T>(&mut self, act: impl FnOnce(&mut Controls, &mut Rig<'_>) -> T) -> (Camera, T) {
        let Self { controls, job, tree, size, .. } = self;
        let (low, high) = job.scene.extent().unwrap_or_default();
        let mut surface = |origin, direction| {
            pick::nearest(tree, &job.scene, origin, direction).map(|hit| f64::from(hit.t))
        };
        let mut rig = Rig {
            camera: job.camera,
            extent: (low.as_dvec3(), high.as_dvec3()),
            size: *size,
            surface: &mut surface,
        };
        let done = act(controls, &mut rig);
        (rig.camera, done)
    }

    /// Changes how the camera projects.
    pub fn set_projection(&mut self, projection: Projection) {
        self.look(Camera { projection, ..self.job.camera });
    }

    /// The point around which a drag turns the camera.
    pub fn turns_around(&self) -> Option<DVec3> {
        self.controls.turns_around()
    }

    /// What dragging does.
    pub fn mode(&mut self) -> &mut Mode {
        &mut self.controls.mode
    }

    /// Whether what is selected is described. It is not while a second click may follow, since a panel could be in its way.
    pub fn shows_selection(&self) -> bool {
        self.selection.is_some() && self.selected_for >= DOUBLE
    }

    /// The size of the picture, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The files that were opened last.
    pub fn recent(&self) -> &[PathBuf] {
        &self.recent.files
    }

    /// Remembers the scene's file. A replay leaves no trace.
    fn remember(&mut self) {
        if self.is_exact {
            return;
        }
        if let Err(error) = self.recent.add(&self.options.scene) {
            self.console.detail(format_args!("the list of recent files cannot be written: {error}"));
        }
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
            is_gpu: self.is_gpu(),
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
