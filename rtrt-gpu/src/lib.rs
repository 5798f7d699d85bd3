//! The GPU backend of rtrt: renders with the kernels of [`rtrt_core`], and gives the same bits as a CPU.
//!
//! ```no_run
//! use rtrt_core::backend::Backend;
//! # fn main() -> Result<(), rtrt_gpu::Error> {
//! let gpu = rtrt_gpu::Gpu::new(rtrt_gpu::Options::default())?;
//! println!("{}", gpu.describe().adapter);
//! # Ok(())
//! # }
//! ```
//!
//! The device runs the stages of [`rtrt_core::stage`], compiled to SPIR-V by `rtrt-shaders`. Before it is
//! trusted, it is asked what the kernels make of some thousand numbers; a device that answers otherwise than the
//! CPU is refused ([`Error::Canary`]). Scenes stay on the device, and only what changed is uploaded. A frame
//! whose buffers would be too large for the device is rendered in bands, which no pixel depends on.
//!
//! Functions whose names end in `_async` give futures that leave their thread free while the device works; a browser
//! has no others. They are not `Send`: errors of devices are caught on the thread that a future is first polled on.

mod adapter;
mod array;
mod band;
mod barriers;
mod buffers;
mod canary;
mod device;
mod dispatch;
mod entry;
mod error;
mod fetch;
mod frame;
mod info;
mod instance;
mod pipeline;
mod raster;
mod slot;
mod spirv;
mod texture;
mod timer;
mod wait;
mod world;

pub use adapter::{Adapter, Options, adapters_async};
#[cfg(not(target_arch = "wasm32"))]
pub use adapter::{adapters, left_out};
pub use error::Error;
pub use info::{Kind, Route};
pub use wgpu;
pub use world::World;

/// Features that a device is to have where its adapter has them; see [`Gpu::with_device`].
pub const FEATURES: wgpu::Features = device::FEATURES;

/// The compiled stages, as they are handed to a device: SPIR-V.
pub const SHADERS: &[u8] = rtrt_shaders::SPIRV;

use device::watched;
use frame::Renderer;
#[cfg(not(target_arch = "wasm32"))]
use rtrt_core::backend::Backend;
use rtrt_core::backend::{Description, Picture, RenderError, Request};
use rtrt_core::kernel::canary::OUTPUTS;
use rtrt_core::layout::{Frame, PROBES};
use rtrt_core::scene::{Scene, Setup};
use rtrt_core::schedule::Stage;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use timer::HostClock;
use wait::Waiting;
use world::Queries;

/// An opened GPU.
pub struct Gpu {
    renderer: Renderer,
    setup: Setup,
    /// What asks rays, once a world has needed it.
    queries: OnceLock<Queries>,
}

