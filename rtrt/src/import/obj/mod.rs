//! OBJ with MTL: one mesh and one object for each material.

mod material;
mod mtl;
mod normals;
mod parse;
mod texture;

use crate::import::builder::Builder;
use crate::import::error::quoted;
use crate::import::geometry::{Geometry, Tangents};
use crate::import::marks::{Marks, bounds, diameter};
use crate::import::origin::Bounds;
use crate::import::polygon::Splitter;
use crate::import::{ImportError, NamedCamera, text};
use glam::{DVec3, Mat4};
use material::Materials;
use parse::{Corner, NONE, Obj, Polygon};
use rtrt_core::layout::Attribute;
use rtrt_core::scene::Join;
use std::collections::HashMap;

/// Whether the bytes begin as OBJ does: after empty lines and comments, with one of its usual words.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    const WORDS: [&[u8]; 9] = [b"v", b"vt", b"vn", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl"];
    let lines = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.into_iter().find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let word = first.and_then(|line| line.split(u8::is_ascii_whitespace).next());
    word.is_some_and(|word| WORDS.contains(&word))
}

/// Adds the file's meshes to the scene. OBJ has no cameras.
pub(super) fn load<J: Join>(
    builder: &mut Builder<'_, J>,
    bytes: &[u8],
) -> Result<Vec<NamedCamera>, ImportError> {
    let bytes = text::utf8(bytes);
    let mut obj = parse::parse(&bytes).map_err(|why| builder.invalid(why))?;
    builder.origin = Bounds::of(&obj.positions).origin();
    if builder.origin != DVec3::ZERO {
        obj.positions = parse::relative_positions(&bytes, builder.origin);
    }
    warn(builder, &obj);
    normals::smooth(&mut obj);
    let mut materials = Materials::new(builder, &obj.libraries);
    let mut unknown = 0;
    // The polygons before the first `usemtl`, then those of each material.
    let mut groups: Vec<Vec<Polygon>> = vec![Vec::new(); obj.materials.len() + 1];
    for &polygon in &obj.polygons {
        groups[polygon.material.map_or(0, |material| material + 1)].push(polygon);
    }
    let marks = Drawn::new(builder, &obj);
    for (number, polygons) in groups.into_iter().enumerate() {
        let marks_here = marks.of(number);
        if polygons.is_empty() && marks_here.is_empty() {
            continue;
        }
        let name = number.checked_sub(1).map(|material| obj.materials[material].clone());
        let source = name.as_ref().and_then(|name| materials.find(name));
        unknown += usize::from(name.is_some() && source.is_none());
        let (material, has_normal_map) = materials.add(builder, source.as_ref(), !obj.colors.is_empty())?;
        builder.name_material(name.clone().unwrap_or("default".into()));
        let name = name.map_or("the polygons without a material".into(), |name| quoted(&name));
        for shapes in marks_here {
            // They have no normals, so their colors are shown as they are.
            let unlit = builder.add_unlit(material)?;
            let drawn =
                shapes.geometry(&marks.vertices, marks.diameter).map_err(|why| builder.invalid(why))?;
            let mesh = builder.add_mesh(&name, drawn)?;
            let object = builder.add_instance(&name, mesh, unlit, Mat4::IDENTITY)?;
            builder.label_file(object, shapes.kind());
        }
        if polygons.is_empty() {
            continue;
        }
        if has_normal_map {
            add_face_normals(&mut obj, &polygons);
        }
        let tangents = if has_normal_map { Tangents::Made { second: false } } else { Tangents::None };
        let mesh = builder.add_mesh(&name, Geometry { tangents, ..geometry(&obj, &polygons) })?;
        let object = builder.add_instance(&name, mesh, material, Mat4::IDENTITY)?;
        builder.label_file(object, "faces");
    }
    if unknown > 0 {
        builder.warn(format!("{unknown} materials are in no material library; they are drawn gray"));
    }
    Ok(Vec::new())
}

/// The points and lines of a file.
struct Drawn {
    /// By the group of polygons with the same material.
    groups: HashMap<usize, [Marks; 2]>,
    vertices: Geometry,
    diameter: f64,
}

