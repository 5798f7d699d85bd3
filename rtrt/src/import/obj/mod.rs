//! OBJ with MTL: one mesh and one object for each material.

mod mtl;
mod parse;
mod polygon;

use crate::import::builder::Builder;
use crate::import::error::quoted;
use crate::import::geometry::{Geometry, pack_color};
use crate::import::{ImportError, NamedCamera, file, picture};
use glam::Mat4;
use parse::{Corner, NONE, Obj, Polygon};
use polygon::Splitter;
use rtrt_core::layout::{Attribute, COLOR_LIMIT, Texture, Wrap};
use rtrt_core::scene::{Join, Material, MaterialIndex};
use std::collections::HashMap;

/// Draws a file into the scene. OBJ has no cameras.
pub(super) fn load<J: Join>(
    builder: &mut Builder<'_, J>,
    bytes: &[u8],
) -> Result<Vec<NamedCamera>, ImportError> {
    let obj = parse::parse(bytes).map_err(|why| builder.invalid(why))?;
    if obj.skipped > 0 {
        builder.warn(format!("{} points, lines or curves are left out", obj.skipped));
    }
    if obj.unresolved > 0 {
        let count = obj.unresolved;
        builder.warn(format!("{count} references to texture coordinates or normals lead nowhere"));
    }
    let sources = libraries(builder, &obj);
    let mut unknown = 0;
    let mut textures = HashMap::new();
    // The polygons before the first `usemtl`, then those of each material.
    let mut groups: Vec<Vec<Polygon>> = vec![Vec::new(); obj.materials.len() + 1];
    for &polygon in &obj.polygons {
        groups[polygon.material.map_or(0, |material| material + 1)].push(polygon);
    }
    for (number, polygons) in groups.into_iter().enumerate().filter(|(_, polygons)| !polygons.is_empty()) {
        let name = number.checked_sub(1).map(|material| &obj.materials[material]);
        let source = name.and_then(|name| sources.get(name));
        unknown += usize::from(name.is_some() && source.is_none());
        let material = material(builder, source, &mut textures)?;
        let name = name.map_or("the polygons without a material".into(), |name| quoted(name));
        let mesh = builder.add_mesh(&name, geometry(&obj, &polygons))?;
        builder.add_instance(&name, mesh, material, Mat4::IDENTITY)?;
    }
    if unknown > 0 {
        builder.warn(format!("{unknown} materials are in no material library; they are drawn gray"));
    }
    Ok(Vec::new())
}

/// The materials of all libraries, by name; of two with the same name the first.
fn libraries<J: Join>(builder: &mut Builder<'_, J>, obj: &Obj) -> HashMap<String, mtl::Source> {
    let mut materials = HashMap::new();
    for name in &obj.libraries {
        match builder.files.read(&file::beside(&builder.path, name), file::LONGEST) {
            Ok(bytes) => {
                for source in mtl::parse(&bytes) {
                    materials.entry(source.name.clone()).or_insert(source);
                }
            }
            Err(error) => builder.warn(format!("material library {}: {error}", quoted(name))),
        }
    }
    materials
}

/// A material of the scene; gray and dull without a source.
///
/// MTL's highlight has the brightness `Ks` at its peak, ours grows with its sharpness: the
/// factor `8 / (Ns + 8)` makes the peaks equal.
fn material<J: Join>(
    builder: &mut Builder<'_, J>,
    source: Option<&mtl::Source>,
    textures: &mut HashMap<String, Texture>,
) -> Result<MaterialIndex, ImportError> {
    let Some(source) = source else {
        return builder.add_material(Material::new([0.7; 3]).roughness(0.8));
    };
    let texture = match &source.texture {
        None => None,
        Some(name) => match textures.get(name) {
            Some(&texture) => Some(texture),
            None => {
                let place = file::beside(&builder.path, name);
                let bytes = builder.files.read(&place, file::LONGEST).map_err(|error| error.to_string());
                let texture = builder.add_texture(&quoted(name), bytes.and_then(|b| picture::decode(&b)))?;
                textures.insert(name.clone(), texture);
                Some(texture)
            }
        },
    };
    let wrap = if source.clamp { Wrap::Clamp } else { Wrap::Repeat } as u32;
    let peak = 8.0 / (source.shininess + 8.0);
    // The inverse of what a roughness makes of highlights.
    let roughness = libm::sqrtf(libm::sqrtf(2.0 / (source.shininess + 2.0)));
    let texture = texture.map(|texture| Texture { wrap_u: wrap, wrap_v: wrap, ..texture });
    let specular = source.specular.map(|s| (s * peak / (1.0 - 0.5 * roughness)).min(COLOR_LIMIT));
    let material = Material::new(source.diffuse)
        .base_color_map(texture)
        .roughness(roughness)
        .specular(specular, source.shininess)
        .emission(source.emission);
    builder.add_material(if source.alpha < 1.0 { material.blend(source.alpha) } else { material })
}

/// The triangles of the polygons. Corners that are alike are one vertex. A polygon with a
/// normal missing has none at all, and is then drawn flat.
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
        color: obj.colors.get(position as usize).map_or(!0, |&[r, g, b]| pack_color([r, g, b, 1.0])),
    }
}
