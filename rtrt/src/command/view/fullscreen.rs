//! A window that fills the screen.

use std::time::{Duration, Instant};
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::window::{Fullscreen, Window};

/// The time that a window manager has to fill the screen.
const PATIENCE: Duration = Duration::from_millis(300);

/// Whether the window fills the screen, and who made it so.
#[derive(Debug, Default)]
pub struct FullScreen {
    is_full: bool,
    /// When to see whether there was a window manager that did it.
    look: Option<Instant>,
    /// Place and size of a window that has filled the screen by itself.
    before: Option<(PhysicalPosition<i32>, PhysicalSize<u32>)>,
}

impl FullScreen {
    /// Fills the screen, or leaves it.
    pub fn set(&mut self, is_full: bool, window: &Window) {
        if self.is_full == is_full {
            return;
        }
        self.is_full = is_full;
        self.look = is_full.then(|| Instant::now() + PATIENCE);
        window.set_fullscreen(is_full.then_some(Fullscreen::Borderless(None)));
        if let (false, Some((place, size))) = (is_full, self.before.take()) {
            place_at(window, place, size);
        }
    }

    /// Fills the screen where nobody else does. Returns the time of the next call.
    pub fn due(&mut self, now: Instant, window: &Window) -> Option<Instant> {
        let look = self.look?;
        if look > now {
            return Some(look);
        }
        self.look = None;
        let monitor = window.current_monitor().or_else(|| window.available_monitors().next())?;
        let before = window.inner_size();
        if before != monitor.size() {
            self.before = Some((window.outer_position().unwrap_or_default(), before));
            place_at(window, monitor.position(), monitor.size());
        }
        None
    }
}

fn place_at(window: &Window, place: PhysicalPosition<i32>, size: PhysicalSize<u32>) {
    window.set_outer_position(place);
    // Where the system refuses, the window stays as it is.
    _ = window.request_inner_size(size);
}
