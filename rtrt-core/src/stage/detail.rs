//! Detail: a second set of texture coordinates, normals from textures, normals of coats and tangents of brushed
//! surfaces, where a material has them.
//!
//! Runs after `surface`, and only in frames of scenes that have such materials
//! ([`Frame::details`](crate::layout::Frame)). A normal is needed before light; all other textures are
//! read after it. `surface` itself would bind more than 8 buffers with textures. Tangents take one word
//! a vertex, stored only for meshes that need them.

use crate::kernel::closest_hit::{ClosestHit, ClosestHitRows};
use crate::kernel::interpolate::Weights;
use crate::kernel::tangent::{bumped, direction, pack_direction, unpack};
use crate::kernel::texture::{Maps, MaterialField, MaterialLookup, sample};
use crate::kernel::variance::of_map;
use crate::lane::{Bits, Lane, Mask, Select, V3};
use crate::layout::{Frame, Instance, MaterialRecord, NONE};
use crate::num::{FLOOR, flush, flush3, normalize, recip, sqrt};
use crate::stage::surface::{Identity, OfInstance, Space, Surfaces, Vertices, triangles};

/// The surfaces with normal maps and second texture coordinates applied.
#[inline(always)]
pub fn detail<L: Lane>(
    frame: &Frame,
    maps: &Maps<'_>,
    vertices: &Vertices<'_>,
    best: &ClosestHit<L>,
    surfaces: &Surfaces<L>,
) -> Surfaces<L> {
    let none = surfaces.material.broadcast(0);
    if !surfaces.material.gt(none).any() {
        return *surfaces;
    }
    let second = with_second_set(vertices, best, surfaces);
    relief(frame, maps, vertices, best, &second)
}

/// The surfaces with their second set of texture coordinates, where their meshes have one.
///
/// The footprint is that of the first set, times how much larger the triangle is in the
/// second: the square root of the areas' ratio.
#[inline(always)]
fn with_second_set<L: Lane>(
    vertices: &Vertices<'_>,
    best: &ClosestHit<L>,
    surfaces: &Surfaces<L>,
) -> Surfaces<L> {
    let token = surfaces.footprint.token();
    let found = best.rows();
    let first = vertices.of_instances::<L, SecondUv>(token, best.instance, &found);
    let has = first.gt(first.broadcast(0));
    if !has.any() {
        return *surfaces;
    }
    let [[sa, ta, sb, tb], [sc, tc, area, _]] = triangles(best, &found, has).gather(
        #[inline(always)]
        |lane| second_set(vertices, &found, lane),
    );
    let zero = surfaces.footprint.broadcast(0.0);
    let weights = Weights::new(best.u, best.v);
    let second_area = ((sb - sa) * (tc - ta) - (sc - sa) * (tb - ta)).abs();
    let footprint = surfaces.footprint * sqrt(second_area * recip(area.abs()));
    let footprint = area.abs().gt(zero.broadcast(FLOOR)).select(footprint, zero);
    Surfaces {
        second_uv: [
            has.select(flush(weights.mix(sa, sb, sc)), zero),
            has.select(flush(weights.mix(ta, tb, tc)), zero),
        ],
        second_footprint: has.select(flush(footprint), zero),
        ..*surfaces
    }
}

/// Where the second texture coordinates start.
struct SecondUv;

impl OfInstance for SecondUv {
    const NONE: u32 = 0;
    #[inline(always)]
    fn of(instance: &Instance) -> u32 {
        instance.first_second_uv
    }
}

