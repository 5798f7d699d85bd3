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
mod light;
mod material;
mod node;
mod primitive;

pub(super) use animation::Track;
pub(super) use primitive::pack;

use crate::import::animation::{Animation, Node};
use crate::import::builder::Builder;
use crate::import::error::quoted;
use crate::import::{ImportError, NamedCamera};
use buffer::Buffers;
use gltf_json::{Index, Mesh, Root};
use material::Materials;
use rtrt_core::scene::{Join, MaterialIndex, MeshIndex};
use std::collections::HashMap;
use std::rc::Rc;

/// Whether the bytes start like glTF, binary or JSON.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(container::MAGIC) || bytes.trim_ascii_start().starts_with(b"{")
}

/// What a mesh consists of.
type Parts = Rc<[(MeshIndex, MaterialIndex)]>;

/// A file being drawn into a scene.
struct Import<'a, 'b, J> {
    builder: &'a mut Builder<'b, J>,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    materials: Materials<'a>,
    /// The meshes that were met, by index.
    meshes: HashMap<usize, Parts>,
    cameras: Vec<NamedCamera>,
    /// The nodes that were met.
    nodes: Vec<Node>,
}

/// Draws a file into the scene, and returns its cameras and what moves.
pub(super) fn load<J: Join>(
    builder: &mut Builder<'_, J>,
    bytes: &[u8],
) -> Result<(Vec<NamedCamera>, Option<Animation>), ImportError> {
    let (root, binary) = container::open(builder, bytes)?;
    let path = builder.path.clone();
    let buffers = Buffers::new(&path, &root, binary);
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
    light::expose(&mut builder.scene);
    Ok((cameras, Animation::new(&path, nodes)))
}

impl<J: Join> Import<'_, '_, J> {
    fn invalid(&self, why: String) -> ImportError {
        self.builder.invalid(why)
    }

    /// The parts of a mesh, stored once however many nodes have it.
    fn mesh(&mut self, index: Index<Mesh>) -> Result<Parts, ImportError> {
        let number = index.value();
        if let Some(parts) = self.meshes.get(&number) {
            return Ok(parts.clone());
        }
        let root = self.root;
        let mesh = root.get(index).ok_or_else(|| self.invalid(format!("there is no mesh {number}")))?;
        let name = match &mesh.name {
            Some(name) => format!("mesh {number} ({})", quoted(name)),
            None => format!("mesh {number}"),
        };
        let mut parts = Vec::new();
        for (place, primitive) in mesh.primitives.iter().enumerate() {
            let name = format!("{name}, primitive {place}");
            let (material, coordinates) = self.materials.get(self.builder, primitive.material)?;
            let path = &self.builder.path;
            match primitive::geometry(path, root, self.buffers, primitive, &coordinates)? {
                Ok(geometry) => parts.push((self.builder.add_mesh(&name, geometry)?, material)),
                Err(kind) => _ = self.builder.not_drawn.insert(kind),
            }
            if primitive.targets.is_some() {
                self.builder.not_drawn.insert("morph targets");
            }
        }
        let parts: Parts = parts.into();
        self.meshes.insert(number, parts.clone());
        Ok(parts)
    }
}
