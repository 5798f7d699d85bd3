//! PLY: polygons over shared vertices, as text or binary.
//!
//! The format has neither units nor axes. Coordinates are taken as they are: one unit of the file is one of the scene,
//! and +y is up, as in glTF.
//!
//! Properties have no fixed meaning; names do, by habit:
//!
//! | element | properties |
//! |---|---|
//! | `vertex` | `x y z`; `nx ny nz`; `red green blue alpha`, `r g b a`, `diffuse_red` …; `u v`, `s t`, `texture_u texture_v` |
//! | `face` | `vertex_indices` or `vertex_index`; `texcoord` (a pair for each corner); colors as of vertices |
//! | `edge` | `vertex1`, `vertex2` |
//! | `tristrips` | `vertex_indices`, in which −1 ends a strip |
//!
//! A file with vertices alone is a cloud of points.
//!
//! Colors are sRGB, which is what scanners and editors write: integers up to the largest of their type, or numbers of
//! 0 ..= 1. `comment TextureFile NAME` names the image of the base color, whose `v` points up.
//!
//! Vertices without normals get smooth ones: faces share vertices, and a vertex with one position has one normal
//! ([`angle_weighted`]). Where a file repeats a vertex, for a sharp edge, nothing is shared and the edge stays sharp.

mod header;
mod reader;
mod table;

use super::builder::Builder;
use super::error::quoted;
use super::geometry::Geometry;
use super::marks::{Marks, bounds, diameter};
use super::normals::{angle_weighted, finite};
use super::origin::Bounds;
use super::polygon::Splitter;
use super::{ImportError, file, picture};
use glam::{DVec3, Mat4};
pub(super) use header::looks_like;
use rtrt_core::layout::{Attribute, Texture};
use rtrt_core::scene::{Join, Material};
use std::collections::HashMap;
use table::Ply;

/// Adds the faces of a file to the scene as one object, its edges as another; or its points.
pub(super) fn load<J: Join>(builder: &mut Builder<'_, J>, bytes: &[u8]) -> Result<(), ImportError> {
    let header = header::parse(bytes).map_err(|why| builder.invalid(why))?;
    let read = |origin| table::read(&header, bytes, origin);
    let mut ply = read(DVec3::ZERO).map_err(|why| builder.invalid(why))?;
    builder.origin = Bounds::of(&ply.positions).origin();
    if builder.origin != DVec3::ZERO {
        ply = read(builder.origin).map_err(|why| builder.invalid(why))?;
    }
    if ply.positions.is_empty() {
        return Err(builder.invalid("it has no vertices".into()));
    }
    add_marks(builder, &ply)?;
    if ply.faces.ends.is_empty() {
        return Ok(());
    }
    if ply.skipped > 0 {
        builder.warn(format!("faces with fewer than three corners are left out: {}", ply.skipped));
    }
    let has_uv = !ply.uvs.is_empty() || !ply.faces.uvs.is_empty();
    let texture = if has_uv { texture(builder, &header.textures)? } else { None };
    let (geometry, not_finite) = geometry(&mut ply);
    if not_finite > 0 {
        builder.warn(format!(
            "vertices whose normals or texture coordinates are not finite are drawn without those: {not_finite}"
        ));
    }
    let is_colored = texture.is_some() || !ply.colors.is_empty() || !ply.faces.colors.is_empty();
    let dull = Material::new([if is_colored { 1.0 } else { 0.7 }; 3]).roughness(0.8).base_color_map(texture);
    let material = builder.add_material(if is_see_through(&geometry) { dull.blend(1.0) } else { dull })?;
    builder.name_material("faces".into());
    let mesh = builder.add_mesh("the faces", geometry)?;
    let object = builder.add_instance("the faces", mesh, material, Mat4::IDENTITY)?;
    builder.label_file(object, "faces");
    Ok(())
}

