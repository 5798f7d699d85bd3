//! What a run has rendered: the JSON of `--report`, and the header of EXR files.
//!
//! Its list `frames` has the keys of [`rtrt::poses`], so that `--cameras` renders the same views again.

use super::gpus;
use super::job::RenderJob;
use super::memory::peak_rss_bytes;
use super::report::{Machine, PerStage};
use super::views::Names;
use glam::{DMat4, DVec3};
use rtrt::hash;
use rtrt::import::Label;
use rtrt::layers::Layers;
use rtrt::objects::seen;
use rtrt::pose::{Pinhole, to_world};
use rtrt_core::backend::{Picture, ToneMap};
use rtrt_core::scene::Projection;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// All of a run.
#[derive(Serialize)]
pub struct RunReport {
    version: &'static str,
    /// SHA-256 of the shaders; null without the feature `gpu`.
    shaders: Option<String>,
    #[serde(flatten)]
    machine: Machine,
    scenes: Vec<SceneReport>,
    frames: Vec<FrameReport>,
    /// The names of the frames.
    #[serde(skip)]
    names: Names,
    /// Wall-clock time since the command began.
    total_ms: f64,
    /// The peak memory of the process; null on systems without that figure.
    peak_rss_bytes: Option<u64>,
}

/// A scene of a run.
#[derive(Serialize)]
struct SceneReport {
    scene: PathBuf,
    /// The files that it was read from.
    files: Vec<PathBuf>,
    load_ms: f64,
    bvh_build_ms: f64,
    triangles: u64,
    drawn_triangles: u64,
    /// The bytes of its arrays.
    scene_bytes: usize,
    /// Each object that can be in a picture.
    objects: Vec<ObjectReport>,
}

/// What the file calls an object.
#[derive(Serialize)]
struct ObjectReport {
    /// The number in the layer object.
    id: usize,
    node: String,
    mesh: String,
    material: String,
    /// The number in the layer material.
    material_id: u32,
}

/// A picture of a run.
#[derive(Serialize)]
struct FrameReport {
    /// That of its camera, with a number where another frame has it: what `--cameras` calls it.
    name: String,
    /// Its place in `scenes`.
    scene: usize,
    file_path: Option<PathBuf>,
    aov: Option<PathBuf>,
    #[serde(flatten)]
    shot: Shot,
    /// Stops by which light was raised.
    exposure: f32,
    tone_map: &'static str,
    /// SHA-256 of the pixels.
    hash: String,
    frame_ms: f64,
    stages_ms: PerStage<f64>,
    /// The objects of which something is seen.
    seen: Vec<SeenReport>,
}

/// The visible pixels of an object, and its boxes.
#[derive(Serialize)]
struct SeenReport {
    id: u32,
    /// Pixels whose first sub-ray hits it.
    pixels: u32,
    /// Left, top, and the first column and row beyond.
    box_2d: [u32; 4],
    /// Lower and upper corner around all of it, world space.
    box_3d: [[f64; 3]; 2],
}

/// How the light of a picture was taken: nothing that differs from run to run, and nothing of its display.
#[derive(Debug, Clone, Serialize)]
pub struct Shot {
    camera: String,
    frame: u32,
    /// Seconds; null for a scene at rest.
    time: Option<f64>,
    w: u32,
    h: u32,
    samples: u32,
    /// Rows of the matrix from the camera's axes (x to the right, y up, z backward) to world space.
    transform_matrix: [[f64; 4]; 4],
    eye: [f64; 3],
    look_at: [f64; 3],
    up: [f32; 3],
    /// The lens, pixels from the upper left corner; null for parallel rays.
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    /// Degrees; null unless it says all of the lens.
    fov_y: Option<f64>,
    /// The height of the picture, world units, with parallel rays.
    parallel: Option<f32>,
    /// The depths between which surfaces are drawn, world units; null for no limit.
    near: f32,
    far: Option<f32>,
}

