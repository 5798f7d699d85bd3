//! What a case is.

use glam::Vec3;
use rtrt_core::backend::{LAYERS, Request, Shading, Shadows, ToneMap};
use rtrt_core::scene::{Camera, Projection, Scene};

/// How exactly a backend must agree with the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agree {
    /// In every bit of every buffer.
    Bits,
}

/// A frame that every backend must render alike.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// The kernel or stage that it tests, and its particular.
    pub name: &'static str,
    /// What holds if the case passes.
    pub claim: &'static str,
    /// Builds the scene.
    pub scene: fn() -> Scene,
    /// From where.
    pub camera: Camera,
    /// Pixels in a row, and rows.
    pub size: [u32; 2],
    /// Sub-rays a pixel.
    pub samples: u32,
    /// How many colors a pixel has.
    pub shading: Shading,
    /// Whether lights cast shadows.
    pub shadows: Shadows,
    /// The most layers of surfaces that a ray looks at.
    pub layers: u32,
    /// Stops by which light is raised.
    pub exposure: f32,
    /// How light becomes colors.
    pub tone_map: ToneMap,
    /// Depths of the near and the far plane.
    pub clip: [f32; 2],
    /// From how far away surfaces hide ambient light.
    pub ambient_occlusion: f32,
    /// How exactly.
    pub agree: Agree,
    /// Whether the picture is of a single color. Any other picture that is one is red: it
    /// would pass whatever a backend did.
    pub blank: bool,
    /// Where the case is known to fail. It must fail there, and turns red the day it passes.
    pub known: Option<Known>,
}

/// A failure that is known.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    /// A part of the adapter's name.
    pub adapter: &'static str,
    /// Why, and who says so.
    pub why: &'static str,
}

impl Case {
    /// What most cases have in common: a size that is not a multiple of a block, a camera
    /// 4 units in front of the origin.
    pub const USUAL: Self = Self {
        name: "",
        claim: "",
        scene: Scene::new,
        camera: look([0.0, 0.0, 4.0], [0.0; 3]),
        size: [37, 21],
        samples: 1,
        shading: Shading::Sample,
        shadows: Shadows::Soft,
        layers: LAYERS,
        exposure: 0.0,
        tone_map: ToneMap::None,
        clip: [0.0, f32::INFINITY],
        ambient_occlusion: 0.0,
        agree: Agree::Bits,
        blank: false,
        known: None,
    };

    /// The request to the backend.
    pub fn request(&self) -> Request<'_> {
        Request::new(&self.camera, self.size)
            .samples(self.samples)
            .shading(self.shading)
            .shadows(self.shadows)
            .layers(self.layers)
            .exposure(self.exposure)
            .tone_map(self.tone_map)
            .clip(self.clip[0], self.clip[1])
            .ambient_occlusion(self.ambient_occlusion)
            .deferred(true)
    }
}

/// A camera at `eye` that looks at a point, with y up and a field of view of one radian.
pub(crate) const fn look(eye: [f32; 3], at: [f32; 3]) -> Camera {
    Camera {
        eye: Vec3::from_array(eye),
        look_at: Vec3::from_array(at),
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 1.0 },
    }
}

/// The same with another field of view, radians.
pub(crate) const fn zoom(fov_y: f32, camera: Camera) -> Camera {
    Camera { projection: Projection::Perspective { fov_y }, ..camera }
}

/// The same with parallel rays; the picture is `height` world units high.
pub(crate) const fn parallel(height: f32, camera: Camera) -> Camera {
    Camera { projection: Projection::Orthographic { height }, ..camera }
}

/// A camera whose picture has these edges, at distance 1.
pub(crate) const fn off_center(left: f32, right: f32, bottom: f32, top: f32, camera: Camera) -> Camera {
    Camera { projection: Projection::OffCenter { left, right, bottom, top }, ..camera }
}
