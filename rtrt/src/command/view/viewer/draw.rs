//! Pictures: rendered where they are shown, or to be taken there, or to be written.

use super::{Timing, Viewer, Wanted};
use crate::command::Error;
use crate::command::job::rays;
use crate::command::view::pace::Detail;
use bytemuck::cast_slice;
use rtrt_core::backend::{RenderError, STAGES};
use std::time::Instant;

impl Viewer {
    /// Whether the picture can be rendered into a texture of the window's device.
    pub fn is_drawn_here(&mut self, wanted: &Wanted) -> bool {
        self.backends[self.current].here().is_some()
            && wanted.debug.is_none()
            && self.drawn.as_ref() != Some(wanted)
    }

    /// Renders the picture, into a texture of the window's device if there is one, and takes note if
    /// that fails. Gives the size of a picture that is not in the texture.
    pub fn render(&mut self, wanted: Wanted, texture: Option<wgpu::Texture>) -> Option<[u32; 2]> {
        if texture.is_some_and(|texture| self.draw_here(wanted, &texture)) {
            return None;
        }
        let drawn = self.draw(wanted);
        let is_drawn = drawn.is_ok();
        self.note(drawn);
        is_drawn.then_some(wanted.detail.size)
    }

    /// Renders the picture, or the debug view, if that is not what is there already.
    pub(super) fn draw(&mut self, wanted: Wanted) -> Result<(), Error> {
        if self.drawn == Some(wanted) {
            return Ok(());
        }
        self.begin(wanted)?;
        let start = Instant::now();
        let request = self.job.request(wanted.debug.is_some());
        let backend = &mut self.backends[self.current];
        let rendered = self.job.render(backend.backend(), &request, &mut self.picture);
        match rendered {
            Err(Error::Render { source, .. }) if is_of_device(&source) && backend.here().is_some() => {
                self.part(source);
                let request = self.job.request(wanted.debug.is_some());
                self.job.render(self.backends[self.current].backend(), &request, &mut self.picture)?;
            }
            rendered => rendered?,
        }
        let job = &self.job;
        self.shown = wanted.debug.map(|view| job.show(view, &self.picture)).transpose()?;
        self.measured(wanted.detail, start, self.picture.stages_ms);
        self.drawn = Some(wanted);
        Ok(())
    }

    /// Renders the picture into a texture of the window's device. Where that fails, the device is no
    /// longer shared, and the picture is still to be rendered.
    fn draw_here(&mut self, wanted: Wanted, texture: &wgpu::Texture) -> bool {
        if self.begin(wanted).is_err() {
            return false;
        }
        let start = Instant::now();
        let Some(gpu) = self.backends[self.current].here() else { return false };
        match gpu.render_into(texture, &self.job.scene, &self.job.request(false)) {
            Ok(stages_ms) => {
                self.measured(wanted.detail, start, stages_ms);
                true
            }
            Err(error) => {
                if is_of_device(&error) {
                    self.part(error);
                }
                false
            }
        }
    }

    /// Leaves the window's device, which has failed.
    fn part(&mut self, why: RenderError) {
        self.console.say(format_args!("warning: {why}; pictures are read back from here on"));
        let parted = self.backends[self.current].part(&self.console);
        self.note(parted);
    }

    /// Makes the job that of a picture.
    fn begin(&mut self, Wanted { detail, shadows, layers, debug, .. }: Wanted) -> Result<(), Error> {
        (self.drawn, self.shown) = (None, None);
        rays(detail.size, detail.samples, debug.is_some())?;
        let job = &mut self.job;
        (job.size, job.samples, job.shadows, job.layers) = (detail.size, detail.samples, shadows, layers);
        Ok(())
    }

    /// Takes note of how long a picture took.
    fn measured(&mut self, detail: Detail, start: Instant, stages_ms: [f64; STAGES.len()]) {
        let frame_ms = start.elapsed().as_secs_f64() * 1e3;
        self.pace.measured(detail.rays(), frame_ms);
        self.timing = Some(Timing { detail, frame_ms, stages_ms });
    }

    /// The pixels of the picture that was rendered last, row by row: red, green, blue, alpha.
    pub fn pixels(&self) -> &[u8] {
        match &self.shown {
            Some(shown) => cast_slice(&shown.pixels),
            None => self.picture.bytes(),
        }
    }
}

/// Whether another backend may do better.
fn is_of_device(error: &RenderError) -> bool {
    matches!(error, RenderError::Backend { .. })
}
