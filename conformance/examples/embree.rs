//! The yardstick: Embree 3 with packets of 8 rays, same scene, camera, rays and threads as
//! `rtrt bench` at one sample, one light and 1280x720.
//!
//! ```text
//! apt-get install libembree-dev
//! cargo run --release -p conformance --features embree --example embree -- \
//!     SCENE eye-x,y,z look-at-x,y,z fov-degrees light-x,y,z [isa]
//! ```
//!
//! Prints the time of the tree build (high quality), and rays per second: primary rays
//! alone, then primary and shadow rays with Lambert's cosine. `isa` is Embree's (`avx2` by
//! default, `avx512` for what it would choose itself on newer processors).

use glam::Vec3;
use rayon::prelude::*;
use rtrt_core::backend::{Request, Shadows};
use rtrt_core::layout::View;
use rtrt_core::scene::{Camera, Projection, Setup};
use std::ffi::CString;
use std::path::Path;
use std::time::Instant;

#[path = "yardstick/embree3.rs"]
mod embree3;

use embree3::{Committed, Context, HIGH, Hits8, NONE, Rays8, build, rtcIntersect8, rtcOccluded8};

/// `RTC_INTERSECT_CONTEXT_FLAG_COHERENT`.
const COHERENT: i32 = 1;
const SIZE: [u32; 2] = [1280, 720];
const THREADS: usize = 2;
const RUNS: usize = 12;

/// What one pass over the frame found.
#[derive(Clone, Copy, Default)]
struct Found {
    hits: u64,
    shadow_rays: u64,
    light: f32,
}

impl Found {
    fn plus(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            light: self.light + other.light,
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, eye, look_at, fov, light, isa @ ..] = &arguments[..] else {
        return Err("SCENE eye look-at fov light [isa]".into());
    };
    let loaded = rtrt::import::load(Path::new(scene), &rtrt_core::scene::Sequential)?;
    let camera = Camera {
        eye: vector(eye)?,
        look_at: vector(look_at)?,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: fov.parse::<f32>()?.to_radians() },
    };
    let light = vector(light)?.to_array();
    let mut setup = Setup::default();
    setup.prepare(&loaded.scene, &Request::new(&camera, SIZE).shadows(Shadows::Hard).layers(1))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(THREADS).build()?;
    let isa = isa.first().map_or("avx2", String::as_str);
    let config = CString::new(format!("threads={THREADS},isa={isa}"))?;

    let start = Instant::now();
    let embree = build(&loaded.scene, &config, HIGH);
    println!("embree {isa}, {THREADS} threads: build {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
    let primary = f64::from(SIZE[0] * SIZE[1]);
    for light in [None, Some(light)] {
        let mut best = f64::MAX;
        let mut found = Found::default();
        for _ in 0..RUNS {
            let start = Instant::now();
            found = pool.install(|| frame(&embree, &setup.views[0], light));
            best = best.min(start.elapsed().as_secs_f64());
        }
        let rays = primary + found.shadow_rays as f64;
        let what = if light.is_some() { "primary and shadow" } else { "primary" };
        println!(
            "{what}: {:.1} M rays/s, {} hits, {} shadow rays",
            rays / best / 1e6,
            found.hits,
            found.shadow_rays
        );
    }
    Ok(())
}

/// `x,y,z`.
fn vector(text: &str) -> Result<Vec3, Box<dyn std::error::Error>> {
    let parts = text.split(',').map(str::parse).collect::<Result<Vec<f32>, _>>()?;
    Ok(Vec3::from(<[f32; 3]>::try_from(parts).map_err(|_| "not x,y,z")?))
}

/// One pass over the frame, in tiles of 16 x 16 rays and packets of 4 x 2.
fn frame(scene: &Committed, view: &View, light: Option<[f32; 3]>) -> Found {
    (0..SIZE[1].div_ceil(16))
        .into_par_iter()
        .map(|row| {
            let mut found = Found::default();
            for packet in 0..SIZE[0].div_ceil(16) * 32 {
                let (tile, place) = (packet / 32, packet % 32);
                let corner = [tile * 16 + place % 4 * 4, row * 16 + place / 4 * 2];
                found = found.plus(trace(scene, view, corner, light));
            }
            found
        })
        .reduce(Found::default, Found::plus)
}

/// One packet.
fn trace(scene: &Committed, view: &View, corner: [u32; 2], light: Option<[f32; 3]>) -> Found {
    let mut context =
        Context { flags: COHERENT, filter: std::ptr::null_mut(), instance: NONE, optional: [0; 12] };
    let mut hits = Hits8 {
        rays: Rays8 {
            origin: view.center.map(|c| [c; 8]),
            near: [0.0; 8],
            direction: [[0.0; 8]; 3],
            time: [0.0; 8],
            far: [f32::INFINITY; 8],
            mask: [u32::MAX; 8],
            id: [0; 8],
            flags: [0; 8],
        },
        normal: [[0.0; 8]; 3],
        u: [0.0; 8],
        v: [0.0; 8],
        primitive: [NONE; 8],
        geometry: [NONE; 8],
        instance: [NONE; 8],
    };
    for i in 0..8 {
        let at = |axis: usize, add: usize| (corner[axis] as f32 + add as f32 + 0.5) / 16.0;
        let (a, b) = (at(0, i % 4), at(1, i / 4));
        for k in 0..3 {
            hits.rays.direction[k][i] = a * view.along_x[k] + b * view.along_y[k] + view.along[k];
        }
    }
    // SAFETY: the structures are laid out as Embree's headers say, and aligned.
    unsafe { rtcIntersect8([-1; 8].as_ptr(), scene.0, &mut context, &mut hits) };
    let mut found =
        Found { hits: hits.geometry.iter().filter(|&&g| g != NONE).count() as u64, ..Found::default() };
    let (Some(light), true) = (light, found.hits > 0) else { return found };

    let mut shadow = hits.rays;
    let (mut valid, mut cosine) = ([0; 8], [0.0; 8]);
    for i in 0..8 {
        if hits.geometry[i] == NONE {
            continue;
        }
        let at = |k: usize| hits.rays.origin[k][i] + hits.rays.far[i] * hits.rays.direction[k][i];
        let point = [at(0), at(1), at(2)];
        let way = [light[0] - point[0], light[1] - point[1], light[2] - point[2]];
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let normal = [hits.normal[0][i], hits.normal[1][i], hits.normal[2][i]];
        let direction = [hits.rays.direction[0][i], hits.rays.direction[1][i], hits.rays.direction[2][i]];
        let facing = if dot(normal, direction) > 0.0 { -dot(normal, way) } else { dot(normal, way) };
        if facing <= 0.0 {
            continue;
        }
        cosine[i] = facing / (dot(normal, normal) * dot(way, way)).sqrt();
        valid[i] = -1;
        found.shadow_rays += 1;
        for k in 0..3 {
            shadow.origin[k][i] = point[k];
            shadow.direction[k][i] = way[k];
        }
        (shadow.near[i], shadow.far[i]) = (1e-4, 1.0);
    }
    // SAFETY: as above.
    unsafe { rtcOccluded8(valid.as_ptr(), scene.0, &mut context, &mut shadow) };
    found.light = (0..8).filter(|&i| valid[i] != 0 && shadow.far[i] >= 0.0).map(|i| cosine[i]).sum();
    found
}
