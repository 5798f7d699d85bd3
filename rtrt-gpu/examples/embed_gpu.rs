//! An application that has a wgpu device of its own lets rtrt render into a texture of its own.
//!
//! ```text
//! $ cargo run --release -p rtrt-gpu --example embed_gpu
//! llvmpipe (LLVM 15.0.6, 256 bits) (vulkan), the application's own device
//! 200x113 pixels in the application's own texture, all equal to the CPU's
//! ```
//!
//! Without a device that can be used it says so, and ends well.

use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{
    Attribute, Bvh, Camera, Light, Material, Mesh, MeshError, Projection, Scene, Sequential,
};
use rtrt_gpu::{Gpu, Route, wgpu};
use std::error::Error;

/// Rows need not be a multiple of anything.
const SIZE: [u32; 2] = [200, 113];

fn main() -> Result<(), Box<dyn Error>> {
    let Some((device, queue)) = pollster::block_on(open()) else {
        println!("skipped: no adapter");
        return Ok(());
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("the application's own"),
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut gpu = match Gpu::with_device(device.clone(), queue.clone(), Route::Auto) {
        Ok(gpu) => gpu,
        // The canary refuses a device that would not give the CPU's bits.
        Err(error) => {
            println!("skipped: {error}");
            return Ok(());
        }
    };
    println!("{}, the application's own device", gpu.describe().adapter);

    let scene = scene()?;
    let camera = Camera {
        eye: Vec3::new(0.0, 1.0, 4.0),
        look_at: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.9 },
    };
    let request = Request::new(&camera, SIZE).samples(4).shadows(Shadows::Hard);
    gpu.render_into(&texture, &scene, &request)?;

    // From here on the texture is the application's: it may be drawn, filtered, shown. Here it is
    // read back.
    let mut picture = Picture::default();
    rtrt_cpu::Cpu::new(rtrt_cpu::Options::default())?.render(&scene, &request, &mut picture)?;
    assert_eq!(read(&device, &queue, &texture)?, *picture.bytes());
    let [width, height] = SIZE;
    println!("{width}x{height} pixels in the application's own texture, all equal to the CPU's");
    Ok(())
}

/// A device with what rtrt can use: SPIR-V as it is, and clocks.
async fn open() -> Option<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await.ok()?;
    let useful = wgpu::Features::PASSTHROUGH_SHADERS | wgpu::Features::TIMESTAMP_QUERY;
    let wanted = wgpu::DeviceDescriptor {
        required_features: adapter.features() & useful,
        required_limits: adapter.limits(),
        ..Default::default()
    };
    adapter.request_device(&wanted).await.ok()
}

/// A triangle over a floor, in the light of a lamp.
fn scene() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new();
    let red = scene.add_material(Material::new([0.8, 0.2, 0.1]).roughness(0.6))?;
    let gray = scene.add_material(Material::new([0.5; 3]).roughness(0.9))?;
    let floor = [[-3.0, -1.0, 3.0], [3.0, -1.0, 3.0], [0.0, -1.0, -5.0]];
    for (corners, material) in [([[-1.0, -0.6, 0.0], [1.0, -0.6, 0.3], [0.0, 1.0, -0.2]], red), (floor, gray)]
    {
        let mesh = triangle(corners)?;
        let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential))?;
        scene.add_instance(mesh, material, Mat4::IDENTITY)?;
    }
    let position = Vec3::new(2.0, 4.0, 2.0);
    scene.add_light(Light::point(position));
    Ok(scene)
}

/// A triangle that has no normals: its own is used.
fn triangle(corners: [[f32; 3]; 3]) -> Result<Mesh, MeshError> {
    let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
    Mesh::new(corners.to_vec(), vec![attribute; 3], vec![0, 1, 2])
}

/// The texture's pixels, without what copies pad rows with.
fn read(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let row = 4 * texture.width();
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(padded * texture.height()),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut commands = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    commands.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([commands.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let mapped = buffer.get_mapped_range(..)?;
    let rows = mapped.chunks_exact(padded as usize);
    Ok(rows.flat_map(|padded| &padded[..row as usize]).copied().collect())
}

#[test]
fn runs() {
    main().expect("no error");
}
