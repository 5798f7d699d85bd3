//! The library that finds adapters, without a window system.

/// An instance for adapters that draw in no window.
///
/// Mesa's layer for choosing devices connects to Wayland in each instance that has Wayland's extension, and
/// without a display it prints an error that concerns nobody here. So there are no extensions for windows.
pub(crate) fn windowless(backends: wgpu::Backends) -> wgpu::Instance {
    #[cfg(all(unix, not(target_vendor = "apple"), not(target_os = "android")))]
    if backends.contains(wgpu::Backends::VULKAN)
        && let Some(instance) = vulkan()
    {
        return instance;
    }
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}

/// An instance of Vulkan without extensions for windows; none where there is no Vulkan.
#[cfg(all(unix, not(target_vendor = "apple"), not(target_os = "android")))]
fn vulkan() -> Option<wgpu::Instance> {
    use wgpu::hal::vulkan::{Api, CreateInstanceCallbackArgs, Instance};
    const WINDOWS: [&[u8]; 3] = [b"VK_KHR_wayland_surface", b"VK_KHR_xlib_surface", b"VK_KHR_xcb_surface"];
    let descriptor = wgpu::hal::InstanceDescriptor {
        name: "rtrt",
        flags: wgpu::InstanceFlags::empty(),
        memory_budget_thresholds: Default::default(),
        backend_options: Default::default(),
        telemetry: None,
        display: None,
    };
    let keep_windows_out = |args: CreateInstanceCallbackArgs<'_, '_, '_>| {
        args.extensions.retain(|name| !WINDOWS.contains(&name.to_bytes()));
    };
    // SAFETY: wgpu-hal asks its list of extensions, which is the one that is changed here, before it uses any of
    // these three, and only to create a surface, which nobody asks of this instance.
    let instance = unsafe { Instance::init_with_callback(&descriptor, Some(Box::new(keep_windows_out))) };
    // SAFETY: it was created above, and nothing else has it.
    Some(unsafe { wgpu::Instance::from_hal::<Api>(instance.ok()?) })
}
