//! What renders for the viewer: a backend, or one that shares the window's device.

use crate::command::Error;
use crate::command::console::Console;
use crate::command::job::open;
use crate::command::options::BackendOptions;
use crate::command::report::Machine;
use rtrt::choose::ChooseError;
use rtrt_core::backend::Backend;
use rtrt_gpu::{Gpu, Route};

/// A backend, opened.
pub struct Engine {
    renders: Renders,
    machine: Machine,
    /// How it was opened.
    options: BackendOptions,
    /// Whether it draws what the camera sees.
    hybrid: bool,
    /// Whether it has made a picture: for the first one, a GPU compiles shaders.
    pub is_warm: bool,
}

/// Where pictures are made.
enum Renders {
    /// Wherever the backend makes them; they are read back.
    Apart(Box<dyn Backend>),
    /// On the window's device, where they may stay.
    Here(Box<Gpu>),
}

impl Engine {
    /// Opens a backend. With `hybrid`, it draws what the camera sees.
    pub fn open(options: &BackendOptions, hybrid: bool, console: &Console) -> Result<Self, Error> {
        let (backend, machine) = open(options, hybrid, console)?;
        let (renders, options) = (Renders::Apart(backend), options.clone());
        Ok(Self { renders, machine, options, hybrid, is_warm: false })
    }

    /// Which it is.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Goes over to the window's device, if that is of the same adapter. Where it is not, or is
    /// refused, pictures are read back as before.
    pub fn share(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, console: &Console) {
        let info = device.adapter_info();
        let adapter = format!("{} ({})", info.name, info.backend);
        if !self.is_gpu() || self.machine.adapter() != adapter {
            return;
        }
        let gpu = Gpu::with_device(device.clone(), queue.clone(), Route::Auto)
            .and_then(|mut gpu| gpu.set_hybrid(self.hybrid).map(|()| gpu));
        match gpu {
            Ok(gpu) => {
                self.renders = Renders::Here(Box::new(gpu));
                console.detail("pictures stay on the window's device");
            }
            Err(error) => console.detail(format_args!("pictures are read back: {error}")),
        }
    }

    /// Lets it draw what the camera sees, or no longer. Only a GPU can.
    pub fn set_hybrid(&mut self, hybrid: bool, console: &Console) -> Result<(), Error> {
        if self.hybrid == hybrid {
            return Ok(());
        }
        match &mut self.renders {
            Renders::Here(gpu) => gpu.set_hybrid(hybrid).map_err(ChooseError::from)?,
            Renders::Apart(_) => self.renders = Self::open(&self.options, hybrid, console)?.renders,
        }
        (self.hybrid, self.is_warm) = (hybrid, false);
        Ok(())
    }

    /// Whether it is a GPU.
    pub fn is_gpu(&self) -> bool {
        self.machine.kind() == "gpu"
    }

    /// Leaves the window's device.
    pub fn part(&mut self, console: &Console) -> Result<(), Error> {
        self.renders = Self::open(&self.options, self.hybrid, console)?.renders;
        Ok(())
    }

    /// That of the window's device, if it is shared.
    pub fn here(&mut self) -> Option<&mut Gpu> {
        match &mut self.renders {
            Renders::Here(gpu) => Some(gpu),
            Renders::Apart(_) => None,
        }
    }

    /// The backend.
    pub fn backend(&mut self) -> &mut dyn Backend {
        match &mut self.renders {
            Renders::Apart(backend) => &mut **backend,
            Renders::Here(gpu) => &mut **gpu,
        }
    }
}
