//! A window that the CPU draws, in memory that the display reads.

use super::paint::{Canvas, Painter};
use super::scale::scale;
use egui::{Context, FullOutput};
use softbuffer::{SoftBufferError, Surface};
use std::num::NonZeroU32;
use std::sync::Arc;
use winit::event_loop::{ActiveEventLoop, OwnedDisplayHandle};
use winit::window::Window;

/// The longest side of a window, pixels.
const MOST: u32 = 16_384;

/// A surface in memory.
pub struct MemoryScreen {
    window: Arc<Window>,
    surface: Surface<OwnedDisplayHandle, Arc<Window>>,
    size: [u32; 2],
    /// The picture, for when only the overlay changes.
    picture: Vec<u8>,
    picture_size: [u32; 2],
    /// The picture at the size at which it is shown, without what lies over it.
    scaled: Vec<u32>,
    scaled_size: Option<[u32; 2]>,
    painter: Painter,
}

impl MemoryScreen {
    /// A surface on a window, or the reason for a failure.
    pub fn new(window: Arc<Window>, events: &ActiveEventLoop) -> Result<Self, String> {
        let why = |error: SoftBufferError| format!("nothing draws in windows: {error}");
        let context = softbuffer::Context::new(events.owned_display_handle()).map_err(why)?;
        let surface = Surface::new(&context, Arc::clone(&window)).map_err(why)?;
        let size = window.inner_size();
        Ok(Self {
            window,
            surface,
            size: [size.width, size.height].map(|side| side.clamp(1, MOST)),
            picture: Vec::new(),
            picture_size: [0; 2],
            scaled: Vec::new(),
            scaled_size: None,
            painter: Painter::default(),
        })
    }

    /// The size of the surface, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Changes the size of the surface.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.size = size.map(|side| side.clamp(1, MOST));
    }

    /// Takes a picture: red, green, blue and alpha, row by row.
    pub fn upload(&mut self, pixels: &[u8], size: [u32; 2]) {
        self.picture.clear();
        self.picture.extend_from_slice(pixels);
        (self.picture_size, self.scaled_size) = (size, None);
    }

    /// Shows the picture, scaled to this size in pixels, in the upper left corner, and the overlay.
    pub fn show(&mut self, context: &Context, mut over: FullOutput, shown: [u32; 2]) -> Result<(), String> {
        let units = over.pixels_per_point;
        let jobs = context.tessellate(over.shapes, units);
        for (id, deltas) in over.textures_delta.set.drain() {
            deltas.iter().for_each(|delta| self.painter.update(id, delta));
        }
        if self.scaled_size != Some(shown) {
            self.scaled.clear();
            self.scaled.resize((shown[0] * shown[1]) as usize, 0);
            scale(&self.picture, self.picture_size, &mut self.scaled, shown);
            self.scaled_size = Some(shown);
        }
        let [width, height] = self.size;
        let sides = NonZeroU32::new(width).zip(NonZeroU32::new(height));
        let (across, down) = sides.ok_or("the window has no size")?;
        let why = |error: SoftBufferError| format!("the window cannot be drawn: {error}");
        self.surface.resize(across, down).map_err(why)?;
        let mut buffer = self.surface.buffer_mut().map_err(why)?;
        let kept = width.min(shown[0]) as usize;
        let rows = buffer.chunks_exact_mut(width as usize);
        for (row, scaled) in rows.zip(self.scaled.chunks_exact(shown[0].max(1) as usize)) {
            row[..kept].copy_from_slice(&scaled[..kept]);
            row[kept..].fill(0);
        }
        let below = (width * height.min(shown[1])) as usize;
        buffer[below..].fill(0);
        self.painter.paint(&jobs, units, &mut Canvas { pixels: &mut buffer, size: self.size });
        self.window.pre_present_notify();
        buffer.present().map_err(why)?;
        // Requests to an X server wait in a buffer until a reply is needed. This question needs one; without it the
        // picture would be seen at the next event.
        self.window.is_minimized();
        over.textures_delta.free.drain().for_each(|id| self.painter.free(id));
        Ok(())
    }
}
