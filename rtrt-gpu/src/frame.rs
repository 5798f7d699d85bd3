//! One frame on a device: bin, then band after band of rays.

use crate::Error;
use crate::band::{Band, bands, shadow_words};
use crate::buffers::{Buffers, Slot};
use crate::device::{Device, watched};
use crate::pipeline::{FIRST_OF_BAND, LAYERS, PASSES, Pipeline, ZEROED, groups};
use crate::texture::{check, copy};
use crate::timer::Timer;
use bytemuck::Pod;
use rtrt_core::backend::{Deferred, Picture, STAGES};
use rtrt_core::grid::{BLOCK_RAYS, RayIndex};
use rtrt_core::kernel::cover::Cover;
use rtrt_core::kernel::lists::{Entry, Lists};
use rtrt_core::layout::{Frame, Hit, Lit, Surface, View};
use rtrt_core::scene::{Scene, Setup};
use rtrt_core::stage;
use rtrt_core::stage::edges::Edges;
use std::ops::Range;
use wgpu::BufferUsages;

/// Entries that the lists have room for at first.
const FIRST_CAPACITY: u32 = 1 << 16;

/// What is read back after a band: the number of entries in the lists, then times, then
/// pixels. Times want to be aligned to 256 bytes.
const TIMES: u64 = 256;
const PIXELS: u64 = 512;

/// Everything that renders frames on one device.
pub(crate) struct Renderer {
    pub device: Device,
    pipelines: Vec<Pipeline>,
    buffers: Buffers,
    /// The numbers of the frame for each layer of surfaces behind the first.
    layers: Vec<wgpu::Buffer>,
    read_back: Option<wgpu::Buffer>,
    timer: Timer,
    capacity: u32,
    /// The most bytes that a buffer of a band may have.
    band_bytes: u64,
}

impl Renderer {
    /// Compiles all entry points.
    pub fn new(device: Device, band_bytes: Option<u64>) -> Result<Self, Error> {
        let (pipelines, timer) = watched(&device.device, || Ok((pipelines(&device), Timer::new(&device)?)))?;
        Ok(Self {
            band_bytes: band_bytes.unwrap_or(u64::MAX).min(device.limit),
            device,
            pipelines,
            buffers: Buffers::default(),
            layers: Vec::new(),
            read_back: None,
            timer,
            capacity: FIRST_CAPACITY,
        })
    }