impl Shot {
    /// How the job's picture is taken, at this time of its animation.
    pub fn new(job: &RenderJob, camera: &str, frame: u32, time: Option<f64>) -> Self {
        let lens = Pinhole::new(&job.camera, job.size);
        let (fov_y, parallel) = match job.camera.projection {
            Projection::Perspective { fov_y } => (Some(f64::from(fov_y).to_degrees()), None),
            Projection::Orthographic { height } => (None, Some(height)),
            Projection::OffCenter { .. } => (None, None),
        };
        Self {
            camera: camera.into(),
            frame,
            time,
            w: job.size[0],
            h: job.size[1],
            samples: job.samples,
            // A camera that looks nowhere is refused before it is rendered.
            transform_matrix: (DMat4::from_translation(job.origin)
                * to_world(&job.camera).unwrap_or(DMat4::IDENTITY))
            .transpose()
            .to_cols_array_2d(),
            eye: in_file(job.camera.eye.into(), job.origin),
            look_at: in_file(job.camera.look_at.into(), job.origin),
            up: job.camera.up.into(),
            fl_x: lens.map(|lens| lens.fx),
            fl_y: lens.map(|lens| lens.fy),
            cx: lens.map(|lens| lens.cx),
            cy: lens.map(|lens| lens.cy),
            fov_y,
            parallel,
            near: job.clip[0],
            far: Some(job.clip[1]).filter(|far| far.is_finite()),
        }
    }
}

/// A point in the file's coordinates; without an origin, the shortest numbers that are the same in single precision.
fn in_file(point: [f32; 3], origin: DVec3) -> [f64; 3] {
    let axis = |axis: usize| {
        let shortest = point[axis].to_string().parse();
        if origin[axis] == 0.0 { shortest } else { Ok(origin[axis] + f64::from(point[axis])) }
            .unwrap_or(f64::from(point[axis]))
    };
    [0, 1, 2].map(axis)
}

impl RunReport {
    /// A report without scenes.
    pub fn new(machine: &Machine) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            shaders: gpus::shaders(),
            machine: machine.clone(),
            scenes: vec![],
            frames: vec![],
            names: Names::default(),
            total_ms: 0.0,
            peak_rss_bytes: None,
        }
    }

    /// Adds a scene, to which the next frames belong.
    pub fn add_scene(&mut self, path: &Path, job: &RenderJob) {
        let object = |(id, instance): (usize, &rtrt_core::layout::Instance)| {
            let Label { node, mesh, material, .. } = job.label(id);
            ObjectReport { id, node, mesh, material, material_id: instance.material }
        };
        self.scenes.push(SceneReport {
            scene: path.to_owned(),
            files: job.files().to_vec(),
            load_ms: job.load_ms,
            bvh_build_ms: job.bvh_build_ms,
            triangles: job.scene.triangles(),
            drawn_triangles: job.scene.drawn_triangles(),
            scene_bytes: job.scene.bytes(),
            objects: job.scene.instances().iter().enumerate().map(object).collect(),
        });
    }

    /// Adds a picture of the last scene.
    pub fn add_frame(
        &mut self,
        shot: Shot,
        [file_path, aov]: [Option<&Path>; 2],
        job: &RenderJob,
        picture: &Picture,
        layers: &Layers,
        frame_ms: f64,
    ) {
        let report = |seen: rtrt::objects::Seen| SeenReport {
            id: seen.object,
            pixels: seen.pixels,
            box_2d: seen.box_2d,
            box_3d: seen.box_3d.map(|corner| in_file(corner, job.origin)),
        };
        let tone_map = ToneMap::ALL.iter().find(|(_, map)| *map == job.tone_map);
        let name = self.names.take(&shot.camera, self.frames.len());
        self.frames.push(FrameReport {
            name,
            scene: self.scenes.len().saturating_sub(1),
            file_path: file_path.map(Path::to_owned),
            aov: aov.map(Path::to_owned),
            shot,
            exposure: job.exposure,
            tone_map: tone_map.map_or("none", |(name, _)| name),
            hash: hash::pixels(picture),
            frame_ms,
            stages_ms: PerStage(picture.stages_ms),
            seen: seen(&job.scene, layers).into_iter().map(report).collect(),
        });
    }

    /// The report as it is at the end of a run that began then.
    pub fn finished(self, began: Instant) -> Self {
        Self { total_ms: began.elapsed().as_secs_f64() * 1e3, peak_rss_bytes: peak_rss_bytes(), ..self }
    }
}