/// Adds the edges, and all vertices as points if there is nothing else.
///
/// Points with colors and without normals show their colors as they are: scanners measure those under light.
fn add_marks<J: Join>(builder: &mut Builder<'_, J>, ply: &Ply) -> Result<(), ImportError> {
    let (marks, name) = if !ply.edges.is_empty() {
        (Marks::Lines(ply.edges.clone()), "edges")
    } else if ply.faces.ends.is_empty() {
        let is_finite = |vertex: &u32| ply.positions[*vertex as usize].iter().all(|c| c.is_finite());
        let points: Vec<u32> = (0..ply.positions.len() as u32).filter(is_finite).collect();
        let missing = ply.positions.len() - points.len();
        if missing > 0 {
            builder.warn(format!("points whose coordinates are not finite are left out: {missing}"));
        }
        (Marks::Points(points), "points")
    } else {
        return Ok(());
    };
    let attribute = |vertex: usize| Attribute {
        normal: ply.normals.get(vertex).copied().map_or([0.0; 3], finite),
        uv: [0.0; 2],
        color: ply.colors.get(vertex).copied().unwrap_or(Attribute::WHITE),
    };
    let attributes = (0..ply.positions.len()).map(attribute).collect();
    let source = Geometry { positions: ply.positions.clone(), attributes, ..Geometry::default() };
    let (low, high) = bounds(ply.positions.iter().copied());
    let diameter = diameter(builder.point_size, low, high);
    let geometry = marks.geometry(&source, diameter).map_err(|why| builder.invalid(why))?;
    let has_colors = !ply.colors.is_empty();
    let material = Material::new([if has_colors { 1.0 } else { 0.7 }; 3]).roughness(0.8);
    let material = builder.add_material(material.unlit(has_colors && ply.normals.is_empty()))?;
    builder.name_material(name.into());
    let mesh = builder.add_mesh(&format!("the {name}"), geometry)?;
    let object = builder.add_instance(name, mesh, material, Mat4::IDENTITY)?;
    builder.label_file(object, name);
    Ok(())
}

/// The texture of the base color; none, with a warning, if its file cannot be read.
fn texture<J: Join>(builder: &mut Builder<'_, J>, names: &[String]) -> Result<Option<Texture>, ImportError> {
    let Some(name) = names.first() else { return Ok(None) };
    if names.len() > 1 {
        builder.warn(format!("only the first of {} textures is drawn", names.len()));
    }
    let path = builder.files.beside(&[&builder.path], name);
    let bytes = builder.files.read(&path, file::LONGEST).map_err(|error| error.to_string());
    let image = bytes.and_then(|bytes| picture::decode(&bytes));
    builder.add_texture(&quoted(name), image).map(Some)
}

/// Whether a vertex is not opaque. Where all have an alpha of 0 it means nothing: some programs write that.
fn is_see_through(geometry: &Geometry) -> bool {
    let alphas = || geometry.attributes.iter().map(|attribute| attribute.color[1] >> 16);
    alphas().any(|alpha| alpha != 0xffff) && alphas().any(|alpha| alpha != 0)
}

/// A corner of a face: vertex, texture coordinates and color.
type Corner = (u32, [u32; 2], [u32; 2]);

