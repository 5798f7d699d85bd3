//! A window that a GPU draws: the picture as a texture under the overlay.

use egui::epaint::{ClippedPrimitive, Mesh, Primitive};
use egui::{Color32, Context, FullOutput, Pos2, Rect, TextureId, pos2, vec2};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{CurrentSurfaceTexture, TextureFormat, TextureUsages};
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// The graphics APIs for windows.
const BACKENDS: wgpu::Backends =
    wgpu::Backends::VULKAN.union(wgpu::Backends::METAL).union(wgpu::Backends::DX12);

/// A surface with its device and painter.
pub struct DeviceScreen {
    window: Arc<Window>,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    renderer: Renderer,
    picture: Option<ScreenTexture>,
    /// Whether the picture is shown at another size than its own.
    is_scaled: bool,
    failure: Arc<Mutex<Option<String>>>,
}

/// The picture on the device.
struct ScreenTexture {
    texture: wgpu::Texture,
    id: TextureId,
}

impl DeviceScreen {
    /// A screen on a window with the name of its adapter, and whether that is software; or the reason for a failure.
    pub fn new(window: Arc<Window>, events: &ActiveEventLoop) -> Result<(Self, String, bool), String> {
        let display = Box::new(events.owned_display_handle());
        let wanted = wgpu::Backends::from_env().unwrap_or(BACKENDS);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: BACKENDS & wanted,
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_with_display_handle(display)
        });
        let surface = instance
            .create_surface(Arc::clone(&window))
            .map_err(|error| format!("no graphics driver draws in windows: {error}"))?;
        let preference = wgpu::PowerPreference::from_env().unwrap_or(wgpu::PowerPreference::HighPerformance);
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: preference,
            compatible_surface: Some(&surface),
            ..Default::default()
        }))
        .map_err(|error| format!("no adapter draws in windows: {error}"))?;
        let info = adapter.get_info();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            // All features: a renderer may share the device.
            required_features: adapter.features() & rtrt_gpu::FEATURES,
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .map_err(|error| format!("{}: {error}", info.name))?;
        let failure = Arc::new(Mutex::new(None));
        let first = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error| {
            first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error.to_string());
        }));
        let config = config(&surface, &adapter, &window, &device)
            .ok_or_else(|| format!("{} draws in windows of another kind", info.name))?;
        surface.configure(&device, &config);
        // Texels are fetched by index, so the filters of devices do not matter.
        let renderer = Renderer::new(&device, config.format, RendererOptions::PREDICTABLE);
        let is_software = info.device_type == wgpu::DeviceType::Cpu;
        let picture = None;
        let screen = Self {
            window,
            instance,
            surface,
            config,
            device,
            queue,
            renderer,
            picture,
            is_scaled: false,
            failure,
        };
        Ok((screen, info.name, is_software))
    }

    /// The size of the surface, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// Changes the size of the surface.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        let most = self.device.limits().max_texture_dimension_2d;
        (self.config.width, self.config.height) = (width.clamp(1, most), height.clamp(1, most));
        self.surface.configure(&self.device, &self.config);
    }

    /// Uploads a picture: red, green, blue and alpha, row by row.
    pub fn upload(&mut self, pixels: &[u8], size: [u32; 2]) {
        let texture = self.texture(size);
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: None };
        self.queue.write_texture(texture.as_image_copy(), pixels, layout, texture.size());
    }

    /// The texture for a picture of this size.
    pub fn texture(&mut self, [width, height]: [u32; 2]) -> wgpu::Texture {
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        if let Some(shown) = self.picture.as_ref().filter(|shown| shown.texture.size() == size) {
            return shown.texture.clone();
        }
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TextureFormat::Rgba8Unorm,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        let (renderer, nearest) = (&mut self.renderer, wgpu::FilterMode::Nearest);
        self.is_scaled = false;
        let id = match self.picture.take() {
            Some(ScreenTexture { id, .. }) => {
                renderer.update_egui_texture_from_wgpu_texture(&self.device, &view, nearest, id);
                id
            }
            None => renderer.register_native_texture(&self.device, &view, nearest),
        };
        self.picture = Some(ScreenTexture { texture: texture.clone(), id });
        texture
    }

    /// Shows the picture at this size in pixels, and the overlay.
    pub fn show(&mut self, context: &Context, mut over: FullOutput, size: [u32; 2]) -> Result<(), String> {
        let scale = over.pixels_per_point;
        self.filter(size);
        let mut jobs: Vec<_> = self.backdrop(size, scale).into_iter().collect();
        jobs.extend(context.tessellate(over.shapes, scale));
        for (id, deltas) in over.textures_delta.set.drain() {
            for delta in deltas {
                self.renderer.update_texture(&self.device, &self.queue, id, &delta);
            }
        }
        self.paint(&jobs, scale)?;
        for id in over.textures_delta.free.drain() {
            self.renderer.free_texture(&id);
        }
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    /// Has the picture's colors interpolated where it is shown at another size than its own.
    fn filter(&mut self, [width, height]: [u32; 2]) {
        let Some(ScreenTexture { texture, id }) = &self.picture else { return };
        let is_scaled = texture.size() != wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        if is_scaled == self.is_scaled {
            return;
        }
        self.is_scaled = is_scaled;
        let filter = if is_scaled { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest };
        let view = texture.create_view(&Default::default());
        self.renderer.update_egui_texture_from_wgpu_texture(&self.device, &view, filter, *id);
    }

    /// The picture as a rectangle of so many pixels in the upper left corner.
    fn backdrop(&self, size: [u32; 2], scale: f32) -> Option<ClippedPrimitive> {
        let [width, height] = size.map(|side| side as f32 / scale);
        let place = Rect::from_min_size(Pos2::ZERO, vec2(width, height));
        let mut mesh = Mesh::with_texture(self.picture.as_ref()?.id);
        mesh.add_rect_with_uv(place, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        Some(ClippedPrimitive { clip_rect: place, primitive: Primitive::Mesh(mesh) })
    }

    fn paint(&mut self, jobs: &[ClippedPrimitive], pixels_per_point: f32) -> Result<(), String> {
        let Some(frame) = self.frame()? else { return Ok(()) };
        let view = frame.texture.create_view(&Default::default());
        let descriptor = ScreenDescriptor { size_in_pixels: self.size(), pixels_per_point };
        let mut commands = self.device.create_command_encoder(&Default::default());
        self.renderer.update_buffers(&self.device, &self.queue, &mut commands, jobs, &descriptor);
        let pass = commands.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        self.renderer.render(&mut pass.forget_lifetime(), jobs, &descriptor);
        self.queue.submit([commands.finish()]);
        self.window.pre_present_notify();
        self.queue.present(frame);
        Ok(())
    }

    /// The texture of the next frame; none while the window is hidden.
    fn frame(&mut self) -> Result<Option<wgpu::SurfaceTexture>, String> {
        for _ in 0..2 {
            match self.surface.get_current_texture() {
                CurrentSurfaceTexture::Success(frame) | CurrentSurfaceTexture::Suboptimal(frame) => {
                    return Ok(Some(frame));
                }
                CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => return Ok(None),
                CurrentSurfaceTexture::Outdated => {}
                CurrentSurfaceTexture::Lost => {
                    let window = Arc::clone(&self.window);
                    self.surface = self.instance.create_surface(window).map_err(|error| error.to_string())?;
                }
                CurrentSurfaceTexture::Validation => return Err("the surface is refused".into()),
            }
            self.surface.configure(&self.device, &self.config);
        }
        Ok(None)
    }
}

/// The configuration of the surface: 8 bits per channel, without a conversion.
fn config(
    surface: &wgpu::Surface<'_>,
    adapter: &wgpu::Adapter,
    window: &Window,
    device: &wgpu::Device,
) -> Option<wgpu::SurfaceConfiguration> {
    let most = device.limits().max_texture_dimension_2d;
    let size = window.inner_size();
    let (width, height) = (size.width.clamp(1, most), size.height.clamp(1, most));
    let formats = surface.get_capabilities(adapter).formats;
    let wanted =
        |format: &&TextureFormat| matches!(format, TextureFormat::Bgra8Unorm | TextureFormat::Rgba8Unorm);
    let format = *formats.iter().find(wanted).or(formats.first())?;
    let default = surface.get_default_config(adapter, width, height)?;
    Some(wgpu::SurfaceConfiguration { format, present_mode: wgpu::PresentMode::AutoVsync, ..default })
}
