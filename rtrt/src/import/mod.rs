//! Scenes from files: glTF 2.0 (`.glb`, `.gltf`), OBJ with MTL, STL and PLY.
//!
//! STL and PLY have neither units nor axes: one unit of the file is one of the scene, and +y is up. Facets of STL are
//! flat; faces of PLY that share a vertex are smooth there, unless the file has normals.
//!
//! ```no_run
//! # use rtrt_core::scene::Sequential;
//! let loaded = rtrt::import::load("scene.glb".as_ref(), &Sequential)?;
//! println!("{} triangles", loaded.scene.drawn_triangles());
//! # Ok::<(), rtrt::import::ImportError>(())
//! ```
//!
//! [`Loaded::warnings`] names the content of a file that is not drawn. A file with an error in
//! content that would be drawn is refused with one line that gives the reason. No file makes the
//! import panic, hang, or allocate much more than the file's size and the documented limits.
//!
//! A scene that is far from the origin of the file's coordinates is moved: [`Loaded::origin`].
//!
//! [`framing`] is the camera of scenes without one, and [`light_by_default`] lights scenes without lights.

mod animation;
pub(crate) mod builder;
mod color;
mod deformed;
mod environment;
mod error;
mod file;
mod framing;
pub(crate) mod geometry;
mod glow;
mod gltf;
mod ground;
mod ktx2;
mod loaded;
mod marks;
mod normals;
mod obj;
mod origin;
mod picture;
mod placement;
mod ply;
mod polygon;
mod stl;
mod text;
mod track;

pub use animation::{Animation, Pose};
pub use environment::{Surroundings, light_by_default, surround, surround_with_studio};
pub use error::ImportError;
pub use framing::{framing, framing_from, framing_played};
pub use ground::add_ground;
pub use loaded::{Label, Loaded, NamedCamera};

use crate::cache::Cache;
use rtrt_core::scene::Join;
use std::path::Path;

/// Loads a scene. `join` runs the two halves of a BVH build, in parallel if it has threads.
///
/// Binary glTF is known by its first bytes, and so is text that no OBJ or PLY file begins with. Otherwise the ending of the
/// name decides on the format, else the first bytes do.
///
/// # Errors
/// The file cannot be read, cannot be drawn, or is too large; see [`ImportError`].
pub fn load(path: &Path, join: &impl Join) -> Result<Loaded, ImportError> {
    load_with(path, join, &Options::default())
}

/// How a scene is loaded.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options<'a> {
    /// BVHs of meshes come from this cache, and new ones are added to it. A cache that cannot be written is a warning.
    pub cache: Option<&'a Cache>,
    /// The diameter of points and lines, in units of the scene, above 0; none for 1/250 of the diagonal of what the file
    /// holds.
    pub point_size: Option<f32>,
}

/// [`load`] with options.
///
/// # Errors
/// As for [`load`].
pub fn load_with(path: &Path, join: &impl Join, options: &Options<'_>) -> Result<Loaded, ImportError> {
    let bytes = file::read(path, file::LONGEST);
    let bytes = bytes.map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })?;
    load_bytes(path, &bytes, join, options)
}

/// [`load_with`] of the bytes of a scene that is in no file. Messages call it `path`, and files that it names are
/// looked for beside that.
///
/// # Errors
/// As for [`load`].
pub fn load_bytes(
    path: &Path,
    bytes: &[u8],
    join: &impl Join,
    options: &Options<'_>,
) -> Result<Loaded, ImportError> {
    let mut builder = builder::Builder::new(path, join, options);
    builder.files.add(path);
    if bytes.trim_ascii().is_empty() {
        return Err(builder.invalid("it is empty".into()));
    }
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let (cameras, animation) = match ending.as_deref() {
        // Whatever the name ends in: no file of another format begins so.
        _ if gltf::is_binary(bytes) => gltf::load(&mut builder, bytes)?,
        Some("glb" | "gltf") => gltf::load(&mut builder, bytes)?,
        Some("obj" | "ply") if gltf::looks_like(bytes) => gltf::load(&mut builder, bytes)?,
        Some("obj") => (obj::load(&mut builder, bytes)?, None),
        Some("ply") => ply::load(&mut builder, bytes).map(|()| (vec![], None))?,
        Some("stl") => stl::load(&mut builder, bytes).map(|()| (vec![], None))?,
        _ if gltf::looks_like(bytes) => gltf::load(&mut builder, bytes)?,
        _ if ply::looks_like(bytes) => ply::load(&mut builder, bytes).map(|()| (vec![], None))?,
        _ if stl::looks_like(bytes) => stl::load(&mut builder, bytes).map(|()| (vec![], None))?,
        _ if obj::looks_like(&text::utf8(bytes)) => (obj::load(&mut builder, bytes)?, None),
        _ => return Err(ImportError::Format { path: path.to_owned() }),
    };
    builder.warn_of_coarse_meshes();
    if animation.is_none() {
        glow::add_lights(&mut builder);
    } else {
        glow::warn(&mut builder);
    }
    let labels = builder.labels();
    let scene = builder.scene;
    let camera = cameras.first().map_or_else(|| framing(&scene, 16.0 / 9.0), |named| named.camera);
    let mut warnings = builder.warnings;
    if !builder.not_drawn.is_empty() {
        let list: Vec<_> = builder.not_drawn.into_iter().collect();
        warnings.push(format!("not drawn: {}", list.join(", ")));
    }
    let (files, bvh_build_ms, origin) = (builder.files.list(), builder.bvh_build_ms, builder.origin);
    Ok(Loaded { scene, origin, cameras, camera, labels, animation, warnings, files, bvh_build_ms })
}
