//! How the time of a frame grows with instances, pixels, lights and threads: a table and a plot for
//! each, on the native CPU backend. Every picture that is timed is compared with the one that a
//! single thread of single lanes gives.
//!
//! `cargo run --release -p conformance --example scaling -- docs`

use conformance::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use plotters::prelude::*;
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Camera, Light, Projection, Scene};
use rtrt_core::schedule::Stage;
use rtrt_cpu::{Cpu, Options};
use std::error::Error;
use std::path::Path;

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 9.0, 26.0),
    look_at: Vec3::ZERO,
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.8 },
};
const SIZE: [u32; 2] = [1280, 720];
const FRAMES: usize = 7;

/// The lines of a plot: which stages each of them adds up.
const LINES: [(&str, &[Stage]); 5] = [
    ("frame", &Stage::ALL),
    ("prepare, bin", &[Stage::Prepare, Stage::Bin]),
    ("visibility", &[Stage::Visibility]),
    ("occlusion", &[Stage::Occlusion]),
    ("others", &[Stage::Surface, Stage::Detail, Stage::Light, Stage::Shade, Stage::Layers, Stage::Resolve]),
];

/// What a frame took: its x, and milliseconds for each of [`LINES`].
type Row = (f64, [f64; LINES.len()]);

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: scaling FOLDER")?;
    let threads = std::thread::available_parallelism()?.get();
    println!("{:?}", Cpu::new(Options::default())?.describe());

    let counts = [10, 100, 1000, 10_000, 100_000, 1_000_000];
    let rows = counts.map(|count| (f64::from(count), frame(&balls(count, 0), SIZE, threads)));
    plot(&folder, "instances", "balls of 64 triangles, instances of one mesh", &rows)?;

    let hall = balls(1000, 0);
    let sizes = [[160, 90], [320, 180], [640, 360], [1280, 720], [2560, 1440], [3840, 2160]];
    let rows = sizes.map(|size| (f64::from(size[0]) * f64::from(size[1]), frame(&hall, size, threads)));
    plot(&folder, "pixels", "pixels", &rows)?;

    let rows = [1, 4, 16, 64, 256, 1024]
        .map(|lights| (f64::from(lights), frame(&balls(1000, lights), SIZE, threads)));
    plot(&folder, "lights", "lights that reach a sixth of the scene", &rows)?;

    let rows: Vec<Row> = (1..=threads).map(|n| (n as f64, frame(&hall, SIZE, n))).collect();
    plot(&folder, "threads", "threads", &rows)?;
    Ok(())
}

/// Balls of the same total volume, whatever their number, above a floor; so many lamps, or a sun if
/// that is none.
fn balls(count: u32, lights: u32) -> Scene {
    let mut random = Random(3);
    let mut build = Build::default();
    let ball = build.mesh(Shape::ball(4));
    let size = 2.0 / (count as f32).cbrt();
    for _ in 0..count {
        let place = Mat4::from_translation(random.vector(8.0)) * Mat4::from_scale(Vec3::splat(size));
        build.instance(ball, place);
    }
    let mut build = build.shape(Shape::floor(40.0, -9.0));
    if lights == 0 {
        return build.light(Light::sun([0.3, -1.0, -0.4])).scene;
    }
    for _ in 0..lights {
        build = build.light(Light::point(random.vector(9.0).to_array()).reach(3.0));
    }
    build.scene
}

/// The median time of a frame, by lines.
fn frame(scene: &Scene, size: [u32; 2], threads: usize) -> [f64; LINES.len()] {
    let request = Request::new(&CAMERA, size).shadows(Shadows::Hard);
    let render =
        |cpu: &mut Cpu, picture: &mut Picture| cpu.render(scene, &request, picture).expect("a frame");
    let new = |lanes, threads| Cpu::new(Options { lanes, threads: Some(threads) }).expect("a processor");
    let mut cpu = new(None, threads);
    let mut picture = Picture::default();
    let mut rows = Vec::new();
    for _ in 0..=FRAMES {
        render(&mut cpu, &mut picture);
        rows.push(
            LINES.map(|(_, stages)| {
                stages.iter().map(|&stage| picture.stages_ms[stage as usize]).sum::<f64>()
            }),
        );
    }
    let mut expected = Picture::default();
    render(&mut new(Some(1), 1), &mut expected);
    assert_eq!(picture.pixels, expected.pixels, "the picture depends on lanes or threads");
    std::array::from_fn(|line| {
        // The first frame finds its memory.
        let mut times: Vec<f64> = rows[1..].iter().map(|row: &[f64; LINES.len()]| row[line]).collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    })
}

/// Prints the rows, and draws them on logarithmic axes.
fn plot(folder: &str, name: &str, what: &str, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    println!("\n{name:>12} {}", LINES.map(|(line, _)| format!("{line:>14}")).join(""));
    for (x, times) in rows {
        println!("{x:>12} {}", times.map(|ms| format!("{ms:>11.2} ms")).join(""));
    }
    let path = Path::new(folder).join(format!("scaling-{name}.svg"));
    let area = SVGBackend::new(&path, (640, 400)).into_drawing_area();
    area.fill(&WHITE)?;
    // A stage that takes no time at all has no place on a logarithmic axis.
    let shown = |ms: f64| ms.max(0.01);
    let most = rows.iter().map(|(_, times)| times[0]).fold(0.1, f64::max);
    let (first, last) = (rows[0].0, rows[rows.len() - 1].0.max(rows[0].0 * 2.0));
    let mut chart = ChartBuilder::on(&area)
        .margin(12)
        .margin_right(36)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d((first..last).log_scale(), (0.01..most * 2.0).log_scale())?;
    let plain = |number: &f64| format!("{number}");
    chart
        .configure_mesh()
        .x_desc(what)
        .y_desc("milliseconds a frame")
        .x_label_formatter(&plain)
        .y_label_formatter(&plain)
        .draw()?;
    for (line, (label, _)) in LINES.iter().enumerate() {
        let color = Palette99::pick(line).to_rgba();
        let points = rows.iter().map(|(x, times)| (*x, shown(times[line])));
        chart
            .draw_series(LineSeries::new(points, color.stroke_width(2)).point_size(3))?
            .label(*label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.8))
        .draw()?;
    area.present()?;
    println!("{}", path.display());
    Ok(())
}
