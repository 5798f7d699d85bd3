//! Primitives: from accessors to triangles.

use super::accessor::Column;
use super::buffer::Buffers;
use super::draco::Draco;
use crate::import::ImportError;
use crate::import::geometry::{Deform, Geometry, JointWeights, Tangents, Target};
use crate::import::marks::{self, Marks};
use glam::Vec3;
use gltf_json::accessor::{Accessor, Type};
use gltf_json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};
use rtrt_core::layout::Attribute;
use std::path::Path;

/// The texture coordinates that a material uses.
#[derive(Debug, Default, Clone)]
pub(super) struct Coordinates {
    /// The set of the file in each of the two slots of the scene.
    pub sets: [Option<u32>; 2],
    /// The slot of the normal map, which needs tangents.
    pub bump: Option<u32>,
}

impl Coordinates {
    /// The slot of a set, a new one if necessary; none if both are taken.
    pub fn slot(&mut self, set: u32) -> Option<u32> {
        let slot = self.sets.iter_mut().position(|slot| *slot.get_or_insert(set) == set)?;
        Some(slot as u32)
    }
}

/// The triangles of a primitive, or the name of its kind if it is not drawn. Points and lines have this diameter, or one
/// that follows from the primitive's bounds.
///
/// A vertex without a normal gets the normal 0. The renderer replaces it by the triangle's normal: flat
/// shading without a copy of each vertex for each triangle.
pub(super) fn geometry(
    path: &Path,
    root: &Root,
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    coordinates: &Coordinates,
    diameter: Option<f64>,
) -> Result<Result<Geometry, &'static str>, ImportError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(ImportError::Invalid {
            path: path.to_owned(),
            why: "a primitive has an unknown mode".into(),
        });
    };
    let column = |index: Index<Accessor>, types: &[Type]| Column::new(path, root, buffers, index, types);
    let draco = Draco::new(path, root, buffers, primitive)?;
    let attribute = |semantic: Semantic, types: &[Type]| match draco
        .as_ref()
        .and_then(|draco| draco.column(&semantic, types))
    {
        Some(column) => column.map(Some).map_err(|why| ImportError::Invalid { path: path.to_owned(), why }),
        None => {
            let index = primitive.attributes.get(&Checked::Valid(semantic));
            index.map(|&index| column(index, types)).transpose()
        }
    };
    let Some(positions) = attribute(Semantic::Positions, &[Type::Vec3])? else {
        return Ok(Err("primitives without positions"));
    };
    let normals = attribute(Semantic::Normals, &[Type::Vec3])?;
    let colors = attribute(Semantic::Colors(0), &[Type::Vec3, Type::Vec4])?;
    let set = |slot: usize| match coordinates.sets[slot] {
        Some(set) => attribute(Semantic::TexCoords(set), &[Type::Vec2]),
        None => Ok(None),
    };
    let (uvs, second_uvs) = (set(0)?, set(1)?);
    let given = match coordinates.bump {
        Some(_) if normals.is_some() => attribute(Semantic::Tangents, &[Type::Vec4])?,
        _ => None,
    };
    let invalid = |why: &str| ImportError::Invalid { path: path.to_owned(), why: why.into() };
    if [&normals, &colors, &uvs, &second_uvs, &given]
        .into_iter()
        .flatten()
        .any(|other| other.count != positions.count)
    {
        return Err(invalid("the attributes of a primitive differ in number"));
    }
    if u32::try_from(positions.count).is_err() {
        return Err(invalid("a primitive has more than 4 billion vertices"));
    }

    let indices: Vec<u32> = match (&draco, primitive.indices) {
        (Some(draco), _) => draco.indices.clone(),
        (None, Some(index)) => {
            let indices = column(index, &[Type::Scalar])?;
            if !indices.is_index() {
                return Err(invalid("the indices of a primitive are not unsigned integers"));
            }
            (0..indices.count).map(|i| indices.index(i)).collect()
        }
        (None, None) => (0..positions.count as u32).collect(),
    };
    let mode = if draco.is_some() { Mode::Triangles } else { mode };
    let mut indices = corners(mode, indices);
    let vertices = used(&mut indices, positions.count);
    let at = |vertex: &u32| *vertex as usize;
    let attributes = vertices.iter().map(|vertex| {
        let normal = normals.as_ref().map_or([0.0; 4], |normals| normals.at(at(vertex)));
        let uv = uvs.as_ref().map_or([0.0; 2], |uvs| two(uvs.at(at(vertex))));
        let color = colors.as_ref().map_or(Attribute::WHITE, |colors| {
            let opaque = if colors.width == 3 { 1.0 } else { 0.0 };
            let [r, g, b, a] = colors.at(at(vertex));
            Attribute::pack_color([r, g, b, a + opaque])
        });
        Attribute { normal: [normal[0], normal[1], normal[2]], uv, color }
    });
    let attributes = attributes.collect();
    let positions_count = positions.count;
    let positions = vertices.iter().map(|vertex| {
        let [x, y, z, _] = positions.at(at(vertex));
        [x, y, z]
    });
    let positions = positions.collect();
    let second_uv = second_uvs.map(|uvs| vertices.iter().map(|vertex| two(uvs.at(at(vertex)))).collect());
    let tangents = match (given, coordinates.bump) {
        (_, None) => Tangents::None,
        (Some(given), _) => Tangents::Given(vertices.iter().map(|vertex| given.at(at(vertex))).collect()),
        (None, Some(slot)) => Tangents::Made { second: slot == 1 },
    };
    let deform = Deform {
        joint_sets: joint_sets(&attribute, positions_count, &vertices)?,
        targets: targets(primitive, &column, &vertices)?,
    };
    let geometry = Geometry { positions, attributes, indices, second_uv, tangents, deform };
    if let Some(found) = marks_between(mode, &geometry.indices) {
        let of_mesh = || {
            let (low, high) = marks::bounds(geometry.positions.iter().copied());
            marks::diameter(None, low, high)
        };
        let diameter = diameter.unwrap_or_else(of_mesh);
        return found.geometry(&geometry, diameter).map(Ok).map_err(|why| invalid(&why));
    }
    // A normal map needs normals.
    let is_flat = coordinates.bump.is_some() && normals.is_none();
    Ok(Ok(if is_flat { faceted(geometry) } else { geometry }))
}