/// The second texture coordinates of the corners of one lane's triangle, and twice its area
/// in the first ones.
#[inline(always)]
fn second_set<L: Lane>(vertices: &Vertices<'_>, found: &ClosestHitRows<L>, lane: usize) -> [[f32; 4]; 2] {
    let index = found.instance(lane);
    if index == NONE {
        return [[0.0; 4]; 2];
    }
    let instance = &vertices.instances[index as usize];
    if instance.first_second_uv == 0 {
        return [[0.0; 4]; 2];
    }
    let [a, b, c] = instance.corners(vertices.mesh_data, found.triangle(lane));
    let (p, q, r) = (
        &vertices.attributes[a as usize].uv,
        &vertices.attributes[b as usize].uv,
        &vertices.attributes[c as usize].uv,
    );
    let area = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
    // Two words a vertex, counted from the mesh's first.
    let at = instance.first_second_uv;
    let (a, b, c) = (
        at + 2 * (a - instance.first_vertex),
        at + 2 * (b - instance.first_vertex),
        at + 2 * (c - instance.first_vertex),
    );
    let number = |word: u32| f32::from_bits(vertices.mesh_data[word as usize]);
    [[number(a), number(a + 1), number(b), number(b + 1)], [number(c), number(c + 1), area, 0.0]]
}

/// What asks for tangents: normal maps, with their scales, and brushed surfaces, with their direction.
struct Bumps;

impl MaterialField<7> for Bumps {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 7] {
        let levels = |map: usize| material.textures[map].levels as f32;
        let [cosine, sine] = material.brushed_turn;
        let brushed = (material.extensions & MaterialRecord::IS_BRUSHED) as f32;
        let (normal, coat) = (levels(MaterialRecord::NORMAL), levels(MaterialRecord::COAT_NORMAL));
        [normal, material.bump, coat, material.coat_bump, brushed, cosine, sine]
    }
}

/// The surfaces whose normals are turned by the normal maps of the materials that have one (see [`bumped`]), and
/// vary by the maps' part, too; with the normals of coats, and the directions of brushed surfaces.
#[inline(always)]
fn relief<L: Lane>(
    frame: &Frame,
    maps: &Maps<'_>,
    vertices: &Vertices<'_>,
    best: &ClosestHit<L>,
    surfaces: &Surfaces<L>,
) -> Surfaces<L> {
    let token = surfaces.footprint.token();
    let zero = surfaces.footprint.broadcast(0.0);
    let has_coats = frame.has(MaterialRecord::HAS_COAT);
    let is_brushed = frame.has(MaterialRecord::IS_BRUSHED);
    let mut found_surfaces = *surfaces;
    if has_coats {
        let none = surfaces.material.broadcast(0);
        let found = surfaces.material.gt(none);
        found_surfaces.coat_normal = found.select(pack_direction(surfaces.normal), none);
    }
    let chosen = MaterialLookup::new(surfaces.material);
    let [levels, scale, coat_levels, coat_scale, brushed, cosine, sine]: [L; 7] =
        chosen.numbers::<Bumps, 7>(token, maps);
    let (is_bumped, is_coat_bumped, brushed) = (levels.gt(zero), coat_levels.gt(zero), brushed.gt(zero));
    let wanted = is_bumped | is_coat_bumped | brushed;
    if !wanted.any() {
        return found_surfaces;
    }
    let found = best.rows();
    let [[nax, nay, naz, sa], [nbx, nby, nbz, ta], [ncx, ncy, ncz, sb], [tb, sc, tc, sign]] =
        triangles(best, &found, wanted).gather(
            #[inline(always)]
            |lane| corners(vertices, &found, lane),
        );
    let has = wanted & sign.abs().gt(zero);
    if !has.any() {
        return found_surfaces;
    }
    let weights = Weights::new(best.u, best.v);
    let vertex_normal = weights.mix3(
        V3 { x: nax, y: nay, z: naz },
        V3 { x: nbx, y: nby, z: nbz },
        V3 { x: ncx, y: ncy, z: ncz },
    );
    let along = weights.mix3(direction(sa, ta), direction(sb, tb), direction(sc, tc));
    // In the object's space, so that a mirrored instance has a mirrored relief.
    let up = vertex_normal.cross(along).scale(sign);
    let none = surfaces.material.broadcast(0);
    let identity = vertices.of_instances::<L, Identity>(token, best.instance, &found);
    let (vertex_normal, along, up) = if identity.eq(none).any() {
        let space = Space::of(vertices, zero, best.instance, &found);
        (space.normal(vertex_normal), space.vector(along), space.vector(up))
    } else {
        (vertex_normal, along, up)
    };
    let behind = vertex_normal.dot(surfaces.normal).lt(zero);
    let tex_coords = surfaces.tex_coords();
    let bumps = has & is_bumped;
    if bumps.any() {
        let [x, y, z, deviation] = sample::<L, { MaterialRecord::NORMAL }, false>(maps, &chosen, &tex_coords);
        let map = [(x * 2.0 - 1.0) * scale, (y * 2.0 - 1.0) * scale, z * 2.0 - 1.0];
        let turned = flush3(bumped(surfaces.normal, along, up, behind, map));
        found_surfaces.normal = V3::select(bumps, turned, surfaces.normal);
        let variance = surfaces.variance + of_map(deviation, scale);
        found_surfaces.variance = bumps.select(variance, surfaces.variance);
    }
    if has_coats {
        let bumps = has & is_coat_bumped;
        let [x, y, z, _] = sample::<L, { MaterialRecord::COAT_NORMAL }, false>(maps, &chosen, &tex_coords);
        let map = [(x * 2.0 - 1.0) * coat_scale, (y * 2.0 - 1.0) * coat_scale, z * 2.0 - 1.0];
        let turned = bumped(surfaces.normal, along, up, behind, map);
        found_surfaces.coat_normal = bumps.select(pack_direction(turned), found_surfaces.coat_normal);
    }
    if is_brushed {
        let [x, y, ..] = sample::<L, { MaterialRecord::BRUSHED }, false>(maps, &chosen, &tex_coords);
        // White without a texture: the tangent itself.
        let levels = chosen.numbers::<BrushedLevels, 1>(token, maps);
        let has_map = levels[0].gt(zero);
        let (x, y) = (has_map.select(x * 2.0 - 1.0, x), has_map.select(y * 2.0 - 1.0, zero));
        let turned =
            normalize(along).scale(x * cosine - y * sine) + normalize(up).scale(x * sine + y * cosine);
        found_surfaces.tangent = (has & brushed).select(pack_direction(turned), found_surfaces.tangent);
    }
    found_surfaces
}

