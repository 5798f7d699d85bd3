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
mod deformed;
mod environment;
mod error;
mod file;
mod framing;
pub(crate) mod geometry;
mod gltf;
mod loaded;
mod obj;
mod picture;
mod track;

pub use animation::{Animation, Pose};
pub use environment::surround;
pub use error::ImportError;
pub use framing::{framing, framing_played, light_by_default};
pub use loaded::{Loaded, NamedCamera};

use crate::cache::Cache;
use rtrt_core::scene::Join;
use std::path::Path;

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
