//! One frame on a device: bin, unless the lists are still the same, then band after band of rays.

use crate::band::{Band, bands};
use crate::buffers::Buffers;
use crate::device::{Device, watched};
use crate::dispatch::{Encoder, Pipelines};
use crate::error::Error;
use crate::fetch::Results;
use crate::raster::Raster;
use crate::slot::{Slot, list_words};
use crate::texture::{check, copy};
use crate::timer::{HostClock, Timer};
use rtrt_core::backend::{Deferred, Picture, Request};
use rtrt_core::grid::RayIndex;
use rtrt_core::layout::{Frame, View};
use rtrt_core::scene::{ListCacheKey, ReusableLists, Scene, Setup};
use rtrt_core::schedule::Stage;
use std::sync::atomic::{AtomicBool, Ordering};
use wgpu::BufferUsages;

/// Entries that the lists have room for at first.
const FIRST_CAPACITY: u32 = 1 << 16;

/// What is read back after a band: the number of entries in the lists, then times, then
/// pixels. Times want to be aligned to 256 bytes.
const TIMES: u64 = 256;
const PIXELS: u64 = 512;

/// The first stage that is repeated for each band of rays.
const FIRST_OF_BAND: Stage = Stage::Visibility;

/// Everything that renders frames on one device.
pub(crate) struct Renderer {
    pub device: Device,
    pipelines: Pipelines,
    pub buffers: Buffers,
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
    pub async fn new(device: Device, band_bytes: Option<u64>) -> Result<Self, Error> {
        let timer = watched(&device.device, async { Timer::new(&device) }).await?;
        Ok(Self {
            band_bytes: band_bytes.unwrap_or(u64::MAX).min(device.limit),
            device,
            pipelines: Pipelines::new(),
            buffers: Buffers::default(),
            read_back: None,
            timer,
            raster: None,
            capacity: FIRST_CAPACITY,
            list_key: ListCacheKey::default(),
            listed: None,
        })
    }

    /// Has the closest surfaces drawn instead of traced, or traced again.
    pub async fn set_hybrid(&mut self, is_hybrid: bool) -> Result<(), Error> {
        if is_hybrid != self.raster.is_some() {
            self.raster = None;
            if is_hybrid {
                self.raster =
                    Some(watched(&self.device.device, async { Ok(Raster::new(&self.device)) }).await?);
            }
        }
        Ok(())
    }

