//! Materials and textures.

use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

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
pub struct Material {
    /// Linear RGB, multiplied with the texture and the vertex color.
    pub diffuse: [f32; 3],
    /// Blinn-Phong exponent, 1 ..= 8192.
    pub shininess: f32,
    /// Linear RGB of the highlight.
    pub specular: [f32; 3],
    /// Light of its own, linear RGB.
    pub emission: [f32; 3],
    /// [`Material::COLOR`] and so on.
    pub textures: [Texture; 1],
}
const _: () = assert!(size_of::<Material>() == 40 + 56 && offset_of!(Material, textures) == 40);

impl Material {
    /// The texture of the diffuse color, sRGB.
    pub const COLOR: usize = 0;
}