    /// Renders the frame that was set up into the picture, or into a texture: the picture then holds
    /// times, and no pixels.
    pub fn render(
        &mut self,
        scene: &Scene,
        setup: &Setup,
        deferred: bool,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<(), Error> {
        let device = self.device.device.clone();
        let result = watched(&device, || self.frame(scene, setup, deferred, texture, picture));
        if result.is_err() {
            // Whatever is there now is not to be relied on.
            self.buffers = Buffers::default();
            self.read_back = None;
        }
        result
    }

    fn frame(
        &mut self,
        scene: &Scene,
        setup: &Setup,
        deferred: bool,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<(), Error> {
        let frame = setup.frame;
        match texture {
            Some(texture) => check(texture, &frame)?,
            None => {
                picture.width = frame.width;
                picture.height = frame.height;
                picture.pixels.resize((frame.width * frame.height) as usize, 0);
            }
        }
        let empty = || {
            let tint_words = if frame.is_tinted() { frame.lights } else { 0 };
            let layer_count = frame.layers.max(1) - 1;
            let mask_words = frame.mask_words;
            deferred.then(|| Deferred { mask_words, tint_words, layer_count, ..Deferred::default() })
        };
        picture.stages_ms = [0.0; STAGES.len()];
        self.buffers.upload_scene(&self.device, scene, setup)?;
        self.buffers.upload::<View>(&self.device, Slot::Views, &setup.views)?;
        let covers = u64::from(stage::prepare::count(&frame));
        self.buffers.reserve::<Cover>(&self.device, Slot::Covers, covers)?;
        self.buffers.reserve::<u32>(&self.device, Slot::Counts, u64::from(frame.blocks))?;

        let mut bands = bands(&frame, self.band_bytes);
        let Some(first) = bands.next() else { return Ok(()) };
        let entries = loop {
            picture.deferred = empty();
            let entries = self.band(first.with_room(self.capacity), 0, texture, picture)?;
            if entries <= self.capacity {
                break entries;
            }
            // Nothing is lost because a list was full: the frame begins again with room.
            self.capacity = entries.saturating_add(entries / 4);
            picture.stages_ms = [0.0; STAGES.len()];
        };
        for band in bands {
            self.band(band.with_room(self.capacity), FIRST_OF_BAND, texture, picture)?;
        }
        if let Some(deferred) = &mut picture.deferred {
            let words = u64::from(Lists::header(frame.blocks)) + 2 * u64::from(entries);
            self.fetch(Slot::Lists, 0..words as usize, &mut deferred.lists)?;
        }
        Ok(())
    }

    /// Runs the stages from `first_stage` on for a band of rays, and reads its times back, and its
    /// pixels if they do not go into a texture. Gives the number of entries in the lists.
    fn band(
        &mut self,
        band: Band,
        first_stage: usize,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<u32, Error> {
        let (device, frame) = (&self.device, &band.frame);
        let [first_made, pixel_count] = frame.grid().pixels(RayIndex(frame.first_ray), frame.rays);
        let [first_pixel, kept_pixels] = frame.grid().pixels(RayIndex(band.first), band.rays);
        let skipped = first_pixel - first_made;
        let rays = u64::from(frame.rays);
        let list_words = u64::from(Lists::header(frame.blocks)) + 2 * u64::from(frame.capacity);
        let behind = frame.layers.max(1) - 1;
        let kept = if picture.deferred.is_some() { u64::from(behind) } else { 0 };
        let [shadows, tints] = shadow_words(frame);
        self.buffers.upload(device, Slot::Frame, &[*frame])?;
        while self.layers.len() < behind as usize {
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            self.layers.push(device.buffer("frame of a layer", size_of::<Frame>() as u64, usage)?);
        }
        for (layers, buffer) in (1..frame.layers).rev().zip(&self.layers) {
            device.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&Frame { layers, ..*frame }));
        }
        self.buffers.reserve::<Entry>(device, Slot::Placed, u64::from(frame.capacity))?;
        self.buffers.reserve::<u32>(device, Slot::Lists, list_words)?;
        self.buffers.reserve::<Hit>(device, Slot::Hits, rays)?;
        self.buffers.reserve::<Surface>(device, Slot::Surfaces, rays)?;
        self.buffers.reserve::<u32>(device, Slot::Masks, rays * u64::from(frame.mask_words))?;
        self.buffers.reserve::<u32>(device, Slot::Shadows, rays * shadows)?;
        let blocks = if frame.window == 0 { 0 } else { rays / u64::from(BLOCK_RAYS) };
        self.buffers.reserve::<Edges>(device, Slot::Edges, blocks * u64::from(frame.lights))?;
        self.buffers.reserve::<u32>(device, Slot::Soft, blocks * u64::from(frame.lights))?;
        self.buffers.reserve::<u32>(device, Slot::Tints, rays * tints)?;
        self.buffers.reserve::<Hit>(device, Slot::Layers, rays * kept)?;
        self.buffers.reserve::<Lit>(device, Slot::Lit, rays)?;
        self.buffers.reserve::<[f32; 4]>(device, Slot::Colors, rays)?;
        self.buffers.reserve::<u32>(device, Slot::Pixels, u64::from(pixel_count))?;
        let bytes = PIXELS + if texture.is_some() { 0 } else { 4 * u64::from(pixel_count) };
        if self.read_back.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
            self.read_back = Some(device.buffer("read back", bytes, usage)?);
        }

        let mut commands = device.device.create_command_encoder(&Default::default());
        for stage in first_stage..STAGES.len() {
            if stage == LAYERS && picture.deferred.is_some() {
                // The layers behind the first take its buffers.
                let next = device.device.create_command_encoder(&Default::default());
                device.queue.submit([std::mem::replace(&mut commands, next).finish()]);
                self.fetch_first_layer(&band, &mut picture.deferred)?;
            }
            self.encode(&mut commands, frame, stage, kept > 0);
            self.timer.end_stage(device, &mut commands, stage, &mut picture.stages_ms)?;
        }
        let (Some(read_back), Some(lists), Some(made)) =
            (&self.read_back, self.buffers.get(Slot::Lists), self.buffers.get(Slot::Pixels))
        else {
            return Ok(0);
        };
        commands.copy_buffer_to_buffer(lists, 4 * u64::from(frame.blocks), read_back, 0, 4);
        match texture {
            Some(texture) => {
                copy(&mut commands, made, skipped, frame.width, [first_pixel, kept_pixels], texture);
            }
            None => commands.copy_buffer_to_buffer(made, 0, read_back, PIXELS, 4 * u64::from(pixel_count)),
        }
        self.timer.copy(&mut commands, read_back, TIMES);
        let mut entries = 0;
        let timer = &self.timer;
        device.finish(commands, read_back, bytes, |mapped| {
            entries = bytemuck::pod_read_unaligned(&mapped[..4]);
            timer.add(&mapped[TIMES as usize..PIXELS as usize], first_stage, &mut picture.stages_ms);
            if texture.is_none() {
                let range = first_pixel as usize..(first_pixel + kept_pixels) as usize;
                let from = PIXELS as usize + 4 * skipped as usize;
                let kept = &mapped[from..from + 4 * kept_pixels as usize];
                bytemuck::cast_slice_mut(&mut picture.pixels[range]).copy_from_slice(kept);
            }
        })?;
        self.fetch_colors(&band, &mut picture.deferred)?;
        Ok(entries)
    }

