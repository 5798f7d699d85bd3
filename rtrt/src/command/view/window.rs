//! The window: it queues input events, and runs the frames.

use super::clipboard::Clipboard;
use super::controls::Free;
use super::failure::{panics_caught, reason};
use super::figures::{Figures, Presented, Report};
use super::fullscreen::FullScreen;
use super::input::{Event, Modifiers, Replay, Step, header};
use super::interface::Interface;
use super::live::Live;
use super::screen::Screen;
use super::seen::Seen;
use super::shots::Shots;
use super::system::{Fingers, translated};
use super::viewer::{Over, Rendered, Viewer, Waker, Wanted};
use super::watch::{self, Change, Watch};
use super::{guides, overlay, panel};
use crate::command::Error;
use crate::command::options::ViewOptions;
use crate::command::output;
use egui::style::ScrollStyle;
use egui::{Context, FullOutput, Key, OutputCommand, Popup};
use rtrt::choose::Choice;
use std::fs::File;
use std::io::Write;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

/// The longest time step of a frame, seconds; longer ones would make jumps.
const LONGEST: f32 = 0.1;
/// The usual time step of a frame, seconds.
const FRAME: f32 = 1.0 / 60.0;
/// How long a closed window waits for the frame in progress.
const LEAVES: Duration = Duration::from_millis(50);
/// How long a window waits for its first scene before it opens, so that it opens with a picture, or not at all.
const OPENS: Duration = Duration::from_millis(100);

/// A window of fewer units than these, across and down, has a smaller user interface.
const ROOM: [f32; 2] = [480.0, 300.0];
/// The size of the smallest one, in sizes of the usual one.
const LEAST: f32 = 2.0 / 3.0;

/// What wakes the window.
#[derive(Debug, Clone, Copy)]
pub enum Woken {
    /// The work of this number is finished.
    Work(u32),
    /// Something else is: a backend is ready, a screenshot is written.
    Viewer,
}

/// Where input comes from.
enum Source {
    Person,
    /// A recording, frame by frame.
    Replay(Replay),
    /// A recording at its own speed.
    Live(Live),
}

/// The viewer in its window.
pub struct App {
    /// None while a thread loads the first scene, or works with it.
    viewer: Option<Viewer>,
    in_progress: Option<InProgress>,
    /// The number of the last work.
    works: u32,
    /// Whether the viewer knows the screen.
    is_met: bool,
    shots: Shots,
    /// Times of the whole loop.
    figures: Figures,
    /// Wakes the window when the thread ends.
    proxy: EventLoopProxy<Woken>,
    /// The scene of the title and of the watch.
    scene: PathBuf,
    screen: Option<Screen>,
    /// What is to draw the window.
    draws: Choice,
    context: Context,
    interface: Interface,
    /// The list of objects.
    rows: panel::Rows,
    opened: panel::Opened,
    /// The events since the last frame, with their times.
    events: Vec<(Instant, Event)>,
    fingers: Fingers,
    full_screen: FullScreen,
    /// The text that the last frame showed, for a replay that points at it.
    seen: Seen,
    /// Whether a button of the mouse is held, and which modifiers are.
    is_held: bool,
    modifiers: Modifiers,
    clipboard: Clipboard,
    /// The size of the picture in pixels, and the pixels per unit of the user interface.
    size: [u32; 2],
    scale: f32,
    time: f64,
    last: Instant,
    /// Whether nothing has happened since then.
    is_idle: bool,
    source: Source,
    /// The file of the replay.
    replayed: Option<PathBuf>,
    record: Option<(PathBuf, File)>,
    /// Whether files are watched, and how, once there is a scene.
    watches: bool,
    watch: Option<Watch>,
    /// The time at which the overlay needs the next frame.
    wake: Option<Instant>,
    /// Whether the figures of the loop are printed in the end.
    reports: bool,
    /// Why the viewer ended.
    result: Result<(), Error>,
}