/// The triangles with the vertices that they use, and how many normals and texture coordinates are not finite.
fn geometry(ply: &mut Ply) -> (Geometry, usize) {
    const NONE: u32 = u32::MAX;
    let triangles = triangles(ply);
    if ply.normals.is_empty() {
        let vertices: Vec<u32> =
            triangles.iter().map(|&(corner, _)| ply.faces.corners[corner as usize]).collect();
        ply.normals = angle_weighted(&ply.positions, &vertices);
    }
    let mut geometry = Geometry::default();
    let mut not_finite = 0;
    let mut plain = vec![NONE; ply.positions.len()];
    let mut known: HashMap<Corner, u32> = HashMap::new();
    let has_corners = !ply.faces.uvs.is_empty() || !ply.faces.colors.is_empty();
    for (corner, face) in triangles {
        let (corner, face) = (corner as usize, face as usize);
        let vertex = ply.faces.corners[corner];
        let of = vertex as usize;
        let uv = ply.faces.uvs.get(corner).or(ply.uvs.get(of)).copied().unwrap_or([0.0, 1.0]);
        let color = ply.faces.colors.get(face).or(ply.colors.get(of)).copied().unwrap_or(Attribute::WHITE);
        let place = if has_corners {
            known.entry((vertex, uv.map(f32::to_bits), color)).or_insert(NONE)
        } else {
            &mut plain[of]
        };
        if *place == NONE {
            *place = geometry.positions.len() as u32;
            let is_finite = |numbers: &[f32]| numbers.iter().all(|n| n.is_finite());
            not_finite += usize::from(!is_finite(&uv) || !is_finite(&ply.normals[of]));
            let uv = if is_finite(&uv) { [uv[0], 1.0 - uv[1]] } else { [0.0; 2] };
            geometry.positions.push(ply.positions[of]);
            geometry.attributes.push(Attribute { normal: finite(ply.normals[of]), uv, color });
        }
        geometry.indices.push(*place);
    }
    (geometry, not_finite)
}

/// The corners of the triangles of all faces, each with its face.
fn triangles(ply: &Ply) -> Vec<(u32, u32)> {
    let (mut splitter, mut outline) = (Splitter::new(), Vec::new());
    let mut triangles = Vec::with_capacity(ply.faces.corners.len());
    let mut first = 0;
    for (face, &end) in (0..).zip(&ply.faces.ends) {
        outline.clear();
        outline.extend(ply.faces.corners[first..end].iter().map(|&vertex| ply.positions[vertex as usize]));
        triangles.extend(splitter.split(&outline).iter().map(|&corner| (first as u32 + corner, face)));
        first = end;
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Ply {
        table::read(&header::parse(text.as_bytes()).unwrap(), text.as_bytes(), DVec3::ZERO).unwrap()
    }

    /// A roof: two rectangles that share a ridge.
    const ROOF: &str = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                        element face 2\nproperty list uchar int vertex_indices\nend_header\n\
                        -1 0 0\n0 0 1\n0 2 1\n-1 2 0\n1 0 0\n1 2 0\n4 0 1 2 3\n4 1 4 5 2\n";

    #[test]
    fn faces_that_share_vertices_are_smooth() {
        let (geometry, not_finite) = geometry(&mut read(ROOF));
        assert_eq!((geometry.indices.len(), geometry.positions.len(), not_finite), (12, 6, 0));
        let ridge = geometry.positions.iter().position(|p| *p == [0.0, 0.0, 1.0]).unwrap();
        let normal = geometry.attributes[ridge].normal;
        assert!(normal.iter().zip([0.0, 0.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{normal:?}");
    }

    #[test]
    fn corners_with_colors_of_their_faces_are_apart() {
        let colored = ROOF
            .replace(
                "end_header",
                "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header",
            )
            .replace("4 0 1 2 3", "4 0 1 2 3 255 0 0")
            .replace("4 1 4 5 2", "4 1 4 5 2 0 0 255");
        let (geometry, _) = geometry(&mut read(&colored));
        assert_eq!(geometry.positions.len(), 8);
        let colors: Vec<[u32; 2]> =
            geometry.indices.iter().map(|&i| geometry.attributes[i as usize].color).collect();
        assert_eq!((colors[0], colors[6]), ([0xffff, 0xffff_0000], [0, 0xffff_ffff]));
    }

    #[test]
    fn vertices_that_no_face_uses_may_be_anything() {
        let text = ROOF.replace("vertex 6", "vertex 7").replace("1 2 0\n4", "1 2 0\nnan inf 1e39\n4");
        assert_eq!(geometry(&mut read(&text)).0.positions.len(), 6);
    }
}
