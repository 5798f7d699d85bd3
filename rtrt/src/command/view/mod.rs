//! `rtrt view`: a scene in a window.
//!
//! | module | holds |
//! |---|---|
//! | `input` | events as data, one a line of text |
//! | `controls` | what keys and the mouse do |
//! | `camera`, `pace` | functions: how a camera moves, how fine a picture can be in the given time |
//! | `viewer` | all state but the window; renders by the functions of `rtrt render` |
//! | `engine` | the backend, or a GPU backend on the window's own device |
//! | `window`, `screen` | winit; wgpu |
//! | `overlay`, `panel` | egui |
//! | `reproduce` | the command line that renders the current picture |
//! | `watch` | files that change |
//!
//! - **Events are text first.** A recording and a person take the same path, and a replay takes its
//!   clock from the file. So a replay is a test. egui-winit was refused: its events cannot be recorded,
//!   and it brings a clipboard.
//! - **The printed command renders the picture.** A test reads it back with the command's own parser.
//!   Numbers that the panel changed are options of it.
//! - **Pictures are exact.** egui's shader draws the picture as a texture with nearest texels, and a
//!   test compares the window's pixels with the file. The GPU that draws the window renders into the
//!   texture; other pictures are uploaded. Screenshots are rendered once more and read back, with the
//!   same bits.
//! - **The viewer renders on a worker thread; input waits in a queue.** Nothing changes during a frame.
//!   A replay renders on the window's thread. While a GPU compiles its stages, before its first picture,
//!   the overlay says so.
//! - **Errors of the window are errors of the command.** winit panics where a library or an extension of
//!   the display is missing; [`run`] catches that.

use rtrt::moves as camera;
mod controls;
mod engine;
mod failure;
mod input;
mod overlay;
mod pace;
mod panel;
mod reproduce;
mod screen;
mod viewer;
mod watch;
mod window;

use super::options::ViewOptions;
use super::stream::is_stream;
use super::{Error, names};
pub use controls::keys;
use failure::{panics_caught, reason};
use input::Replay;
use std::fs;
use std::path::Path;
use viewer::Viewer;
use window::App;
use winit::event_loop::EventLoop;

/// Opens a window, and shows the scene until it is closed.
pub fn run(options: &ViewOptions) -> Result<(), Error> {
    let refused = |why| Error::Window { scene: options.common.scene.clone(), why };
    names::check(&options.output)?;
    if options.watch && is_stream(&options.common.scene) {
        return Err(Error::Usage("--watch needs a file: standard input and pipes can be read only once"));
    }
    let replay = options.replay.as_deref().map(replay).transpose()?;
    // Before the scene is loaded: loading is in vain without a display.
    let events = panics_caught(|| EventLoop::new().map_err(|error| reason(&error))).map_err(refused)?;
    let viewer = Viewer::new(options)?;
    let mut app = App::new(options, viewer, replay, events.create_proxy())?;
    events.run_app(&mut app).map_err(|error| refused(reason(&error)))?;
    app.result
}

/// Reads a recording.
fn replay(path: &Path) -> Result<Replay, Error> {
    let refused = |why: String| Error::Replay { path: path.to_owned(), why };
    let text = fs::read_to_string(path).map_err(|error| refused(error.to_string()))?;
    Replay::parse(&text, path.parent().unwrap_or(Path::new(""))).map_err(|error| refused(error.to_string()))
}
