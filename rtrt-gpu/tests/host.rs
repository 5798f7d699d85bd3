//! What a frame costs the host.

use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::layout::Attribute;
use rtrt_core::scene::{Bvh, Camera, Light, Material, Mesh, Projection, Scene, Sequential};
use rtrt_gpu::{Gpu, Options};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts what is allocated.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: all is passed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: what holds for the caller's layout holds here.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the place comes from `alloc`, with this layout.
        unsafe { System.dealloc(place, layout) }
    }
}

/// So many triangles strewn around, each an instance, with a sun and some lamps.
fn scene(instances: u32) -> Scene {
    let mut scene = Scene::new();
    let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Mesh::new(corners, vec![attribute; 3], vec![0, 1, 2]).unwrap();
    let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
    let paint = scene.add_material(Material::new([0.8, 0.5, 0.3]).roughness(0.7)).unwrap();
    let place =
        |n: u32| Vec3::new((n * 37 % 101) as f32, (n * 59 % 103) as f32, (n * 71 % 107) as f32) - 50.0;
    for instance in 0..instances {
        scene.add_instance(mesh, paint, Mat4::from_translation(place(instance))).unwrap();
    }
    scene.add_light(Light::sun(Vec3::new(0.3, -1.0, -0.4)));
    for lamp in 0..3 {
        let (position, color) = (place(lamp * 7), Vec3::splat(0.3));
        scene.add_light(Light::point(position).color(color).reach(9.0));
    }
    scene
}

/// The least that a frame takes the host once all is warm, milliseconds, and how often it
/// allocates; the camera moves from frame to frame.
fn cost(gpu: &mut Gpu, scene: &Scene) -> (f64, u64) {
    let mut picture = Picture::default();
    let frames = (0..12).map(|frame| {
        let eye = Vec3::new(0.1 * frame as f32, 20.0, 49.0);
        let projection = Projection::Perspective { fov_y: 0.9 };
        let camera = Camera { eye, look_at: Vec3::ZERO, up: Vec3::Y, projection };
        let shadows = Shadows::Hard;
        let request = Request::new(&camera, [64, 36]).shadows(shadows);
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        gpu.render(scene, &request, &mut picture).unwrap();
        (picture.host_ms.unwrap(), ALLOCATIONS.load(Ordering::Relaxed) - before)
    });
    frames.skip(4).fold((f64::MAX, u64::MAX), |least, now| (least.0.min(now.0), least.1.min(now.1)))
}

#[test]
fn a_frame_of_ten_thousand_objects_costs_the_host_what_one_of_ten_does() {
    let mut gpu = match Gpu::new(Options::default()) {
        Ok(gpu) => gpu,
        Err(error) if std::env::var_os("RTRT_REQUIRE_GPU").is_some() => panic!("{error}"),
        Err(error) => return println!("skipped: {error}"),
    };
    let [(few_ms, few), (many_ms, many)] = [10, 10_000].map(|instances| cost(&mut gpu, &scene(instances)));
    println!("10 instances: {few_ms:.3} ms, {few} allocations; 10,000: {many_ms:.3} ms, {many} allocations");
    // Generous: other work may keep the processor. 0.3 ms is usual.
    assert!(many_ms < 5.0, "{many_ms} ms");
    // All are wgpu's own, for commands.
    assert!(many <= few + few / 4, "{many} allocations, {few} with 10 instances");
}
