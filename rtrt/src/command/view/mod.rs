//! `rtrt view`: a scene in a window.
//!
//! | module | holds |
//! |---|---|
//! | `input`, `live` | events as data, one a line of text; recordings at their own speed |
//! | `controls` | what keys and the mouse do |
//! | `pace` | functions: how fine a picture can be in the given time |
//! | `viewer` | all state but the window; renders by the functions of `rtrt render` |
//! | `engine` | the backend, or a GPU backend on the window's own device |
//! | `window`, `system` | winit: frames, events |
//! | `screen` | what draws the window: wgpu, or the CPU |
//! | `interface`, `overlay`, `guides`, `panel` | egui |
//! | `fullscreen` | the whole screen, with and without a window manager |
//! | `seen` | text on the screen, at which a recording points |
//! | `recent` | the files that were opened last |
//! | `clipboard` | text that programs copy for one another |
//! | `figures` | times from events to pictures |
//! | `reproduce` | the command line that renders the current picture |
//! | `watch` | files that change |
//!
//! - **Events are text first.** A recording and a person take the same path, and a replay takes its
//!   clock from the file. So a replay is a test. egui-winit was refused: its events cannot be recorded.
//! - **The printed command renders the picture.** A test reads it back with the command's own parser.
//!   Numbers that the panel changed are options of it.
//! - **Pictures are exact.** A picture of the window's size is shown pixel by pixel, and a test compares the
//!   window with the file. The GPU that draws the window renders into its texture; other pictures are
//!   uploaded. Screenshots are rendered once more and read back, with the same bits.
//! - **A window without a GPU is drawn by the CPU,** in memory that it shares with the display. A software
//!   device took 100 ms to present a picture of 1280 × 720 (9.9 frames a second whatever was in it).
//! - **The whole loop is measured,** from the event to the presented picture. While things move, the detail of
//!   pictures follows from that; then they are refined: a quarter of the pixels, all, all samples.
//! - **The viewer renders on a worker thread; input waits in a queue.** Nothing changes during a frame. Input ends
//!   a frame that refines (`Request::until`), so it waits for the few milliseconds of a block. A replay renders
//!   on the window's thread; with `--live` it has the recording's times, and is like a person.
//! - **While a GPU compiles, the CPU draws.**
//! - **A closed window is gone at once.** Nothing waits for a thread that compiles a shader or loads a scene: the process
//!   ends. Files are written beside their place and renamed, so they are whole or not there.
//! - **A thread of its own loads another scene,** with a copy of the options. The one that is shown stays as it is
//!   until then. A panorama goes into the scene, so the worker thread reads it, and pictures wait.
//! - **Errors of the window are errors of the command.** winit panics where a library or an extension of
//!   the display is missing; [`run`] catches that.

use rtrt::moves::{self as camera, hand as motion};
mod clipboard;
mod controls;
mod engine;
mod failure;
mod figures;
mod fullscreen;
mod guides;
mod input;
mod interface;
mod live;
mod overlay;
mod pace;
mod panel;
mod recent;
mod reproduce;
mod screen;
mod seen;
mod shots;
mod system;
mod viewer;
mod watch;
mod window;

use super::options::{OUTPUT, ViewOptions};
use super::stream::is_stream;
use super::{Error, names, output};
pub use controls::keys;
use failure::{panics_caught, reason};
use input::Replay;
use std::fs;
use std::path::Path;
use window::App;
use winit::event_loop::EventLoop;

/// Opens a window, and shows the scene until it is closed.
pub fn run(options: &ViewOptions) -> Result<(), Error> {
    let refused = |why| Error::Window { scene: options.common.scene.clone(), why };
    names::check(&options.output)?;
    if options.output != Path::new(OUTPUT) {
        output::check(&names::filled(&options.output, &options.common.scene, "camera", 0))?;
    }
    if options.watch && is_stream(&options.common.scene) {
        return Err(Error::Usage("--watch needs a file: standard input and pipes can be read only once"));
    }
    let replay = options.replay.as_deref().map(replay).transpose()?;
    // Before anything is loaded: loading is in vain without a display.
    let events = panics_caught(|| EventLoop::with_user_event().build().map_err(|error| reason(&error)));
    let events = events.map_err(refused)?;
    let mut app = App::new(options, replay, events.create_proxy())?;
    let ran = events.run_app(&mut app).map_err(|error| refused(reason(&error)));
    let result = app.conclude();
    // The process ends: to free a scene takes time for nothing.
    std::mem::forget(app);
    ran.and(result)
}

/// Reads a recording.
fn replay(path: &Path) -> Result<Replay, Error> {
    let refused = |why: String| Error::Replay { path: path.to_owned(), why };
    let text = fs::read_to_string(path).map_err(|error| refused(error.to_string()))?;
    Replay::parse(&text, path.parent().unwrap_or(Path::new(""))).map_err(|error| refused(error.to_string()))
}
