//! Which adapters there are, and which to take.

use crate::device::Device;
use crate::{Error, Gpu, Options, Route, canary};
use std::fmt;

/// What an adapter is, the most promising first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A GPU with memory of its own.
    Discrete,
    /// A GPU that shares the processor's memory.
    Integrated,
    /// A GPU lent to a virtual machine.
    Virtual,
    /// Not known.
    Other,
    /// No GPU: the driver computes on the processor.
    Software,
}

impl Kind {
    pub(crate) fn new(kind: wgpu::DeviceType) -> Self {
        match kind {
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu => Self::Integrated,
            wgpu::DeviceType::VirtualGpu => Self::Virtual,
            wgpu::DeviceType::Cpu => Self::Software,
            wgpu::DeviceType::Other => Self::Other,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Other => "unknown",
            Self::Software => "software",
        })
    }
}

/// An adapter that is there. It is not opened yet, and may turn out to be of no use.
#[derive(Debug)]
pub struct Adapter {
    raw: wgpu::Adapter,
    /// Its name.
    pub name: String,
    /// The interface it is reached through.
    pub api: String,
    /// What it is.
    pub kind: Kind,
    /// The driver and its version.
    pub driver: String,
    /// Whether it takes SPIR-V as it is, which is what keeps every rounding in place.
    pub passthrough: bool,
}

impl Adapter {
    fn new(raw: wgpu::Adapter) -> Self {
        let info = raw.get_info();
        Self {
            api: info.backend.to_string(),
            kind: Kind::new(info.device_type),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            passthrough: has_passthrough(&info, raw.features()),
            name: info.name,
            raw,
        }
    }

    /// Opens it, and asks it the canary, by the route that [`Route::Auto`] takes.
    ///
    /// # Errors
    /// It cannot be opened, or computes other numbers than the CPU.
    pub fn open(&self) -> Result<Gpu, Error> {
        Gpu::of(open(&self.raw, Route::Auto)?, None)
    }
}

/// All adapters in the order in which [`crate::Gpu::new`] would try them; none is opened.
/// `WGPU_BACKEND` and `WGPU_POWER_PREF` in the environment have the meaning that wgpu gives them. Their
/// position here is their number in [`Options::adapter`].
pub fn adapters() -> Vec<Adapter> {
    enumerate(wanted()).into_iter().map(Adapter::new).collect()
}

/// Adapters that are there, but not among [`adapters`], each with why: `WGPU_BACKEND` in the environment
/// leaves them out.
pub fn left_out() -> Vec<String> {
    let Ok(value) = std::env::var("WGPU_BACKEND") else { return Vec::new() };
    let Some(wanted) = wgpu::Backends::from_env() else { return Vec::new() };
    let adapters = enumerate(KNOWN - wanted);
    let label = |adapter: &wgpu::Adapter| label(&adapter.get_info());
    adapters.iter().map(|adapter| format!("WGPU_BACKEND={value} leaves out {}", label(adapter))).collect()
}

/// Opens the adapter that the options ask for, or else the first that can be used.
pub(crate) fn choose(options: &Options) -> Result<Device, Error> {
    let adapters = enumerate(wanted());
    let Some(wanted) = &options.adapter else {
        let mut tried = Vec::new();
        for adapter in &adapters {
            match open(adapter, options.route) {
                Ok(device) => return Ok(device),
                Err(error) => tried.push(error.to_string()),
            }
        }
        tried.extend(left_out());
        return Err(Error::NoAdapter { tried });
    };
    let named =
        |adapter: &&wgpu::Adapter| label(&adapter.get_info()).to_lowercase().contains(&wanted.to_lowercase());
    let numbered = wanted.parse().ok().and_then(|number: usize| adapters.get(number));
    match numbered.or_else(|| adapters.iter().find(named)) {
        Some(adapter) => open(adapter, options.route),
        None => Err(Error::AdapterNotFound {
            wanted: wanted.clone(),
            names: adapters.iter().map(|adapter| label(&adapter.get_info())).chain(left_out()).collect(),
        }),
    }
}

/// Opens the adapter and asks it the canary.
fn open(adapter: &wgpu::Adapter, route: Route) -> Result<Device, Error> {
    let device = Device::open(adapter, route)?;
    canary::check(&device)?;
    Ok(device)
}

/// The interfaces that a renderer may use.
const KNOWN: wgpu::Backends = wgpu::Backends::VULKAN.union(wgpu::Backends::METAL).union(wgpu::Backends::DX12);

/// Those of them that `WGPU_BACKEND` in the environment names, or all.
fn wanted() -> wgpu::Backends {
    wgpu::Backends::from_env().map_or(KNOWN, |wanted| wanted & KNOWN)
}

/// All adapters that are reached through one of these, the most promising first. With `WGPU_POWER_PREF=low` in
/// the environment, integrated GPUs come before discrete ones.
fn enumerate(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    let saves_power = wgpu::PowerPreference::from_env() == Some(wgpu::PowerPreference::LowPower);
    adapters.sort_by_key(|adapter| match Kind::new(adapter.get_info().device_type) {
        kind @ (Kind::Discrete | Kind::Integrated) => {
            (Kind::Discrete, saves_power == (kind == Kind::Discrete))
        }
        kind => (kind, false),
    });
    adapters
}

/// What the adapter is called, with its interface: one GPU may be there twice.
pub(crate) fn label(info: &wgpu::AdapterInfo) -> String {
    format!("{} ({})", info.name, info.backend)
}

/// Whether an adapter or a device with these features takes SPIR-V as it is.
pub(crate) fn has_passthrough(info: &wgpu::AdapterInfo, features: wgpu::Features) -> bool {
    info.backend == wgpu::Backend::Vulkan && features.contains(wgpu::Features::PASSTHROUGH_SHADERS)
}
