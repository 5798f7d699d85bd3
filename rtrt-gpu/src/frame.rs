//! One frame on a device: bin, unless the lists are still the same, then band after band of rays.

use crate::Error;
use crate::band::{Band, bands, shadow_words};
use crate::buffers::{Buffers, Slot};
use crate::device::{Device, watched};
use crate::pipeline::{DRAWN, FIRST_OF_BAND, LAYERS, PASSES, Pipeline, ZEROED, groups};
use crate::raster::Raster;
use crate::texture::{check, copy};
use crate::timer::{HostClock, Timer};
use rtrt_core::backend::{Deferred, Picture, STAGES};
use rtrt_core::grid::{BLOCK_RAYS, RayIndex};
use rtrt_core::kernel::lists::{BlockLists, ListEntry};
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::layout::{Frame, Hit, Lit, Surface, View};
use rtrt_core::scene::{ListCacheKey, ReusableLists, Scene, Setup};
use rtrt_core::stage;
use rtrt_core::stage::penumbra_blocks::PenumbraSummary;
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
    /// For each row of [`PASSES`], once a frame has needed it.
    pipelines: Vec<Option<Pipeline>>,
    pub buffers: Buffers,
    /// The numbers of the frame for each layer of surfaces behind the first.
    layers: Vec<wgpu::Buffer>,
    read_back: Option<wgpu::Buffer>,
    timer: Timer,
    /// What draws the closest surfaces, if they are not to be traced.
    raster: Option<Raster>,
    capacity: u32,
    /// What the lists were made of that are there, the blocks that they have, and their room.
    list_key: ListCacheKey,
    listed: Option<[u32; 2]>,
    /// The most bytes that a buffer of a band may have.
    band_bytes: u64,
}

impl Renderer {
    /// A renderer that has compiled nothing yet.
    pub fn new(device: Device, band_bytes: Option<u64>) -> Result<Self, Error> {
        let timer = watched(&device.device, || Timer::new(&device))?;
        Ok(Self {
            band_bytes: band_bytes.unwrap_or(u64::MAX).min(device.limit),
            device,
            pipelines: vec![None; PASSES.len()],
            buffers: Buffers::default(),
            layers: Vec::new(),
            read_back: None,
            timer,
            raster: None,
            capacity: FIRST_CAPACITY,
            list_key: ListCacheKey::default(),
            listed: None,
        })
    }

    /// Has the closest surfaces drawn instead of traced, or traced again.
    pub fn set_hybrid(&mut self, is_hybrid: bool) -> Result<(), Error> {
        if is_hybrid != self.raster.is_some() {
            self.raster = None;
            if is_hybrid {
                self.raster = Some(watched(&self.device.device, || Ok(Raster::new(&self.device)))?);
            }
        }
        Ok(())
    }

