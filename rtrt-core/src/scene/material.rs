//! From metallic-roughness to this renderer's shading.

use crate::kernel::reflect::shininess;
use crate::layout::{AlphaMode, COLOR_LIMIT, LIGHT_LIMIT, Material, Texture};
use crate::scene::SceneError;
use crate::scene::floor::floored;
use core::slice;

/// The light that a surface that is no metal mirrors head-on.
const DIELECTRIC: f32 = 0.04;

/// The material with this base color (linear RGB), metalness and roughness (0 ..= 1).
///
/// ```text
/// highlight = (0.04 + (base − 0.04) · metallic) · (1 − roughness / 2)
/// diffuse   = base · (1 − metallic / 2)
/// shininess = 2 / roughness⁴ − 2, within 1 ..= 8192
/// ```
///
/// The exponent is the usual match between Blinn-Phong and a microfacet lobe of width
/// `roughness²` (Walter et al. 2007). A metal keeps half of its diffuse color because
/// without an environment there is nothing for it to mirror but the lights. Textures multiply
/// base color, metalness and roughness before this is computed, for each ray (see
/// [`crate::stage::shade`]).
pub fn phong(
    base: [f32; 3],
    metallic: f32,
    roughness: f32,
    texture: Texture,
    emission: [f32; 3],
) -> Material {
    let (metallic, roughness) = (metallic.clamp(0.0, 1.0), roughness.clamp(0.0, 1.0));
    Material {
        base,
        shininess: shininess(roughness),
        specular: [DIELECTRIC; 3],
        metallic,
        emission,
        roughness,
        bump: 1.0,
        occlusion: 1.0,
        unlit: 0,
        alpha: 1.0,
        alpha_mode: AlphaMode::Opaque as u32,
        cutoff: 0.5,
        double_sided: 1,
        textures: [texture, Texture::NONE, Texture::NONE, Texture::NONE, Texture::NONE],
    }
}

/// The material as a scene holds it: numbers too small to count are 0.
///
/// # Errors
/// A number is not finite, or out of its range.
pub(super) fn checked(mut material: Material) -> Result<Material, SceneError> {
    let m = &mut material;
    m.double_sided = u32::from(m.double_sided != 0);
    within("base color", &mut m.base, -COLOR_LIMIT, COLOR_LIMIT)?;
    within("highlight", &mut m.specular, -COLOR_LIMIT, COLOR_LIMIT)?;
    within("emission", &mut m.emission, -LIGHT_LIMIT, LIGHT_LIMIT)?;
    for (what, value, low, high) in [
        ("exponent", &mut m.shininess, 0.0, 8192.0),
        ("metalness", &mut m.metallic, 0.0, 1.0),
        ("roughness", &mut m.roughness, 0.0, 1.0),
        ("strength of occlusion", &mut m.occlusion, 0.0, 1.0),
        ("strength of the normal map", &mut m.bump, -COLOR_LIMIT, COLOR_LIMIT),
        ("alpha", &mut m.alpha, 0.0, COLOR_LIMIT),
        ("cutoff", &mut m.cutoff, -COLOR_LIMIT, COLOR_LIMIT),
    ] {
        within(what, slice::from_mut(value), low, high)?;
    }
    for texture in &m.textures {
        let [u, v] = texture.turn;
        let mut numbers = [u[0], u[1], v[0], v[1], texture.shift[0], texture.shift[1], texture.log_size];
        within("placing of a texture", &mut numbers, f32::MIN, f32::MAX)?;
    }
    Ok(material)
}

/// Makes 0 of what is too small to count.
///
/// # Errors
/// A number is out of range, as NaN always is.
fn within(what: &'static str, values: &mut [f32], low: f32, high: f32) -> Result<(), SceneError> {
    for value in values {
        if !(low..=high).contains(value) {
            return Err(SceneError::Material { what, value: *value, low, high });
        }
        *value = floored(*value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_one_and_within_its_range() {
        let usual = phong([0.5; 3], 0.5, 0.5, Texture::NONE, [1.0; 3]);
        assert_eq!(checked(usual), Ok(usual));
        let fields: [fn(&mut Material) -> &mut f32; 14] = [
            |m| &mut m.base[0],
            |m| &mut m.base[2],
            |m| &mut m.specular[1],
            |m| &mut m.emission[0],
            |m| &mut m.shininess,
            |m| &mut m.metallic,
            |m| &mut m.roughness,
            |m| &mut m.occlusion,
            |m| &mut m.bump,
            |m| &mut m.alpha,
            |m| &mut m.cutoff,
            |m| &mut m.textures[3].turn[1][0],
            |m| &mut m.textures[4].shift[1],
            |m| &mut m.textures[0].log_size,
        ];
        for (number, field) in fields.into_iter().enumerate() {
            // Of where textures lie, only what is no number is refused.
            let large = if number < 11 { 1e30 } else { f32::NAN };
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, large] {
                let mut wrong = usual;
                *field(&mut wrong) = bad;
                assert!(matches!(checked(wrong), Err(SceneError::Material { .. })), "{number}: {bad}");
            }
        }
        let bright = Material { base: [COLOR_LIMIT; 3], emission: [LIGHT_LIMIT; 3], ..usual };
        assert_eq!(checked(bright), Ok(bright));
    }
}
