//! glTF 2.0.
//!
//! The JSON is read in the types of `gltf-json`; the `gltf` crate on top of it, which
//! follows indices and reads accessors, panics on files whose indices, ranges or node
//! graphs are broken. Here whatever is drawn is checked as it is met, and the rest of the
//! file is left alone.

mod accessor;
mod animation;
mod buffer;
mod container;
mod extensions;
mod levels;
mod light;
mod material;
mod meshes;
mod node;
mod primitive;
mod transform;

use crate::import::animation::Animation;
use crate::import::builder::Builder;
use crate::import::{ImportError, NamedCamera};
use buffer::Buffers;
use material::Materials;
use meshes::Import;
use rtrt_core::scene::Join;
use std::collections::HashMap;

/// Whether the bytes start like glTF, binary or JSON.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(container::MAGIC) || bytes.trim_ascii_start().starts_with(b"{")
}

/// Draws a file into the scene, and returns its cameras and what moves.
pub(super) fn load<J: Join>(
    builder: &mut Builder<'_, J>,
    bytes: &[u8],
) -> Result<(Vec<NamedCamera>, Option<Animation>), ImportError> {
    let (root, binary) = container::open(builder, bytes)?;
    let path = builder.path.clone();
    let buffers = Buffers::new(&path, &root, binary, builder.files.clone());
    let mut import = Import {
        root: &root,
        buffers: &buffers,
        materials: Materials::new(&root, &buffers),
        meshes: HashMap::new(),
        cameras: Vec::new(),
        nodes: Vec::new(),
        builder,
    };
    import.draw_scene()?;
    let (cameras, nodes) = (import.cameras, import.nodes);
    let names = root.animations.iter().map(|animation| animation.name.clone().unwrap_or_default());
    let animation = Animation::new(&path, names.collect(), nodes);
    animation.rest()?.apply(&mut builder.scene)?;
    light::expose(&mut builder.scene);
    Ok((cameras, Some(animation).filter(Animation::moves)))
}
