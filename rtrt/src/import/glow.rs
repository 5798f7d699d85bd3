//! Surfaces that glow and light the scene: few, large and flat ones, as lamps in ceilings are.
//!
//! Such a surface becomes a spot light with a radius, so that its shadows are soft:
//!
//! ```text
//! position  = its middle, a little in front of it
//! radius    = √(area / π)
//! intensity = 3/2 · area · emission, candela along its normal, where emission is in nits
//! ```
//!
//! A flat surface of uniform radiance `L` sends `L · area · cos θ` candela, π · L · area lumens in all. A spot light of 90°
//! sends its intensity times cos² θ, 2π/3 times it in all: the factor makes the energy equal, and light along the normal a
//! half brighter. The distance counts from the middle, which is too bright a surface that is nearer than it is wide.

use super::builder::Builder;
use glam::{DMat4, DVec3, DVec4, Vec3};
use rtrt_core::layout::{Instance, LIGHT_LIMIT};
use rtrt_core::scene::{Join, Light, Scene};

/// What the warning says.
const NOT_DRAWN: &str = "the light that glowing surfaces shed";
/// The most triangles of a surface.
const MOST_TRIANGLES: u32 = 64;
/// The most surfaces: of more, none sheds light.
const MOST: usize = 8;
/// The least side of a square of the surface's area, in diagonals of the scene.
const LEAST: f64 = 1.0 / 32.0;
/// The least distance of the scene's middle in front of the surface, in diagonals of the scene: a screen lights nothing of
/// the device that it is a part of.
const LEAST_HEIGHT: f64 = 0.1;
/// The length of the sum of a flat surface's areas as vectors, as a share of the sum of their lengths.
const FLAT: f64 = 0.999;

/// Says that surfaces glow and do not light the scene, if there are such: what moves is not followed by its light.
pub(super) fn warn<J: Join>(builder: &mut Builder<'_, J>) {
    if glowing(&builder.scene).next().is_some() {
        builder.not_drawn.insert(NOT_DRAWN);
    }
}

/// Adds lights for the surfaces of the scene that glow, and says whether others are left.
pub(super) fn add_lights<J: Join>(builder: &mut Builder<'_, J>) {
    let lights = lamps(&builder.scene);
    let glows = glowing(&builder.scene).count();
    if glows > lights.len() {
        builder.not_drawn.insert(NOT_DRAWN);
    }
    lights.into_iter().for_each(|light| builder.scene.add_light(light));
}

/// The instances that glow, with the light of each; none for one with a texture of it.
fn glowing(scene: &Scene) -> impl Iterator<Item = (&Instance, Option<Vec3>, bool)> {
    scene.instances().iter().zip(0..).filter_map(|(instance, number)| {
        let material = scene.material(scene.material_of(scene.instance_index(number)?)?)?;
        let is_plain = material.emission_map.is_none();
        let glows = material.emission != Vec3::ZERO && !material.unlit;
        glows.then_some((instance, is_plain.then_some(material.emission), material.double_sided))
    })
}

/// A light for each surface that glows, if they are few.
fn lamps(scene: &Scene) -> Vec<Light> {
    let Some((low, high)) = scene.extent() else { return vec![] };
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let (middle, diagonal) = ((low + high) * 0.5, (high - low).length_squared().sqrt());
    let lamp = |(instance, emission, double_sided): (&Instance, Option<Vec3>, bool)| {
        lamp(scene, instance, emission?, double_sided, middle, diagonal)
    };
    let lamps: Vec<_> = glowing(scene).filter_map(lamp).collect();
    if lamps.len() > MOST { vec![] } else { lamps }
}

/// The light of a surface; none if it is small or not flat, or if the scene is not in front of it.
fn lamp(
    scene: &Scene,
    instance: &Instance,
    emission: Vec3,
    double_sided: bool,
    scene_middle: DVec3,
    diagonal: f64,
) -> Option<Light> {
    if instance.is_sphere() || instance.triangles > MOST_TRIANGLES {
        return None;
    }
    let [x, y, z] = instance.to_world.map(|row| DVec4::from(row.map(f64::from)));
    let to_world = DMat4::from_cols(x, y, z, DVec4::W).transpose();
    let indices = &scene.mesh_data()[instance.first_index as usize..][..3 * instance.triangles as usize];
    let (mut area, mut vector, mut middle) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for corners in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|corner| {
            let position = scene.positions()[(instance.first_vertex + corners[corner]) as usize];
            to_world.transform_point3(DVec3::from(position.map(f64::from)))
        });
        let twice = (b - a).cross(c - a);
        let own = 0.5 * twice.length_squared().sqrt();
        area += own;
        vector += twice * 0.5;
        middle += (a + b + c) * (own / 3.0);
    }
    let length = vector.length_squared().sqrt();
    if !(area.sqrt() >= LEAST * diagonal && length >= FLAT * area) {
        return None;
    }
    let middle = middle / area;
    // A mirrored mesh shows its other side.
    let normal = vector / length * to_world.determinant().signum();
    let height = (scene_middle - middle).dot(normal);
    let normal = if double_sided && height < 0.0 { -normal } else { normal };
    if height.abs() < LEAST_HEIGHT * diagonal || (scene_middle - middle).dot(normal) < 0.0 {
        return None;
    }
    let color = (emission.as_dvec3() * (1.5 * area)).as_vec3();
    if !(color.min_element() >= 0.0 && color.max_element() <= LIGHT_LIMIT) {
        return None;
    }
    let position = middle + normal * (area.sqrt() * 1e-3);
    let light = Light::spot(position.as_vec3(), normal.as_vec3(), core::f32::consts::FRAC_PI_2);
    Some(light.color(color).inverse_square(true).radius((area / core::f64::consts::PI).sqrt() as f32))
}
