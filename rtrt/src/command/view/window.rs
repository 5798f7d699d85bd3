//! The window: it turns system events into input events, and runs the frames.

use super::controls::Free;
use super::failure::{panics_caught, reason};
use super::input::{Button, Event, Modifiers, Replay, Step, header};
use super::screen::Screen;
use super::viewer::Viewer;
use super::watch::{self, Watch};
use super::{overlay, panel};
use crate::command::Error;
use crate::command::options;
use egui::{Context, FullOutput, PointerButton, Popup, Pos2, RawInput, Rect, pos2, vec2};
use std::fs::File;
use std::io::Write;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, PhysicalKey};
use winit::window::{Window, WindowId};

/// The longest time step of a frame, seconds; longer ones would make jumps.
const LONGEST: f32 = 0.1;
/// The usual time step of a frame, seconds.
const FRAME: f32 = 1.0 / 60.0;
/// Pixels of a touchpad per notch of a wheel.
const NOTCH: f64 = 40.0;

/// The viewer in its window.
pub struct App {
    /// None while a thread renders with it.
    viewer: Option<Viewer>,
    in_progress: Option<FrameInProgress>,
    /// Wakes the window when the thread ends.
    proxy: EventLoopProxy<()>,
    /// The scene of the title and of the watch.
    scene: PathBuf,
    screen: Option<Screen>,
    context: Context,
    /// The events since the last frame.
    events: Vec<Event>,
    modifiers: Modifiers,
    /// The position of the pointer, in units of the user interface.
    pointer: Pos2,
    /// The size of the picture in pixels, and the pixels per unit of the user interface.
    size: [u32; 2],
    scale: f32,
    time: f64,
    last: Instant,
    /// Whether nothing has happened since then.
    is_idle: bool,
    replay: Option<Replay>,
    record: Option<(PathBuf, File)>,
    watch: Option<Watch>,
    /// The time at which the overlay needs the next frame.
    wake: Option<Instant>,
    /// Why the viewer ended.
    pub result: Result<(), Error>,
}

/// A frame in progress. The viewer renders on a worker thread; input waits in a queue.
struct FrameInProgress {
    /// Returns the viewer, and the size of a picture that is not on the screen yet.
    thread: JoinHandle<(Viewer, Option<[u32; 2]>)>,
    over: FullOutput,
}

/// Wakes the window when the thread ends, also by a panic.
struct Wake(EventLoopProxy<()>);

impl Drop for Wake {
    fn drop(&mut self) {
        // The window may be closed.
        _ = self.0.send_event(());
    }
}