impl Drawn {
    fn new<J: Join>(builder: &Builder<'_, J>, obj: &Obj) -> Self {
        let mut groups = HashMap::new();
        for (marks, material) in &obj.marks {
            let group = material.map_or(0, |material| material + 1);
            let empty = || [Marks::Points(Vec::new()), Marks::Lines(Vec::new())];
            for have in groups.entry(group).or_insert_with(empty) {
                match (have, marks) {
                    (Marks::Points(have), Marks::Points(more)) => have.extend(more),
                    (Marks::Lines(have), Marks::Lines(more)) => have.extend(more),
                    _ => {}
                }
            }
        }
        if groups.is_empty() {
            return Self { groups, vertices: Geometry::default(), diameter: 1.0 };
        }
        let (low, high) = bounds(obj.positions.iter().copied());
        let attributes = (0..obj.positions.len() as u32).map(|vertex| attribute(obj, [vertex, NONE, NONE]));
        let vertices = Geometry {
            positions: obj.positions.clone(),
            attributes: attributes.collect(),
            ..Geometry::default()
        };
        Self { groups, vertices, diameter: diameter(builder.point_size, low, high) }
    }

    /// The points, and the lines, of a group; none that are empty.
    fn of(&self, group: usize) -> Vec<&Marks> {
        self.groups.get(&group).into_iter().flatten().filter(|marks| !marks.is_empty()).collect()
    }
}

/// Warns of elements that are not drawn as the file has them.
fn warn<J: Join>(builder: &mut Builder<'_, J>, obj: &Obj) {
    let Obj { skipped, unresolved, not_finite, .. } = *obj;
    if skipped > 0 {
        builder
            .warn(format!("curves, surfaces and faces of fewer than three corners are left out: {skipped}"));
    }
    if unresolved > 0 {
        builder.warn(format!("{unresolved} references to texture coordinates or normals lead nowhere"));
    }
    if not_finite > 0 {
        builder.warn(format!(
            "{not_finite} corners have texture coordinates or normals that are not finite; \
             those are drawn without texture coordinates, or with the normal of the face"
        ));
    }
}

/// Gives the corners of polygons without normals the normals of their faces: a normal map turns a normal, so there has
/// to be one.
fn add_face_normals(obj: &mut Obj, polygons: &[Polygon]) {
    for polygon in polygons {
        if normals::lacks_normals(obj, polygon) {
            let normal = obj.add_face_normal(polygon);
            for corner in &mut obj.corners[polygon.first..polygon.first + polygon.corners] {
                corner[2] = normal;
            }
        }
    }
}

/// The triangles of the polygons. Equal corners share a vertex. A polygon with a corner without a normal has no normals
/// at all, and the renderer then takes those of its triangles.
fn geometry(obj: &Obj, polygons: &[Polygon]) -> Geometry {
    let mut geometry = Geometry::default();
    let mut known: HashMap<Corner, u32> = HashMap::new();
    let mut splitter = Splitter::new();
    let mut outline = Vec::new();
    for polygon in polygons {
        let corners = &obj.corners[polygon.first..polygon.first + polygon.corners];
        let flat = corners.iter().any(|corner| corner[2] == NONE);
        outline.clear();
        outline.extend(corners.iter().map(|corner| obj.positions[corner[0] as usize]));
        for &corner in splitter.split(&outline) {
            let mut corner = corners[corner as usize];
            if flat {
                corner[2] = NONE;
            }
            let vertex = *known.entry(corner).or_insert_with(|| {
                geometry.positions.push(obj.positions[corner[0] as usize]);
                geometry.attributes.push(attribute(obj, corner));
                geometry.positions.len() as u32 - 1
            });
            geometry.indices.push(vertex);
        }
    }
    geometry
}

fn attribute(obj: &Obj, [position, uv, normal]: Corner) -> Attribute {
    let [u, v] = obj.uvs.get(uv as usize).copied().unwrap_or([0.0, 1.0]);
    Attribute {
        normal: obj.normals.get(normal as usize).copied().unwrap_or_default(),
        uv: [u, 1.0 - v],
        color: obj
            .colors
            .get(position as usize)
            .map_or(Attribute::WHITE, |&[r, g, b]| Attribute::pack_color([r, g, b, 1.0])),
    }
}
