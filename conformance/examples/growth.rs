//! What the 2D structure is worth: how the time of a frame grows with the number of instances, with
//! lists of blocks and without; with the size of a texture; and with levels of detail.
//!
//! `cargo run --release -p conformance --example growth`

use conformance::shape::{Build, Random, Shape, paved};
use glam::{Mat4, Vec3};
use rtrt::demo;
use rtrt::import::Loaded;
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Camera, Light, Projection, Scene, Structure};
use rtrt_core::schedule::Stage;

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 9.0, 26.0),
    look_at: Vec3::ZERO,
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.8 },
};

fn main() {
    let mut cpu = rtrt_cpu::Cpu::new(rtrt_cpu::Options::default()).expect("a processor");
    println!("{:?}, 640x360", cpu.describe());
    println!("{:>9} {:>12} {:>12} {:>8}", "instances", "blocks, ms", "none, ms", "times");
    for instances in [10, 100, 1000, 10_000, 100_000] {
        let mut scene = cubes(instances);
        let (usual, with) = median(&mut cpu, &scene, 9);
        scene.structure = Structure::None;
        let (other, without) = median(&mut cpu, &scene, if instances > 5000 { 1 } else { 3 });
        assert_eq!(usual, other, "the picture depends on the structure");
        let [with, without] = [with, without].map(|stages| stages.iter().sum::<f64>());
        println!("{instances:>9} {with:>12.2} {without:>12.2} {:>8.1}", without / with);
    }
    println!("{:>9} {:>12} {:>12}", "texels", "shade, ms", "frame, ms");
    for side in [16, 64, 256, 1024, 4096] {
        let (_, stages) = median(&mut cpu, &paved(side), 15);
        println!(
            "{side:>4}^2    {:>12.2} {:>12.2}",
            stages[Stage::Shade as usize],
            stages.iter().sum::<f64>()
        );
    }
    let Loaded { mut scene, camera, .. } = demo::levels(&rtrt_cpu::Parallel).expect("a scene");
    let total = |stages: [f64; Stage::COUNT]| stages.iter().sum::<f64>();
    let with = total(median_from(&mut cpu, &scene, &camera, 15).1);
    for instance in 0..scene.instances().len() as u32 {
        let instance = scene.instance_index(instance).expect("an instance");
        scene.set_levels(instance, &[]).expect("an instance");
    }
    let without = total(median_from(&mut cpu, &scene, &camera, 15).1);
    println!("demo:levels: {with:.2} ms with levels of detail, {without:.2} ms without");
}

/// Cubes of the same total volume, whatever their number, in a box; a sun.
fn cubes(count: u32) -> Scene {
    let mut build = Build::default();
    let cube = build.mesh(Shape::cube());
    let size = 2.0 / (count as f32).cbrt();
    let mut random = Random(3);
    for _ in 0..count {
        let turn = Mat4::from_rotation_y(random.within(0.0, 3.0));
        build.instance(
            cube,
            Mat4::from_translation(random.vector(8.0)) * turn * Mat4::from_scale(Vec3::splat(size)),
        );
    }
    build.light(Light::sun(Vec3::new(0.3, -1.0, -0.4)).color(Vec3::splat(2.5))).scene
}

/// The pixels, and the median time of each stage.
fn median(cpu: &mut rtrt_cpu::Cpu, scene: &Scene, frames: usize) -> (Vec<u32>, [f64; Stage::COUNT]) {
    median_from(cpu, scene, &CAMERA, frames)
}

/// The same from elsewhere.
fn median_from(
    cpu: &mut rtrt_cpu::Cpu,
    scene: &Scene,
    camera: &Camera,
    frames: usize,
) -> (Vec<u32>, [f64; Stage::COUNT]) {
    let request = Request::new(camera, [640, 360]).shadows(Shadows::Hard);
    let mut picture = Picture::default();
    let mut all = Vec::new();
    for _ in 0..=frames {
        cpu.render(scene, &request, &mut picture).expect("a frame");
        all.push(picture.stages_ms);
    }
    // The first frame finds its memory.
    let of = |stage: usize| {
        let mut times: Vec<f64> = all[1..].iter().map(|stages| stages[stage]).collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    (picture.pixels, core::array::from_fn(of))
}
