//! Materials, from the named arguments of Python.

use crate::arrays::vector;
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rtrt_core::scene::{AlphaMode, Material, Texture};

/// The properties of a material, in the order of the stub.
const NAMES: [&str; 23] = [
    "base_color",
    "base_color_map",
    "metallic",
    "roughness",
    "metallic_roughness_map",
    "specular",
    "specular_strength",
    "specular_map",
    "specular_color_map",
    "emission",
    "emission_map",
    "normal_map",
    "normal_scale",
    "occlusion_map",
    "occlusion_strength",
    "alpha",
    "alpha_mode",
    "alpha_cutoff",
    "double_sided",
    "unlit",
    "transmission",
    "transmission_map",
    "shadow_catcher",
];

/// The material with these changes; maps are numbers of `textures`.
pub fn changed(
    mut material: Material,
    changes: Option<&Bound<'_, PyDict>>,
    textures: &[Texture],
) -> PyResult<Material> {
    let Some(changes) = changes else { return Ok(material) };
    let (mut mode, mut cutoff) = (None, None);
    for (key, value) in changes {
        let name: String = key.extract()?;
        let wrong = |_| PyTypeError::new_err(format!("{name} cannot be {value}"));
        let number = || value.extract::<f32>().map_err(wrong);
        let truth = || value.extract::<bool>().map_err(wrong);
        let color = || vector::<3>(&name, &value).map(Into::into);
        let map = || {
            let number: Option<i64> = value.extract().map_err(wrong)?;
            let texture = |number: i64| {
                usize::try_from(number).ok().and_then(|number| textures.get(number)).copied().ok_or_else(
                    || {
                        let count = textures.len();
                        PyIndexError::new_err(format!(
                            "{name} is texture {number}, but there are {count} textures"
                        ))
                    },
                )
            };
            number.map(texture).transpose()
        };
        match name.as_str() {
            "base_color" => material.base_color = color()?,
            "base_color_map" => material.base_color_map = map()?,
            "metallic" => material.metallic = number()?,
            "roughness" => material.roughness = number()?,
            "metallic_roughness_map" => material.metallic_roughness_map = map()?,
            "specular" => material.specular = color()?,
            "specular_strength" => material.specular_strength = number()?,
            "specular_map" => material.specular_map = map()?,
            "specular_color_map" => material.specular_color_map = map()?,
            "emission" => material.emission = color()?,
            "emission_map" => material.emission_map = map()?,
            "normal_map" => material.normal_map = map()?,
            "normal_scale" => material.normal_scale = number()?,
            "occlusion_map" => material.occlusion_map = map()?,
            "occlusion_strength" => material.occlusion_strength = number()?,
            "alpha" => material.alpha = number()?,
            "alpha_mode" => mode = Some(value.extract::<String>().map_err(wrong)?),
            "alpha_cutoff" => cutoff = Some(number()?),
            "double_sided" => material.double_sided = truth()?,
            "unlit" => material.unlit = truth()?,
            "transmission" => material.transmission = number()?,
            "transmission_map" => material.transmission_map = map()?,
            "shadow_catcher" => {
                if truth()? {
                    material = Material::shadow_catcher();
                }
            }
            _ => {
                let known = NAMES.join(", ");
                return Err(PyTypeError::new_err(format!("a material has no {name:?}, but: {known}")));
            }
        }
    }
    if let Some(mode) = mode {
        material.alpha_mode = match mode.as_str() {
            "opaque" => AlphaMode::Opaque,
            "mask" => AlphaMode::Mask { cutoff: cutoff.unwrap_or(0.5) },
            "blend" => AlphaMode::Blend,
            _ => {
                let why = format!("alpha_mode is {mode:?}, and not one of opaque, mask, blend");
                return Err(PyValueError::new_err(why));
            }
        };
    } else if let Some(cutoff) = cutoff {
        material.alpha_mode = AlphaMode::Mask { cutoff };
    }
    Ok(material)
}
