//! A simulation whose pictures are part of its result: 100 frames, one hash, the same on every machine.
//!
//! ```text
//! $ cargo run --release -p rtrt --example deterministic_sim
//! cpu, scalar: fc598b2b…
//! cpu, AVX-512: fc598b2b…
//! gpu, llvmpipe (LLVM 15.0.6, 256 bits) (vulkan): fc598b2b…
//! ```
//!
//! Balls bounce in a box. Their motion is additions, multiplications and comparisons of `f32`, which every
//! processor rounds alike; the pictures are rtrt's. So two machines may run in lockstep and compare hashes, and a
//! recorded run may be played again.

use glam::{Mat4, Vec3};
use rtrt::choose::{Choice, Options, choose};
use rtrt::hash;
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{
    Attribute, Bvh, Camera, InstanceIndex, Light, Material, Mesh, Projection, Scene, Sequential,
};
use std::error::Error;

const FRAMES: u32 = 100;
const BALLS: u32 = 5;

/// Of all frames.
const HASH: &str = "e015e91581e56da4374df9bbebd4b491b9fa360d3f57ac226bb70b4ba0df08f0";

fn main() -> Result<(), Box<dyn Error>> {
    let scalar = Options { choice: Choice::Cpu, lanes: Some(1), threads: Some(1), ..Options::default() };
    let widest = Options { choice: Choice::Cpu, ..Options::default() };
    let gpu = Options { choice: Choice::Gpu, ..Options::default() };
    for options in [scalar, widest, gpu] {
        let mut chosen = match choose(&options) {
            Ok(chosen) => chosen,
            Err(error) => {
                println!("skipped: {error}");
                continue;
            }
        };
        let machine = chosen.backend.describe();
        let hash = simulate(&mut *chosen.backend)?;
        println!("{}, {}: {hash}", machine.kind, machine.adapter);
        assert_eq!(hash, HASH);
    }
    Ok(())
}

/// A ball: where it is, how it moves.
struct Ball {
    object: InstanceIndex,
    at: Vec3,
    step: Vec3,
}

/// Runs the simulation from its start, and gives the hash of all its frames.
fn simulate(backend: &mut dyn Backend) -> Result<String, Box<dyn Error>> {
    let (mut scene, mut balls) = start()?;
    let camera = Camera {
        eye: Vec3::new(0.0, 1.0, 6.0),
        look_at: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.8 },
    };
    let request = Request::new(&camera, [48, 32]).shadows(Shadows::Hard).layers(1);
    let (mut picture, mut frames) = (Picture::default(), vec![]);
    for _ in 0..FRAMES {
        balls.iter_mut().for_each(advance);
        let moved = balls.iter().map(|ball| (ball.object, placed(ball.at)));
        scene.set_transforms(moved)?;
        backend.render(&scene, &request, &mut picture)?;
        frames.extend_from_slice(&picture.bytes());
    }
    Ok(hash::of(&frames))
}

/// A sixtieth of a second: gravity, then walls.
fn advance(ball: &mut Ball) {
    ball.step.y -= 1.0 / 512.0;
    ball.at += ball.step;
    for axis in 0..3 {
        if ball.at[axis].abs() > 1.0 {
            ball.at[axis] = ball.at[axis].signum();
            ball.step[axis] *= -0.875;
        }
    }
}

fn placed(at: Vec3) -> Mat4 {
    Mat4::from_translation(at) * Mat4::from_scale(Vec3::splat(0.25))
}

/// Balls (octahedra, really) over a floor, a lamp above them.
fn start() -> Result<(Scene, Vec<Ball>), Box<dyn Error>> {
    let mut scene = Scene::new();
    let blue = scene.add_material(Material::new([0.2, 0.4, 0.8]).roughness(0.4))?;
    let white = scene.add_material(Material::new([0.8; 3]).roughness(0.9))?;
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis.to_array());
    let tips = vec![x, y, z, (-Vec3::X).to_array(), (-Vec3::Y).to_array(), (-Vec3::Z).to_array()];
    let sides = vec![0, 1, 2, 1, 3, 2, 3, 4, 2, 4, 0, 2, 1, 0, 5, 3, 1, 5, 4, 3, 5, 0, 4, 5];
    let smooth =
        tips.iter().map(|&normal| Attribute { normal, uv: [0.0; 2], color: Attribute::WHITE }).collect();
    let ball = Mesh::new(tips, smooth, sides)?;
    let up = Attribute { normal: y, uv: [0.0; 2], color: Attribute::WHITE };
    let corners = vec![[-2.0, -1.3, 2.0], [2.0, -1.3, 2.0], [0.0, -1.3, -4.0]];
    let floor = Mesh::new(corners, vec![up; 3], vec![0, 1, 2])?;
    let floor = scene.add_mesh(&floor, &Bvh::build(&floor, &Sequential))?;
    scene.add_instance(floor, white, Mat4::IDENTITY)?;
    let ball = scene.add_mesh(&ball, &Bvh::build(&ball, &Sequential))?;
    let mut balls = vec![];
    for number in 0..BALLS {
        let i = number as f32;
        let at = Vec3::new(i * 0.375 - 0.75, 0.125 * i, 0.25 - i * 0.125);
        let step = Vec3::new(0.03125, 0.0, 0.0625) * (i - 1.5);
        balls.push(Ball { object: scene.add_instance(ball, blue, placed(at))?, at, step });
    }
    let position = Vec3::new(1.0, 4.0, 2.0);
    scene.add_light(Light::point(position));
    Ok((scene, balls))
}

#[test]
fn runs() {
    main().expect("no error");
}
