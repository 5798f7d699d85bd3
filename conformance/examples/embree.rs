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
use rtrt_core::layout::{Instance, View};
use rtrt_core::scene::{Camera, Projection, Scene, Setup};
use std::collections::HashMap;
use std::ffi::{CString, c_char, c_void};
use std::path::Path;
use std::time::Instant;

const SIZE: [u32; 2] = [1280, 720];
const THREADS: usize = 2;
const RUNS: usize = 12;
const NONE: u32 = u32::MAX;

// From rtcore_common.h, rtcore_buffer.h and rtcore_geometry.h of Embree 3.
const TRIANGLES: i32 = 0;
const INSTANCE: i32 = 121;
const INDICES: i32 = 0;
const VERTICES: i32 = 1;
const UINT3: i32 = 0x5003;
const FLOAT3: i32 = 0x9003;
const ROWS_3X4: i32 = 0x9134;
const HIGH: i32 = 2;
const COHERENT: i32 = 1;

type Handle = *mut c_void;

#[link(name = "embree3")]
unsafe extern "C" {
    fn rtcNewDevice(config: *const c_char) -> Handle;
    fn rtcNewScene(device: Handle) -> Handle;
    fn rtcNewGeometry(device: Handle, kind: i32) -> Handle;
    fn rtcSetNewGeometryBuffer(
        geometry: Handle,
        kind: i32,
        slot: u32,
        format: i32,
        stride: usize,
        count: usize,
    ) -> Handle;
    fn rtcCommitGeometry(geometry: Handle);
    fn rtcAttachGeometry(scene: Handle, geometry: Handle) -> u32;
    fn rtcSetSceneBuildQuality(scene: Handle, quality: i32);
    fn rtcCommitScene(scene: Handle);
    fn rtcSetGeometryInstancedScene(geometry: Handle, scene: Handle);
    fn rtcSetGeometryTransform(geometry: Handle, step: u32, format: i32, matrix: *const c_void);
    fn rtcIntersect8(valid: *const i32, scene: Handle, context: *mut Context, rays: *mut Hits8);
    fn rtcOccluded8(valid: *const i32, scene: Handle, context: *mut Context, rays: *mut Rays8);
}

/// `RTCIntersectContext`, with room for the optional fields.
#[repr(C, align(16))]
struct Context {
    flags: i32,
    filter: Handle,
    instance: u32,
    optional: [u32; 12],
}

/// `RTCRay8`.
#[repr(C, align(32))]
#[derive(Clone, Copy)]
struct Rays8 {
    origin: [[f32; 8]; 3],
    near: [f32; 8],
    direction: [[f32; 8]; 3],
    time: [f32; 8],
    far: [f32; 8],
    mask: [u32; 8],
    id: [u32; 8],
    flags: [u32; 8],
}

/// `RTCRayHit8`.
#[repr(C, align(32))]
struct Hits8 {
    rays: Rays8,
    normal: [[f32; 8]; 3],
    u: [f32; 8],
    v: [f32; 8],
    primitive: [u32; 8],
    geometry: [u32; 8],
    instance: [u32; 8],
}

/// A committed scene, which any thread may trace.
struct Committed(Handle);
// SAFETY: Embree's scenes are read only after `rtcCommitScene`, from any thread.
unsafe impl Sync for Committed {}

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
    let embree = build(&loaded.scene, &config);
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

/// The scene as Embree has it: meshes in world space together, the others instanced.
fn build(scene: &Scene, config: &CString) -> Committed {
    // SAFETY: handles come from the calls above them; buffers are written within the size
    // that they were made with.
    unsafe {
        let device = rtcNewDevice(config.as_ptr());
        let top = rtcNewScene(device);
        rtcSetSceneBuildQuality(top, HIGH);
        let mut meshes = HashMap::new();
        for instance in scene.instances() {
            if instance.is_identity == 1 {
                rtcAttachGeometry(top, mesh(device, scene, instance));
                continue;
            }
            let shared = *meshes.entry(instance.root).or_insert_with(|| {
                let shared = rtcNewScene(device);
                rtcSetSceneBuildQuality(shared, HIGH);
                rtcAttachGeometry(shared, mesh(device, scene, instance));
                rtcCommitScene(shared);
                shared
            });
            let instance = rtcNewGeometry(device, INSTANCE);
            rtcSetGeometryInstancedScene(instance, shared);
            rtcSetGeometryTransform(instance, 0, ROWS_3X4, instance.to_world.as_ptr().cast());
            rtcCommitGeometry(instance);
            rtcAttachGeometry(top, instance);
        }
        rtcCommitScene(top);
        Committed(top)
    }
}

/// The instance's mesh.
///
/// # Safety
/// `device` is a device of Embree's.
unsafe fn mesh(device: Handle, scene: &Scene, instance: &Instance) -> Handle {
    let count = 3 * instance.triangles as usize;
    let indices = &scene.mesh_data()[instance.first_index as usize..][..count];
    let vertices = indices.iter().max().map_or(0, |&most| most as usize + 1);
    // SAFETY: Embree gives buffers of the size asked for.
    unsafe {
        let geometry = rtcNewGeometry(device, TRIANGLES);
        let positions = rtcSetNewGeometryBuffer(geometry, VERTICES, 0, FLOAT3, 12, vertices);
        let from = scene.positions()[instance.first_vertex as usize..].as_ptr();
        std::ptr::copy_nonoverlapping(from, positions.cast(), vertices);
        let words = rtcSetNewGeometryBuffer(geometry, INDICES, 0, UINT3, 12, count / 3);
        std::ptr::copy_nonoverlapping(indices.as_ptr(), words.cast(), count);
        rtcCommitGeometry(geometry);
        geometry
    }
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
