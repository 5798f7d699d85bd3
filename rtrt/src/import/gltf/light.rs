//! Lights: KHR_lights_punctual.

use crate::import::builder::Builder;
use glam::{DMat4, DVec3, Vec3};
use gltf_json::extensions::scene::khr_lights_punctual::{Light as Source, Type};
use gltf_json::validation::Checked;
use rtrt_core::scene::{Join, Light, LightKind, Scene, Setup};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// Adds a light of the file where its node is: in candela (point, spot) or lux (sun), before
/// [`expose`].
pub(super) fn add<J: Join>(builder: &mut Builder<'_, J>, source: &Source, to_world: &DMat4) {
    let color = Vec3::from(source.color) * source.intensity;
    let position = to_world.w_axis.truncate().as_vec3();
    let direction = -to_world.z_axis.truncate().as_vec3();
    let reach = source.range.filter(|reach| reach.is_finite() && *reach > 0.0);
    let usable = color.is_finite() && color.min_element() >= 0.0 && position.is_finite();
    if builder.scene.lights().len() == Setup::MAX_LIGHTS {
        return builder.warn(format!("only the first {} lights are drawn", Setup::MAX_LIGHTS));
    }
    let light = match source.type_ {
        Checked::Valid(Type::Directional) => Light::sun(direction).color(color),
        Checked::Valid(Type::Point) => Light::point(position).color(color).reach(reach).inverse_square(true),
        Checked::Valid(Type::Spot) => {
            let (inner, outer) = source
                .spot
                .as_ref()
                .map_or((0.0, FRAC_PI_4), |spot| (spot.inner_cone_angle, spot.outer_cone_angle));
            // The limits of the format. An outer angle of 0 has no light.
            let outer = if outer > 0.0 { outer.clamp(1e-3, FRAC_PI_2) } else { FRAC_PI_4 };
            let inner = if inner > 0.0 { inner.min(outer) } else { 0.0 };
            Light::spot(position, direction, outer)
                .color(color)
                .reach(reach)
                .inverse_square(true)
                .inner(inner)
        }
        Checked::Invalid => return builder.warn("a light of an unknown type is left out".into()),
    };
    if !usable || direction.length_squared() == 0.0 || !direction.is_finite() {
        return builder.warn("a light is left out: its color or its node's transform is not usable".into());
    }
    builder.scene.add_light(light);
}

/// Exposes the lights: scales all of them by one factor, so that the strongest one has an incoming light of
/// 1 in the center of the scene. A white surface is then white.
///
/// ```text
/// sun    arrives as   color
/// point  arrives as   color / max(distance to the middle, diagonal of the bounds / 4)²
/// spot   likewise, wherever it points
/// ```
///
/// Files give lights in candela and lux, from a few (a lamp written by hand) to a hundred thousand
/// (daylight). An 8-bit picture does not have that range, and files have no exposure. The factor
/// also contains the 1/π between illuminance and reflected light, which this renderer omits.
pub(super) fn expose(scene: &mut Scene) {
    let Some((low, high)) = scene.extent() else { return };
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let middle = (low + high) * 0.5;
    let nearest = (high - low).length_squared() / 16.0;
    let arriving = |light: &Light| {
        let strength = f64::from(light.color.max_element());
        let squared: f64 = (light.position.as_dvec3() - middle as DVec3).length_squared();
        if light.kind == LightKind::Sun { strength } else { strength / squared.max(nearest) }
    };
    let strongest = scene.lights().iter().map(arriving).fold(0.0, f64::max);
    if !(strongest > 0.0 && strongest.is_finite()) {
        return;
    }
    for light in scene.lights_mut() {
        light.color = (light.color.as_dvec3() / strongest).as_vec3();
    }
}
