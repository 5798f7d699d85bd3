//! A scene from a file, with its cameras, its animation and warnings.

use super::animation::Animation;
use rtrt_core::scene::{Camera, Scene};
use std::path::PathBuf;

/// A camera of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedCamera {
    /// What the file calls it; empty if it has no name.
    pub name: String,
    /// The camera.
    pub camera: Camera,
}

/// A scene from a file.
#[derive(Debug)]
pub struct Loaded {
    /// The scene, lit.
    pub scene: Scene,
    /// The file's cameras, in the order in which its nodes are met.
    pub cameras: Vec<NamedCamera>,
    /// The first of them, or [`framing`](super::framing) for a picture of 16 to 9.
    pub camera: Camera,
    /// Whether the file has no lights, and [`light_by_default`](super::light_by_default) was asked for
    /// [`Loaded::camera`]. Who looks from elsewhere may ask again.
    pub lit_by_default: bool,
    /// What moves, if something does; see [`Animation::play`]. The scene is as the file has it at rest.
    pub animation: Option<Animation>,
    /// What the file has that is not drawn as it says, a line each.
    pub warnings: Vec<String>,
    /// The files that the scene consists of, also those that were looked for and are not there.
    pub files: Vec<PathBuf>,
    /// Time taken to build mesh trees, or to take them from the cache, in milliseconds.
    pub bvh_build_ms: f64,
}
