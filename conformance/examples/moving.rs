//! What a frame of 10,000 moving instances costs, on the CPU and on the GPU.
//!
//! `cargo run --release -p conformance --example moving`

use conformance::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, Request};
use rtrt_core::scene::{Camera, InstanceIndex, Light, Motion, Projection};
use rtrt_core::schedule::Stage;
use std::time::Instant;

const OBJECTS: u32 = 10_000;
const FRAMES: u32 = 12;

fn main() {
    let mut build = Build::default();
    let cube = build.mesh(Shape::cube());
    let mut random = Random(3);
    let moving: Vec<(InstanceIndex, Mat4, Motion)> = (0..OBJECTS)
        .map(|_| {
            let start = Mat4::from_translation(random.vector(40.0)) * Mat4::from_scale(Vec3::splat(0.3));
            let motion = Motion {
                velocity: random.vector(2.0),
                axis: random.vector(1.0),
                rate: random.within(0.0, 3.0),
            };
            (build.instance(cube, start), start, motion)
        })
        .collect();
    let sun = Light::sun(Vec3::new(0.3, -1.0, -0.4)).color(Vec3::splat(2.5));
    let mut scene = build.light(sun).scene;
    let camera = Camera {
        eye: Vec3::new(0.0, 20.0, 70.0),
        look_at: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.9 },
    };
    let request = Request::new(&camera, [1280, 720]);
    let mut backends: Vec<Box<dyn Backend>> =
        vec![Box::new(rtrt_cpu::Cpu::new(rtrt_cpu::Options::default()).expect("a processor"))];
    match rtrt_gpu::Gpu::new(rtrt_gpu::Options::default()) {
        Ok(gpu) => backends.push(Box::new(gpu)),
        Err(error) => println!("no GPU: {error}"),
    }
    let mut pictures = Vec::new();
    for backend in &mut backends {
        let mut picture = Picture::default();
        let mut rows: Vec<[f64; Stage::COUNT + 1]> = Vec::new();
        for frame in 0..FRAMES {
            let time = f64::from(frame) / 60.0;
            let start = Instant::now();
            scene
                .set_transforms(
                    moving.iter().map(|(instance, start, motion)| (*instance, motion.at(*start, time))),
                )
                .expect("all within range");
            let moved_ms = start.elapsed().as_secs_f64() * 1e3;
            backend.render(&scene, &request, &mut picture).expect("a frame");
            let mut row = [moved_ms; Stage::COUNT + 1];
            row[1..].copy_from_slice(&picture.stages_ms);
            rows.push(row);
        }
        println!("{:?}", backend.describe());
        for (stage, name) in ["move"].into_iter().chain(Stage::ALL.map(Stage::name)).enumerate() {
            let mut times: Vec<f64> = rows[2..].iter().map(|row| row[stage]).collect();
            times.sort_by(f64::total_cmp);
            println!("{name:>12} {:8.2} ms", times[times.len() / 2]);
        }
        pictures.push(picture.pixels);
    }
    assert!(pictures.windows(2).all(|pair| pair[0] == pair[1]), "backends disagree");
}
