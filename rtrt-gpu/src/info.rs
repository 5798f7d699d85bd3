//! What an adapter is, and how the module gets to it.

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

/// How the compiled module gets to the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Route {
    /// [`Route::Passthrough`] where the adapter has it, else [`Route::Naga`].
    #[default]
    Auto,
    /// As it is, by Vulkan: no compiler but the driver's touches it.
    Passthrough,
    /// Translated by naga, to whatever the adapter takes. naga drops what forbids the driver to reorder sums, so
    /// every float operation gets a barrier first; the device takes longer.
    Naga,
}

/// What the adapter is called, with its interface: one GPU may be there twice.
pub(crate) fn label(info: &wgpu::AdapterInfo) -> String {
    format!("{} ({})", info.name, info.backend)
}

/// Whether an adapter or a device with these features takes SPIR-V as it is.
pub(crate) fn has_passthrough(info: &wgpu::AdapterInfo, features: wgpu::Features) -> bool {
    info.backend == wgpu::Backend::Vulkan && features.contains(wgpu::Features::PASSTHROUGH_SHADERS)
}
