//! Scenes from files: glTF 2.0 (`.glb`, `.gltf`) and OBJ with MTL.
//!
//! ```no_run
//! # use rtrt_core::scene::Sequential;
//! let loaded = rtrt::import::load("scene.glb".as_ref(), &Sequential)?;
//! println!("{} triangles", loaded.scene.drawn_triangles());
//! # Ok::<(), rtrt::import::ImportError>(())
//! ```
//!
//! What a file has that is not drawn is said in [`Loaded::warnings`]. A file is refused,
//! with one line that says why, where it is broken in what would be drawn; nothing that a
//! file says makes the import panic, hang, or allocate much more than the file's size and
//! the documented limits.
//!
//! Scenes without lights are lit as by [`light_by_default`], scenes without a camera are
//! seen as by [`framing`], and what no surface covers is dark blue.

mod animation;
pub(crate) mod builder;
mod environment;
mod error;
mod file;
mod framing;
mod gltf;
mod obj;
mod picture;
mod shape;

pub use animation::{Animation, Pose};
pub use environment::surround;
pub use error::ImportError;
pub use framing::{framing, framing_played, light_by_default};

use crate::cache::Cache;
use rtrt_core::scene::{Camera, Join, Scene};
use std::path::{Path, PathBuf};

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
    /// The first of them, or [`framing`] for a picture of 16 to 9.
    pub camera: Camera,
    /// Whether the file has no lights, and [`light_by_default`] was asked for
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

/// Loads a scene. `join` runs the halves of tree builds, at once where it has threads.
///
/// What the file is follows from its name's ending, else from its first bytes.
///
/// # Errors
/// The file cannot be read, drawn, or is too large; see [`ImportError`].
pub fn load(path: &Path, join: &impl Join) -> Result<Loaded, ImportError> {
    load_cached(path, join, None)
}

/// [`load`], with the trees of meshes taken from a cache where they are there, and kept in it
/// where not.
///
/// # Errors
/// As for [`load`]. A cache that cannot be used is a warning.
pub fn load_cached(path: &Path, join: &impl Join, cache: Option<&Cache>) -> Result<Loaded, ImportError> {
    let mut builder = builder::Builder::new(path, join, cache);
    let bytes = builder.files.read(path, file::LONGEST);
    let bytes = bytes.map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })?;
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let (cameras, animation) = match ending.as_deref() {
        Some("glb" | "gltf") => gltf::load(&mut builder, &bytes)?,
        Some("obj") => (obj::load(&mut builder, &bytes)?, None),
        _ if gltf::looks_like(&bytes) => gltf::load(&mut builder, &bytes)?,
        _ => return Err(ImportError::Format { path: path.to_owned() }),
    };
    let mut scene = builder.scene;
    let camera = cameras.first().map_or_else(|| framing(&scene, 16.0 / 9.0), |named| named.camera);
    let lit_by_default = scene.lights().is_empty();
    if lit_by_default {
        light_by_default(&mut scene, &camera);
    }
    let mut warnings = builder.warnings;
    if !builder.not_drawn.is_empty() {
        let list: Vec<_> = builder.not_drawn.into_iter().collect();
        warnings.push(format!("not drawn: {}", list.join(", ")));
    }
    let (files, bvh_build_ms) = (builder.files.list(), builder.bvh_build_ms);
    Ok(Loaded { scene, cameras, camera, lit_by_default, animation, warnings, files, bvh_build_ms })
}
