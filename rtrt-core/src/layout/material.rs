//! Materials and textures.

use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// The largest channel of a material's base color and highlight: 2¹⁶.
pub const COLOR_LIMIT: f32 = 65_536.0;

/// The largest channel of what gives light: of lights, emissions, ambient light and backgrounds,
/// 2⁴⁸. With it, [`COLOR_LIMIT`] and 1,024 lights no color overflows, however near a light is:
/// ```text
/// 2⁴⁸ · 2⁴⁰ (falloff) · 1025 (lobe) · 1024 (lights) · 3 · 2¹⁶ (highlight) < 2¹²⁷
/// ```
pub const LIGHT_LIMIT: f32 = 281_474_976_710_656.0;

/// What happens to texture coordinates outside 0 ..= 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Wrap {
    /// The texture repeats.
    #[default]
    Repeat = 0,
    /// The edge goes on.
    Clamp = 1,
    /// The texture repeats, every other time mirrored.
    Mirror = 2,
}

/// What a surface's alpha does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum AlphaKind {
    /// Nothing.
    #[default]
    Opaque = 0,
    /// The surface is there where alpha is not below a cutoff, and opaque; elsewhere it is not.
    Mask = 1,
    /// So much of the surface covers what is behind it.
    Blend = 2,
}

/// Where a texture's mip chain lies in the scene's texels, and how it is laid on a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Texture {
    /// The word that says where the finest level's texels start; those of the coarser levels
    /// follow it.
    pub first: u32,
    /// Columns of the finest level.
    pub width: u32,
    /// Rows of the finest level.
    pub height: u32,
    /// Levels; 0 for no texture (white).
    pub levels: u32,
    /// log₂ of the geometric mean of width and height, each times what `turn` stretches it by.
    pub log_size: f32,
    /// [`Wrap`] of the columns.
    pub wrap_u: u32,
    /// [`Wrap`] of the rows.
    pub wrap_v: u32,
    /// Which of the vertices' sets of texture coordinates is used: 0 or 1.
    pub set: u32,
    /// With `shift`, where a point's texture coordinates are in the texture:
    /// `turn · (u, v) + shift`, two rows.
    pub turn: [[f32; 2]; 2],
    /// See `turn`.
    pub shift: [f32; 2],
}
const _: () = assert!(size_of::<Texture>() == 56 && offset_of!(Texture, turn) == 32);

impl Texture {
    /// No texture.
    pub const NONE: Self = Self {
        first: 0,
        width: 0,
        height: 0,
        levels: 0,
        log_size: 0.0,
        wrap_u: 0,
        wrap_v: 0,
        set: 0,
        turn: [[1.0, 0.0], [0.0, 1.0]],
        shift: [0.0; 2],
    };
}

/// How a surface answers light.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MaterialRecord {
    /// Linear RGB, multiplied with the texture and the vertex color.
    pub base: [f32; 3],
    /// Blinn-Phong exponent, 1 ..= 8192, for a material without a roughness texture.
    pub shininess: f32,
    /// Linear RGB of the highlight where the surface is no metal and not rough.
    pub specular: [f32; 3],
    /// How much of a metal it is, 0 ..= 1, multiplied with the roughness texture's blue.
    pub metallic: f32,
    /// Light of its own, linear RGB, multiplied with the emission texture.
    pub emission: [f32; 3],
    /// 0 ..= 1, multiplied with the roughness texture's green.
    pub roughness: f32,
    /// How strongly the normal map turns normals; 1 for as it is.
    pub bump: f32,
    /// How much of the ambient light the occlusion texture may take, 0 ..= 1.
    pub occlusion: f32,
    /// 1 for a surface that shows its base color whatever the light, else 0.
    pub unlit: u32,
    /// 0 ..= 1, multiplied with the alpha of the base color's texture and of the vertex color.
    pub alpha: f32,
    /// [`AlphaKind`].
    pub alpha_mode: u32,
    /// [`AlphaKind::Mask`]: the least alpha of what is there.
    pub cutoff: f32,
    /// 1 for a surface that the camera sees from both sides, 0 for one that it sees only from
    /// where a triangle's corners are counterclockwise, and a sphere from outside. Light knows no
    /// such difference: both cast the same shadows.
    pub double_sided: u32,
    /// [`MaterialRecord::COLOR`] and so on.
    pub textures: [Texture; MaterialRecord::TEXTURES],
}
const _: () =
    assert!(size_of::<MaterialRecord>() == 76 + 5 * 56 && offset_of!(MaterialRecord, textures) == 76);

impl MaterialRecord {
    /// Textures of a material.
    pub const TEXTURES: usize = 5;
    /// The texture of the base color, sRGB.
    pub const COLOR: usize = 0;
    /// The normal map: the normal's coordinates along tangent, bitangent and normal, −1 ..= 1
    /// as 0 ..= 255.
    pub const NORMAL: usize = 1;
    /// The texture of roughness (green) and metalness (blue).
    pub const ROUGHNESS: usize = 2;
    /// The texture of how much ambient light arrives (red).
    pub const OCCLUSION: usize = 3;
    /// The texture of the emission, sRGB.
    pub const EMISSION: usize = 4;
}
