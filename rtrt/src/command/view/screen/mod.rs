//! The window's surface: the picture under the overlay, drawn by a GPU or by the CPU.

mod device;
mod memory;
mod paint;
mod scale;

use device::DeviceScreen;
use egui::{Context, FullOutput};
use memory::MemoryScreen;
use rtrt::choose::Choice;
use rtrt_gpu::Kind;
use std::sync::Arc;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// A window with what draws it.
pub struct Screen {
    pub window: Arc<Window>,
    /// What draws it, in words.
    pub drawn_by: String,
    /// The name of the adapter, if it is a software adapter.
    pub software: Option<String>,
    paints: Paints,
}

/// Who draws.
enum Paints {
    Device(Box<DeviceScreen>),
    Memory(Box<MemoryScreen>),
}

impl Screen {
    /// A screen on a window, or the reason for a failure. Without a choice the CPU draws where no GPU does, or where it
    /// is software, which takes many times as long.
    pub fn new(window: Arc<Window>, events: &ActiveEventLoop, choice: Choice) -> Result<Self, String> {
        let memory = |why: String| -> Result<(Paints, String, Option<String>), String> {
            let paints = Paints::Memory(Box::new(MemoryScreen::new(Arc::clone(&window), events)?));
            Ok((paints, format!("CPU ({why})"), None))
        };
        let (paints, drawn_by, software) = match choice {
            Choice::Cpu => memory("as asked for".into()),
            // This question concerns no window. One that does makes drivers look for all window systems, and complain
            // about those that are missing.
            Choice::Auto if !rtrt_gpu::adapters().iter().any(|adapter| adapter.kind != Kind::Software) => {
                memory("there is no GPU, or only software".into())
            }
            choice => match (DeviceScreen::new(Arc::clone(&window), events), choice) {
                (Ok((_, name, true)), Choice::Auto) => memory(format!("{name} is software")),
                (Ok((screen, name, is_software)), _) => {
                    Ok((Paints::Device(Box::new(screen)), name.clone(), is_software.then_some(name)))
                }
                (Err(why), Choice::Auto) => memory(why),
                (Err(why), _) => Err(why),
            },
        }?;
        Ok(Self { window, drawn_by, software, paints })
    }

    /// The device that draws the window.
    pub fn device(&self) -> Option<(&wgpu::Device, &wgpu::Queue)> {
        match &self.paints {
            Paints::Device(screen) => Some((&screen.device, &screen.queue)),
            Paints::Memory(_) => None,
        }
    }

    /// The size of the surface, pixels.
    pub fn size(&self) -> [u32; 2] {
        match &self.paints {
            Paints::Device(screen) => screen.size(),
            Paints::Memory(screen) => screen.size(),
        }
    }

    /// Changes the size of the surface.
    pub fn resize(&mut self, size: [u32; 2]) {
        match &mut self.paints {
            Paints::Device(screen) => screen.resize(size),
            Paints::Memory(screen) => screen.resize(size),
        }
    }

    /// Takes a picture: red, green, blue and alpha, row by row.
    pub fn upload(&mut self, pixels: &[u8], size: [u32; 2]) {
        match &mut self.paints {
            Paints::Device(screen) => screen.upload(pixels, size),
            Paints::Memory(screen) => screen.upload(pixels, size),
        }
    }

    /// The texture of the window's device for a picture of this size, if a device draws the window.
    pub fn texture(&mut self, size: [u32; 2]) -> Option<wgpu::Texture> {
        match &mut self.paints {
            Paints::Device(screen) => Some(screen.texture(size)),
            Paints::Memory(_) => None,
        }
    }

    /// Shows the picture, scaled to this size in pixels, and the overlay.
    pub fn show(&mut self, context: &Context, over: FullOutput, size: [u32; 2]) -> Result<(), String> {
        match &mut self.paints {
            Paints::Device(screen) => screen.show(context, over, size),
            Paints::Memory(screen) => screen.show(context, over, size),
        }
    }
}
