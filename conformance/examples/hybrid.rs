//! Hybrid frames beside those that are traced: how many pixels differ, by how much and where, and the time to
//! find the closest surfaces.
//!
//! `cargo run --release -p conformance --example hybrid [FOLDER [WIDTH]]` prints a table, and writes `hybrid.png` into the
//! folder: each frame, dark, with a mark on each pixel that differs. Frames have 640 columns without a width.

use conformance::hybrid::Differences;
use glam::Vec3;
use rtrt::import::Loaded;
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Light, Projection};
use rtrt_core::schedule::Stage;
use rtrt_cpu::{Cpu, Options, Parallel};
use rtrt_gpu::{Gpu, Route, wgpu};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Columns of a frame.
const WIDTH: u32 = 640;
/// Frames that are timed, after one that is not.
const FRAMES: usize = 3;
/// How far a mark reaches from its pixel.
const MARK: u32 = 2;

/// Files, with the field of view, and eye, look-at and light of `docs/performance.md`.
const FILES: [(&str, f32, [[f32; 3]; 3]); 3] = [
    ("sponza/sponza_dabrovic_cc0tex.glb", 60.0, [[-12.0, 4.0, 0.0], [10.0, 4.0, 0.0], [0.0, 14.0, 0.0]]),
    ("stanford/dragon_res2.glb", 45.0, [[0.0, 0.14, 0.3], [0.0, 0.12, 0.0], [1.0, 2.0, 2.0]]),
    ("hero/chess-board.glb", 45.0, [[150.0, 120.0, 250.0], [0.0; 3], [200.0, 400.0, 100.0]]),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let width: u32 = std::env::args().nth(2).map_or(Ok(WIDTH), |width| width.parse())?;
    // Pictures are written at half of it.
    let size = [width, width * 9 / 16].map(|side| side / 2 * 2);
    let mut cpu = Cpu::new(Options::default())?;
    let mut gpu = open()?;
    println!("| scene | samples | rays | as near | pixels | largest | mean | traced | drawn |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut pictures = Vec::new();
    for (name, loaded) in &scenes()? {
        for samples in [1, 4] {
            let camera = &loaded.camera;
            let request = Request::new(camera, size).samples(samples).shadows(Shadows::Hard).deferred(true);
            let (mut traced, mut drawn) = (Picture::default(), Picture::default());
            cpu.render(&loaded.scene, &request, &mut traced)?;
            gpu.set_hybrid(true)?;
            gpu.render(&loaded.scene, &request, &mut drawn)?;
            let found = Differences::of(&request, &traced, &drawn).ok_or("no deferred buffers")?;
            let times = if samples == 1 {
                let drawn_ms = visibility_ms(&mut gpu, loaded, &request)?;
                gpu.set_hybrid(false)?;
                format!("{:.0} ms | {drawn_ms:.0} ms", visibility_ms(&mut gpu, loaded, &request)?)
            } else {
                "| ".into()
            };
            println!(
                "| {name} | {samples} | {} of {} | {} | {} | {} | {:.5} | {times} |",
                found.other,
                found.rays,
                found.near,
                found.pixels.len(),
                found.largest,
                found.mean
            );
            if samples == 4 {
                pictures.push(marked(&drawn, &found));
            }
        }
    }
    if let Some(folder) = std::env::args().nth(1) {
        write(&Path::new(&folder).join("hybrid.png"), size, &pictures)?;
    }
    Ok(())
}

/// The first adapter, without its clock: lavapipe's stands still where something is drawn.
fn open() -> Result<Gpu, Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: adapter.features() & wgpu::Features::PASSTHROUGH_SHADERS,
        required_limits: adapter.limits(),
        ..Default::default()
    }))?;
    Ok(Gpu::with_device(device, queue, Route::Auto)?)
}

fn scenes() -> Result<Vec<(&'static str, Loaded)>, Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let mut scenes = Vec::new();
    for (file, fov_y, [eye, look_at, light]) in FILES.into_iter().filter(|file| folder.join(file.0).exists())
    {
        let mut loaded = rtrt::import::load(&folder.join(file), &Parallel)?;
        loaded.camera.eye = eye.into();
        loaded.camera.look_at = look_at.into();
        loaded.camera.up = Vec3::Y;
        loaded.camera.projection = Projection::Perspective { fov_y: f32::to_radians(fov_y) };
        *loaded.scene.lights_mut() = vec![Light::point(light)];
        let name = file.split(['/', '.']).nth(1).unwrap_or(file);
        scenes.push((name, loaded));
    }
    scenes.push(("demo:matchbox", rtrt::demo::matchbox(&Parallel)?));
    scenes.push(("demo:glass", rtrt::demo::glass(&Parallel)?));
    Ok(scenes)
}

/// The median time of the stage.
fn visibility_ms(
    gpu: &mut Gpu,
    loaded: &Loaded,
    request: &Request<'_>,
) -> Result<f64, Box<dyn std::error::Error>> {
    let request = request.deferred(false);
    let mut picture = Picture::default();
    let mut times = Vec::new();
    for frame in 0..=FRAMES {
        gpu.render(&loaded.scene, &request, &mut picture)?;
        if frame > 0 {
            times.push(picture.stages_ms[Stage::Visibility as usize]);
        }
    }
    times.sort_by(f64::total_cmp);
    Ok(times[FRAMES / 2])
}

/// The picture, darkened, with differing pixels in red.
fn marked(picture: &Picture, found: &Differences) -> Vec<[u8; 3]> {
    let dark = |pixel: &u32| [0, 8, 16].map(|shift| ((pixel >> shift & 255) / 3) as u8);
    let mut pixels: Vec<_> = picture.pixels.iter().map(dark).collect();
    let [width, height] = [picture.width, picture.height];
    for number in &found.pixels {
        let [x, y] = [number % width, number / width];
        for y in y.saturating_sub(MARK)..(y + MARK + 1).min(height) {
            for x in x.saturating_sub(MARK)..(x + MARK + 1).min(width) {
                pixels[(y * width + x) as usize] = [255, 48, 32];
            }
        }
    }
    pixels
}

/// Writes pictures side by side, at half their size.
fn write(
    path: &Path,
    [width, height]: [u32; 2],
    pictures: &[Vec<[u8; 3]>],
) -> Result<(), Box<dyn std::error::Error>> {
    let mut bytes = Vec::new();
    for y in (0..height).step_by(2) {
        for picture in pictures {
            for x in (0..width).step_by(2) {
                // The largest: no mark is lost.
                let four = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
                let four = four.map(|[x, y]| picture[(y * width + x) as usize]);
                bytes.extend(
                    [0, 1, 2].map(|channel| four.iter().map(|pixel| pixel[channel]).max().unwrap_or(0)),
                );
            }
        }
    }
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, width / 2 * pictures.len() as u32, height / 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&bytes)?;
    Ok(())
}
