//! Soft shadows beside a reference that asks for 1,024 points of each light in every pixel.
//!
//! `cargo run --release -p conformance --example soft [FOLDER]` prints the mean errors of hard
//! shadows, of area lights and of analytic soft shadows, and writes pictures into the folder:
//! hard, analytic and reference, side by side.
//!
//! The reference is the average of frames of area lights whose points differ from frame to frame;
//! all else, the sub-rays' places in their pixels included, is as in the frames beside it.

use glam::Vec3;
use rtrt::import::Loaded;
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::grid::Grid;
use rtrt_core::num::srgb_encode;
use rtrt_core::scene::{Camera, Light, LightKind};
use rtrt_core::stage::resolve::average;
use rtrt_cpu::{Cpu, Options, Parallel};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

const SIZE: [u32; 2] = [480, 270];
/// Points of a light in a pixel of the reference.
const POINTS: u32 = 1024;

type Pixels = Vec<[f64; 3]>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1);
    let cornell =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes/cornell/cornell_box/scene.gltf");
    let mut scenes: Vec<(&str, Loaded)> = Vec::new();
    if cornell.exists() {
        let mut loaded = rtrt::import::load(&cornell, &Parallel)?;
        loaded.camera.eye = Vec3::new(0.0, 1.0, 3.2);
        loaded.camera.look_at = Vec3::new(0.0, 0.95, 0.0);
        *loaded.scene.lights_mut() = vec![Light::point(Vec3::new(0.0, 1.7, 0.0)).radius(0.15)];
        scenes.push(("cornell", loaded));
    }
    let mut glass = rtrt::demo::glass(&Parallel)?;
    for light in glass.scene.lights_mut() {
        light.radius = if light.kind == LightKind::Sun { 0.02 } else { 0.2 };
    }
    scenes.push(("demo:glass", glass));

    println!(
        "| scene | samples | hard | area | area, jittered | soft | where shadows are soft: hard | soft |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let mut cpu = Cpu::new(Options::default())?;
    for (name, loaded) in &scenes {
        for samples in [1, 4, 16] {
            let mut render = |shadows| frame(&mut cpu, loaded, &loaded.camera, samples, shadows);
            let mut reference = vec![[0.0; 3]; (SIZE[0] * SIZE[1]) as usize];
            let frames = POINTS / samples;
            for seed in 0..frames {
                let one = render(Shadows::Area { jitter: Some(seed + 1) })?;
                for (sum, color) in reference.iter_mut().flatten().zip(one.iter().flatten()) {
                    *sum += color / f64::from(frames);
                }
            }
            let hard = render(Shadows::Hard)?;
            let soft = render(Shadows::Soft)?;
            let area = render(Shadows::Area { jitter: None })?;
            let jittered = render(Shadows::Area { jitter: Some(0) })?;
            let is_soft = |at: usize| error(&hard[at..=at], &reference[at..=at]) > 0.01;
            let soft_only = |pixels: &Pixels| -> Pixels {
                (0..pixels.len()).filter(|&at| is_soft(at)).map(|at| pixels[at]).collect()
            };
            let expected = soft_only(&reference);
            println!(
                "| {name} | {samples} | {:.4} | {:.4} | {:.4} | {:.4} | {:.4} | {:.4} |",
                error(&hard, &reference),
                error(&area, &reference),
                error(&jittered, &reference),
                error(&soft, &reference),
                error(&soft_only(&hard), &expected),
                error(&soft_only(&soft), &expected),
            );
            if let (Some(folder), 4) = (&folder, samples) {
                let file = format!("soft-{}.png", name.trim_start_matches("demo:"));
                write(&Path::new(folder).join(file), &[&hard, &soft, &reference])?;
            }
        }
    }
    Ok(())
}

/// The linear colors of a frame's pixels.
fn frame(
    cpu: &mut Cpu,
    loaded: &Loaded,
    camera: &Camera,
    samples: u32,
    shadows: Shadows,
) -> Result<Pixels, Box<dyn std::error::Error>> {
    let request = Request::new(camera, SIZE).samples(samples).shadows(shadows).deferred(true);
    let mut picture = Picture::default();
    cpu.render(&loaded.scene, &request, &mut picture)?;
    let deferred = picture.deferred.ok_or("no deferred buffers")?;
    let grid = Grid { width: SIZE[0], height: SIZE[1], side: samples.isqrt() };
    let color = |number| {
        let [r, g, b, _] = average(grid.side, grid.first_ray(number), |ray| deferred.colors[ray.0 as usize]);
        [r, g, b].map(f64::from)
    };
    Ok((0..SIZE[0] * SIZE[1]).map(color).collect())
}

/// The mean of how far channels are off.
fn error(pixels: &[[f64; 3]], reference: &[[f64; 3]]) -> f64 {
    let off: f64 = pixels.iter().flatten().zip(reference.iter().flatten()).map(|(a, b)| (a - b).abs()).sum();
    off / (3 * pixels.len().max(1)) as f64
}

/// Writes pictures side by side.
fn write(path: &Path, pictures: &[&Pixels]) -> Result<(), Box<dyn std::error::Error>> {
    let [width, height] = SIZE;
    let mut bytes = Vec::new();
    for y in 0..height {
        for picture in pictures {
            for color in &picture[(y * width) as usize..][..width as usize] {
                bytes.extend(color.map(|channel| (srgb_encode(channel as f32) * 255.0 + 0.5) as u8));
            }
        }
    }
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, width * pictures.len() as u32, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&bytes)?;
    Ok(())
}
