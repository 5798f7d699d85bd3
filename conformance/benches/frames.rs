//! Times of frames, lists and BVHs. Each timed result is compared with that of a single thread of single
//! lanes gives.
//!
//! `cargo bench -p conformance --bench frames`

use conformance::shape::{Build, Random, Shape};
use divan::Bencher;
use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Bvh, Camera, Light, Projection, Scene, Sequential};
use rtrt_cpu::{Cpu, Options, Parallel};

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 4.0, 14.0),
    look_at: Vec3::ZERO,
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.9 },
};

fn main() {
    divan::main();
}

fn cpu(lanes: u32, threads: usize) -> Option<Cpu> {
    Cpu::new(Options { lanes: Some(lanes), threads: Some(threads) }).ok()
}

/// Times frames of a scene, as wide as this machine can be.
fn frames(bencher: Bencher<'_, '_>, scene: &Scene, camera: &Camera, lanes: u32) {
    let request = Request::new(camera, [320, 180]).shadows(Shadows::Hard);
    let (Some(mut cpu), Some(mut scalar)) = (cpu(lanes, 1), cpu(1, 1)) else {
        println!("no {lanes} lanes here");
        return;
    };
    let (mut picture, mut expected) = (Picture::default(), Picture::default());
    scalar.render(scene, &request, &mut expected).expect("a frame");
    bencher.bench_local(|| cpu.render(scene, &request, &mut picture).expect("a frame"));
    assert_eq!(picture.pixels, expected.pixels, "lanes change the picture");
}

#[divan::bench(args = [1, 8, 16])]
fn matchbox(bencher: Bencher<'_, '_>, lanes: u32) {
    let loaded = rtrt::demo::matchbox(&Sequential).expect("a scene");
    frames(bencher, &loaded.scene, &loaded.camera, lanes);
}

#[divan::bench(args = [1, 8, 16])]
fn glass(bencher: Bencher<'_, '_>, lanes: u32) {
    let loaded = rtrt::demo::glass(&Sequential).expect("a scene");
    frames(bencher, &loaded.scene, &loaded.camera, lanes);
}

#[divan::bench(args = [1, 8, 16])]
fn thousand_balls(bencher: Bencher<'_, '_>, lanes: u32) {
    let mut random = Random(5);
    let mut build = Build::default();
    let ball = build.mesh(Shape::ball(5));
    for _ in 0..1000 {
        let place = Mat4::from_translation(random.vector(5.0)) * Mat4::from_scale(Vec3::splat(0.2));
        build.instance(ball, place);
    }
    let scene = build.light(Light::point([0.0, 9.0, 3.0])).scene;
    frames(bencher, &scene, &CAMERA, lanes);
}

/// A tree of 20,000 triangles.
#[divan::bench(args = ["one thread", "all threads"])]
fn tree(bencher: Bencher<'_, '_>, how: &str) {
    let mesh = Shape::ball(100).mesh();
    let expected = Bvh::build(&mesh, &Sequential);
    let cpu = Cpu::new(Options::default()).expect("a processor");
    bencher.bench_local(|| {
        let tree = match how {
            "one thread" => Bvh::build(&mesh, &Sequential),
            _ => cpu.install(|| Bvh::build(&mesh, &Parallel)),
        };
        assert_eq!(tree, expected, "threads change the tree");
    });
}