    /// Renders the frame that was set up into the picture, or into a texture: the picture then holds
    /// times, and no pixels.
    pub fn render(
        &mut self,
        scene: &Scene,
        setup: &Setup,
        deferred: bool,
        mut clock: HostClock,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<(), Error> {
        let device = self.device.device.clone();
        let result = watched(&device, || self.frame(scene, setup, deferred, &mut clock, texture, picture));
        picture.host_ms = Some(clock.ms);
        if result.is_err() {
            // Whatever is there now is not to be relied on.
            self.buffers = Buffers::default();
            self.listed = None;
            self.read_back = None;
        }
        result
    }

    fn frame(
        &mut self,
        scene: &Scene,
        setup: &Setup,
        deferred: bool,
        clock: &mut HostClock,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<(), Error> {
        let frame = Frame { is_drawn: u32::from(self.raster.is_some()), ..setup.frame };
        match texture {
            Some(texture) => check(texture, &frame)?,
            None => {
                picture.width = frame.width;
                picture.height = frame.height;
                picture.pixels.resize((frame.width * frame.height) as usize, 0);
            }
        }
        let empty = || {
            let transmittance_words = if frame.has_transmittance() { frame.lights } else { 0 };
            let layer_count = frame.layers.max(1) - 1;
            let mask_words = frame.mask_words;
            deferred.then(|| Deferred { mask_words, transmittance_words, layer_count, ..Deferred::default() })
        };
        picture.stages_ms = [0.0; STAGES.len()];
        self.buffers.upload_scene(&self.device, scene, setup)?;
        self.buffers.renew::<View>(&self.device, Slot::Views, &setup.views)?;
        let screen_bounds = u64::from(stage::prepare::count(&frame));
        self.buffers.reserve::<ScreenBounds>(&self.device, Slot::ScreenBounds, screen_bounds)?;
        self.buffers.reserve::<u32>(&self.device, Slot::Counts, u64::from(frame.blocks))?;
        if let Some(raster) = &mut self.raster {
            raster.begin(scene, setup);
        }

        let mut kept = self.list_key.reusable(setup, scene);
        if self.listed.take() != Some([frame.blocks, self.capacity]) {
            kept = ReusableLists::Nothing;
        }
        let entries = loop {
            picture.deferred = empty();
            let (frame, first_stage) = match kept {
                ReusableLists::Nothing => (frame, 0),
                ReusableLists::Lights => {
                    let first_block = setup.views[Frame::CAMERA as usize].first_block;
                    (Frame { views: 1, first_block, ..frame }, 0)
                }
                ReusableLists::All => (frame, FIRST_OF_BAND),
            };
            let frame = Frame { capacity: self.capacity, ..frame };
            let mut bands = bands(&frame, self.band_bytes);
            let Some(first) = bands.next() else { return Ok(()) };
            let entries = self.band(first, first_stage, clock, texture, picture)?;
            if entries <= self.capacity {
                for band in bands {
                    self.band(band, FIRST_OF_BAND, clock, texture, picture)?;
                }
                break entries;
            }
            // Nothing is lost because a list was full: the frame begins again with room.
            self.capacity = entries.saturating_add(entries / 4);
            kept = ReusableLists::Nothing;
            picture.stages_ms = [0.0; STAGES.len()];
        };
        self.listed = Some([frame.blocks, self.capacity]);
        if let Some(deferred) = &mut picture.deferred {
            let words = u64::from(BlockLists::header(frame.blocks)) + 2 * u64::from(entries);
            self.fetch(Slot::BlockLists, 0..words as usize, &mut deferred.lists)?;
        }
        Ok(())
    }

    /// Runs the stages from `first_stage` on for a band of rays, and reads its times back, and its
    /// pixels if they do not go into a texture. Gives the number of entries in the lists.
    fn band(
        &mut self,
        band: Band,
        first_stage: usize,
        clock: &mut HostClock,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<u32, Error> {
        let (device, frame) = (&self.device, &band.frame);
        let [first_made, pixel_count] = frame.grid().pixels(RayIndex(frame.first_ray), frame.rays);
        let [first_pixel, kept_pixels] = frame.grid().pixels(RayIndex(band.first), band.rays);
        let skipped = first_pixel - first_made;
        let rays = u64::from(frame.rays);
        let list_words = u64::from(BlockLists::header(frame.blocks)) + 2 * u64::from(frame.capacity);
        let behind = frame.layers.max(1) - 1;
        let kept = if picture.deferred.is_some() { u64::from(behind) } else { 0 };
        let [shadows, transmittance] = shadow_words(frame);
        while self.layers.len() < behind as usize {
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            self.layers.push(device.buffer("frame of a layer", size_of::<Frame>() as u64, usage)?);
        }
        if self.buffers.renew(device, Slot::Frame, &[*frame])? {
            for (layers, buffer) in (1..frame.layers).rev().zip(&self.layers) {
                device.queue.write_buffer(
                    buffer,
                    0,
                    bytemuck::bytes_of(&Frame { layers, is_drawn: 0, ..*frame }),
                );
            }
        }
        self.buffers.reserve::<ListEntry>(device, Slot::Placed, u64::from(frame.capacity))?;
        self.buffers.reserve::<u32>(device, Slot::BlockLists, list_words)?;
        self.buffers.reserve::<Hit>(device, Slot::Hits, rays)?;
        self.buffers.reserve::<Surface>(device, Slot::Surfaces, rays)?;
        self.buffers.reserve::<u32>(device, Slot::Masks, rays * u64::from(frame.mask_words))?;
        self.buffers.reserve::<u32>(device, Slot::Shadows, rays * shadows)?;
        let blocks = if frame.penumbra_window == 0 { 0 } else { rays / u64::from(BLOCK_RAYS) };
        self.buffers.reserve::<PenumbraSummary>(
            device,
            Slot::PenumbraSummary,
            blocks * u64::from(frame.lights),
        )?;
        self.buffers.reserve::<u32>(device, Slot::Soft, blocks * u64::from(frame.lights))?;
        self.buffers.reserve::<u32>(device, Slot::Transmittance, rays * transmittance)?;
        self.buffers.reserve::<Hit>(device, Slot::Layers, rays * kept)?;
        self.buffers.reserve::<Lit>(device, Slot::Lit, rays)?;
        self.buffers.reserve::<[f32; 4]>(device, Slot::Colors, rays)?;
        self.buffers.reserve::<u32>(device, Slot::Pixels, u64::from(pixel_count))?;
        if let Some(raster) = &mut self.raster {
            raster.reserve(device, &mut self.buffers, frame)?;
        }
        let bytes = PIXELS + if texture.is_some() { 0 } else { 4 * u64::from(pixel_count) };
        if self.read_back.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
            self.read_back = Some(device.buffer("read back", bytes, usage)?);
        }

        compile(device, frame, &mut self.pipelines);
        self.buffers.bind(device, frame, &self.pipelines, &self.layers);
        let mut commands = device.device.create_command_encoder(&Default::default());
        for stage in first_stage..STAGES.len() {
            if stage == LAYERS && picture.deferred.is_some() {
                // The layers behind the first take its buffers.
                let next = device.device.create_command_encoder(&Default::default());
                device.queue.submit([std::mem::replace(&mut commands, next).finish()]);
                self.fetch_first_layer(&band, &mut picture.deferred)?;
            }
            self.encode(&mut commands, frame, stage, kept > 0);
            self.timer.end_stage(device, &mut commands, clock, stage, &mut picture.stages_ms)?;
        }
        let (Some(read_back), Some(lists), Some(made)) =
            (&self.read_back, self.buffers.get(Slot::BlockLists), self.buffers.get(Slot::Pixels))
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
        device.queue.submit([commands.finish()]);
        clock.pause();
        device.read(read_back, bytes, |mapped| {
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
        clock.resume();
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
        if let (FIRST_OF_BAND, Some(raster)) = (stage, &self.raster) {
            raster.encode(&self.device, commands, (stage, &self.timer), frame, &self.buffers);
            return self.encode_drawn(commands, raster, frame, stage);
        }
        if stage != LAYERS {
            return self.encode_pass(commands, frame, stage, 0, self.timer.writes(stage));
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
        for number in 0..=last {
            let writes = self.timer.writes_of(stage, number == 0, number == last);
            self.encode_pass(commands, frame, stage, number, writes);
            if let (true, Some(hits), Some(layers)) =
                (keep, self.buffers.get(Slot::Hits), self.buffers.get(Slot::Layers))
            {
                commands.copy_buffer_to_buffer(hits, 0, layers, number as u64 * bytes, bytes);
            }
        }
    }

    /// Appends the dispatches of a stage once; of the one that is repeated, those for a layer.
    fn encode_pass(
        &self,
        commands: &mut wgpu::CommandEncoder,
        frame: &Frame,
        stage: usize,
        layer: usize,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let label = Some(STAGES[stage]);
        let mut pass = commands.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        for (row, (of, pipeline)) in PASSES.iter().zip(&self.pipelines).enumerate() {
            let groups = groups((of.work)(frame));
            if of.stage != stage || groups.contains(&0) {
                continue;
            }
            if let (Some(pipeline), Some(group)) = (pipeline, self.buffers.group(row, layer)) {
                pipeline.dispatch(&mut pass, group, groups);
            }
        }
    }

    /// Appends the dispatches that follow what was drawn.
    fn encode_drawn(
        &self,
        commands: &mut wgpu::CommandEncoder,
        raster: &Raster,
        frame: &Frame,
        stage: usize,
    ) {
        let timestamp_writes = self.timer.writes_of(stage, false, true);
        let label = Some(STAGES[stage]);
        let mut pass = commands.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        for (row, pipeline) in DRAWN.iter().zip(&raster.pipelines) {
            let groups = groups((row.work)(frame));
            if groups.contains(&0) {
                continue;
            }
            let buffers = row.slots().filter_map(|slot| self.buffers.get(slot));
            pipeline.dispatch(&mut pass, &pipeline.group(&self.device.device, buffers), groups);
        }
    }
}

/// Compiles what the frame dispatches and was not there; what is in the table twice, once.
fn compile(device: &Device, frame: &Frame, pipelines: &mut [Option<Pipeline>]) {
    for (row, pass) in PASSES.iter().enumerate() {
        if pipelines[row].is_none() && !groups((pass.work)(frame)).contains(&0) {
            let same = PASSES.iter().zip(&*pipelines).filter(|(other, _)| other.entry == pass.entry);
            let known = same.filter_map(|(_, pipeline)| pipeline.clone()).next();
            pipelines[row] = Some(known.unwrap_or_else(|| device.pipeline(pass.entry, pass.accesses())));
        }
    }
}

/// Whether a buffer of [`ZEROED`] has to be zero in this frame.
fn is_zeroed(frame: &Frame, slot: Slot) -> bool {
    match slot {
        Slot::Hits => frame.layers > 0 && frame.is_drawn == 0,
        Slot::Masks => frame.layers == 0,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gpu, Options};
    use glam::{Mat4, Vec3};
    use rtrt_core::backend::{Backend, Request};
    use rtrt_core::layout::Attribute;
    use rtrt_core::scene::{Bvh, Camera, Material, Mesh, Projection, Sequential};
    use rtrt_core::stage::raster::is_untraced;

    const CAMERA: Camera = Camera {
        eye: Vec3::ZERO,
        look_at: Vec3::ONE,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 1.0 },
    };
    const REQUEST: Request<'_> = Request::new(&CAMERA, [40, 30]);

    fn open() -> Option<Gpu> {
        match Gpu::new(Options::default()) {
            Ok(gpu) => Some(gpu),
            Err(error) if std::env::var_os("RTRT_REQUIRE_GPU").is_some() => panic!("{error}"),
            Err(error) => {
                println!("skipped: {error}");
                None
            }
        }
    }

    #[test]
    fn a_buffer_beyond_the_limit_is_an_error_and_the_next_frame_is_not() {
        let Some(mut gpu) = open() else { return };
        let limit = std::mem::replace(&mut gpu.renderer.device.limit, 10_000);
        let mut picture = Picture::default();
        let error = gpu.render(&Scene::new(), &REQUEST, &mut picture).unwrap_err();
        assert!(error.to_string().contains("the device allows 10000"), "{error}");
        gpu.renderer.device.limit = limit;
        gpu.render(&Scene::new(), &REQUEST, &mut picture).unwrap();
    }

    /// A square of `2 · steps²` triangles, in the x–y plane within ±1.
    fn square(steps: u32) -> Mesh {
        let side = steps + 1;
        let place = |i: u32| [(i % side) as f32, (i / side) as f32].map(|x| 2.0 * x / steps as f32 - 1.0);
        let positions: Vec<_> = (0..side * side).map(place).map(|[x, y]| [x, y, 0.0]).collect();
        let attribute = Attribute { normal: [0.0, 0.0, 1.0], uv: [0.0; 2], color: u32::MAX };
        let cells = (0..steps * steps).map(|i| i / steps * side + i % steps);
        let indices = cells.flat_map(|a| [a, a + 1, a + side, a + 1, a + side + 1, a + side]).collect();
        Mesh::new(positions, vec![attribute; (side * side) as usize], indices).unwrap()
    }

    #[test]
    fn what_is_drawn_is_not_traced_but_at_edges_and_in_blocks_of_spheres() {
        let Some(mut gpu) = open() else { return };
        let mut scene = Scene::new();
        let white = scene.add_material(Material::new([1.0; 3])).unwrap();
        let mesh = square(100);
        let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
        scene.add_instance(mesh, white, Mat4::from_rotation_z(0.3)).unwrap();
        let camera = Camera { eye: Vec3::new(0.2, 0.3, 4.0), look_at: Vec3::ZERO, ..CAMERA };
        let request = REQUEST.camera(&camera).size([320, 240]).deferred(true);
        gpu.set_hybrid(true).unwrap();
        // What is not known stays unknown.
        gpu.renderer.raster.as_mut().unwrap().pipelines.truncate(1);
        let mut picture = Picture::default();
        let mut count = |scene: &Scene| {
            gpu.render(scene, &request, &mut picture).unwrap();
            let hits = &picture.deferred.as_ref().unwrap().hits;
            let unknown = hits.iter().filter(|hit| is_untraced(hit)).count();
            (unknown, hits.iter().filter(|hit| hit.t != f32::MAX).count() - unknown)
        };
        let (unknown, known) = count(&scene);
        // A triangle covers half a pixel. Rasterizers round corners, most of them to 1/256 of a pixel.
        assert!(known > 10_000 && unknown * 20 < known, "{unknown} {known}");
        let behind = Mat4::from_translation(Vec3::new(0.0, 0.0, -3.0)) * Mat4::from_scale(Vec3::splat(0.5));
        let sphere = scene.add_sphere(white, behind).unwrap();
        let (same, _) = count(&scene);
        assert_eq!(same, unknown, "a sphere that is hidden is not looked for");
        scene.set_transforms([(sphere, Mat4::from_scale(Vec3::splat(0.5)))]).unwrap();
        let (more, _) = count(&scene);
        assert!(more > unknown + 1000 && more < known, "{more} {unknown} {known}");
    }
}