/// The joints of the vertices of a skin, a list for each set of four.
fn joint_sets<'a>(
    attribute: &impl Fn(Semantic, &[Type]) -> Result<Option<Column<'a>>, ImportError>,
    count: usize,
    vertices: &[u32],
) -> Result<Vec<Vec<JointWeights>>, ImportError> {
    let mut sets = Vec::new();
    for set in 0.. {
        let get = |semantic| attribute(semantic, &[Type::Vec4]);
        let Some(weights) = get(Semantic::Weights(set))? else { break };
        let Some(joints) = get(Semantic::Joints(set))? else { break };
        if joints.count != count || weights.count != count {
            return Ok(vec![]);
        }
        let vertex = |&i: &u32| (joints.at(i as usize).map(|joint| joint as u32), weights.at(i as usize));
        sets.push(vertices.iter().map(vertex).collect());
    }
    Ok(sets)
}

/// The morph targets of the vertices.
fn targets<'a>(
    primitive: &Primitive,
    column: &impl Fn(Index<Accessor>, &[Type]) -> Result<Column<'a>, ImportError>,
    vertices: &[u32],
) -> Result<Vec<Target>, ImportError> {
    let pick = |index: Option<Index<Accessor>>| match index {
        Some(index) => {
            let column = column(index, &[Type::Vec3])?;
            let three = |i: usize| {
                let [x, y, z, _] = if i < column.count { column.at(i) } else { [0.0; 4] };
                [x, y, z]
            };
            Ok(vertices.iter().map(|&i| three(i as usize)).collect())
        }
        None => Ok(vec![]),
    };
    let target = |target: &MorphTarget| {
        Ok(Target {
            positions: pick(target.positions)?,
            normals: pick(target.normals)?,
            tangents: pick(target.tangents)?,
        })
    };
    primitive.targets.iter().flatten().map(target).collect()
}

