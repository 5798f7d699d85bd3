//! What a frame must not cost more for: the number of a texture's texels.

use conformance::shape::paved;
use glam::Vec3;
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Camera, Projection, Scene};
use rtrt_core::schedule::Stage;
use rtrt_cpu::{Cpu, Options};

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 9.0, 26.0),
    look_at: Vec3::ZERO,
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.8 },
};

/// How often each frame is timed.
const RUNS: usize = 21;

/// The least time that `shade` takes for each of these, milliseconds. They take turns, so that what else
/// the machine does is no more to blame for one than for another.
fn least<const N: usize>(frames: [(&Scene, [u32; 2]); N]) -> [f64; N] {
    let mut cpu = Cpu::new(Options { lanes: None, threads: Some(1) }).expect("a processor");
    let (mut picture, mut least) = (Picture::default(), [f64::INFINITY; N]);
    for _ in 0..RUNS {
        for ((scene, size), least) in frames.iter().zip(&mut least) {
            let request = Request::new(&CAMERA, *size).shadows(Shadows::Off);
            cpu.render(scene, &request, &mut picture).expect("a frame");
            *least = least.min(picture.stages_ms[Stage::Shade as usize]);
        }
    }
    least
}

/// A texture of 65,536 times as many texels takes less than three times as long: reads that miss the caches,
/// measured as half as long again, but nothing that grows with texels, nor with levels (13 instead of 5).
#[test]
fn a_larger_texture_takes_no_longer() {
    let (small, large) = (paved(16), paved(4096));
    let [few, many, more_rays] = least([(&small, [320, 180]), (&large, [320, 180]), (&small, [1280, 720])]);
    println!("shade: {few:.3} ms with 16 x 16 texels, {many:.3} ms with 4096 x 4096");
    assert!(many < 3.0 * few, "{many} ms instead of {few}");
    // That what grows shows: a frame of sixteen times as many rays.
    assert!(more_rays > 3.0 * few, "{more_rays} ms for 16 times as many rays, {few} ms for one");
}