/// Whether a brushed surface has a texture of its direction.
struct BrushedLevels;

impl MaterialField<1> for BrushedLevels {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 1] {
        [material.textures[MaterialRecord::BRUSHED].levels as f32]
    }
}

/// The normals of the corners of one lane's triangle, object space, beside and before two
/// coordinates of each of their tangents, and the sign of the bitangent; all 0 where there are no tangents.
#[inline(always)]
fn corners<L: Lane>(vertices: &Vertices<'_>, found: &ClosestHitRows<L>, lane: usize) -> [[f32; 4]; 4] {
    let index = found.instance(lane);
    if index == NONE {
        return [[0.0; 4]; 4];
    }
    let instance = &vertices.instances[index as usize];
    if instance.first_tangent == 0 {
        return [[0.0; 4]; 4];
    }
    let [a, b, c] = instance.corners(vertices.mesh_data, found.triangle(lane));
    // Tangents are counted from the mesh's first vertex, wrapping.
    let base = instance.first_tangent.wrapping_sub(instance.first_vertex);
    let t = unpack(vertices.mesh_data[base.wrapping_add(a) as usize]);
    let u = unpack(vertices.mesh_data[base.wrapping_add(b) as usize]);
    let v = unpack(vertices.mesh_data[base.wrapping_add(c) as usize]);
    let attributes = vertices.attributes;
    let (a, b, c) =
        (&attributes[a as usize].normal, &attributes[b as usize].normal, &attributes[c as usize].normal);
    [[a[0], a[1], a[2], t[0]], [b[0], b[1], b[2], t[1]], [c[0], c[1], c[2], u[0]], [u[1], v[0], v[1], t[2]]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::RayIndex;
    use crate::layout::{Attribute, Surface, Wrap};
    use crate::scene::{Bvh, Content, Image, Material, Mesh, Scene, Sequential};
    use crate::stage::fixture::{Prepared, closest, surfaces};
    use std::vec;

    /// The surface at x = 0.5 and y = 0.5 of a square from −4 to 4 whose second texture coordinates are
    /// three times its first, with a normal map of this color on the second.
    fn detailed(rgb: [u8; 3]) -> [Surface; 2] {
        let corners = [[-4.0, -4.0, 0.0], [4.0, -4.0, 0.0], [4.0, 4.0, 0.0], [-4.0, 4.0, 0.0]];
        let uv = corners.map(|[x, y, _]: [f32; 3]| [x * 0.125, y * -0.125]);
        let attributes = uv.map(|uv| Attribute { normal: [0.0, 0.0, 1.0], uv, color: Attribute::WHITE });
        let mesh = Mesh::new(corners.to_vec(), attributes.to_vec(), vec![0, 1, 2, 0, 2, 3]).unwrap();
        let mesh = mesh.with_second_uv(uv.map(|uv| uv.map(|c| c * 3.0)).to_vec()).unwrap();
        let mesh = mesh.with_made_tangents(true);
        let mut scene = Scene::new();
        let rgba = [rgb[0], rgb[1], rgb[2], 255].repeat(16);
        let map =
            scene.add_map(&Image { width: 4, height: 4, rgba }, [Wrap::Repeat; 2], Content::Numbers).unwrap();
        let map = crate::layout::Texture { set: 1, ..map };
        let material = scene.add_material(Material::default().normal_map(map, 1.0)).unwrap();
        let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
        scene.add_instance(mesh, material, glam::Mat4::IDENTITY).unwrap();
        let prepared = Prepared::new(scene, |request| request);
        assert_eq!(prepared.frame().details, 1);
        let (context, scene) = (prepared.context(), &prepared.scene);
        let ray: RayIndex = context.frame.grid().index([8, 7]);
        let ([closest], [plain]) = (closest::<f32, 1>(&prepared, ray), surfaces::<f32, 1>(&prepared, ray));
        let maps = Maps { materials: scene.materials(), texels: scene.texels() };
        let (instances, mesh_data) = (context.geometry.instances, scene.mesh_data());
        let vertices = Vertices { instances, mesh_data, attributes: scene.attributes() };
        [plain, detail(context.frame, &maps, &vertices, &closest, &plain)].map(|surfaces| surfaces.lane(0))
    }

    #[test]
    fn a_second_set_has_its_own_coordinates_and_footprint() {
        let [plain, detailed] = detailed([128, 128, 255]);
        assert_eq!((plain.second_uv, plain.second_footprint), ([0.0; 2], 0.0));
        let [u, v] = detailed.second_uv;
        assert!((u - 0.1875).abs() < 1e-6 && (v + 0.1875).abs() < 1e-6, "{u} {v}");
        assert!((detailed.second_footprint - 3.0 * plain.footprint).abs() < 1e-5);
        assert_eq!(
            (plain.origin, plain.uv, plain.footprint),
            (detailed.origin, detailed.uv, detailed.footprint)
        );
    }

    #[test]
    fn a_normal_map_turns_the_normal_along_its_columns_and_rows() {
        let near = |rgb, expected: [f32; 3]| {
            let normal = detailed(rgb)[1].normal;
            assert!(normal.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.01), "{rgb:?}: {normal:?}");
        };
        near([128, 128, 255], [0.0, 0.0, 1.0]);
        // (0.6, 0, 0.8) and (0, 0.6, 0.8); rows of a map run down, its second coordinate up.
        near([204, 128, 230], [0.6, 0.0, 0.8]);
        near([128, 204, 230], [0.0, 0.6, 0.8]);
    }
}