    /// Appends the dispatches of a stage to the commands. With `keep`, what each layer has hit
    /// is copied.
    fn encode(&self, commands: &mut wgpu::CommandEncoder, frame: &Frame, stage: usize, keep: bool) {
        for (_, slot) in ZEROED.iter().filter(|(of, slot)| *of == stage && is_zeroed(frame, *slot)) {
            if let Some(buffer) = self.buffers.get(*slot) {
                commands.clear_buffer(buffer, 0, None);
            }
        }
        if stage != LAYERS {
            return self.encode_pass(commands, frame, stage, None, self.timer.writes(stage));
        }
        let Some(last) = (frame.layers.max(1) as usize - 1).checked_sub(1) else {
            // Nothing but its time.
            _ = commands.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(STAGES[stage]),
                timestamp_writes: self.timer.writes(stage),
            });
            return;
        };
        let bytes = u64::from(frame.rays) * size_of::<Hit>() as u64;
        for (number, uniform) in self.layers[..=last].iter().enumerate() {
            let writes = self.timer.writes_of(stage, number == 0, number == last);
            self.encode_pass(commands, frame, stage, Some(uniform), writes);
            if let (true, Some(hits), Some(layers)) =
                (keep, self.buffers.get(Slot::Hits), self.buffers.get(Slot::Layers))
            {
                commands.copy_buffer_to_buffer(hits, 0, layers, number as u64 * bytes, bytes);
            }
        }
    }

    /// Appends the dispatches of a stage once; `uniform` is what they get for the numbers of
    /// the frame, if not those.
    fn encode_pass(
        &self,
        commands: &mut wgpu::CommandEncoder,
        frame: &Frame,
        stage: usize,
        uniform: Option<&wgpu::Buffer>,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let label = Some(STAGES[stage]);
        let mut pass = commands.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        for (row, pipeline) in PASSES.iter().zip(&self.pipelines).filter(|(row, _)| row.stage == stage) {
            let groups = groups((row.work)(frame));
            if groups.contains(&0) {
                continue;
            }
            let buffers = row.slots().filter_map(|slot| match (slot, uniform) {
                (Slot::Frame, Some(uniform)) => Some(uniform),
                _ => self.buffers.get(slot),
            });
            pipeline.dispatch(&self.device.device, &mut pass, buffers, groups);
        }
    }

    /// Appends what a band's first layer has left to the deferred buffers, if they were asked
    /// for.
    fn fetch_first_layer(&self, band: &Band, deferred: &mut Option<Deferred>) -> Result<(), Error> {
        let Some(deferred) = deferred else { return Ok(()) };
        let (frame, tints) = (&band.frame, deferred.tint_words);
        self.fetch(Slot::Hits, band.kept(1), &mut deferred.hits)?;
        self.fetch(Slot::Surfaces, band.kept(1), &mut deferred.surfaces)?;
        self.fetch(Slot::Masks, band.kept(frame.mask_words), &mut deferred.masks)?;
        self.fetch(Slot::Lit, band.kept(1), &mut deferred.lit)?;
        self.fetch(Slot::Tints, band.kept(tints), &mut deferred.tints)?;
        if frame.window > 0 {
            let (left, behind) = (band.kept(tints), frame.rays as usize * tints as usize);
            self.fetch(Slot::Shadows, left.clone(), &mut deferred.left)?;
            let sizes = left.start + behind..left.end + behind;
            self.fetch(Slot::Shadows, sizes, &mut deferred.penumbras)?;
        }
        Ok(())
    }

    /// Appends a band's colors and what its layers have hit to the deferred buffers, if they
    /// were asked for.
    fn fetch_colors(&self, band: &Band, deferred: &mut Option<Deferred>) -> Result<(), Error> {
        let Some(deferred) = deferred else { return Ok(()) };
        let (rays, count) = (band.frame.rays as usize, deferred.layer_count as usize);
        self.fetch(Slot::Colors, band.kept(1), &mut deferred.colors)?;
        if count > 0 {
            let mut layers: Vec<Hit> = Vec::new();
            self.fetch(Slot::Layers, 0..rays * count, &mut layers)?;
            let kept = band.kept(deferred.layer_count);
            deferred.layers.extend(kept.map(|at| layers[at % count * rays + at / count]));
        }
        Ok(())
    }

    /// Appends these elements of a buffer to `to`.
    fn fetch<T: Pod>(&self, slot: Slot, range: Range<usize>, to: &mut Vec<T>) -> Result<(), Error> {
        let Some(buffer) = self.buffers.get(slot).filter(|_| !range.is_empty()) else { return Ok(()) };
        let size = size_of::<T>();
        let bytes = self.device.fetch(buffer, (range.end * size) as u64)?;
        to.extend(bytemuck::pod_collect_to_vec::<u8, T>(&bytes[range.start * size..]));
        Ok(())
    }
}

