//! Materials and textures.

use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// The largest channel of a material's base color and highlight: 2¹⁶.
pub const COLOR_LIMIT: f32 = 65_536.0;

/// The largest channel of lights, emissions, ambient light and backgrounds: 2⁴⁸. With it, [`COLOR_LIMIT`] and 1,024 lights no color overflows, however near a light is:
/// ```text
/// 2⁴⁸ · 2⁴⁰ (falloff) · 1025 (lobe) · 1024 (lights) · 3 · 2¹⁶ (highlight) < 2¹²⁷
/// ```
pub const LIGHT_LIMIT: f32 = 281_474_976_710_656.0;

/// The treatment of texture coordinates outside 0 ..= 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Wrap {
    /// The texture repeats.
    #[default]
    Repeat = 0,
    /// The edge texels continue.
    Clamp = 1,
    /// The texture repeats, every other time mirrored.
    Mirror = 2,
}

/// Where a texture shows its nearest texel instead of a mix of four. Mip levels are mixed in each case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Filter {
    /// Nowhere.
    #[default]
    Linear = 0,
    /// Where texels are larger than pixels.
    NearestMagnified = 1,
    /// Everywhere.
    Nearest = 2,
    /// Where texels are smaller than pixels.
    NearestMinified = 3,
}

/// The meaning of a surface's alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum AlphaKind {
    /// Nothing.
    #[default]
    Opaque = 0,
    /// The surface is opaque where alpha is at least the cutoff, and has a hole elsewhere.
    Mask = 1,
    /// Alpha is the share of the background that the surface covers.
    Blend = 2,
}

/// The place of a texture's mip chain in the scene's texels, and its mapping to a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Texture {
    /// The word that holds the start of the finest level's texels. Those of coarser levels follow it.
    pub first: u32,
    /// Columns of the finest level.
    pub width: u32,
    /// Rows of the finest level.
    pub height: u32,
    /// Levels; 0 for no texture (white).
    pub levels: u32,
    /// log₂ of the geometric mean of width and height, each times the stretch of `turn`.
    pub log_size: f32,
    /// [`Wrap`] of the columns.
    pub wrap_u: u32,
    /// [`Wrap`] of the rows.
    pub wrap_v: u32,
    /// Which of the vertices' sets of texture coordinates is used: 0 or 1.
    pub set: u32,
    /// [`Filter`].
    pub filter: u32,
    /// The linear part of the map from texture coordinates to the texture, two rows:
    /// `turn · (u, v) + shift`.
    pub turn: [[f32; 2]; 2],
    /// See `turn`.
    pub shift: [f32; 2],
}
const _: () = assert!(size_of::<Texture>() == 60 && offset_of!(Texture, turn) == 36);

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
        filter: 0,
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
    /// How strongly it mirrors light where it is no metal, 0 ..= 1: the share that it mirrors at grazing angles.
    pub strength: f32,
    /// Linear RGB that it mirrors head-on where it is no metal, each 0 ..= 1, times `strength`.
    pub specular: [f32; 3],
    /// Metalness, 0 ..= 1, multiplied with the roughness texture's blue.
    pub metallic: f32,
    /// Light of its own, linear RGB, multiplied with the emission texture.
    pub emission: [f32; 3],
    /// 0 ..= 1, multiplied with the roughness texture's green.
    pub roughness: f32,
    /// The scale of the normal map; 1 leaves it unchanged.
    pub bump: f32,
    /// The strength of the occlusion texture, 0 ..= 1; 0 without one.
    pub occlusion: f32,
    /// 1 for a surface that shows its base color whatever the light, [`MaterialRecord::CATCHES_SHADOWS`] for one that shows
    /// shadows and nothing else, 0 for others.
    pub unlit: u32,
    /// 0 ..= 1, multiplied with the alpha of the base color's texture and of the vertex color.
    pub alpha: f32,
    /// [`AlphaKind`].
    pub alpha_mode: u32,
    /// [`AlphaKind::Mask`]: the least alpha that is not a hole.
    pub cutoff: f32,
    /// 1 for a surface that is seen from both sides. 0 culls back faces as the camera sees them, and, for shadows, as
    /// the light does: triangles whose corners are clockwise, and the inside of spheres.
    pub double_sided: u32,
    /// What it has beyond metallic-roughness: the sum of [`MaterialRecord::SPECULAR_MAPS`] and so on.
    pub extensions: u32,
    /// The share of it that a clear coat covers, 0 ..= 1, multiplied with the red of its texture.
    pub coat: f32,
    /// 0 ..= 1, multiplied with the green of its texture.
    pub coat_roughness: f32,
    /// How strongly the normal map of the coat turns its normals.
    pub coat_bump: f32,
    /// Linear RGB of the sheen, multiplied with its texture.
    pub sheen: [f32; 3],
    /// 0 ..= 1, multiplied with the alpha of its texture.
    pub sheen_roughness: f32,
    /// How much rougher it is along a tangent, 0 ..= 1, multiplied with the blue of its texture.
    pub brushed: f32,
    /// Cosine and sine of the angle from the mesh's tangent to that one.
    pub brushed_turn: [f32; 2],
    /// The share of it that a thin film covers, 0 ..= 1, multiplied with the red of its texture.
    pub film: f32,
    /// The film's index of refraction.
    pub film_ior: f32,
    /// Nanometers: where the green of its texture is 0, and where it is 1.
    pub film_thickness: [f32; 2],
    /// The share of light that goes through it in place of being scattered, 0 ..= 1, multiplied with the red of its
    /// texture.
    pub transmission: f32,
    /// The index of refraction of the body that it bounds where light goes through it, at least 1; 1 for a thin pane.
    pub refraction: f32,
    /// [`MaterialRecord::COLOR`] and so on.
    pub textures: [Texture; MaterialRecord::TEXTURES],
}
const _: () =
    assert!(size_of::<MaterialRecord>() == 144 + 16 * 60 && offset_of!(MaterialRecord, textures) == 144);

