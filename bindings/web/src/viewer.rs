//! The viewer: a scene, a camera, and frames of it.

use crate::{Page, bytes, error, json};
use glam::{DVec3, Vec3};
use rtrt::import::{self, Loaded};
use rtrt::{demo, hash, moves};
use rtrt_core::backend::{Backend, Request, Shadows, ToneMap};
use rtrt_core::scene::{Camera, Scene, Sequential};
use serde::Serialize;
use std::path::Path;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsError, JsValue};
use web_time::Instant;

/// A scene that is shown.
pub struct Shown {
    /// What the command calls it.
    name: String,
    loaded: Loaded,
    camera: Camera,
    /// Whether a person has moved the camera.
    is_moved: bool,
    /// Center and radius.
    ball: (DVec3, f64),
}

/// What the page says about a scene.
#[derive(Serialize)]
struct Facts<'a> {
    name: &'a str,
    objects: usize,
    triangles: u64,
    lights: usize,
    warnings: &'a [String],
}

/// A frame.
#[wasm_bindgen]
pub struct Frame {
    pixels: JsValue,
    hash: String,
    ms: f64,
    command: String,
}

#[wasm_bindgen]
impl Frame {
    /// Red, green, blue, alpha, row by row.
    #[wasm_bindgen(getter)]
    pub fn pixels(&self) -> JsValue {
        self.pixels.clone()
    }
    /// SHA-256 of them.
    #[wasm_bindgen(getter)]
    pub fn hash(&self) -> String {
        self.hash.clone()
    }
    /// Milliseconds that it took.
    #[wasm_bindgen(getter)]
    pub fn ms(&self) -> f64 {
        self.ms
    }
    /// The command that prints the same hash.
    #[wasm_bindgen(getter)]
    pub fn command(&self) -> String {
        self.command.clone()
    }
}

#[wasm_bindgen]
impl Page {
    /// Shows a scene: a name that begins with `demo:`, or the bytes of a file of this name. Gives facts about it.
    pub fn show(&mut self, name: &str, file: &[u8], width: u32, height: u32) -> Result<String, JsError> {
        let mut loaded = match name {
            demo::MATCHBOX => demo::matchbox(&Sequential)?,
            demo::GLASS => demo::glass(&Sequential)?,
            demo::SPHERES => demo::spheres(&Sequential)?,
            demo::LEVELS => demo::levels(&Sequential)?,
            demo::MOVING => demo::moving(&Sequential)?,
            _ => import::load_bytes(Path::new(name), file, &Sequential, &import::Options::default())?,
        };
        import::light_by_default(&mut loaded.scene)?;
        let (low, high) = loaded.scene.extent().ok_or_else(|| error("nothing in the scene is drawn"))?;
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let mut shown = Shown {
            name: name.into(),
            camera: loaded.camera,
            loaded,
            is_moved: false,
            ball: ((low + high) * 0.5, low.distance(high) * 0.5),
        };
        shown.home(width, height);
        let scene = &shown.loaded.scene;
        let facts = json(&Facts {
            name,
            objects: scene.instances().len(),
            triangles: scene.drawn_triangles(),
            lights: scene.lights().len(),
            warnings: &shown.loaded.warnings,
        });
        self.shown = Some(shown);
        facts
    }

    /// Puts the camera where the command puts it in a picture of this size.
    pub fn home(&mut self, width: u32, height: u32) {
        if let Some(shown) = &mut self.shown {
            shown.home(width, height);
        }
    }

    /// Moves the camera on its orbit, radians, and nearer by a share of the way.
    pub fn orbit(&mut self, yaw: f64, pitch: f64, nearer: f64) {
        if let Some(Shown { camera, is_moved, ball, .. }) = &mut self.shown {
            let distance = moves::pivot(camera, *ball);
            let Some(axes) = moves::axes(camera) else { return };
            let pivot = camera.eye.as_dvec3() + axes.forward * distance;
            let orbited = moves::hand::orbited(camera, pivot, yaw, pitch);
            *camera = moves::moved(&orbited, [0.0, 0.0, distance * nearer]);
            *is_moved = true;
        }
    }

    /// Renders a frame, on the processor or the GPU.
    pub async fn render(
        &mut self,
        on_gpu: bool,
        width: u32,
        height: u32,
        samples: u32,
        exposure: f32,
        shadows: &str,
    ) -> Result<Frame, JsError> {
        let Self { cpu, gpu, shown, picture, .. } = self;
        let shown = shown.as_ref().ok_or_else(|| error("there is no scene"))?;
        let kind = match shadows {
            "off" => Shadows::Off,
            "hard" => Shadows::Hard,
            _ => Shadows::Soft,
        };
        let clip = match shown.loaded.cameras.first() {
            Some(named) if !shown.is_moved => named.clip,
            _ => [0.0, f32::INFINITY],
        };
        let request = Request::new(&shown.camera, [width, height])
            .samples(samples)
            .exposure(exposure)
            .tone_map(ToneMap::Neutral)
            .shadows(kind)
            .clip(clip[0], clip[1]);
        let scene: &Scene = &shown.loaded.scene;
        let start = Instant::now();
        if on_gpu {
            let gpu = gpu.as_mut().ok_or_else(|| error("there is no GPU"))?;
            gpu.render_async(scene, &request, picture).await?;
        } else {
            cpu.render(scene, &request, picture)?;
        }
        let ms = start.elapsed().as_secs_f64() * 1e3;
        let command = shown.command([width, height], samples, exposure, shadows);
        Ok(Frame { pixels: bytes(&picture.bytes()), hash: hash::pixels(picture), ms, command })
    }
}

impl Shown {
    fn home(&mut self, width: u32, height: u32) {
        let aspect = width as f32 / height as f32;
        let named = self.loaded.cameras.first();
        self.camera = match named {
            Some(named) => named.fitted(aspect),
            None => import::framing(&self.loaded.scene, aspect),
        };
        self.is_moved = false;
    }

    /// The command that renders the same picture.
    fn command(&self, [width, height]: [u32; 2], samples: u32, exposure: f32, shadows: &str) -> String {
        let mut words = format!(
            "rtrt render {} --size {width}x{height} --samples {samples} --shadows {shadows} --hash",
            self.name
        );
        if exposure != 0.0 {
            words += &format!(" --exposure {exposure}");
        }
        if self.is_moved {
            let origin = self.loaded.origin;
            let point = |point: Vec3| match origin == DVec3::ZERO {
                true => format!("{},{},{}", point.x, point.y, point.z),
                false => {
                    let DVec3 { x, y, z } = point.as_dvec3() + origin;
                    format!("{x},{y},{z}")
                }
            };
            let Camera { eye, look_at, .. } = self.camera;
            words += &format!(" --eye {} --look-at {}", point(eye), point(look_at));
        }
        words
    }
}
