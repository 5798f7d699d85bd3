//! Tests that compare pictures with stored ones, to the bit.
//!
//! ```text
//! $ cargo run --release -p rtrt --example golden
//! 676df3730fce30af57fd1d453a90c38b249507c6e549f85dfaf0c0042ef39d97  three balls
//! $ cargo test --release -p rtrt --example golden
//! test a_ball_rests_on_its_floor ... ok
//! test one_hash_on_every_machine ... ok
//! test what_a_program_draws_is_what_it_drew_before ... ok
//! ```
//!
//! The stored pictures are `tests/golden/*.png`. After an intended change, `RTRT_BLESS=1 cargo test` stores them again,
//! and `git diff` shows which: they are part of the review. docs/golden.md has more.

use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, Request};
use rtrt_core::scene::{Camera, Light, Material, Projection, Scene, SceneError};
use rtrt_cpu::Cpu;

/// What a program of yours draws: balls in a row.
fn balls(count: u32) -> Result<Scene, SceneError> {
    let mut scene = Scene::new();
    let floor = scene.add_material(Material::new([0.6, 0.6, 0.55]).roughness(0.9))?;
    scene
        .add_sphere(floor, Mat4::from_translation(Vec3::Y * -100.0) * Mat4::from_scale(Vec3::splat(100.0)))?;
    for ball in 0..count {
        let share = ball as f32 / count.max(1) as f32;
        let paint = Material::new([0.8, 0.3 + 0.5 * share, 0.2]).roughness(0.2 + 0.6 * share);
        let paint = scene.add_material(paint)?;
        let place = Vec3::new(2.2 * ball as f32 - 1.1 * (count as f32 - 1.0), 1.0, 0.0);
        scene.add_sphere(paint, Mat4::from_translation(place))?;
    }
    scene.add_light(Light::point([3.0, 6.0, 4.0]).color([20.0; 3]).inverse_square(true).radius(0.5));
    Ok(scene)
}

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 2.5, 7.0),
    look_at: Vec3::new(0.0, 0.8, 0.0),
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.7 },
};

/// The SHA-256 of the pixels of three balls.
fn hash() -> Result<String, Box<dyn std::error::Error>> {
    let mut picture = Picture::default();
    let request = Request::new(&CAMERA, [128, 72]).samples(4).exposure(0.5);
    Cpu::new(rtrt_cpu::Options::default())?.render(&balls(3)?, &request, &mut picture)?;
    Ok(rtrt::hash::pixels(&picture))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{}  three balls", hash()?);
    Ok(())
}

#[test]
fn one_hash_on_every_machine() {
    assert_eq!(hash().unwrap(), "676df3730fce30af57fd1d453a90c38b249507c6e549f85dfaf0c0042ef39d97");
}

#[test]
fn a_ball_rests_on_its_floor() {
    let scene = balls(1).unwrap();
    rtrt::assert_picture!(&scene, &CAMERA, "one_ball", size([64, 36]), samples(4));
}

#[test]
fn what_a_program_draws_is_what_it_drew_before() {
    let scene = balls(3).unwrap();
    rtrt::assert_picture!(&scene, &CAMERA, "three_balls", size([128, 72]), samples(4), exposure(0.5));
}
