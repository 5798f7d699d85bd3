//! From metallic-roughness to this renderer's shading.

use crate::layout::{Material, Texture};

/// The material with this base color (linear RGB), metalness and roughness (0 ..= 1).
///
/// ```text
/// specular  = 0.04 + (base − 0.04) · metallic, halved by roughness
/// diffuse   = base · (1 − metallic / 2)
/// shininess = 2 / roughness⁴ − 2, within 1 ..= 8192
/// ```
///
/// The exponent is the usual match between Blinn-Phong and a microfacet lobe of width
/// `roughness²` (Walter et al. 2007). A metal keeps half of its diffuse color because
/// there is nothing for it to mirror but the lights.
pub fn phong(
    base: [f32; 3],
    metallic: f32,
    roughness: f32,
    texture: Texture,
    emission: [f32; 3],
) -> Material {
    let (metallic, roughness) = (metallic.clamp(0.0, 1.0), roughness.clamp(0.0, 1.0));
    let width = roughness * roughness;
    Material {
        diffuse: base.map(|b| b * (1.0 - 0.5 * metallic)),
        shininess: (2.0 / (width * width).max(1e-6) - 2.0).clamp(1.0, 8192.0),
        specular: base.map(|b| (0.04 + (b - 0.04) * metallic) * (1.0 - 0.5 * roughness)),
        emission,
        textures: [texture],
    }
}