/// The figures of a replay, as `--json` prints them.
#[derive(serde::Serialize)]
struct LoopReport {
    #[serde(rename = "loop")]
    figures: Report,
}

/// Work in progress. The viewer renders on a worker thread; input waits in a queue.
struct InProgress {
    number: u32,
    thread: JoinHandle<Result<(Viewer, Rendered), Error>>,
    /// None if nothing is to be shown afterwards.
    frame: Option<Frame>,
    stop: Arc<AtomicBool>,
    ends: Ends,
}

/// What ends the work of a thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ends {
    /// Any input.
    WithInput,
    /// Escape, in a moment.
    WithEscape,
    /// Nothing: it may last.
    Itself,
}

/// What a frame shows, and when it began.
struct Frame {
    over: FullOutput,
    /// What that shows.
    showed: Over,
    began: Instant,
    /// The picture, if it is a new one.
    wanted: Option<Wanted>,
    is_settled: bool,
}

/// Wakes the window when the thread of this work ends, also by a panic.
struct Wake(EventLoopProxy<Woken>, u32);

impl Drop for Wake {
    fn drop(&mut self) {
        // The window may be closed.
        _ = self.0.send_event(Woken::Work(self.1));
    }
}

impl App {
    /// A viewer without its window, which begins to load its scene.
    pub fn new(
        options: &ViewOptions,
        replay: Option<Replay>,
        proxy: EventLoopProxy<Woken>,
    ) -> Result<Self, Error> {
        let record = options.record.as_ref().map(|path| -> Result<_, Error> {
            let begin = |mut file: File| file.write_all(header().as_bytes()).map(|()| file);
            let refused = |source| Error::Record { path: path.clone(), source };
            Ok((path.clone(), File::create(path).and_then(begin).map_err(refused)?))
        });
        let scene = options.common.scene.clone();
        let context = Context::default();
        // The viewer uses these keys.
        context.options_mut(|options| options.zoom_with_keyboard = false);
        // What can be scrolled shows it.
        context.all_styles_mut(|style| style.spacing.scroll = ScrollStyle::solid());
        let source = match replay {
            None => Source::Person,
            Some(replay) if options.live => Source::Live(Live::new(replay)),
            Some(replay) => Source::Replay(replay),
        };
        let wakes = proxy.clone();
        // The window may be closed.
        let waker: Waker = Arc::new(move || _ = wakes.send_event(Woken::Viewer));
        let mut app = Self {
            watches: options.watch,
            watch: None,
            viewer: None,
            in_progress: None,
            works: 0,
            is_met: false,
            shots: Shots::new(Waker::clone(&waker)),
            figures: Figures::default(),
            proxy,
            screen: None,
            draws: options.window,
            context,
            interface: Interface::default(),
            rows: panel::Rows::default(),
            opened: panel::Opened::default(),
            fingers: Fingers::default(),
            full_screen: FullScreen::default(),
            seen: Seen::default(),
            events: vec![(Instant::now(), Event::Size(options.common.size, 1.0))],
            is_held: false,
            modifiers: Modifiers::default(),
            clipboard: Clipboard::default(),
            size: options.common.size,
            scale: 1.0,
            time: 0.0,
            last: Instant::now(),
            is_idle: true,
            reports: options.common.json && options.replay.is_some(),
            source,
            replayed: options.replay.clone(),
            record: record.transpose()?,
            wake: None,
            result: Ok(()),
            scene,
        };
        let (options, shots) = (options.clone(), app.shots.clone());
        app.spawn(None, Ends::Itself, move |_| {
            Viewer::new(&options, waker, shots).map(|viewer| (viewer, Rendered::Nowhere))
        });
        Ok(app)
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<Screen, String> {
        let [width, height] = self.size;
        let attributes = Window::default_attributes()
            .with_title(title(&self.scene))
            .with_inner_size(PhysicalSize::new(width, height));
        let window = events.create_window(attributes).map_err(|error| reason(&error))?;
        Screen::new(Arc::new(window), events, self.draws)
    }

    /// Takes the screen.
    fn take(&mut self, screen: Screen) -> Result<(), Error> {
        screen.window.request_redraw();
        let scale = screen.window.scale_factor() as f32;
        self.queue(Event::Size(screen.size(), scale));
        self.screen = Some(screen);
        self.meet()
    }

    /// Tells the viewer of its screen, once both are there. A software adapter is a warning.
    fn meet(&mut self) -> Result<(), Error> {
        let (Some(viewer), Some(screen), false) = (&mut self.viewer, &self.screen, self.is_met) else {
            return Ok(());
        };
        self.is_met = true;
        self.watch = self.watches.then(|| Watch::new(&self.scene, viewer.job.files()));
        if let Some((device, queue)) = screen.device() {
            viewer.share(device, queue);
        }
        viewer.drawn_by.clone_from(&screen.drawn_by);
        match &screen.software {
            Some(name) => viewer.warn(format_args!("the window is drawn by a software adapter: {name}")),
            None => Ok(()),
        }
    }

    /// Shows that the first scene is being loaded.
    fn wait(&mut self, events: &ActiveEventLoop) {
        let Some(screen) = self.screen.as_mut().filter(|_| !self.is_met) else { return };
        // A replay begins with its first frame.
        if matches!(self.source, Source::Replay(_)) {
            return;
        }
        let (size, scale) = (screen.size(), screen.window.scale_factor() as f32);
        let input = self.interface.input(&[], (size, readable(size, scale)), (self.time, FRAME));
        let over = self.context.run_ui(input, |ui| overlay::waits(ui.ctx(), &self.scene));
        let shown = screen.show(&self.context, over, size);
        if let Err(why) = shown {
            let scene = self.scene.clone();
            self.end(events, Err(Error::Window { scene, why }));
        }
    }

    /// Runs a frame: events, overlay, picture. Events wait while a frame is in progress.
    fn frame(&mut self, events: &ActiveEventLoop) {
        let Some(mut viewer) = self.viewer.take() else { return self.wait(events) };
        let (began, showed) = (Instant::now(), viewer.over());
        let over = match self.step(&mut viewer) {
            Ok(Some(step)) => self.happen(&mut viewer, &step),
            Ok(None) => return self.end(events, Ok(())),
            Err(error) => return self.end(events, Err(error)),
        };
        let wanted = if viewer.has_to_open() { None } else { viewer.next() };
        let frame = Frame { over, showed, began, wanted, is_settled: viewer.is_settled() };
        let Some(wanted) = wanted else {
            self.figures.unanswered();
            // What a message says is seen before it is done.
            let is_seen = viewer.over() == frame.showed;
            self.finish(events, viewer, frame, Rendered::Nowhere);
            if is_seen {
                self.use_time();
            }
            return;
        };
        self.figures.begins(began);
        let screen = self.screen.as_mut().filter(|_| viewer.is_rendered_in_place(&wanted));
        let texture = screen.and_then(|screen| screen.texture(wanted.detail.size));
        if matches!(self.source, Source::Replay(_)) {
            let rendered = viewer.render(wanted, texture, &AtomicBool::new(false));
            return self.finish(events, viewer, frame, rendered);
        }
        let ends = if frame.is_settled { Ends::WithInput } else { Ends::WithEscape };
        self.work(viewer, Some(frame), ends, move |viewer, stop| viewer.render(wanted, texture, stop));
    }

    /// Has a thread open an environment, or do what can be done while nothing is to be drawn.
    fn use_time(&mut self) {
        let Some(viewer) = self.viewer.take_if(|_| self.screen.is_some()) else { return };
        if viewer.has_to_open() {
            self.work(viewer, None, Ends::Itself, |viewer, _| {
                viewer.open_environment_now();
                Rendered::Nowhere
            });
        } else if viewer.has_spare_work() {
            self.work(viewer, None, Ends::WithInput, |viewer, stop| {
                viewer.work(stop);
                Rendered::Nowhere
            });
        } else {
            self.viewer = Some(viewer);
        }
    }

    /// Has a thread work with the viewer.
    fn work(
        &mut self,
        mut viewer: Viewer,
        frame: Option<Frame>,
        ends: Ends,
        work: impl FnOnce(&mut Viewer, &AtomicBool) -> Rendered + Send + 'static,
    ) {
        self.spawn(frame, ends, move |stop| {
            let rendered = work(&mut viewer, stop);
            Ok((viewer, rendered))
        });
    }

    /// Has a thread work.
    fn spawn(
        &mut self,
        frame: Option<Frame>,
        ends: Ends,
        work: impl FnOnce(&AtomicBool) -> Result<(Viewer, Rendered), Error> + Send + 'static,
    ) {
        self.works = self.works.wrapping_add(1);
        let (number, stop) = (self.works, Arc::new(AtomicBool::new(false)));
        let (wake, flag) = (Wake(self.proxy.clone(), number), Arc::clone(&stop));
        let thread = std::thread::spawn(move || {
            let _wake = wake;
            work(&flag)
        });
        self.in_progress = Some(InProgress { number, thread, frame, stop, ends });
    }

    /// Takes over what a thread has done.
    fn done(&mut self, events: &ActiveEventLoop, InProgress { thread, frame, .. }: InProgress) {
        let done = thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        match (done, frame) {
            (Ok((viewer, rendered)), Some(frame)) => self.finish(events, viewer, frame, rendered),
            (Ok((viewer, _)), None) => {
                self.viewer = Some(viewer);
                if let Err(error) = self.meet() {
                    self.end(events, Err(error));
                }
            }
            (Err(error), _) => self.end(events, Err(error)),
        }
    }

    /// Handles the events of a step. Returns the overlay.
    fn happen(&mut self, viewer: &mut Viewer, step: &Step) -> FullOutput {
        // The overlay has precedence, also for a key that closes a part of it.
        let were_free = self.are_keys_free();
        let over = self.overlay(viewer, step);
        let free = Free {
            keys: were_free && self.are_keys_free(),
            pointer: !self.context.is_pointer_over_egui() && !self.context.egui_is_using_pointer(),
        };
        for event in &step.events {
            viewer.handle(event, free);
        }
        if viewer.advance(f64::from(step.seconds)) {
            self.figures.changed(self.last);
        }
        over
    }

    /// Whether no text field and no popup has the keyboard.
    fn are_keys_free(&self) -> bool {
        !self.context.egui_wants_keyboard_input() && !Popup::is_any_open(&self.context)
    }

    /// Shows a frame.
    fn finish(&mut self, events: &ActiveEventLoop, viewer: Viewer, frame: Frame, rendered: Rendered) {
        let viewer = self.viewer.insert(viewer);
        let Some(screen) = &mut self.screen else { return };
        let Frame { over, showed, began, wanted, is_settled } = frame;
        if let (Some(wanted), Rendered::InMemory) = (wanted, rendered) {
            screen.upload(&viewer.pixels(), wanted.detail.size);
        }
        let delay = over.viewport_output.values().map(|output| output.repaint_delay).min();
        // Events, time and pictures change what lies over the picture after it was laid out.
        let delay = if viewer.over() == showed { delay } else { Some(Duration::ZERO) };
        self.wake = delay.and_then(|delay| Instant::now().checked_add(delay));
        if self.scene != viewer.scene() {
            self.scene = viewer.scene().to_owned();
            screen.window.set_title(&title(&self.scene));
        }
        self.full_screen.set(viewer.settings.full_screen, &screen.window);
        if let Some(watch) = &mut self.watch {
            watch.follow(&self.scene, viewer.job.files());
        }
        let shown = screen.show(&self.context, over, self.size);
        if let Some(wanted) = wanted.filter(|_| rendered != Rendered::Nowhere) {
            let now = Instant::now();
            let picture = Presented { is_moving: !is_settled, is_sharp: viewer.is_sharp(&wanted) };
            self.figures.presented(now, picture);
            let render_ms = viewer.timing.map_or(0.0, |timing| timing.frame_ms);
            viewer.presented(((now - began).as_secs_f64() * 1e3 - render_ms).max(0.0));
        }
        let shown = shown.map_err(|why| Error::Window { scene: self.scene.clone(), why });
        let result = shown.and_then(|()| viewer.failure().map_or(Ok(()), Err));
        if result.is_err() || viewer.is_closed {
            self.end(events, result);
        }
    }

    /// The events before this frame; none at the end of a recording.
    fn step(&mut self, viewer: &mut Viewer) -> Result<Option<Step>, Error> {
        let now = Instant::now();
        // Motion after a rest begins now.
        let longest = if self.is_idle { FRAME } else { LONGEST };
        let mut seconds = (now - self.last).as_secs_f32().min(longest);
        self.last = now;
        match &mut self.source {
            Source::Person => {}
            Source::Replay(replay) => {
                let Some(step) = replay.next() else { return Ok(None) };
                self.events.extend(step.events.into_iter().map(|event| (now, event)));
                seconds = step.seconds;
            }
            Source::Live(live) => {
                match live.due(now) {
                    Some(due) => self.events.extend(due),
                    // What moves by itself never rests.
                    None if self.figures.is_waited_for() && !viewer.moves() && live.waits(now) => {}
                    None if viewer.is_loading() && live.waits(now) => {}
                    None => return Ok(None),
                }
            }
        }
        let mut step = Step { events: Vec::new(), seconds };
        for (at, event) in std::mem::take(&mut self.events) {
            let event = self.pointed(event)?;
            // A window gets its size without a person.
            if !matches!(event, Event::Size(..)) {
                self.figures.event(at);
            }
            step.events.push(event);
        }
        self.figures.step();
        self.write(&step)?;
        for event in &step.events {
            if let Event::Size(size, scale) = event {
                (self.size, self.scale) = (*size, readable(*size, *scale));
                viewer.resize(*size);
                if let (true, Some(screen)) = (self.is_replay(), &self.screen) {
                    // The system may refuse; the picture has its size nevertheless.
                    _ = screen.window.request_inner_size(PhysicalSize::new(size[0], size[1]));
                }
            }
        }
        Ok(Some(step))
    }

    /// An event of a recording that points at a text, as the move to where that was seen last.
    fn pointed(&self, event: Event) -> Result<Event, Error> {
        let Event::Point(point) = &event else { return Ok(event) };
        let [x, y] = self.seen.place(point).ok_or_else(|| {
            let path = self.replayed.clone().unwrap_or_default();
            Error::Replay { path, why: format!("nothing that is seen says {:?}", point.text) }
        })?;
        Ok(Event::Move(x, y))
    }

    /// Writes a step into the recording.
    fn write(&mut self, step: &Step) -> Result<(), Error> {
        let Some((path, file)) = &mut self.record else { return Ok(()) };
        let written = file.write_all(step.to_string().as_bytes());
        written.map_err(|source| Error::Record { path: path.clone(), source })
    }

    /// Passes the events to the overlay, and returns it.
    fn overlay(&mut self, viewer: &mut Viewer, step: &Step) -> FullOutput {
        self.time += f64::from(step.seconds);
        let times = (self.time, step.seconds);
        let input = self.interface.input(&step.events, (self.size, self.scale), times);
        let last = self.figures.last();
        let over = self.context.run_ui(input, |ui| {
            guides::show(ui.ctx(), viewer);
            overlay::show(ui.ctx(), viewer, &last);
            self.opened.give_room(ui.ctx(), &mut viewer.settings);
            if viewer.settings.panel {
                panel::show(ui.ctx(), viewer);
            }
            if viewer.settings.objects {
                panel::show_objects(ui.ctx(), viewer, &mut self.rows);
            }
            panel::show_selection(ui.ctx(), viewer);
        });
        if self.is_replay() {
            self.seen = Seen::of(&over, self.scale);
            return over;
        }
        for command in &over.platform_output.commands {
            if let OutputCommand::CopyText(text) = command {
                self.clipboard.copy(text.clone());
            }
        }
        over
    }

    fn is_replay(&self) -> bool {
        !matches!(self.source, Source::Person)
    }

    /// Queues an event for the next frame. A replay ignores it. A frame that refines the picture ends for what a person
    /// does on purpose.
    fn queue(&mut self, event: Event) {
        if self.is_replay() {
            return;
        }
        if let Event::Button(_, is_held) = event {
            self.is_held = is_held;
        }
        if let Event::Modifiers(held) = event {
            self.modifiers = held;
        }
        // Ctrl with a letter is a shortcut, which some systems report as text too. Ctrl with Alt may be AltGr.
        if matches!(event, Event::Text(_)) && self.modifiers.ctrl && !self.modifiers.alt {
            return;
        }
        if event.is_urgent(self.is_held) {
            self.interrupt(event == Event::Press(Key::Escape));
        }
        let pastes = self.modifiers.ctrl && event == Event::Press(Key::V);
        self.events.push((Instant::now(), event));
        // Only a field of text asks for the clipboard. A click that still waits may be on one.
        let clicks = |(_, event): &(Instant, Event)| matches!(event, Event::Button(..));
        if pastes && (self.context.egui_wants_keyboard_input() || self.events.iter().any(clicks)) {
            let text = self.clipboard.text().map(Event::Paste);
            self.events.extend(text.map(|text| (Instant::now(), text)));
        }
    }

    /// Ends the work in progress, if input ends it, or in any case.
    fn interrupt(&self, in_any_case: bool) {
        if let Some(InProgress { stop, ends, .. }) = &self.in_progress
            && (in_any_case || *ends == Ends::WithInput)
        {
            stop.store(true, Ordering::Relaxed);
        }
    }

    /// Whether Escape closes the window before the work in progress ends. What a person did before is done first, unless
    /// that lasts; and Escape may close a part of the overlay.
    fn closes_at_once(&self) -> bool {
        let Some(InProgress { ends, .. }) = &self.in_progress else { return false };
        let is_deed = |event: &Event| {
            matches!(
                event,
                Event::Press(_) | Event::Text(_) | Event::Paste(_) | Event::Button(..) | Event::Drop(_)
            )
        };
        let waits = self.events.iter().any(|(_, event)| is_deed(event));
        !self.is_replay() && (*ends == Ends::Itself || !waits && self.are_keys_free())
    }

    /// Closes the window by Escape.
    fn escape(&mut self, events: &ActiveEventLoop) {
        let rest = std::mem::take(&mut self.events).into_iter().map(|(_, event)| event);
        let seconds = self.last.elapsed().as_secs_f32().min(LONGEST);
        let step = Step { events: rest.chain([Event::Press(Key::Escape)]).collect(), seconds };
        let written = self.write(&step);
        self.end(events, written);
    }

    /// Closes the window.
    fn end(&mut self, events: &ActiveEventLoop, result: Result<(), Error>) {
        if self.result.is_ok() {
            self.result = result;
        }
        // Whatever is still to end, the window is gone at once.
        self.screen = None;
        events.exit();
        self.interrupt(true);
        // A frame ends in a moment. What lasts is given up together with the process; files are whole or not there.
        if let Some(InProgress { thread, ends, .. }) = self.in_progress.take() {
            let (start, most) = (Instant::now(), if ends == Ends::Itself { Duration::ZERO } else { LEAVES });
            while !thread.is_finished() && start.elapsed() < most {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    }

    /// Does without a window what the viewer still owes: screenshots that somebody wanted are written, and the figures of a replay
    /// are printed. Returns why the viewer ended.
    pub fn conclude(&mut self) -> Result<(), Error> {
        let written = self.shots.all().into_iter().try_for_each(|(_, written)| written);
        std::mem::replace(&mut self.result, Ok(())).and(written)?;
        if self.reports {
            output::print(output::json(&LoopReport { figures: self.figures.report() })?)?;
        }
        Ok(())
    }
}

/// The pixels per unit of a user interface that can be read: in a small window it is smaller, so that more of it is seen.
fn readable(size: [u32; 2], scale: f32) -> f32 {
    let room = |side: usize| size[side] as f32 / (ROOM[side] * scale);
    scale * room(0).min(room(1)).clamp(LEAST, 1.0)
}

fn title(scene: &Path) -> String {
    let name = scene.file_name().unwrap_or(scene.as_os_str());
    format!("{} – rtrt", name.to_string_lossy())
}

impl ApplicationHandler<Woken> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.screen.is_some() {
            return;
        }
        let start = Instant::now();
        let is_loaded = |work: &InProgress| work.thread.is_finished();
        while !self.in_progress.as_ref().is_none_or(is_loaded) && start.elapsed() < OPENS {
            std::thread::sleep(Duration::from_millis(1));
        }
        if let Some(loaded) = self.in_progress.take_if(|work| is_loaded(work)) {
            self.done(events, loaded);
            if events.exiting() {
                return;
            }
        }
        match panics_caught(|| self.open(events)) {
            Ok(screen) => {
                if let Err(error) = self.take(screen) {
                    self.end(events, Err(error));
                }
            }
            Err(why) => {
                let scene = self.scene.clone();
                self.end(events, Err(Error::Window { scene, why }));
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match &event {
            WindowEvent::CloseRequested => return self.end(events, Ok(())),
            WindowEvent::RedrawRequested => return self.frame(events),
            WindowEvent::Resized(size) if size.width > 0 && size.height > 0 => {
                let Some(screen) = &mut self.screen else { return };
                screen.resize([size.width, size.height]);
                let event = Event::Size(screen.size(), screen.window.scale_factor() as f32);
                self.queue(event);
            }
            WindowEvent::ScaleFactorChanged { scale_factor, .. } => {
                self.queue(Event::Size(self.size, *scale_factor as f32));
            }
            event => {
                let translated = translated(event, &mut self.fingers);
                if translated.contains(&Event::Press(Key::Escape)) && self.closes_at_once() {
                    return self.escape(events);
                }
                translated.into_iter().for_each(|event| self.queue(event));
            }
        }
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, woken: Woken) {
        let is_done = |work: &mut InProgress| matches!(woken, Woken::Work(number) if number == work.number);
        if let Some(done) = self.in_progress.take_if(is_done) {
            self.done(events, done);
        }
        // For the queued events and the new timing.
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let now = Instant::now();
        let next = match &self.source {
            Source::Live(live) => live.wake(),
            _ => None,
        };
        let (Some(screen), Some(viewer)) = (&self.screen, &mut self.viewer) else {
            // Events of a recording end a frame as those of a person do.
            if matches!(&self.source, Source::Live(live) if live.acts(now)) {
                self.interrupt(false);
            }
            let next = next.filter(|next| *next > now);
            return events.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        };
        let due = viewer.due().map(|seconds| self.last + Duration::from_secs_f64(seconds));
        let mut is_due = matches!(self.source, Source::Replay(_));
        if let Some(change) = self.watch.as_mut().and_then(|watch| watch.change(now)) {
            match change {
                Change::Changed => viewer.open_again(),
                Change::Gone => viewer.miss(),
            }
            is_due = true;
        }
        self.is_idle = !is_due && due.is_none();
        let look = self.watch.as_ref().map(|_| now + watch::EVERY);
        let fills = self.full_screen.due(now, &screen.window);
        let wakes = [self.wake, due, next, look, fills];
        if is_due || wakes.iter().flatten().any(|wake| *wake <= now) {
            screen.window.request_redraw();
        }
        let wake = wakes.into_iter().flatten().filter(|wake| *wake > now).min();
        events.set_control_flow(wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
