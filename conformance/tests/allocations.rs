//! Memory: the CPU's frames take none once their buffers have grown.

use conformance::shape::{Build, Shape};
use glam::Vec3;
use rtrt_core::backend::{Backend, Picture, Request, Shading, Shadows};
use rtrt_core::scene::{Camera, Light, Material, Projection, Scene};
use rtrt_cpu::{Cpu, Options};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU32, Ordering};

/// The number of allocations of all threads.
static ALLOCATIONS: AtomicU32 = AtomicU32::new(0);

/// Counts, and passes on.
struct Counting;

// SAFETY: every call goes on to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Frames that are counted.
const FRAMES: u32 = 20;

/// A floor, a sheet above it, and two lights, one of them with a radius.
fn scene(sheet: Material) -> Scene {
    let quad = Shape::quad([-0.5, 0.5, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
    let build = Build::default().shape(Shape::floor(3.0, 0.0)).shape_of(quad, sheet);
    build.light(Light::point([0.3, 2.0, 0.0]).radius(0.4)).light(Light::point([-0.7, 1.5, 0.2])).scene
}

/// The number of allocations in frames after the first three.
fn allocations(scene: &Scene, shadows: Shadows, shading: Shading) -> u32 {
    let camera = Camera {
        eye: Vec3::new(0.5, 2.5, 3.0),
        look_at: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.8 },
    };
    let request = Request::new(&camera, [160, 90]).shadows(shadows).samples(4).shading(shading);
    let mut cpu = Cpu::new(Options::default()).expect("a backend");
    let mut picture = Picture::default();
    for frame in 0..3 + FRAMES {
        if frame == 3 {
            ALLOCATIONS.store(0, Ordering::Relaxed);
        }
        cpu.render(scene, &request, &mut picture).expect("a frame");
    }
    ALLOCATIONS.load(Ordering::Relaxed)
}

// One test, since all tests of a file count together.
#[test]
fn warm_frames_ask_for_no_memory() {
    let opaque = Material::new([0.8; 3]).roughness(0.5);
    let pane = opaque.blend(0.5);
    for (sheet, name) in [(opaque, "opaque"), (pane, "a pane")] {
        for (shadows, shading) in [
            (Shadows::Hard, Shading::Sample),
            (Shadows::Hard, Shading::Pixel),
            (Shadows::Soft, Shading::Sample),
        ] {
            let count = allocations(&scene(sheet), shadows, shading);
            // Threads are handed their work through a queue, which takes memory for some 60 jobs at
            // once.
            assert!(count <= 2, "{name}, {shadows:?}, {shading:?}: {count} in {FRAMES} frames");
        }
    }
}
