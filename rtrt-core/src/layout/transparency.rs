//! What shadow rays and masks need of an instance that is not opaque everywhere.
//!
//! Traversal needs it before it is known which surface is the closest, so it lies in the scene's mesh data:
//! a record for each such instance, and texture coordinates and colors for each of its mesh's vertices. Only
//! the texels lie elsewhere. The scene writes these structs; kernels, whose shader compiler casts no slices,
//! read them word by word at the offsets that the compiler gives.

use crate::layout::Texture;
use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// The record of an instance.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Transparency {
    /// [`AlphaKind`](crate::layout::AlphaKind); never `Opaque`.
    pub alpha_mode: u32,
    /// The least alpha of what a mask leaves in place.
    pub cutoff: f32,
    /// Linear RGB and alpha of the material.
    pub base: [f32; 4],
    /// Where the [`TransparencyVertex`] of the mesh's first vertex is in the mesh data.
    pub first_vertex: u32,
    /// The texture of the base color.
    pub texture: FinestLevel,
}
const _: () = assert!(size_of::<Transparency>() == 76 && offset_of!(Transparency, first_vertex) == 24);
const _: () = assert!(offset_of!(Transparency, texture) == 28);

/// The finest level of a [`Texture`], and how it is laid on a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FinestLevel {
    /// The word of the scene's texels that says where the level starts.
    pub first: u32,
    /// Columns.
    pub width: u32,
    /// Rows; 0 for no texture (white).
    pub height: u32,
    /// [`Wrap`](crate::layout::Wrap) of the columns.
    pub wrap_u: u32,
    /// [`Wrap`](crate::layout::Wrap) of the rows.
    pub wrap_v: u32,
    /// [`Filter`](crate::layout::Filter).
    pub filter: u32,
    /// See [`Texture::turn`].
    pub turn: [[f32; 2]; 2],
    /// See [`Texture::shift`].
    pub shift: [f32; 2],
}
const _: () = assert!(size_of::<FinestLevel>() == 48 && offset_of!(FinestLevel, turn) == 24);
const _: () = assert!(offset_of!(FinestLevel, shift) == 40);

/// What a vertex of such an instance's mesh has.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TransparencyVertex {
    /// Coordinates in the texture of the base color.
    pub uv: [f32; 2],
    /// Linear RGBA, 8 bits each, red lowest.
    pub color: [u32; 2],
}
const _: () = assert!(size_of::<TransparencyVertex>() == 16 && offset_of!(TransparencyVertex, color) == 8);

/// The word of `mesh_data` at a byte offset in a record that starts at the word `at`.
#[inline(always)]
fn word(mesh_data: &[u32], at: u32, offset: usize) -> u32 {
    mesh_data[at as usize + offset / size_of::<u32>()]
}

/// The same as a number.
#[inline(always)]
fn number(mesh_data: &[u32], at: u32, offset: usize) -> f32 {
    f32::from_bits(word(mesh_data, at, offset))
}

/// Two numbers, one after the other.
#[inline(always)]
fn pair(mesh_data: &[u32], at: u32, offset: usize) -> [f32; 2] {
    [number(mesh_data, at, offset), number(mesh_data, at, offset + size_of::<f32>())]
}

impl Transparency {
    /// Words of a record.
    pub const WORDS: u32 = (size_of::<Self>() / size_of::<u32>()) as u32;

    /// The alpha mode in the record at the word `at`.
    #[inline(always)]
    pub(crate) fn load_alpha_mode(mesh_data: &[u32], at: u32) -> u32 {
        word(mesh_data, at, offset_of!(Self, alpha_mode))
    }

    /// The cutoff in it.
    #[inline(always)]
    pub(crate) fn load_cutoff(mesh_data: &[u32], at: u32) -> f32 {
        number(mesh_data, at, offset_of!(Self, cutoff))
    }

    /// All of it.
    #[inline(always)]
    pub fn load(mesh_data: &[u32], at: u32) -> Self {
        let (base, turn) = (offset_of!(Self, base), offset_of!(Self, texture.turn));
        let ([r, g], [b, a]) = (pair(mesh_data, at, base), pair(mesh_data, at, base + size_of::<[f32; 2]>()));
        Self {
            alpha_mode: Self::load_alpha_mode(mesh_data, at),
            cutoff: Self::load_cutoff(mesh_data, at),
            base: [r, g, b, a],
            first_vertex: word(mesh_data, at, offset_of!(Self, first_vertex)),
            texture: FinestLevel {
                first: word(mesh_data, at, offset_of!(Self, texture.first)),
                width: word(mesh_data, at, offset_of!(Self, texture.width)),
                height: word(mesh_data, at, offset_of!(Self, texture.height)),
                wrap_u: word(mesh_data, at, offset_of!(Self, texture.wrap_u)),
                wrap_v: word(mesh_data, at, offset_of!(Self, texture.wrap_v)),
                filter: word(mesh_data, at, offset_of!(Self, texture.filter)),
                turn: [pair(mesh_data, at, turn), pair(mesh_data, at, turn + size_of::<[f32; 2]>())],
                shift: pair(mesh_data, at, offset_of!(Self, texture.shift)),
            },
        }
    }
}

impl FinestLevel {
    /// That of a texture.
    pub fn new(texture: &Texture) -> Self {
        let &Texture { first, levels, wrap_u, wrap_v, filter, turn, shift, .. } = texture;
        let [width, height] = if levels > 0 { [texture.width, texture.height] } else { [0; 2] };
        Self { first, width, height, wrap_u, wrap_v, filter, turn, shift }
    }
}

impl TransparencyVertex {
    /// Words of a vertex.
    pub const WORDS: u32 = (size_of::<Self>() / size_of::<u32>()) as u32;

    /// The vertex at the word `at`.
    #[inline(always)]
    pub fn load(mesh_data: &[u32], at: u32) -> Self {
        Self {
            uv: pair(mesh_data, at, offset_of!(Self, uv)),
            color: [
                word(mesh_data, at, offset_of!(Self, color)),
                word(mesh_data, at, offset_of!(Self, color) + 4),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every word is another, and none of them stands for NaN.
    #[test]
    fn what_is_written_is_read() {
        let words: std::vec::Vec<u32> = (100..).take(5 + Transparency::WORDS as usize).collect();
        let record = Transparency::load(&words, 5);
        assert_eq!(bytemuck::cast_slice::<_, u32>(&[record]), &words[5..]);
        let vertex = TransparencyVertex::load(&words, 3);
        assert_eq!(bytemuck::cast_slice::<_, u32>(&[vertex]), &words[3..7]);
    }
}
