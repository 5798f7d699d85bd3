//! A mesh as it comes from outside, checked.

use crate::layout::Attribute;
use crate::scene::BvhError;
use crate::scene::floor::floored;
use crate::scene::tangent;
use alloc::vec;
use alloc::vec::Vec;

/// The largest coordinate that a mesh or a placed instance may have, in magnitude: 2³⁰.
/// The triangle test multiplies three of them, which must stay far from overflow.
pub const COORDINATE_LIMIT: f32 = 1_073_741_824.0;

/// Why a mesh was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A coordinate is NaN, infinite, or beyond [`COORDINATE_LIMIT`].
    #[error("vertex {vertex} has the coordinate {value}, which is not within ±2^30")]
    Coordinate {
        /// The vertex.
        vertex: usize,
        /// Its coordinate.
        value: f32,
    },
    /// A normal or a texture coordinate is NaN or infinite.
    #[error("vertex {vertex} has the normal or texture coordinate {value}")]
    Attribute {
        /// The vertex.
        vertex: usize,
        /// The value.
        value: f32,
    },
    /// An index names a vertex that the mesh does not have.
    #[error("index {index} is {value}, but the mesh has {vertices} vertices")]
    Index {
        /// Which index.
        index: usize,
        /// What it says.
        value: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The number of indices is not a multiple of three.
    #[error("{count} indices do not make whole triangles")]
    Ragged {
        /// How many indices there are.
        count: usize,
    },
    /// Positions and attributes differ in number.
    #[error("{positions} positions but {attributes} attributes")]
    Lengths {
        /// How many positions there are.
        positions: usize,
        /// How many attributes there are.
        attributes: usize,
    },
    /// More triangles than references can number.
    #[error("{triangles} triangles are more than a mesh may have (33 million)")]
    TooLarge {
        /// How many triangles there are.
        triangles: usize,
    },
    /// A BVH is not one of these triangles.
    #[error(transparent)]
    Tree(#[from] BvhError),
}

/// Triangles with their vertices, checked: every number is finite and every index valid.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    attributes: Vec<Attribute>,
    indices: Vec<u32>,
    tangents: Vec<u32>,
    second_uv: Vec<[f32; 2]>,
}

impl Mesh {
    /// The most triangles a mesh may have: nodes are numbered with 26 bits.
    pub const MAX_TRIANGLES: usize = 1 << 25;

    /// The mesh of these vertices (positions in object space, one attribute each) and
    /// triangles (three indices each). Triangles without area are kept; no ray meets them.
    ///
    /// # Errors
    /// Anything that is not finite, out of range, or does not fit together; see
    /// [`MeshError`].
    pub fn new(
        mut positions: Vec<[f32; 3]>,
        mut attributes: Vec<Attribute>,
        indices: Vec<u32>,
    ) -> Result<Self, MeshError> {
        if positions.len() != attributes.len() {
            return Err(MeshError::Lengths { positions: positions.len(), attributes: attributes.len() });
        }
        if !indices.len().is_multiple_of(3) {
            return Err(MeshError::Ragged { count: indices.len() });
        }
        if indices.len() / 3 > Self::MAX_TRIANGLES {
            return Err(MeshError::TooLarge { triangles: indices.len() / 3 });
        }
        for (vertex, position) in positions.iter_mut().enumerate() {
            for value in position {
                if !value.is_finite() || value.abs() > COORDINATE_LIMIT {
                    return Err(MeshError::Coordinate { vertex, value: *value });
                }
                *value = floored(*value);
            }
        }
        for (vertex, attribute) in attributes.iter_mut().enumerate() {
            for value in attribute.normal.iter_mut().chain(&mut attribute.uv) {
                if !value.is_finite() {
                    return Err(MeshError::Attribute { vertex, value: *value });
                }
                *value = floored(*value);
            }
        }
        let vertices = positions.len();
        match indices.iter().position(|&i| i as usize >= vertices) {
            Some(index) => Err(MeshError::Index { index, value: indices[index], vertices }),
            None => Ok(Self { positions, attributes, indices, tangents: Vec::new(), second_uv: Vec::new() }),
        }
    }

    /// No triangles.
    pub(super) fn nothing() -> Self {
        let (positions, attributes, indices) = (Vec::new(), Vec::new(), Vec::new());
        Self { positions, attributes, indices, tangents: Vec::new(), second_uv: Vec::new() }
    }

    /// What stands for the sphere of radius 1 among meshes: two triangles without area, whose
    /// bounds are the sphere's. They can be asked for corners and colors like others.
    pub(super) fn around_sphere() -> Self {
        let white = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
        Self {
            positions: vec![[-1.0; 3], [1.0; 3]],
            attributes: vec![white; 2],
            indices: vec![0, 1, 1, 0, 1, 1],
            tangents: Vec::new(),
            second_uv: Vec::new(),
        }
    }

