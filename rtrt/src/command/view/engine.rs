//! The viewer's backend, which may share the window's device.

use crate::command::Error;
use crate::command::console::Console;
use crate::command::job::{Opened, open};
use crate::command::options::BackendOptions;
use crate::command::report::Machine;
use rtrt::choose::{Choice, ChooseError};
use rtrt_core::backend::{Backend, RenderError};
use rtrt_core::layout::Frame;
use rtrt_cpu::Cpu;
use rtrt_gpu::{Gpu, Route};
use std::sync::atomic::AtomicBool;

/// An open backend.
pub struct Engine {
    renders: Renders,
    machine: Machine,
    /// The options that opened it.
    options: BackendOptions,
    /// Whether it rasterizes the first surfaces.
    hybrid: bool,
    /// Whether it is a GPU that computes on the processor.
    is_software: bool,
    /// Whether it has rendered a picture. A GPU compiles shaders for the first one.
    pub is_warm: bool,
}

/// The place of rendering.
enum Renders {
    /// A separate backend; pictures are read back.
    Separate(Box<dyn Backend>),
    /// The window's device; pictures stay there.
    Shared(Box<Gpu>),
}

impl Engine {
    /// Opens a backend. With `hybrid` it rasterizes the first surfaces.
    pub fn open(options: &BackendOptions, hybrid: bool, console: &Console) -> Result<Self, Error> {
        let Opened { backend, machine, is_software } = open(options, hybrid, console)?;
        let (renders, options) = (Renders::Separate(backend), options.clone());
        Ok(Self { renders, machine, options, hybrid, is_software, is_warm: false })
    }

    /// The CPU.
    pub fn cpu(options: &BackendOptions) -> Result<Self, Error> {
        let cpu = Cpu::new(rtrt_cpu::Options { lanes: options.lanes, threads: options.threads() });
        let cpu = cpu.map_err(ChooseError::Cpu)?;
        let (machine, options) = (Machine::from(cpu.describe()), options.clone());
        let options = BackendOptions { backend: Choice::Cpu, ..options };
        Ok(Self {
            renders: Renders::Separate(Box::new(cpu)),
            machine,
            options,
            hybrid: false,
            is_software: false,
            is_warm: false,
        })
    }

    /// Compiles what frames like this one need, until `stop` is true.
    pub fn warm_up(&mut self, frame: &Frame, stop: &AtomicBool) -> Result<(), RenderError> {
        self.backend().warm_up(frame, stop)?;
        self.is_warm = true;
        Ok(())
    }

    /// The backend and its hardware.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Switches to the window's device if it has the same adapter. If not, or if the device is refused, pictures
    /// are still read back.
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
                self.renders = Renders::Shared(Box::new(gpu));
                console.detail("pictures stay on the window's device");
            }
            Err(error) => console.detail(format_args!("pictures are read back: {error}")),
        }
    }

    /// Switches hybrid frames on or off. Only a GPU has them.
    pub fn set_hybrid(&mut self, hybrid: bool, console: &Console) -> Result<(), Error> {
        if self.hybrid == hybrid {
            return Ok(());
        }
        match &mut self.renders {
            Renders::Shared(gpu) => gpu.set_hybrid(hybrid).map_err(ChooseError::from)?,
            Renders::Separate(_) => self.renders = Self::open(&self.options, hybrid, console)?.renders,
        }
        (self.hybrid, self.is_warm) = (hybrid, false);
        Ok(())
    }

    /// Whether it is a GPU.
    pub fn is_gpu(&self) -> bool {
        self.machine.kind() == "gpu"
    }

    /// Whether it is a GPU that is no slower than the CPU.
    pub fn is_fast(&self) -> bool {
        self.is_gpu() && !self.is_software
    }

    /// Stops sharing the window's device.
    pub fn unshare(&mut self, console: &Console) -> Result<(), Error> {
        self.renders = Self::open(&self.options, self.hybrid, console)?.renders;
        Ok(())
    }

    /// The backend on the window's device, if it is shared.
    pub fn shared(&mut self) -> Option<&mut Gpu> {
        match &mut self.renders {
            Renders::Shared(gpu) => Some(gpu),
            Renders::Separate(_) => None,
        }
    }

    /// The backend.
    pub fn backend(&mut self) -> &mut dyn Backend {
        match &mut self.renders {
            Renders::Separate(backend) => &mut **backend,
            Renders::Shared(gpu) => &mut **gpu,
        }
    }
}
