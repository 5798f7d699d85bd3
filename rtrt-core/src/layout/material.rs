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

/// Where a texture's mip chain lies in the scene's texels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Texture {
    /// First texel of the finest level; the coarser ones follow without gaps.
    pub first: u32,
    /// Columns of the finest level.
    pub width: u32,
    /// Rows of the finest level.
    pub height: u32,
    /// Levels; 0 for no texture (white).
    pub levels: u32,
    /// log₂ of the geometric mean of width and height.
    pub log_size: f32,
    /// [`Wrap`] of the columns.
    pub wrap_u: u32,
    /// [`Wrap`] of the rows.
    pub wrap_v: u32,
}
const _: () = assert!(size_of::<Texture>() == 28);

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
    /// The texture of the diffuse color.
    pub texture: Texture,
    /// Light of its own, linear RGB.
    pub emission: [f32; 3],
}
const _: () = assert!(size_of::<Material>() == 68 && offset_of!(Material, texture) == 28);
