//! Shade: the color that a ray brings back.

use crate::kernel::texture::sample;
use crate::layout::{Frame, Lit, Material, Surface};
use crate::num::flush;
use crate::stage::surface::channel;

/// Linear RGB and alpha of what a ray has found:
///
/// ```text
/// base · (ambient + diffuse light) + specular · specular light + emission
/// base = material · texture · vertex color
/// ```
///
/// or the background where it found nothing. Alpha is 1: every surface is opaque.
#[inline(always)]
pub fn shade(
    frame: &Frame,
    materials: &[Material],
    texels: &[u32],
    surface: &Surface,
    lit: &Lit,
) -> [f32; 4] {
    if surface.material == 0 {
        return [frame.background_r, frame.background_g, frame.background_b, 1.0];
    }
    let material = &materials[surface.material as usize - 1];
    let texture = sample(texels, &material.texture, surface.uv, surface.footprint);
    let ambient = [frame.ambient_r, frame.ambient_g, frame.ambient_b];
    let color = |i: usize| {
        let base = material.diffuse[i] * texture[i] * channel(surface.color, i as u32);
        let diffuse = flush(base * (ambient[i] + lit.diffuse[i]));
        flush(diffuse + flush(material.specular[i] * lit.specular[i]) + material.emission[i])
    };
    [color(0), color(1), color(2), 1.0]
}
