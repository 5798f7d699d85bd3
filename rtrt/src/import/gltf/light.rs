//! Lights: KHR_lights_punctual.

use crate::import::builder::Builder;
use glam::{DMat4, Vec3};
use gltf_json::extensions::scene::khr_lights_punctual::{Light as Source, Type};
use gltf_json::validation::Checked;
use rtrt_core::layout::LIGHT_LIMIT;
use rtrt_core::scene::{Join, Light, Setup};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// Adds a light of the file where its node is: in candela (point, spot) or lux (sun).
pub(super) fn add<J: Join>(builder: &mut Builder<'_, J>, source: &Source, to_world: &DMat4) {
    let color = Vec3::from(source.color) * source.intensity;
    let position = to_world.w_axis.truncate().as_vec3();
    let direction = -to_world.z_axis.truncate().as_vec3();
    let reach = source.range.filter(|reach| reach.is_finite() && *reach > 0.0);
    let usable = color.is_finite()
        && (0.0..=LIGHT_LIMIT).contains(&color.min_element())
        && color.max_element() <= LIGHT_LIMIT
        && position.is_finite();
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
