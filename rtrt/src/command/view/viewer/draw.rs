//! Rendering of pictures for the window and for files.

use super::{Timing, Viewer, Wanted};
use crate::command::Error;
use crate::command::job::{RenderJob, rays};
use crate::command::view::pace::Detail;
use rtrt::debug::DebugImage;
use rtrt_core::backend::{Picture, RenderError, little_endian};
use rtrt_core::schedule::Stage;
use std::borrow::Cow;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Where a picture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rendered {
    /// In the texture of the window's device.
    InPlace,
    /// In memory.
    InMemory,
    /// Nowhere: the frame failed, or was stopped.
    Nowhere,
}

impl Viewer {
    /// Whether the picture can be rendered into a texture of the window's device.
    pub fn is_rendered_in_place(&mut self, wanted: &Wanted) -> bool {
        self.engine().shared().is_some() && wanted.debug.is_none() && self.drawn.as_ref() != Some(wanted)
    }

    /// Renders the picture until `stop` is true, into a texture of the window's device if there is one. A failure is
    /// noted; a picture that was stopped is requested again.
    pub fn render(&mut self, wanted: Wanted, texture: Option<wgpu::Texture>, stop: &AtomicBool) -> Rendered {
        if texture.is_some_and(|texture| self.render_in_place(wanted, &texture, stop)) {
            return Rendered::InPlace;
        }
        match self.draw(wanted, stop) {
            Ok(()) => return Rendered::InMemory,
            Err(Error::Render { source: RenderError::Stopped, .. }) => self.given = None,
            Err(error) => self.note(Err(error)),
        }
        Rendered::Nowhere
    }

    /// Renders the picture or the debug view, unless it is the current one.
    pub(super) fn draw(&mut self, wanted: Wanted, stop: &AtomicBool) -> Result<(), Error> {
        if self.drawn == Some(wanted) {
            return Ok(());
        }
        self.begin(wanted)?;
        let start = Instant::now();
        let request = self.job.request(wanted.debug.is_some()).until(stop);
        let backend = self.engines.drawing_mut();
        let rendered = self.job.render(backend.backend(), &request, &mut self.picture);
        match rendered {
            Err(Error::Render { source, .. }) if is_of_device(&source) && backend.shared().is_some() => {
                self.unshare(source);
                let request = self.job.request(wanted.debug.is_some()).until(stop);
                self.job.render(self.engines.drawing_mut().backend(), &request, &mut self.picture)?;
            }
            rendered => rendered?,
        }
        let job = &self.job;
        self.shown = wanted.debug.map(|view| job.show(view, &self.picture)).transpose()?;
        self.measured(wanted.detail, start, self.picture.stages_ms);
        self.drawn = Some(wanted);
        Ok(())
    }

    /// Renders the picture into a texture of the window's device. Returns whether it succeeded; on a failure the
    /// device is no longer shared.
    fn render_in_place(&mut self, wanted: Wanted, texture: &wgpu::Texture, stop: &AtomicBool) -> bool {
        if self.begin(wanted).is_err() {
            return false;
        }
        let start = Instant::now();
        let Some(gpu) = self.engines.drawing_mut().shared() else { return false };
        match gpu.render_into(texture, &self.job.scene, &self.job.request(false).until(stop)) {
            Ok(stages_ms) => {
                self.measured(wanted.detail, start, stages_ms);
                true
            }
            Err(error) => {
                if is_of_device(&error) {
                    self.unshare(error);
                }
                false
            }
        }
    }

    /// Stops sharing the window's device after its failure.
    fn unshare(&mut self, why: RenderError) {
        self.console.say(format_args!("warning: {why}; pictures are read back from here on"));
        let unshared = self.engines.drawing_mut().unshare(&self.console);
        self.note(unshared);
    }

    /// Applies the settings of a picture to the job.
    fn begin(&mut self, wanted: Wanted) -> Result<(), Error> {
        (self.drawn, self.shown) = (None, None);
        wanted.check()?;
        self.engines.drawing_mut().set_hybrid(wanted.hybrid, &self.console)?;
        wanted.apply(&mut self.job);
        Ok(())
    }

    /// Records the time of a picture.
    fn measured(&mut self, detail: Detail, start: Instant, stages_ms: [f64; Stage::COUNT]) {
        let frame_ms = start.elapsed().as_secs_f64() * 1e3;
        let engine = self.engines.drawing_mut();
        // Later frames do not compile shaders.
        if engine.is_warm || !engine.is_gpu() {
            self.pace.measured(detail.rays(), frame_ms);
        }
        engine.is_warm = true;
        self.timing = Some(Timing { detail, frame_ms, stages_ms });
    }

