//! Where a texture lies on a surface.

use rtrt_core::layout::Texture;

/// The offset, rotation and scale of texture coordinates, `v` pointing down.
///
/// ```text
/// place in the texture = offset + rotation · (scale · (u, v))
/// ```
///
/// This is KHR_texture_transform's order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    pub offset: [f32; 2],
    /// Radians.
    pub rotation: f32,
    pub scale: [f32; 2],
}

impl Placement {
    /// The texture, placed. Numbers that are not finite count as 0.
    pub fn apply(&self, texture: Texture) -> Texture {
        let finite = |number: f32| if number.is_finite() { number } else { 0.0 };
        let [u, v] = self.scale.map(finite);
        let (sin, cos) = libm::sincosf(finite(self.rotation));
        // The footprint of a pixel grows with the density of texels on the surface.
        let area = (u * v).abs().min(f32::MAX);
        let log_density = if area > 1e-12 { 0.5 * libm::log2f(area) } else { 0.0 };
        Texture {
            turn: [[cos * u, sin * v], [-sin * u, cos * v]],
            shift: self.offset.map(finite),
            log_size: texture.log_size + log_density,
            ..texture
        }
    }
}
