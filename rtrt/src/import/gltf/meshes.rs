//! The state of an import, and the meshes of a file.

use super::accessor::Column;
use super::buffer::Buffers;
use super::mark_size::{MarkSizes, is_mark};
use super::material::Materials;
use super::primitive;
use crate::import::animation::SceneNode;
use crate::import::builder::Builder;
use crate::import::deformed::{DeformedMesh, Skin, turn_mirrored};
use crate::import::error::quoted;
use crate::import::geometry::Geometry;
use crate::import::{ImportError, NamedCamera};
use glam::DMat4;
use gltf_json::accessor::Type;
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Mesh, Root};
use rtrt_core::scene::{Join, MaterialIndex, MeshIndex};
use std::collections::HashMap;
use std::rc::Rc;

/// The primitives of a mesh, with their materials.
pub(super) type MeshParts = Rc<[(MeshIndex, MaterialIndex)]>;

/// A file that is being imported.
pub(super) struct Import<'a, 'b, J> {
    pub builder: &'a mut Builder<'b, J>,
    pub root: &'a Root,
    pub buffers: &'a Buffers<'a>,
    pub materials: Materials<'a>,
    /// The meshes that were added, by index.
    pub meshes: HashMap<usize, MeshParts>,
    /// The materials of points and lines without normals, by the number of their material in the file.
    pub unlit: HashMap<Option<usize>, MaterialIndex>,
    pub mark_sizes: MarkSizes,
    /// The way of each node of the file to world space at rest.
    pub rest_worlds: Vec<DMat4>,
    pub cameras: Vec<NamedCamera>,
    /// The nodes of the scene, in depth-first order.
    pub nodes: Vec<SceneNode>,
}

impl<'a, J: Join> Import<'a, '_, J> {
    pub fn invalid(&self, why: String) -> ImportError {
        self.builder.invalid(why)
    }

    /// The primitives of a mesh. The nodes that have it share them.
    pub fn mesh(&mut self, index: Index<Mesh>) -> Result<MeshParts, ImportError> {
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
        let parts: MeshParts = parts.into();
        self.meshes.insert(number, parts.clone());
        Ok(parts)
    }

    /// The primitives of a deformed mesh of one node. Its geometry at rest is added to `shapes`.
    pub fn shapes(
        &mut self,
        index: Index<Mesh>,
        weights: Option<&Vec<f32>>,
        skin: Option<Skin>,
        shapes: &mut Vec<DeformedMesh>,
    ) -> Result<MeshParts, ImportError> {
        let source = self.source(index)?;
        let weights = weights.or(source.weights.as_ref()).into_iter().flatten();
        let weights: Vec<f64> = weights.map(|&weight| f64::from(weight)).collect();
        let joints: Vec<DMat4> = skin.iter().flat_map(|skin| skin.matrices(&self.rest_worlds)).collect();
        let mut parts = Vec::new();
        for (place, primitive) in source.primitives.iter().enumerate() {
            let targets = primitive.targets.as_ref().map_or(0, Vec::len) as u64;
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            let vertices = positions.and_then(|&index| self.root.get(index)).map_or(0, |a| a.count.0);
            self.builder.count_deformed(vertices.saturating_mul(1 + targets))?;
            if let Some((name, mut rest, material)) = self.primitive(index, place, primitive)? {
                turn_mirrored(&mut rest, &joints);
                let mesh = self.builder.add_mesh(&name, rest.clone())?;
                parts.push((mesh, material));
                shapes.push(DeformedMesh { name, mesh, rest, weights: weights.clone(), skin: skin.clone() });
            }
        }
        Ok(parts.into())
    }

    /// The skin with this index.
    pub fn skin(&self, index: Index<gltf_json::Skin>) -> Result<Skin, ImportError> {
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

    /// The material for points and lines without normals: the format has their colors as they are, without light.
    fn without_light(
        &mut self,
        number: Option<usize>,
        material: MaterialIndex,
    ) -> Result<MaterialIndex, ImportError> {
        if let Some(&unlit) = self.unlit.get(&number) {
            return Ok(unlit);
        }
        let unlit = self.builder.add_unlit(material)?;
        self.unlit.insert(number, unlit);
        Ok(unlit)
    }

    pub fn source(&self, index: Index<Mesh>) -> Result<&'a Mesh, ImportError> {
        let missing = || self.invalid(format!("there is no mesh {}", index.value()));
        self.root.get(index).ok_or_else(missing)
    }

    /// The name, the triangles and the material of a primitive; none if it is not drawn.
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
        let diameter = self.mark_sizes.of(number);
        match primitive::geometry(path, self.root, self.buffers, primitive, &coordinates, diameter)? {
            Ok(geometry) => {
                let has_normals = primitive.attributes.contains_key(&Checked::Valid(Semantic::Normals));
                let material = if is_mark(primitive) && !has_normals {
                    self.without_light(primitive.material.map(|index| index.value()), material)?
                } else {
                    material
                };
                Ok(Some((name, geometry, material)))
            }
            Err(kind) => {
                self.builder.not_drawn.insert(kind);
                Ok(None)
            }
        }
    }
}