impl App {
    /// A viewer without its window.
    pub fn new(
        options: &options::ViewOptions,
        viewer: Viewer,
        replay: Option<Replay>,
        proxy: EventLoopProxy<()>,
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
        Ok(Self {
            watch: options.watch.then(|| Watch::new(&scene, viewer.job.files())),
            viewer: Some(viewer),
            in_progress: None,
            proxy,
            screen: None,
            context,
            events: vec![Event::Size(options.common.size, 1.0)],
            modifiers: Modifiers::default(),
            pointer: Pos2::ZERO,
            size: options.common.size,
            scale: 1.0,
            time: 0.0,
            last: Instant::now(),
            is_idle: true,
            replay,
            record: record.transpose()?,
            wake: None,
            result: Ok(()),
            scene,
        })
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<Screen, String> {
        let [width, height] = self.size;
        let attributes = Window::default_attributes()
            .with_title(title(&self.scene))
            .with_inner_size(PhysicalSize::new(width, height));
        let window = events.create_window(attributes).map_err(|error| reason(&error))?;
        let screen = Screen::new(Arc::new(window), events)?;
        if let Some(viewer) = &mut self.viewer {
            viewer.share(&screen.device, &screen.queue);
        }
        Ok(screen)
    }

    /// Takes the screen. A software adapter is a warning.
    fn take(&mut self, screen: Screen) -> Result<(), Error> {
        screen.window.request_redraw();
        let scale = screen.window.scale_factor() as f32;
        self.queue(Event::Size(screen.size(), scale));
        let screen = self.screen.insert(screen);
        match (&screen.software, &self.viewer) {
            (Some(name), Some(viewer)) => {
                viewer.warn(format_args!("the window is drawn by a software adapter: {name}"))
            }
            _ => Ok(()),
        }
    }

    /// Runs a frame: events, overlay, picture. Events wait while a frame is in progress.
    fn frame(&mut self, events: &ActiveEventLoop) {
        let Some(mut viewer) = self.viewer.take() else { return };
        let mut over = match self.step(&mut viewer) {
            Ok(Some(step)) => self.happen(&mut viewer, &step),
            Ok(None) => return self.end(events, Ok(())),
            Err(error) => return self.end(events, Err(error)),
        };
        let Some(wanted) = viewer.next() else { return self.finish(events, viewer, over, None) };
        if viewer.is_cold() {
            over = self.wait(&mut viewer, over);
        }
        let screen = self.screen.as_mut().filter(|_| viewer.is_rendered_in_place(&wanted));
        let texture = screen.map(|screen| screen.texture(wanted.detail.size));
        if self.replay.is_some() {
            let new = viewer.render(wanted, texture);
            return self.finish(events, viewer, over, new);
        }
        let wake = Wake(self.proxy.clone());
        let thread = std::thread::spawn(move || {
            let _wake = wake;
            let new = viewer.render(wanted, texture);
            (viewer, new)
        });
        self.in_progress = Some(FrameInProgress { thread, over });
    }

    /// Shows a message while shaders are compiled. Returns the overlay of the finished picture.
    fn wait(&mut self, viewer: &mut Viewer, mut over: FullOutput) -> FullOutput {
        over.append(self.overlay(viewer, &Step::default(), Some("compiling shaders …")));
        if let Some(screen) = &mut self.screen {
            // The finished picture will report the error.
            _ = screen.show(&self.context, over, self.size);
        }
        self.overlay(viewer, &Step::default(), None)
    }

    /// Handles the events of a step. Returns the overlay.
    fn happen(&mut self, viewer: &mut Viewer, step: &Step) -> FullOutput {
        // The overlay has precedence, also for a key that closes a part of it.
        let were_free = self.are_keys_free();
        let over = self.overlay(viewer, step, None);
        let free = Free {
            keys: were_free && self.are_keys_free(),
            pointer: !self.context.is_pointer_over_egui() && !self.context.egui_is_using_pointer(),
        };
        for event in &step.events {
            viewer.handle(event, free);
        }
        viewer.advance(f64::from(step.seconds));
        over
    }

    /// Whether no text field and no popup has the keyboard.
    fn are_keys_free(&self) -> bool {
        !self.context.egui_wants_keyboard_input() && !Popup::is_any_open(&self.context)
    }

    /// Shows a frame. `new` is the size of the viewer's picture if it is not on the screen yet.
    fn finish(&mut self, events: &ActiveEventLoop, viewer: Viewer, over: FullOutput, new: Option<[u32; 2]>) {
        let viewer = self.viewer.insert(viewer);
        let Some(screen) = &mut self.screen else { return };
        if let Some(size) = new {
            screen.upload(&viewer.pixels(), size);
        }
        let delay = over.viewport_output.values().map(|output| output.repaint_delay).min();
        self.wake = delay.and_then(|delay| Instant::now().checked_add(delay));
        if self.scene != viewer.scene() {
            self.scene = viewer.scene().to_owned();
            screen.window.set_title(&title(&self.scene));
        }
        if let Some(watch) = &mut self.watch {
            watch.follow(&self.scene, viewer.job.files());
        }
        let shown = screen.show(&self.context, over, self.size);
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
        let seconds = (now - self.last).as_secs_f32().min(longest);
        self.last = now;
        let mut step = Step { events: std::mem::take(&mut self.events), seconds };
        if let Some(replay) = &mut self.replay {
            let Some(Step { events, seconds }) = replay.next() else { return Ok(None) };
            step.events.extend(events);
            step.seconds = seconds;
        }
        if let Some((path, file)) = &mut self.record {
            let written = file.write_all(step.to_string().as_bytes());
            written.map_err(|source| Error::Record { path: path.clone(), source })?;
        }
        for event in &step.events {
            if let Event::Size(size, scale) = event {
                (self.size, self.scale) = (*size, *scale);
                viewer.resize(*size);
                if let (Some(_), Some(screen)) = (&self.replay, &self.screen) {
                    // The system may refuse; the picture has its size nevertheless.
                    _ = screen.window.request_inner_size(PhysicalSize::new(size[0], size[1]));
                }
            }
        }
        Ok(Some(step))
    }

    /// Passes the events to the overlay, and returns it. `waits` is a message to show.
    fn overlay(&mut self, viewer: &mut Viewer, step: &Step, waits: Option<&str>) -> FullOutput {
        self.time += f64::from(step.seconds);
        let [width, height] = self.size.map(|side| side as f32 / self.scale);
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height))),
            time: Some(self.time),
            predicted_dt: step.seconds,
            events: step.events.iter().filter_map(|event| self.egui_event(event)).collect(),
            ..RawInput::default()
        };
        for viewport in input.viewports.values_mut() {
            viewport.native_pixels_per_point = Some(self.scale);
        }
        self.context.run_ui(input, |ui| {
            overlay::show(ui.ctx(), viewer, waits);
            if viewer.settings.panel {
                panel::show(ui.ctx(), viewer);
            }
        })
    }

    /// The event for the overlay.
    fn egui_event(&mut self, event: &Event) -> Option<egui::Event> {
        let key = |key: &egui::Key, pressed, modifiers| egui::Event::Key {
            key: *key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        };
        let Modifiers { ctrl, shift, alt } = self.modifiers;
        let modifiers = egui::Modifiers { ctrl, shift, alt, command: ctrl, mac_cmd: false };
        Some(match event {
            Event::Size(..) | Event::Drop(_) => return None,
            Event::Press(pressed) => key(pressed, true, modifiers),
            Event::Release(released) => key(released, false, modifiers),
            Event::Modifiers(held) => {
                self.modifiers = *held;
                return None;
            }
            Event::Text(text) => egui::Event::Text(text.clone()),
            Event::Move(x, y) => {
                self.pointer = pos2(*x, *y) / self.scale;
                egui::Event::PointerMoved(self.pointer)
            }
            Event::Leave => egui::Event::PointerGone,
            Event::Button(button, pressed) => egui::Event::PointerButton {
                pos: self.pointer,
                button: match button {
                    Button::Left => PointerButton::Primary,
                    Button::Middle => PointerButton::Middle,
                    Button::Right => PointerButton::Secondary,
                },
                pressed: *pressed,
                modifiers,
            },
            Event::Wheel(notches) => egui::Event::MouseWheel {
                unit: egui::MouseWheelUnit::Line,
                delta: vec2(0.0, *notches),
                phase: egui::TouchPhase::Move,
                source: egui::MouseWheelSource::Unknown,
                modifiers,
            },
            Event::Focus(has) => egui::Event::WindowFocused(*has),
        })
    }

    /// Queues the input event of a window event.
    fn translate_window_event(&mut self, event: &WindowEvent) {
        let scale = |screen: &Screen| screen.window.scale_factor() as f32;
        let input = match event {
            WindowEvent::Resized(size) if size.width > 0 && size.height > 0 => {
                let Some(screen) = &mut self.screen else { return };
                screen.resize([size.width, size.height]);
                Event::Size(screen.size(), scale(screen))
            }
            WindowEvent::ScaleFactorChanged { scale_factor, .. } => {
                Event::Size(self.size, *scale_factor as f32)
            }
            WindowEvent::Focused(has) => Event::Focus(*has),
            WindowEvent::DroppedFile(path) => Event::Drop(path.clone()),
            WindowEvent::ModifiersChanged(held) => {
                let held = held.state();
                let ctrl = held.control_key() || held.super_key();
                Event::Modifiers(Modifiers { ctrl, shift: held.shift_key(), alt: held.alt_key() })
            }
            WindowEvent::CursorMoved { position, .. } => Event::Move(position.x as f32, position.y as f32),
            WindowEvent::CursorLeft { .. } => Event::Leave,
            WindowEvent::MouseWheel { delta: MouseScrollDelta::LineDelta(_, notches), .. } => {
                Event::Wheel(*notches)
            }
            WindowEvent::MouseWheel { delta: MouseScrollDelta::PixelDelta(pixels), .. } => {
                Event::Wheel((pixels.y / NOTCH) as f32)
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let button = match button {
                    MouseButton::Left => Button::Left,
                    MouseButton::Middle => Button::Middle,
                    MouseButton::Right => Button::Right,
                    _ => return,
                };
                Event::Button(button, *state == ElementState::Pressed)
            }
            WindowEvent::KeyboardInput { event, .. } => return self.typed(event),
            _ => return,
        };
        self.queue(input);
    }

    fn typed(&mut self, event: &KeyEvent) {
        let pressed = event.state == ElementState::Pressed;
        if let Some(key) = key(event) {
            self.queue(if pressed { Event::Press(key) } else { Event::Release(key) });
        }
        let text = event.text.as_ref().filter(|text| pressed && !text.chars().any(char::is_control));
        if let Some(text) = text {
            self.queue(Event::Text(text.to_string()));
        }
    }

    /// Queues an event for the next frame. A replay ignores it.
    fn queue(&mut self, event: Event) {
        if self.replay.is_none() {
            self.events.push(event);
        }
    }

    fn end(&mut self, events: &ActiveEventLoop, result: Result<(), Error>) {
        if self.result.is_ok() {
            self.result = result;
        }
        // The process must not end while a frame is in progress.
        if let Some(FrameInProgress { thread, .. }) = self.in_progress.take() {
            _ = thread.join();
        }
        events.exit();
    }
}

