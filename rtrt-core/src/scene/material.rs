//! From metallic-roughness to this renderer's shading.

use crate::kernel::reflect::shininess;
use crate::layout::{AlphaMode, Material, Texture};

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
        textures: [texture, Texture::NONE, Texture::NONE, Texture::NONE, Texture::NONE],
    }
}