    /// The pixels of the last picture, row by row: red, green, blue, alpha.
    pub fn pixels(&self) -> Cow<'_, [u8]> {
        pixels(self.shown.as_ref(), &self.picture)
    }
}

/// The pixels of a debug view, or else of a picture, row by row: red, green, blue, alpha.
pub(super) fn pixels<'a>(shown: Option<&'a DebugImage>, picture: &'a Picture) -> Cow<'a, [u8]> {
    match shown {
        Some(shown) => little_endian(&shown.pixels),
        None => picture.bytes(),
    }
}

impl Wanted {
    /// An error if the picture has too many rays.
    pub(super) fn check(&self) -> Result<(), Error> {
        rays(self.detail.size, self.detail.samples, self.debug.is_some()).map(drop)
    }

    /// Gives a job the settings of the picture.
    pub(super) fn apply(&self, job: &mut RenderJob) {
        let Self { detail, shadows, layers, exposure, tone_map, .. } = *self;
        (job.size, job.samples, job.shadows, job.layers) = (detail.size, detail.samples, shadows, layers);
        (job.exposure, job.tone_map) = (exposure, tone_map);
    }
}

/// Whether the error comes from the device, so that another backend may succeed.
fn is_of_device(error: &RenderError) -> bool {
    matches!(error, RenderError::Backend { .. })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Command;
    use crate::command::view::shots::Shots;
    use clap::Parser;

    /// A viewer without a window on a GPU; none, with a message, without a GPU.
    fn viewer() -> Option<Viewer> {
        // A replay does not let the CPU draw while shaders are compiled.
        let line = "rtrt view demo:matchbox --size 64x36 --samples 1 --backend gpu --quiet --replay none";
        let Command::View(options) = Command::parse_from(line.split(' ')) else { unreachable!() };
        let waker: crate::command::view::viewer::Waker = std::sync::Arc::new(|| ());
        match Viewer::new(&options, waker.clone(), Shots::new(waker)) {
            Err(error @ Error::Choose(_)) if std::env::var_os("RTRT_REQUIRE_GPU").is_none() => {
                println!("skipped: {error}");
                None
            }
            viewer => Some(viewer.unwrap()),
        }
    }

    /// A device of the same adapter, as a window has one, that binds so many storage buffers.
    fn device(viewer: &Viewer, bindings: u32) -> (wgpu::Device, wgpu::Queue) {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        let label = |info: wgpu::AdapterInfo| format!("{} ({})", info.name, info.backend);
        let mut same =
            adapters.into_iter().filter(|adapter| label(adapter.get_info()) == viewer.machine().adapter());
        let adapter = same.next().unwrap();
        let limits = adapter.limits();
        let descriptor = wgpu::DeviceDescriptor {
            required_features: adapter.features() & rtrt_gpu::FEATURES,
            required_limits: wgpu::Limits { max_storage_buffers_per_shader_stage: bindings, ..limits },
            ..Default::default()
        };
        pollster::block_on(adapter.request_device(&descriptor)).unwrap()
    }

    /// Renders the next picture. Returns whether it is in a texture of the device.
    fn renders_in_place(viewer: &mut Viewer, device: &wgpu::Device) -> bool {
        let wanted = viewer.next().unwrap();
        let [width, height] = wanted.detail.size;
        let texture = viewer.is_rendered_in_place(&wanted).then(|| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        });
        let rendered = viewer.render(wanted, texture, &AtomicBool::new(false));
        assert!(viewer.failure().is_none());
        rendered == Rendered::InPlace
    }

    /// Asserts that the picture equals that of the CPU.
    fn assert_right(viewer: &mut Viewer) {
        let pixels = viewer.pixels().to_vec();
        viewer.switch().unwrap();
        let wanted = viewer.next().unwrap();
        viewer.render(wanted, None, &AtomicBool::new(false));
        assert!(*pixels == *viewer.pixels(), "the picture is another one");
    }

    #[test]
    fn a_device_that_cannot_be_shared_is_left_alone() {
        let Some(mut viewer) = viewer() else { return };
        let (device, queue) = device(&viewer, 4);
        viewer.share(&device, &queue);
        assert!(!renders_in_place(&mut viewer, &device));
        assert_right(&mut viewer);
    }

    #[test]
    fn a_lost_device_is_no_longer_shared() {
        let Some(mut viewer) = viewer() else { return };
        let (device, queue) = device(&viewer, 8);
        viewer.share(&device, &queue);
        assert!(renders_in_place(&mut viewer, &device), "the device is not shared");
        device.destroy();
        viewer.touch();
        assert!(!renders_in_place(&mut viewer, &device));
        assert_right(&mut viewer);
        // The device is not shared again.
        viewer.switch().unwrap();
        viewer.touch();
        assert!(!renders_in_place(&mut viewer, &device));
    }
}