    /// Renders the frame that was set up into the picture, or into a texture: the picture then holds
    /// times, and no pixels.
    pub async fn render(
        &mut self,
        scene: &Scene,
        setup: &Setup,
        request: &Request<'_>,
        mut clock: HostClock,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<(), Error> {
        let device = self.device.device.clone();
        let result = watched(&device, self.frame(scene, setup, request, &mut clock, texture, picture)).await;
        picture.host_ms = Some(clock.ms);
        // A stopped frame has dispatched nothing that it did not wait for.
        if result.as_ref().is_err_and(|error| !matches!(error, Error::Stopped)) {
            // Whatever is there now is not to be relied on.
            self.buffers = Buffers::default();
            self.listed = None;
            self.read_back = None;
        }
        result
    }

    /// Compiles what frames like this one dispatch.
    pub async fn compile(&mut self, frame: &Frame, stop: &AtomicBool) -> Result<(), Error> {
        let frame = Frame { is_drawn: u32::from(self.raster.is_some()), ..*frame };
        let Self { device, pipelines, .. } = self;
        watched(&device.device, async {
            let is_done = pipelines.compile_all(device, &frame, &|| stop.load(Ordering::Relaxed));
            if is_done { Ok(()) } else { Err(Error::Stopped) }
        })
        .await
    }

    async fn frame(
        &mut self,
        scene: &Scene,
        setup: &Setup,
        request: &Request<'_>,
        clock: &mut HostClock,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<(), Error> {
        let deferred = request.deferred;
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
            deferred.then(|| Deferred {
                mask_words: frame.mask_words,
                transmittance_words: frame.transmittance_words(),
                layer_count: frame.layers_behind(),
                ..Deferred::default()
            })
        };
        picture.stages_ms = [0.0; Stage::COUNT];
        self.buffers.upload_scene(&self.device, scene, setup)?;
        self.buffers.renew::<View>(&self.device, Slot::Views, &setup.views)?;
        if let Some(raster) = &mut self.raster {
            raster.begin(scene, setup);
        }

        let mut kept = self.list_key.reusable(setup, scene);
        if self.listed.take() != Some([frame.blocks, self.capacity]) {
            kept = ReusableLists::Nothing;
        }
        if !self.pipelines.compile_all(&self.device, &frame, &|| request.is_stopped()) {
            return Err(Error::Stopped);
        }
        let entries = loop {
            picture.deferred = empty();
            let (frame, first_stage) = match kept {
                ReusableLists::Nothing => (frame, Stage::Prepare),
                ReusableLists::Lights => {
                    let first_block = setup.views[Frame::CAMERA as usize].first_block;
                    (Frame { views: 1, first_block, ..frame }, Stage::Prepare)
                }
                ReusableLists::All => (frame, FIRST_OF_BAND),
            };
            let frame = Frame { capacity: self.capacity, ..frame };
            let mut bands = bands(&frame, self.band_bytes, deferred);
            let Some(first) = bands.next() else { return Ok(()) };
            let entries = self.band(first, first_stage, clock, texture, picture).await?;
            if entries <= self.capacity {
                for band in bands {
                    if request.is_stopped() {
                        return Err(Error::Stopped);
                    }
                    self.band(band, FIRST_OF_BAND, clock, texture, picture).await?;
                }
                break entries;
            }
            // Nothing is lost because a list was full: the frame begins again with room.
            self.capacity = entries.saturating_add(entries / 4);
            kept = ReusableLists::Nothing;
            picture.stages_ms = [0.0; Stage::COUNT];
        };
        self.listed = Some([frame.blocks, self.capacity]);
        if let Some(deferred) = &mut picture.deferred {
            let words = list_words(&frame, entries) as usize;
            self.results().read(Slot::BlockLists, 0..words, &mut deferred.lists).await?;
        }
        Ok(())
    }

    /// Runs the stages from `first_stage` on for a band of rays, and reads its times back, and its
    /// pixels if they do not go into a texture. Gives the number of entries in the lists.
    async fn band(
        &mut self,
        band: Band,
        first_stage: Stage,
        clock: &mut HostClock,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
    ) -> Result<u32, Error> {
        let (device, frame) = (&self.device, &band.frame);
        let [first_made, pixel_count] = frame.grid().pixels(RayIndex(frame.first_ray), frame.rays);
        let [first_pixel, kept_pixels] = frame.grid().pixels(RayIndex(band.first), band.rays);
        let skipped = first_pixel - first_made;
        let keeps_layers = picture.deferred.is_some() && frame.layers > 1;
        self.buffers.prepare(device, frame, keeps_layers)?;
        if let Some(raster) = &mut self.raster {
            raster.reserve(device, frame)?;
        }
        let bytes = PIXELS + if texture.is_some() { 0 } else { 4 * u64::from(pixel_count) };
        // It returns after it is unmapped, because a caller may drop a frame that is half done.
        let read_back = match self.read_back.take().filter(|buffer| buffer.size() >= bytes) {
            Some(buffer) => buffer,
            None => device.buffer("read back", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?,
        };

        self.pipelines.make(device, frame, &mut self.buffers);
        let results = Results { device, buffers: &self.buffers };
        let encoder = Encoder {
            device,
            pipelines: &self.pipelines,
            buffers: &self.buffers,
            timer: &self.timer,
            raster: self.raster.as_ref(),
            frame,
            keeps_layers,
        };
        let mut commands = device.device.create_command_encoder(&Default::default());
        for stage in Stage::ALL.into_iter().skip(first_stage as usize) {
            if let (Stage::Layers, Some(deferred)) = (stage, &mut picture.deferred) {
                // The layers behind the first take its buffers.
                let next = device.device.create_command_encoder(&Default::default());
                device.queue.submit([std::mem::replace(&mut commands, next).finish()]);
                results.first_layer(&band, deferred).await?;
            }
            encoder.stage(&mut commands, stage);
            self.timer.end_stage(device, &mut commands, clock, stage, &mut picture.stages_ms).await?;
        }
        let (Some(lists), Some(made)) = (self.buffers.get(Slot::BlockLists), self.buffers.get(Slot::Pixels))
        else {
            return Ok(0);
        };
        commands.copy_buffer_to_buffer(lists, 4 * u64::from(frame.blocks), &read_back, 0, 4);
        match texture {
            Some(texture) => {
                copy(&mut commands, made, skipped, frame.width, [first_pixel, kept_pixels], texture);
            }
            None => commands.copy_buffer_to_buffer(made, 0, &read_back, PIXELS, 4 * u64::from(pixel_count)),
        }
        self.timer.copy(&mut commands, &read_back, TIMES);
        let mut entries = 0;
        let timer = &self.timer;
        device.queue.submit([commands.finish()]);
        clock.pause();
        let read = |mapped: &[u8]| {
            entries = bytemuck::pod_read_unaligned(&mapped[..4]);
            timer.add(&mapped[TIMES as usize..PIXELS as usize], first_stage, &mut picture.stages_ms);
            if texture.is_none() {
                let range = first_pixel as usize..(first_pixel + kept_pixels) as usize;
                let from = PIXELS as usize + 4 * skipped as usize;
                let kept = &mapped[from..from + 4 * kept_pixels as usize];
                bytemuck::cast_slice_mut(&mut picture.pixels[range]).copy_from_slice(kept);
            }
        };
        device.read(&read_back, bytes, read).await?;
        if let Some(deferred) = &mut picture.deferred {
            results.colors(&band, deferred).await?;
        }
        self.read_back = Some(read_back);
        clock.resume();
        Ok(entries)
    }

    /// Where results are read from.
    fn results(&self) -> Results<'_> {
        Results { device: &self.device, buffers: &self.buffers }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gpu, Options};
    use glam::{Mat4, Vec3};
    use rtrt_core::backend::Backend;
    use rtrt_core::layout::{Attribute, Hit};
    use rtrt_core::scene::{Bvh, Camera, Material, Mesh, Projection, Sequential};
    use rtrt_core::schedule::{Pass, Step};
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
        let attribute = Attribute { normal: [0.0, 0.0, 1.0], uv: [0.0; 2], color: Attribute::WHITE };
        let cells = (0..steps * steps).map(|i| i / steps * side + i % steps);
        let indices = cells.flat_map(|a| [a, a + 1, a + side, a + 1, a + side + 1, a + side]).collect();
        Mesh::new(positions, vec![attribute; (side * side) as usize], indices).unwrap()
    }

    /// What the last frame has drawn, before the rest is traced.
    fn picked(gpu: &Gpu) -> Vec<Hit> {
        let Renderer { device, pipelines, buffers, timer, raster, capacity, .. } = &gpu.renderer;
        let frame = &Frame { is_drawn: 1, capacity: *capacity, ..gpu.setup.frame };
        let raster = raster.as_ref();
        let encoder = Encoder { device, pipelines, buffers, timer, raster, frame, keeps_layers: false };
        let mut commands = device.device.create_command_encoder(&Default::default());
        let mut pass = commands.begin_compute_pass(&Default::default());
        encoder.step(&mut pass, Step { pass: Pass::Pick, layer: 0 });
        drop(pass);
        device.queue.submit([commands.finish()]);
        let mut hits = Vec::new();
        let read = gpu.renderer.results().read(Slot::Hits, 0..frame.rays as usize, &mut hits);
        pollster::block_on(read).unwrap();
        hits
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
        let mut picture = Picture::default();
        let mut count = |scene: &Scene| {
            gpu.render(scene, &request, &mut picture).unwrap();
            let hits = picked(&gpu);
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