/// The triangles with separate vertices and their own normals.
fn faceted(geometry: Geometry) -> Geometry {
    let corner = |i: &u32| geometry.positions.get(*i as usize).copied().map(Vec3::from);
    let Some(corners) = geometry.indices.iter().map(corner).collect::<Option<Vec<_>>>() else {
        // The mesh refuses an index that is out of range.
        return geometry;
    };
    let at = |i: &u32| *i as usize;
    let normals = corners.chunks_exact(3).map(|t| (t[1] - t[0]).cross(t[2] - t[0]).to_array());
    let normals = normals.flat_map(|normal| [normal; 3]);
    Geometry {
        attributes: geometry
            .indices
            .iter()
            .zip(normals)
            .map(|(i, normal)| Attribute { normal, ..geometry.attributes[at(i)] })
            .collect(),
        positions: corners.iter().map(|corner| corner.to_array()).collect(),
        second_uv: geometry.second_uv.map(|uv| geometry.indices.iter().map(|i| uv[at(i)]).collect()),
        deform: geometry.deform.select(&geometry.indices),
        indices: (0..geometry.indices.len() as u32).collect(),
        tangents: geometry.tangents,
    }
}

fn two([u, v, _, _]: [f32; 4]) -> [f32; 2] {
    [u, v]
}

/// The points or lines between these corners; none of triangles.
fn marks_between(mode: Mode, corners: &[u32]) -> Option<Marks> {
    match mode {
        Mode::Points => Some(Marks::Points(corners.into())),
        Mode::Lines | Mode::LineLoop | Mode::LineStrip => Some(Marks::Lines(corners.as_chunks().0.to_vec())),
        Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => None,
    }
}

/// The corners of all points, lines or triangles, without an incomplete last one.
fn corners(mode: Mode, mut indices: Vec<u32>) -> Vec<u32> {
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
        Mode::LineStrip => indices.windows(2).flatten().copied().collect(),
        Mode::LineLoop => {
            let next = indices.iter().cycle().skip(1);
            let lines = if indices.len() < 2 { 0 } else { indices.len() };
            indices.iter().zip(next).take(lines).flat_map(|(&a, &b)| [a, b]).collect()
        }
        Mode::Triangles | Mode::Lines | Mode::Points => {
            let corners = match mode {
                Mode::Triangles => 3,
                Mode::Lines => 2,
                _ => 1,
            };
            indices.truncate(indices.len() / corners * corners);
            indices
        }
    }
}

/// The vertices that the indices use, in order; `indices` then refer to this list. It has all vertices
/// unless they outnumber the corners: primitives often share one large array and use a part of it.
fn used(indices: &mut [u32], count: usize) -> Vec<u32> {
    if count <= indices.len() {
        return (0..count as u32).collect();
    }
    let mut used: Vec<u32> = indices.iter().copied().filter(|&i| (i as usize) < count).collect();
    used.sort_unstable();
    used.dedup();
    for index in indices {
        // The mesh refuses an index that is out of range.
        *index = used.binary_search(index).map_or(u32::MAX, |place| place as u32);
    }
    used
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_turn_every_other_triangle() {
        assert_eq!(corners(Mode::TriangleStrip, vec![0, 1, 2, 3]), [0, 1, 2, 2, 1, 3]);
        assert_eq!(corners(Mode::TriangleFan, vec![0, 1, 2, 3]), [0, 1, 2, 0, 2, 3]);
        assert_eq!(corners(Mode::Triangles, vec![0, 1, 2, 3]), [0, 1, 2]);
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
            assert!(corners(mode, vec![0]).is_empty() && corners(mode, vec![]).is_empty());
        }
    }

    #[test]
    fn loops_return_to_their_start() {
        assert_eq!(corners(Mode::Lines, vec![0, 1, 2]), [0, 1]);
        assert_eq!(corners(Mode::LineStrip, vec![0, 1, 2]), [0, 1, 1, 2]);
        assert_eq!(corners(Mode::LineLoop, vec![0, 1, 2]), [0, 1, 1, 2, 2, 0]);
        assert_eq!(corners(Mode::Points, vec![4, 5]), [4, 5]);
        for mode in [Mode::Lines, Mode::LineStrip, Mode::LineLoop] {
            assert!(corners(mode, vec![0]).is_empty() && corners(mode, vec![]).is_empty());
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
}
