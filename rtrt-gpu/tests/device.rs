//! A device that an application has opened for itself.

use glam::Vec3;
use rtrt_core::backend::{Backend, Picture, RenderError, Request, Shadows};
use rtrt_core::scene::{Camera, Projection, Scene};
use rtrt_gpu::{Error, Gpu, Route, wgpu};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use wgpu::{Device, Features, Limits, Queue, TextureFormat, TextureUsages};

/// A device with these limits and no more features than these, or none after saying so.
fn open(limits: impl Fn(Limits) -> Limits, features: Features) -> Option<(Device, Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
    let Ok(adapter) = adapter else {
        assert!(std::env::var("RTRT_REQUIRE_GPU").as_deref() != Ok("1"), "a GPU is required");
        println!("skipped: no adapter");
        return None;
    };
    let wanted = wgpu::DeviceDescriptor {
        required_features: adapter.features() & features,
        required_limits: limits(adapter.limits()),
        ..Default::default()
    };
    Some(pollster::block_on(adapter.request_device(&wanted)).unwrap())
}

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 0.0, 3.0),
    look_at: Vec3::ZERO,
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 1.0 },
};

const REQUEST: Request<'static> = Request::new(&CAMERA, [64, 48]).shadows(Shadows::Hard);

fn texture(device: &Device, [width, height]: [u32; 2], format: TextureFormat) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: if width == 48 { TextureUsages::TEXTURE_BINDING } else { TextureUsages::COPY_DST },
        view_formats: &[],
    })
}

/// What a failed frame says.
fn said(error: RenderError) -> String {
    assert!(matches!(error, RenderError::Backend { backend: "gpu", .. }));
    error.to_string()
}

#[test]
fn textures_that_do_not_fit_are_refused_in_words() {
    let Some((device, queue)) = open(|limits| limits, Features::all()) else { return };
    let mut gpu = Gpu::with_device(device.clone(), queue, Route::Auto).unwrap();
    let mut fails = |size, format, request| {
        said(gpu.render_into(&texture(&device, size, format), &Scene::new(), &request).unwrap_err())
    };
    assert!(fails([64, 47], TextureFormat::Rgba8Unorm, REQUEST).contains("the frame needs [64, 48, 1]"));
    assert!(fails([64, 48], TextureFormat::Bgra8Unorm, REQUEST).contains("the format Bgra8Unorm"));
    let narrow = REQUEST.size([48, 48]);
    assert!(fails([48, 48], TextureFormat::Rgba8Unorm, narrow).contains("needs COPY_DST"));
    let fits = texture(&device, [64, 48], TextureFormat::Rgba8UnormSrgb);
    gpu.render_into(&fits, &Scene::new(), &REQUEST).unwrap();
}

#[test]
fn a_device_without_passthrough_and_clocks_goes_through_naga_or_is_refused() {
    let Some((device, queue)) = open(|limits| limits, Features::empty()) else { return };
    let direct = Gpu::with_device(device.clone(), queue.clone(), Route::Passthrough).err().unwrap();
    assert!(matches!(direct, Error::NoPassthrough { .. }), "{direct}");
    match Gpu::with_device(device, queue, Route::Auto) {
        Ok(mut gpu) => {
            assert_eq!(gpu.route(), Route::Naga);
            gpu.render(&Scene::new(), &REQUEST, &mut Picture::default()).unwrap();
        }
        Err(error) => assert!(matches!(error, Error::Canary { .. }), "{error}"),
    }
}

#[test]
fn a_device_with_too_few_bindings_is_refused() {
    let few = |limits| Limits { max_storage_buffers_per_shader_stage: 7, ..limits };
    let Some((device, queue)) = open(few, Features::all()) else { return };
    let error = Gpu::with_device(device, queue, Route::Auto).err().unwrap();
    assert!(matches!(error, Error::TooFewBindings { limit: 7, needed: 8, .. }), "{error}");
}

#[test]
fn a_buffer_beyond_the_limits_of_the_device_is_an_error_with_numbers() {
    let small =
        |limits| Limits { max_buffer_size: 1 << 21, max_storage_buffer_binding_size: 1 << 21, ..limits };
    let Some((device, queue)) = open(small, Features::all()) else { return };
    let mut gpu = Gpu::with_device(device, queue, Route::Auto).unwrap();
    let mut picture = Picture::default();
    // A band takes what there is; the pixels of a row of blocks have to fit.
    gpu.render(&Scene::new(), &REQUEST.size([640, 480]), &mut picture).unwrap();
    let long = REQUEST.size([16_384, 16]).samples(16);
    let error = said(gpu.render(&Scene::new(), &long, &mut picture).unwrap_err());
    assert!(error.contains("the device allows 2097152"), "{error}");
    gpu.render(&Scene::new(), &REQUEST, &mut picture).unwrap();
}

#[test]
fn a_device_that_is_destroyed_is_an_error_and_its_handler_is_left_alone() {
    let Some((device, queue)) = open(|limits| limits, Features::all()) else { return };
    let handled = Arc::new(AtomicU32::new(0));
    let counted = Arc::clone(&handled);
    device.on_uncaptured_error(Arc::new(move |_| _ = counted.fetch_add(1, Ordering::Relaxed)));
    let mut gpu = Gpu::with_device(device.clone(), queue.clone(), Route::Auto).unwrap();
    let mut picture = Picture::default();
    gpu.render(&Scene::new(), &REQUEST, &mut picture).unwrap();
    device.destroy();
    for _ in 0..2 {
        let error = said(gpu.render(&Scene::new(), &REQUEST, &mut picture).unwrap_err());
        println!("{error}");
    }
    assert!(Gpu::with_device(device.clone(), queue, Route::Auto).is_err());
    assert_eq!(handled.load(Ordering::Relaxed), 0);
}
