//! Primitives: from accessors to triangles.

use super::accessor::Column;
use super::buffer::Buffers;
use crate::import::ImportError;
use crate::import::builder::Geometry;
use gltf_json::accessor::{Accessor, Type};
use gltf_json::extensions::texture::TextureTransform;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};
use rtrt_core::layout::Attribute;
use std::path::Path;

/// The texture coordinates that a material's base color is looked up with.
#[derive(Debug, Default, Clone)]
pub(super) struct Coordinates {
    /// Which set, if the base color has a texture.
    pub set: Option<u32>,
    /// What is done to them.
    pub transform: Option<TextureTransform>,
}

/// The triangles of a primitive, or what it is instead.
///
/// A vertex without a normal gets the normal 0, for which the renderer takes the
/// triangle's own: flat shading without a copy of each vertex for each triangle.
pub(super) fn geometry(
    path: &Path,
    root: &Root,
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    coordinates: &Coordinates,
) -> Result<Result<Geometry, &'static str>, ImportError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(ImportError::Invalid {
            path: path.to_owned(),
            why: "a primitive has an unknown mode".into(),
        });
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(Err("points and lines"));
    }
    let column = |index: Index<Accessor>, types: &[Type]| Column::new(path, root, buffers, index, types);
    let attribute = |semantic: Semantic, types: &[Type]| {
        primitive.attributes.get(&Checked::Valid(semantic)).map(|&index| column(index, types)).transpose()
    };
    let Some(positions) = attribute(Semantic::Positions, &[Type::Vec3])? else {
        return Ok(Err("primitives without positions"));
    };
    let normals = attribute(Semantic::Normals, &[Type::Vec3])?;
    let colors = attribute(Semantic::Colors(0), &[Type::Vec3, Type::Vec4])?;
    let uvs = match coordinates.set {
        Some(set) => attribute(Semantic::TexCoords(set), &[Type::Vec2])?,
        None => None,
    };
    let invalid = |why: &str| ImportError::Invalid { path: path.to_owned(), why: why.into() };
    if [&normals, &colors, &uvs].into_iter().flatten().any(|other| other.count != positions.count) {
        return Err(invalid("the attributes of a primitive differ in number"));
    }
    if u32::try_from(positions.count).is_err() {
        return Err(invalid("a primitive has more than 4 billion vertices"));
    }

    let indices: Vec<u32> = match primitive.indices {
        Some(index) => {
            let indices = column(index, &[Type::Scalar])?;
            if !indices.is_index() {
                return Err(invalid("the indices of a primitive are not unsigned integers"));
            }
            (0..indices.count).map(|i| indices.index(i)).collect()
        }
        None => (0..positions.count as u32).collect(),
    };
    let mut indices = triangles(mode, indices);
    let vertices = used(&mut indices, positions.count);
    let at = |vertex: &u32| *vertex as usize;
    let attributes = vertices.iter().map(|vertex| {
        let normal = normals.as_ref().map_or([0.0; 4], |normals| normals.at(at(vertex)));
        let uv = uvs.as_ref().map_or([0.0; 4], |uvs| uvs.at(at(vertex)));
        let color = colors.as_ref().map_or(!0, |colors| {
            let opaque = if colors.width == 3 { 1.0 } else { 0.0 };
            let [r, g, b, a] = colors.at(at(vertex));
            pack([r, g, b, a + opaque])
        });
        Attribute { normal: [normal[0], normal[1], normal[2]], uv: coordinates.apply([uv[0], uv[1]]), color }
    });
    let attributes = attributes.collect();
    let positions = vertices.iter().map(|vertex| {
        let [x, y, z, _] = positions.at(at(vertex));
        [x, y, z]
    });
    Ok(Ok(Geometry { positions: positions.collect(), attributes, indices }))
}

impl Coordinates {
    /// KHR_texture_transform: scaled, then turned, then moved.
    fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let Some(transform) = &self.transform else { return [u, v] };
        let ([scale_u, scale_v], [u0, v0]) = (transform.scale.0, transform.offset.0);
        let (sin, cos) = libm::sincosf(transform.rotation.0);
        let (u, v) = (u * scale_u, v * scale_v);
        [cos * u + sin * v + u0, cos * v - sin * u + v0]
    }
}

/// The corners of all triangles of a list, strip or fan. An incomplete last one is dropped.
fn triangles(mode: Mode, mut indices: Vec<u32>) -> Vec<u32> {
    match mode {
        Mode::TriangleStrip => {
            let turned =
                |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            indices.windows(3).enumerate().flat_map(turned).collect()
        }
        Mode::TriangleFan => {
            let rim = indices.get(1..).unwrap_or(&[]);
            rim.windows(2).flat_map(|edge| [indices[0], edge[0], edge[1]]).collect()
        }
        _ => {
            indices.truncate(indices.len() / 3 * 3);
            indices
        }
    }
}

/// Which vertices to keep, in order; `indices` then count those. All, unless there are more
/// than corners: primitives often share one large array and use a part of it each.
fn used(indices: &mut [u32], count: usize) -> Vec<u32> {
    if count <= indices.len() {
        return (0..count as u32).collect();
    }
    let mut kept: Vec<u32> = indices.iter().copied().filter(|&i| (i as usize) < count).collect();
    kept.sort_unstable();
    kept.dedup();
    for index in indices {
        // One that is out of range stays so, and is refused with the mesh.
        *index = kept.binary_search(index).map_or(u32::MAX, |place| place as u32);
    }
    kept
}

/// A color as vertices have it: linear RGBA, 8 bits each; NaN is white.
pub(in crate::import) fn pack(color: [f32; 4]) -> u32 {
    let byte = |c: f32| if c.is_nan() { 255 } else { (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8 };
    u32::from_le_bytes(color.map(byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_turn_every_other_triangle() {
        assert_eq!(triangles(Mode::TriangleStrip, vec![0, 1, 2, 3]), [0, 1, 2, 2, 1, 3]);
        assert_eq!(triangles(Mode::TriangleFan, vec![0, 1, 2, 3]), [0, 1, 2, 0, 2, 3]);
        assert_eq!(triangles(Mode::Triangles, vec![0, 1, 2, 3]), [0, 1, 2]);
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
            assert!(triangles(mode, vec![0]).is_empty() && triangles(mode, vec![]).is_empty());
        }
    }

    #[test]
    fn vertices_that_no_triangle_uses_are_dropped() {
        let mut indices = [7, 3, 900];
        assert_eq!(used(&mut indices, 1000), [3, 7, 900]);
        assert_eq!(indices, [1, 0, 2]);
        let mut broken = [0, 1, 12];
        used(&mut broken, 10);
        assert_eq!(broken, [0, 1, u32::MAX]);
    }

    #[test]
    fn colors_are_rounded_and_clamped() {
        assert_eq!(pack([2.0, -1.0, 0.5, f32::NAN]), 0xff80_00ff);
    }
}
