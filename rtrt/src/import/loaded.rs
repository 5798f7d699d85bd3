//! A scene from a file, with its cameras, its animation and warnings.

use super::animation::Animation;
use glam::DVec3;
use rtrt_core::scene::{Camera, Projection, Scene};
use std::path::PathBuf;

/// A camera of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedCamera {
    /// Its name in the file; empty if it has none.
    pub name: String,
    /// The camera, with the height of picture that the file gives it.
    pub camera: Camera,
    /// The shape of the picture that the camera is made for, width / height, if the file has one.
    pub aspect: Option<f32>,
    /// The depths of its near and its far plane, world units (see [`Request::clip`](rtrt_core::backend::Request::clip)).
    pub clip: [f32; 2],
}

impl NamedCamera {
    /// The camera for a picture of this `aspect` (width / height): no part of the picture that the file's camera sees is
    /// cropped. A narrower picture shows more above and below, a wider one more on the sides.
    ///
    /// ```
    /// # use rtrt::import::NamedCamera;
    /// # use rtrt_core::scene::{Camera, Projection};
    /// # use glam::Vec3;
    /// # let (eye, look_at, up) = (Vec3::Z, Vec3::ZERO, Vec3::Y);
    /// let camera = Camera { eye, look_at, up, projection: Projection::Orthographic { height: 2.0 } };
    /// let wide = NamedCamera { name: "wide".into(), camera, aspect: Some(3.0), clip: [0.0, 9.0] };
    /// assert_eq!(wide.fitted(1.5).projection, Projection::Orthographic { height: 4.0 });
    /// assert_eq!(wide.fitted(6.0).projection, camera.projection);
    /// ```
    pub fn fitted(&self, aspect: f32) -> Camera {
        let scale = self.aspect.map_or(1.0, |own| f64::from(own) / f64::from(aspect));
        if !(scale > 1.0 && scale.is_finite()) {
            return self.camera;
        }
        let projection = match self.camera.projection {
            Projection::Perspective { fov_y } => {
                let tangent = libm::tan(f64::from(fov_y) * 0.5) * scale;
                Projection::Perspective { fov_y: (2.0 * libm::atan(tangent)) as f32 }
            }
            // Its edges are those of the picture, whatever shape that has.
            Projection::OffCenter { .. } => self.camera.projection,
            Projection::Orthographic { height } => {
                Projection::Orthographic { height: (f64::from(height) * scale) as f32 }
            }
        };
        Camera { projection, ..self.camera }
    }
}

/// What a file calls an object. What has no name in glTF has its number: `node 3`. OBJ, STL and PLY have objects by material
/// or kind: their node is the name of the file, and their mesh what they are made of: `faces`, `facets`, `points`, `edges`,
/// `lines`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Label {
    /// The node, or group.
    pub node: String,
    /// The mesh.
    pub mesh: String,
    /// The material.
    pub material: String,
    /// The names of the nodes above the node, each followed by a slash; those of the nearest 16.
    pub path: String,
}

/// A scene from a file.
#[derive(Debug)]
pub struct Loaded {
    /// The scene, with the lights of the file.
    pub scene: Scene,
    /// What the import has subtracted from the file's coordinates, so that single precision serves a scene that is far
    /// from their origin: 0, unless it is more than 64 of its diagonals away. Coordinates of the scene, its cameras, lights
    /// and animations are relative to it.
    pub origin: DVec3,
    /// The file's cameras, in the depth-first order of its nodes.
    pub cameras: Vec<NamedCamera>,
    /// The first of them, for any picture ([`NamedCamera::fitted`] is for one of a given shape), or
    /// [`framing`](super::framing) for a picture of 16 to 9.
    pub camera: Camera,
    /// What the file calls each instance, in the order of their numbers, which are the same whenever the file is loaded.
    pub labels: Vec<Label>,
    /// The animations of the file, if it has any; see [`Animation::play`]. The scene is at rest.
    pub animation: Option<Animation>,
    /// Deviations from the file, a line each.
    pub warnings: Vec<String>,
    /// The files of the scene, including missing ones.
    pub files: Vec<PathBuf>,
    /// The time in which BVHs were built or read from the cache, milliseconds.
    pub bvh_build_ms: f64,
}