    /// The mesh with a second set of texture coordinates, one a vertex.
    ///
    /// # Errors
    /// A coordinate is not finite, or there are more or fewer than vertices.
    pub fn with_second_uv(mut self, mut uv: Vec<[f32; 2]>) -> Result<Self, MeshError> {
        self.check_length(uv.len())?;
        for (vertex, value) in
            uv.iter_mut().enumerate().flat_map(|(i, uv)| uv.iter_mut().map(move |c| (i, c)))
        {
            if !value.is_finite() {
                return Err(MeshError::Attribute { vertex, value: *value });
            }
            *value = floored(*value);
        }
        self.second_uv = uv;
        Ok(self)
    }

    /// The mesh with tangents for normal maps, one a vertex: a direction, and the sign of the
    /// bitangent, which is `normal × tangent` times that sign (as glTF has them).
    ///
    /// # Errors
    /// A number is not finite, or there are more or fewer than vertices.
    pub fn with_tangents(mut self, tangents: &[[f32; 4]]) -> Result<Self, MeshError> {
        self.check_length(tangents.len())?;
        let mut numbers = tangents.iter().enumerate().flat_map(|(i, t)| t.map(|c| (i, c)));
        if let Some((vertex, value)) = numbers.find(|(_, c)| !c.is_finite()) {
            return Err(MeshError::Attribute { vertex, value });
        }
        self.tangents = tangents.iter().map(|&t| tangent::pack(t)).collect();
        Ok(self)
    }

    /// The mesh with tangents made from its texture coordinates, those of the second set if
    /// `second`. Vertices may be duplicated, where a texture is mirrored.
    pub fn with_made_tangents(mut self, second: bool) -> Self {
        let uv = |i: usize| {
            if second { self.second_uv.get(i).copied().unwrap_or_default() } else { self.attributes[i].uv }
        };
        let made = tangent::make(&self.positions, &self.attributes, uv, &mut self.indices);
        for &(copied, _) in &made[self.positions.len()..] {
            self.positions.push(self.positions[copied as usize]);
            self.attributes.push(self.attributes[copied as usize]);
            if let Some(&uv) = self.second_uv.get(copied as usize) {
                self.second_uv.push(uv);
            }
        }
        self.tangents = made.into_iter().map(|(_, tangent)| tangent).collect();
        self
    }

    fn check_length(&self, attributes: usize) -> Result<(), MeshError> {
        let positions = self.positions.len();
        if attributes == positions { Ok(()) } else { Err(MeshError::Lengths { positions, attributes }) }
    }

    /// Vertex positions, object space.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }
    /// What is interpolated, one a vertex.
    pub fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }
    /// Tangents, packed, one a vertex; empty for none.
    pub(super) fn tangents(&self) -> &[u32] {
        &self.tangents
    }
    /// The second set of texture coordinates, one a vertex; empty for none.
    pub fn second_uv(&self) -> &[[f32; 2]] {
        &self.second_uv
    }
    /// Vertex indices, three a triangle.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }
    /// How many triangles there are.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;
    use bytemuck::Zeroable;

    fn triangle(third: [f32; 3], indices: Vec<u32>) -> Result<Mesh, MeshError> {
        Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], third], vec![Attribute::zeroed(); 3], indices)
    }

    #[test]
    fn refuses_what_is_not_finite_or_does_not_fit() {
        for bad in [f32::NAN, f32::INFINITY, -2e9] {
            let error = triangle([0.0, bad, 0.0], vec![0, 1, 2]).unwrap_err();
            assert!(matches!(error, MeshError::Coordinate { vertex: 2, .. }), "{error}");
        }
        assert!(matches!(triangle([0.0; 3], vec![0, 1, 3]), Err(MeshError::Index { value: 3, .. })));
        assert!(matches!(triangle([0.0; 3], vec![0, 1]), Err(MeshError::Ragged { count: 2 })));
    }

    #[test]
    fn coordinates_too_small_to_subtract_are_zero() {
        let mesh = triangle([1e-30, 1e-17, -1e-19], vec![0, 1, 2]).unwrap();
        assert_eq!(mesh.positions()[2], [0.0, 1e-17, 0.0]);
        let tiny = Attribute { normal: [1e-40, 1.0, 0.0], uv: [1e-17, -1e-39], color: [0; 2] };
        let mesh = Mesh::new(vec![[0.0; 3]; 3], vec![tiny; 3], vec![0, 1, 2]).unwrap();
        assert_eq!(
            mesh.attributes()[0],
            Attribute { normal: [0.0, 1.0, 0.0], uv: [1e-17, 0.0], color: [0; 2] }
        );
    }
}