fn title(scene: &Path) -> String {
    let name = scene.file_name().unwrap_or(scene.as_os_str());
    format!("{} – rtrt", name.to_string_lossy())
}

/// The key by its label; digits and letters of other scripts by their position.
fn key(event: &KeyEvent) -> Option<egui::Key> {
    let by_place = || match event.physical_key {
        PhysicalKey::Code(code) => {
            let name = format!("{code:?}");
            let letter = name.strip_prefix("Key");
            let digit = name.strip_prefix("Digit").or_else(|| name.strip_prefix("Numpad"));
            egui::Key::from_name(letter.or(digit).unwrap_or(&name))
        }
        PhysicalKey::Unidentified(_) => None,
    };
    let place = by_place();
    let is_digit =
        place.is_some_and(|key| key.name().len() == 1 && key.name().as_bytes()[0].is_ascii_digit());
    if is_digit {
        return place;
    }
    let by_print = match &event.logical_key {
        Key::Named(named) => egui::Key::from_name(&format!("{named:?}")),
        Key::Character(text) => egui::Key::from_name(&text.to_uppercase()),
        _ => None,
    };
    by_print.or(place)
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.screen.is_some() {
            return;
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
            _ => self.translate_window_event(&event),
        }
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }

    /// A frame is finished.
    fn user_event(&mut self, events: &ActiveEventLoop, (): ()) {
        let Some(FrameInProgress { thread, over }) = self.in_progress.take() else { return };
        let (viewer, new) = thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        self.finish(events, viewer, over, new);
        // For the queued events and the new timing.
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let (Some(screen), Some(viewer)) = (&self.screen, &mut self.viewer) else {
            return events.set_control_flow(ControlFlow::Wait);
        };
        let now = Instant::now();
        let mut is_due = self.replay.is_some() || viewer.is_busy();
        if self.watch.as_mut().is_some_and(|watch| watch.has_changed(now)) {
            viewer.load(None);
            is_due = true;
        }
        self.is_idle = !is_due;
        if is_due || self.wake.is_some_and(|wake| wake <= now) {
            screen.window.request_redraw();
        }
        let look = self.watch.as_ref().map(|_| now + watch::EVERY);
        let wake = [self.wake, look].into_iter().flatten().filter(|wake| *wake > now).min();
        events.set_control_flow(wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