impl MaterialRecord {
    /// [`MaterialRecord::unlit`] of a surface that shows shadows and nothing else.
    pub const CATCHES_SHADOWS: u32 = 2;
    /// Textures of a material.
    pub const TEXTURES: usize = 16;
    /// The texture of the base color, sRGB.
    pub const COLOR: usize = 0;
    /// The normal map: the normal's coordinates along tangent, bitangent and normal, −1 ..= 1
    /// as 0 ..= 255.
    pub const NORMAL: usize = 1;
    /// The texture of roughness (green) and metalness (blue).
    pub const ROUGHNESS: usize = 2;
    /// The texture of ambient occlusion (red): the share of ambient light that arrives.
    pub const OCCLUSION: usize = 3;
    /// The texture of the emission, sRGB.
    pub const EMISSION: usize = 4;
    /// The texture of the strength of what is mirrored (alpha).
    pub const SPECULAR: usize = 5;
    /// The texture of the color that is mirrored head-on, sRGB.
    pub const SPECULAR_COLOR: usize = 6;
    /// The texture of the share that a coat covers (red).
    pub const COAT: usize = 7;
    /// The texture of the coat's roughness (green).
    pub const COAT_ROUGHNESS: usize = 8;
    /// The normal map of the coat.
    pub const COAT_NORMAL: usize = 9;
    /// The texture of the sheen's color, sRGB.
    pub const SHEEN: usize = 10;
    /// The texture of the sheen's roughness (alpha).
    pub const SHEEN_ROUGHNESS: usize = 11;
    /// The texture of the direction (red and green, −1 ..= 1 as 0 ..= 255) and the strength (blue) of a brushed
    /// surface.
    pub const BRUSHED: usize = 12;
    /// The texture of the share that a film covers (red).
    pub const FILM: usize = 13;
    /// The texture of the film's thickness (green).
    pub const FILM_THICKNESS: usize = 14;
    /// The texture of the share of light that goes through (red).
    pub const TRANSMISSION: usize = 15;

    /// Has textures of what it mirrors.
    pub const SPECULAR_MAPS: u32 = 1;
    /// Has a clear coat.
    pub const HAS_COAT: u32 = 2;
    /// Has a sheen.
    pub const HAS_SHEEN: u32 = 4;
    /// Is brushed.
    pub const IS_BRUSHED: u32 = 8;
    /// Has a thin film.
    pub const HAS_FILM: u32 = 16;
    /// Lets light through.
    pub const TRANSMITS: u32 = 32;
    /// Blends because it lets light through; its alpha counts as 1.
    pub const IGNORES_ALPHA: u32 = 64;
    /// Catches shadows: [`MaterialRecord::unlit`] is [`MaterialRecord::CATCHES_SHADOWS`].
    pub const IS_SHADOW_CATCHER: u32 = 128;
    /// Turns the light that it lets through, or scatters it.
    pub const DEFLECTS: u32 = 256;
}
