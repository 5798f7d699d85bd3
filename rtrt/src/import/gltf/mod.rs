//! glTF 2.0.
//!
//! `gltf-json` reads the JSON. The `gltf` crate on top of it follows indices and reads accessors,
//! but panics on broken indices, ranges and node graphs. This module checks the content that it
//! draws when it reaches it, and ignores the rest of the file.

mod accessor;
mod animation;
mod buffer;
mod container;
mod draco;
mod extended;
mod extensions;
mod far;
mod levels;
mod light;
mod mark_size;
mod material;
mod meshes;
mod meshopt;
mod node;
mod primitive;
mod transform;

use crate::import::animation::Animation;
use crate::import::builder::Builder;
use crate::import::{ImportError, NamedCamera};
use buffer::Buffers;
use mark_size::MarkSizes;
use material::Materials;
use meshes::Import;
use rtrt_core::scene::Join;
use std::collections::HashMap;
use transform::rest_worlds;

/// Whether the bytes begin as binary glTF of a known version does.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(container::MAGIC) && matches!(bytes.get(4..8), Some([1 | 2, 0, 0, 0]))
}

/// Whether the bytes begin as binary or JSON glTF does.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(container::MAGIC) || bytes.trim_ascii_start().starts_with(b"{")
}

/// Adds the content of a file to the scene, and returns its cameras and animations.
pub(super) fn load<J: Join>(
    builder: &mut Builder<'_, J>,
    bytes: &[u8],
) -> Result<(Vec<NamedCamera>, Option<Animation>), ImportError> {
    let (root, binary) = container::open(builder, bytes)?;
    let path = builder.path.clone();
    builder.origin = far::origin(&root);
    let origin = builder.origin;
    let buffers = Buffers::new(&path, &root, binary, builder.files.clone());
    let mut import = Import {
        root: &root,
        buffers: &buffers,
        materials: Materials::new(&root, &buffers),
        meshes: HashMap::new(),
        unlit: HashMap::new(),
        mark_sizes: MarkSizes::new(&root, builder.point_size),
        rest_worlds: if root.skins.is_empty() { vec![] } else { rest_worlds(&root.nodes) },
        cameras: Vec::new(),
        nodes: Vec::new(),
        builder,
    };
    import.draw_scene()?;
    let (cameras, nodes) = (import.cameras, import.nodes);
    let names = root.animations.iter().map(|animation| animation.name.clone().unwrap_or_default());
    let animation = Animation::new(&path, names.collect(), nodes).relative_to(origin);
    animation.rest()?.apply(&mut builder.scene)?;
    Ok((cameras, Some(animation).filter(Animation::moves)))
}