impl Gpu {
    /// Opens an adapter, and asks it the canary. A stage is compiled when a frame first needs it.
    ///
    /// # Errors
    /// No adapter is there or can be used, or the one that was asked for cannot; see [`Error`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn new(options: Options) -> Result<Self, Error> {
        pollster::block_on(Self::open(options, Waiting::Blocks))
    }

    /// [`Gpu::new`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn new_async(options: Options) -> Result<Self, Error> {
        Self::open(options, Waiting::Free).await
    }

    async fn open(options: Options, waiting: Waiting) -> Result<Self, Error> {
        Self::of(adapter::choose(&options, waiting).await?, options.band_bytes).await
    }

    async fn of(device: device::Device, band_bytes: Option<u64>) -> Result<Self, Error> {
        Ok(Self {
            renderer: Renderer::new(device, band_bytes).await?,
            setup: Setup::default(),
            queries: OnceLock::new(),
        })
    }

    /// Renders on a device that an application has opened for itself, with the same wgpu ([`wgpu`]). It is asked
    /// the canary, and gets pipelines and buffers; its handlers of errors are left alone.
    ///
    /// | of the device | needed | without it |
    /// |---|---|---|
    /// | `max_storage_buffers_per_shader_stage` | 8, WebGPU's default | [`Error::TooFewBindings`] |
    /// | `Features::PASSTHROUGH_SHADERS`, on Vulkan | for [`Route::Passthrough`] | [`Route::Naga`] |
    /// | `Features::TIMESTAMP_QUERY` | no | the host waits for each stage to take its time |
    /// | `max_buffer_size`, `max_storage_buffer_binding_size` | as large as the largest array of a scene | [`Error::BufferTooLarge`] when it is rendered |
    ///
    /// # Errors
    /// The device lacks what is needed, fails, or computes other numbers than the CPU ([`Error::Canary`]).
    #[cfg(not(target_arch = "wasm32"))]
    pub fn with_device(device: wgpu::Device, queue: wgpu::Queue, route: Route) -> Result<Self, Error> {
        pollster::block_on(Self::take_over(device, queue, route, Waiting::Blocks))
    }

    /// [`Gpu::with_device`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn with_device_async(
        device: wgpu::Device,
        queue: wgpu::Queue,
        route: Route,
    ) -> Result<Self, Error> {
        Self::take_over(device, queue, route, Waiting::Free).await
    }

    async fn take_over(
        device: wgpu::Device,
        queue: wgpu::Queue,
        route: Route,
        waiting: Waiting,
    ) -> Result<Self, Error> {
        let device = device::Device::new(device, queue, route, waiting).await?;
        canary::check(&device).await?;
        Self::of(device, None).await
    }

    /// Renders a frame into a texture of the same device. No pixel passes through the host, which only waits for
    /// the length of the lists. Gives the milliseconds in each of [`Stage::ALL`].
    ///
    /// The texture has the size of the request, one sample, [`wgpu::TextureUsages::COPY_DST`], and four channels
    /// of 8 bits, red first: `Rgba8Unorm`, or `Rgba8UnormSrgb` where what samples it wants linear numbers. Its
    /// bytes are those of [`Picture::bytes`], so alpha is straight. Rows may have any length. Deferred buffers
    /// are not kept.
    ///
    /// # Errors
    /// The request makes no picture, the texture is another one ([`Error::Texture`]), or the device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn render_into(
        &mut self,
        texture: &wgpu::Texture,
        scene: &Scene,
        request: &Request<'_>,
    ) -> Result<[f64; Stage::COUNT], RenderError> {
        pollster::block_on(self.fill_texture(texture, scene, request, Waiting::Blocks))
    }

    /// [`Gpu::render_into`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn render_into_async(
        &mut self,
        texture: &wgpu::Texture,
        scene: &Scene,
        request: &Request<'_>,
    ) -> Result<[f64; Stage::COUNT], RenderError> {
        self.fill_texture(texture, scene, request, Waiting::Free).await
    }

    async fn fill_texture(
        &mut self,
        texture: &wgpu::Texture,
        scene: &Scene,
        request: &Request<'_>,
        waiting: Waiting,
    ) -> Result<[f64; Stage::COUNT], RenderError> {
        let mut picture = Picture::default();
        self.frame(scene, &request.deferred(false), Some(texture), &mut picture, waiting).await?;
        Ok(picture.stages_ms)
    }

    /// What `Backend::render` does, without blocking. A future that is dropped before
    /// its end leaves nothing of use in the picture, and the GPU as if there had been no such frame.
    ///
    /// # Errors
    /// As there.
    pub async fn render_async(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        self.frame(scene, request, None, picture, Waiting::Free).await
    }

    async fn frame(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        texture: Option<&wgpu::Texture>,
        picture: &mut Picture,
        waiting: Waiting,
    ) -> Result<(), RenderError> {
        let clock = HostClock::start();
        self.setup.prepare(scene, request)?;
        self.renderer.device.waiting = waiting;
        Ok(self.renderer.render(scene, &self.setup, request, clock, texture, picture).await?)
    }

    /// Renders hybrid frames, or, as ever, frames that are traced: the paper's conclusion. The closest surfaces on
    /// the camera's rays are then drawn by the device's rasterizer; shadows, light, and what is seen through
    /// something are traced.
    ///
    /// Such frames are outside the promise of equal bits. A device's rasterizer decides at edges, and between
    /// surfaces that are nearly as far away, which triangle it is that a ray meets; where and how the ray meets that
    /// one is asked of the kernel that traces, and all that follows is as ever. So a frame differs at edges from the
    /// one that is traced, and a little from device to device. What is nearer than 2⁻⁴⁰ of the frame's magnitude
    /// is not seen.
    ///
    /// # Errors
    /// The device cannot draw.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn set_hybrid(&mut self, is_hybrid: bool) -> Result<(), Error> {
        pollster::block_on(self.set_hybrid_async(is_hybrid))
    }

    /// [`Gpu::set_hybrid`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn set_hybrid_async(&mut self, is_hybrid: bool) -> Result<(), Error> {
        // What is drawn are instances, not their parts.
        self.setup.keep_instances_closed(is_hybrid);
        self.renderer.set_hybrid(is_hybrid).await
    }

    /// The device and its queue, for buffers and commands of an application's own ([`World::encode_closest`]).
    pub fn device(&self) -> (&wgpu::Device, &wgpu::Queue) {
        (&self.renderer.device.device, &self.renderer.device.queue)
    }

    /// What the adapter is.
    pub fn kind(&self) -> Kind {
        self.renderer.device.kind
    }

    /// The route that was taken.
    pub fn route(&self) -> Route {
        self.renderer.device.route
    }

    /// The device's answers to [`rtrt_core::kernel::canary::canary`] for every index of `words`.
    ///
    /// # Errors
    /// The device failed.
    pub async fn kernels_async(&self, words: &[u32]) -> Result<Vec<[u32; OUTPUTS]>, Error> {
        let device = &self.renderer.device;
        watched(&device.device, canary::kernels(device, words)).await
    }

    /// [`Gpu::kernels_async`], blocking.
    ///
    /// # Errors
    /// As there.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn kernels(&self, words: &[u32]) -> Result<Vec<[u32; OUTPUTS]>, Error> {
        pollster::block_on(self.kernels_async(words))
    }

    /// The device's answer to [`rtrt_core::layout::probe`], where every word of every value tells its place:
    /// [`Gpu::expected_layout`], if the device looks where the compiler puts things.
    ///
    /// # Errors
    /// The device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn layout(&self) -> Result<[u32; PROBES], Error> {
        pollster::block_on(self.layout_async())
    }

    /// [`Gpu::layout`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn layout_async(&self) -> Result<[u32; PROBES], Error> {
        let device = &self.renderer.device;
        watched(&device.device, canary::layout(device)).await
    }

    /// Where it runs.
    pub fn description(&self) -> Description {
        let adapter = self.renderer.device.name.clone();
        Description { kind: "gpu".into(), adapter, lanes: 1, threads: 0 }
    }

    /// The driver and its version, as far as the interface tells.
    pub fn driver(&self) -> String {
        let info = self.renderer.device.device.adapter_info();
        format!("{} {}", info.driver, info.driver_info).trim().to_owned()
    }

    /// The CPU's answer to the same as [`Gpu::layout`].
    pub fn expected_layout() -> [u32; PROBES] {
        canary::expected_layout()
    }
}

impl Adapter {
    /// Opens it, and asks it the canary, by the route that [`Route::Auto`] takes.
    ///
    /// # Errors
    /// It cannot be opened, or computes other numbers than the CPU.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn open(&self) -> Result<Gpu, Error> {
        pollster::block_on(async { Gpu::of(self.device(Waiting::Blocks).await?, None).await })
    }

    /// [`Adapter::open`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn open_async(&self) -> Result<Gpu, Error> {
        Gpu::of(self.device(Waiting::Free).await?, None).await
    }
}

/// A browser forbids to wait: there is only [`Gpu::render_async`].
#[cfg(not(target_arch = "wasm32"))]
impl Backend for Gpu {
    fn describe(&self) -> Description {
        self.description()
    }

    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        pollster::block_on(self.frame(scene, request, None, picture, Waiting::Blocks))
    }

    fn warm_up(&mut self, frame: &Frame, stop: &AtomicBool) -> Result<(), RenderError> {
        Ok(pollster::block_on(self.renderer.compile(frame, stop))?)
    }
}