/// The pipelines of all passes; one that is in the table twice is compiled once.
fn pipelines(device: &Device) -> Vec<Pipeline> {
    let mut pipelines: Vec<Pipeline> = Vec::with_capacity(PASSES.len());
    for (number, pass) in PASSES.iter().enumerate() {
        let known = PASSES[..number].iter().position(|earlier| earlier.entry == pass.entry);
        pipelines.push(match known {
            Some(earlier) => pipelines[earlier].clone(),
            None => device.pipeline(pass.entry, pass.accesses()),
        });
    }
    pipelines
}

/// Whether a buffer of [`ZEROED`] has to be zero in this frame.
fn is_zeroed(frame: &Frame, slot: Slot) -> bool {
    match slot {
        Slot::Hits => frame.layers > 0,
        Slot::Masks => frame.layers == 0,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gpu, Options};
    use rtrt_core::backend::{Backend, Request, Shadows};
    use rtrt_core::scene::{Camera, Projection};

    #[test]
    fn a_buffer_beyond_the_limit_is_an_error_and_the_next_frame_is_not() {
        let mut gpu = match Gpu::new(Options::default()) {
            Ok(gpu) => gpu,
            Err(error) if std::env::var_os("RTRT_REQUIRE_GPU").is_some() => panic!("{error}"),
            Err(error) => return println!("skipped: {error}"),
        };
        let camera = Camera {
            eye: [0.0; 3].into(),
            look_at: [1.0; 3].into(),
            up: [0.0, 1.0, 0.0].into(),
            projection: Projection::Perspective { fov_y: 1.0 },
        };
        let request = Request {
            camera: &camera,
            size: [40, 30],
            samples: 1,
            shadows: Shadows::Soft,
            layers: 8,
            deferred: false,
        };
        let limit = std::mem::replace(&mut gpu.renderer.device.limit, 10_000);
        let mut picture = Picture::default();
        let error = gpu.render(&Scene::new(), &request, &mut picture).unwrap_err();
        assert!(error.to_string().contains("the device allows 10000"), "{error}");
        gpu.renderer.device.limit = limit;
        gpu.render(&Scene::new(), &request, &mut picture).unwrap();
    }
}
