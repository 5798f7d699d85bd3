//! Rendering of pictures for the window and for files.

use super::{Timing, Viewer, Wanted};
use crate::command::Error;
use crate::command::job::rays;
use crate::command::view::pace::Detail;
use rtrt_core::backend::{RenderError, little_endian};
use rtrt_core::schedule::Stage;
use std::borrow::Cow;
use std::time::Instant;

impl Viewer {
    /// Whether the picture can be rendered into a texture of the window's device.
    pub fn is_rendered_in_place(&mut self, wanted: &Wanted) -> bool {
        self.backends[self.current].shared().is_some()
            && wanted.debug.is_none()
            && self.drawn.as_ref() != Some(wanted)
    }

    /// Renders the picture, into a texture of the window's device if there is one. A failure is noted. Returns the
    /// size of a picture that is not in the texture.
    pub fn render(&mut self, wanted: Wanted, texture: Option<wgpu::Texture>) -> Option<[u32; 2]> {
        if texture.is_some_and(|texture| self.render_in_place(wanted, &texture)) {
            return None;
        }
        let drawn = self.draw(wanted);
        let is_drawn = drawn.is_ok();
        self.note(drawn);
        is_drawn.then_some(wanted.detail.size)
    }

    /// Renders the picture or the debug view, unless it is the current one.
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
            Err(Error::Render { source, .. }) if is_of_device(&source) && backend.shared().is_some() => {
                self.unshare(source);
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

    /// Renders the picture into a texture of the window's device. Returns whether it succeeded; on a failure the
    /// device is no longer shared.
    fn render_in_place(&mut self, wanted: Wanted, texture: &wgpu::Texture) -> bool {
        if self.begin(wanted).is_err() {
            return false;
        }
        let start = Instant::now();
        let Some(gpu) = self.backends[self.current].shared() else { return false };
        match gpu.render_into(texture, &self.job.scene, &self.job.request(false)) {
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
        let unshared = self.backends[self.current].unshare(&self.console);
        self.note(unshared);
    }

    /// Applies the settings of a picture to the job.
    fn begin(&mut self, wanted: Wanted) -> Result<(), Error> {
        let Wanted { detail, shadows, layers, exposure, tone_map, hybrid, debug, .. } = wanted;
        (self.drawn, self.shown) = (None, None);
        rays(detail.size, detail.samples, debug.is_some())?;
        self.backends[self.current].set_hybrid(hybrid, &self.console)?;
        let job = &mut self.job;
        (job.size, job.samples, job.shadows, job.layers) = (detail.size, detail.samples, shadows, layers);
        (job.exposure, job.tone_map) = (exposure, tone_map);
        Ok(())
    }

    /// Records the time of a picture.
    fn measured(&mut self, detail: Detail, start: Instant, stages_ms: [f64; Stage::COUNT]) {
        let frame_ms = start.elapsed().as_secs_f64() * 1e3;
        // Later frames do not compile shaders.
        if !self.is_cold() {
            self.pace.measured(detail.rays(), frame_ms);
        }
        self.backends[self.current].is_warm = true;
        self.timing = Some(Timing { detail, frame_ms, stages_ms });
    }

    /// The pixels of the last picture, row by row: red, green, blue, alpha.
    pub fn pixels(&self) -> Cow<'_, [u8]> {
        match &self.shown {
            Some(shown) => little_endian(&shown.pixels),
            None => self.picture.bytes(),
        }
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
    use clap::Parser;

    /// A viewer without a window on a GPU; none, with a message, without a GPU.
    fn viewer() -> Option<Viewer> {
        let line = "rtrt view demo:matchbox --size 64x36 --samples 1 --backend gpu --quiet";
        let Command::View(options) = Command::parse_from(line.split(' ')) else { unreachable!() };
        match Viewer::new(&options) {
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
        let read_back = viewer.render(wanted, texture);
        assert!(viewer.message().is_none_or(|text| !text.starts_with("error: ")));
        read_back.is_none()
    }

    /// Asserts that the picture equals that of the CPU.
    fn assert_right(viewer: &mut Viewer) {
        let pixels = viewer.pixels().to_vec();
        viewer.switch().unwrap();
        let wanted = viewer.next().unwrap();
        viewer.render(wanted, None);
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
