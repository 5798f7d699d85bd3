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
mod levels;
mod light;
mod material;
mod node;
mod primitive;

pub(super) use animation::Track;
pub(super) use primitive::pack;

use crate::import::animation::{Animation, Node};
use crate::import::builder::{Builder, Geometry};
use crate::import::error::quoted;
use crate::import::shape::{Shape, Skin};
use crate::import::{ImportError, NamedCamera};
use accessor::Column;
use buffer::Buffers;
use glam::DMat4;
use gltf_json::accessor::Type;
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;
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

impl<'a, J: Join> Import<'a, '_, J> {
    fn invalid(&self, why: String) -> ImportError {
        self.builder.invalid(why)
    }

    /// The parts of a mesh, stored once however many nodes have it.
    fn mesh(&mut self, index: Index<Mesh>) -> Result<Parts, ImportError> {
        let number = index.value();
        if let Some(parts) = self.meshes.get(&number) {
            return Ok(parts.clone());
        }
        let mut parts = Vec::new();
        for (place, primitive) in self.source(index)?.primitives.iter().enumerate() {
            if let Some((name, geometry, material)) = self.primitive(index, place, primitive)? {
                parts.push((self.builder.add_mesh(&name, geometry)?, material));
            }
        }
        let parts: Parts = parts.into();
        self.meshes.insert(number, parts.clone());
        Ok(parts)
    }

    /// The parts of a mesh that changes its shape, stored for one node; what they follow from is
    /// added to `shapes`.
    fn shapes(
        &mut self,
        index: Index<Mesh>,
        weights: Option<&Vec<f32>>,
        skin: Option<Skin>,
        shapes: &mut Vec<Shape>,
    ) -> Result<Parts, ImportError> {
        let source = self.source(index)?;
        let weights = weights.or(source.weights.as_ref()).into_iter().flatten();
        let weights: Vec<f64> = weights.map(|&weight| f64::from(weight)).collect();
        let mut parts = Vec::new();
        for (place, primitive) in source.primitives.iter().enumerate() {
            let targets = primitive.targets.as_ref().map_or(0, Vec::len) as u64;
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            let vertices = positions.and_then(|&index| self.root.get(index)).map_or(0, |a| a.count.0);
            self.builder.deform(vertices.saturating_mul(1 + targets))?;
            if let Some((name, rest, material)) = self.primitive(index, place, primitive)? {
                let mesh = self.builder.add_mesh(&name, rest.clone())?;
                parts.push((mesh, material));
                shapes.push(Shape { name, mesh, rest, weights: weights.clone(), skin: skin.clone() });
            }
        }
        Ok(parts.into())
    }

    /// The skin with this index.
    fn skin(&self, index: Index<gltf_json::Skin>) -> Result<Skin, ImportError> {
        let number = index.value();
        let missing = || self.invalid(format!("there is no skin {number}"));
        let skin = self.root.get(index).ok_or_else(missing)?;
        let column = |index| Column::new(&self.builder.path, self.root, self.buffers, index, &[Type::Mat4]);
        let matrices = skin.inverse_bind_matrices.map(column).transpose()?;
        let inverse = |joint: usize| match &matrices {
            Some(matrices) if joint < matrices.count => {
                let numbers: Vec<f64> = matrices.all(joint).into_iter().map(f64::from).collect();
                DMat4::from_cols_slice(&numbers)
            }
            _ => DMat4::IDENTITY,
        };
        Ok(Skin {
            joints: skin.joints.iter().map(Index::value).collect(),
            inverse: (0..skin.joints.len()).map(inverse).collect(),
        })
    }

    fn source(&self, index: Index<Mesh>) -> Result<&'a Mesh, ImportError> {
        let missing = || self.invalid(format!("there is no mesh {}", index.value()));
        self.root.get(index).ok_or_else(missing)
    }

    /// What a primitive is called, its triangles, and its material; none if it is not drawn.
    fn primitive(
        &mut self,
        index: Index<Mesh>,
        place: usize,
        primitive: &Primitive,
    ) -> Result<Option<(String, Geometry, MaterialIndex)>, ImportError> {
        let number = index.value();
        let name = match &self.source(index)?.name {
            Some(name) => format!("mesh {number} ({}), primitive {place}", quoted(name)),
            None => format!("mesh {number}, primitive {place}"),
        };
        let (material, coordinates) = self.materials.get(self.builder, primitive.material)?;
        let path = &self.builder.path;
        match primitive::geometry(path, self.root, self.buffers, primitive, &coordinates)? {
            Ok(geometry) => Ok(Some((name, geometry, material))),
            Err(kind) => {
                self.builder.not_drawn.insert(kind);
                Ok(None)
            }
        }
    }
}
