//! Materials, from the named arguments of Python.

use crate::arrays::{are_finite, there_are, vector};
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

/// What changes begin with: the material, or another one where they make a shadow catcher, or an ordinary material of it.
fn begun(material: Material, changes: &Bound<'_, PyDict>) -> PyResult<Material> {
    let catches = changes.get_item("shadow_catcher")?.map(|value| {
        value.extract::<bool>().map_err(|_| PyTypeError::new_err(format!("shadow_catcher cannot be {value}")))
    });
    let catches = catches.transpose()?;
    let are_others = changes.len() > usize::from(catches.is_some());
    let is_catcher = material.alpha_mode == AlphaMode::Shadows;
    match catches {
        Some(true) if are_others => Err(PyValueError::new_err(
            "a shadow_catcher shows shadows and nothing else: it takes no other properties",
        )),
        None if is_catcher && are_others => Err(PyValueError::new_err(
            "the material is a shadow_catcher, which has no other properties; shadow_catcher=False makes an ordinary one of it",
        )),
        Some(true) => Ok(Material::shadow_catcher()),
        Some(false) if is_catcher => Ok(Material::default()),
        _ => Ok(material),
    }
}

/// The material with these changes; maps are numbers of `textures`.
pub fn changed(
    material: Material,
    changes: Option<&Bound<'_, PyDict>>,
    textures: &[Texture],
) -> PyResult<Material> {
    let Some(changes) = changes else { return Ok(material) };
    let mut material = begun(material, changes)?;
    let (mut mode, mut cutoff) = (None, None);
    for (key, value) in changes {
        let name: String = key.extract()?;
        let wrong = |_| PyTypeError::new_err(format!("{name} cannot be {value}"));
        let number = || {
            let number: f32 = value.extract().map_err(wrong)?;
            are_finite(&name, &[], &[number]).map(|()| number)
        };
        let truth = || value.extract::<bool>().map_err(wrong);
        let color = || vector::<3>(&name, &value).map(Into::into);
        let map = || {
            let number: Option<i64> = value.extract().map_err(wrong)?;
            let texture = |number: i64| {
                usize::try_from(number).ok().and_then(|number| textures.get(number)).copied().ok_or_else(
                    || {
                        let known = there_are(textures.len(), "texture");
                        PyIndexError::new_err(format!("{name} is texture {number}: {known}"))
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
            "shadow_catcher" => {}
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
