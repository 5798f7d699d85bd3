//! What a ray meets of a surface that is not opaque everywhere.
//!
//! A search asks this while it runs, before it is known which surface is seen, so all that
//! it takes lies in the scene's words: for each object that is not opaque a record, and for
//! its mesh the vertices' texture coordinates and colors. Only the texels lie elsewhere.

use crate::kernel::interpolate::Weights;
use crate::kernel::sphere::{longitude_and_latitude, point};
use crate::kernel::texture::{BYTE, Finest, finest};
use crate::kernel::traverse::Geometry;
use crate::kernel::triangle::Meeting;
use crate::lane::{Lane, Mask, Row};
use crate::layout::Object;
use crate::num::{clamp, flush};

/// Words of a record.
pub const RECORD: u32 = 18;
/// Words of a vertex: texture coordinates, color.
pub const VERTEX: u32 = 3;

/// In a record: the [`crate::layout::AlphaMode`].
pub const MODE: u32 = 0;
/// In a record: the least alpha of what is there, in a mask.
pub const CUTOFF: u32 = 1;
/// In a record: linear RGB and alpha of the material.
pub const BASE: u32 = 2;
/// In a record: where the first of the mesh's vertices is in the scene's words.
pub const VERTICES: u32 = 6;
/// In a record: what [`crate::layout::Texture`] says of the base color's texture. Where it
/// starts, columns, rows (0 without a texture), wrapping, `turn`, `shift`.
pub const TEXTURE: u32 = 7;

/// A number in the scene's words.
#[inline(always)]
fn number(geometry: &Geometry<'_>, at: u32) -> f32 {
    f32::from_bits(geometry.words[at as usize])
}

/// The least alpha of what is there of an object that is masked.
#[inline(always)]
pub fn cutoff(geometry: &Geometry<'_>, object: u32) -> f32 {
    number(geometry, geometry.objects[object as usize].pane + CUTOFF)
}

/// The [`crate::layout::AlphaMode`] of an object, as a number.
#[inline(always)]
pub fn mode(geometry: &Geometry<'_>, object: u32) -> u32 {
    mode_of(&geometry.objects[object as usize], geometry.words)
}

/// The same of an object, where `words` are the scene's.
#[inline(always)]
pub fn mode_of(object: &Object, words: &[u32]) -> u32 {
    if object.pane == 0 { 0 } else { words[(object.pane + MODE) as usize] }
}

/// Where rays have met a triangle of an object that is not opaque.
struct Met<L: Lane> {
    object: u32,
    triangle: u32,
    lanes: u32,
    u: L::Row,
    v: L::Row,
}

/// Tint (linear RGB, 0 ..= 1) and alpha (0 ..= 1) of an object with a pane, where rays have met
/// its triangle; all 0 in the other lanes.
///
/// ```text
/// material · texture · vertex color
/// ```
///
/// The texture is taken at its finest level, bilinear: a search knows no footprint.
#[inline(always)]
pub fn pane<L: Lane>(geometry: &Geometry<'_>, object: u32, triangle: u32, found: &Meeting<L>) -> [L; 4] {
    let met = Met::<L> { object, triangle, lanes: found.mask.bits(), u: found.u.row(), v: found.v.row() };
    L::gather(
        found.t.token(),
        #[inline(always)]
        |lane| met.at(geometry, lane),
    )
}

impl<L: Lane> Met<L> {
    /// [`pane`] in one lane.
    #[inline(always)]
    fn at(&self, geometry: &Geometry<'_>, lane: usize) -> [f32; 4] {
        if self.lanes >> lane & 1 == 0 {
            return [0.0; 4];
        }
        let object = &geometry.objects[self.object as usize];
        let pane = object.pane;
        let [a, b, c] = geometry.corners(object, self.triangle);
        let first = geometry.words[(pane + VERTICES) as usize];
        let a = first + VERTEX * (a - object.first_vertex);
        let b = first + VERTEX * (b - object.first_vertex);
        let c = first + VERTEX * (c - object.first_vertex);
        let weights = Weights::new(self.u.at(lane), self.v.at(lane));
        let [u, v] = if object.is_sphere() {
            longitude_and_latitude(point(self.u.at(lane), self.v.at(lane)))
        } else {
            [
                weights.mix(number(geometry, a), number(geometry, b), number(geometry, c)),
                weights.mix(number(geometry, a + 1), number(geometry, b + 1), number(geometry, c + 1)),
            ]
        };
        let (a, b, c) =
            (geometry.words[a as usize + 2], geometry.words[b as usize + 2], geometry.words[c as usize + 2]);
        let t = pane + TEXTURE;
        let uv = [
            flush(u * number(geometry, t + 5) + v * number(geometry, t + 6) + number(geometry, t + 9)),
            flush(u * number(geometry, t + 7) + v * number(geometry, t + 8) + number(geometry, t + 10)),
        ];
        let texture = Finest {
            first: geometry.words[t as usize],
            width: geometry.words[t as usize + 1],
            height: geometry.words[t as usize + 2],
            wrap_u: geometry.words[t as usize + 3],
            wrap_v: geometry.words[t as usize + 4],
        };
        let texel = if texture.height == 0 { [1.0; 4] } else { finest(geometry.texels, &texture, uv) };
        [
            share(number(geometry, pane + BASE) * texel[0] * painted(&weights, a, b, c, 0)),
            share(number(geometry, pane + BASE + 1) * texel[1] * painted(&weights, a, b, c, 8)),
            share(number(geometry, pane + BASE + 2) * texel[2] * painted(&weights, a, b, c, 16)),
            share(number(geometry, pane + BASE + 3) * texel[3] * painted(&weights, a, b, c, 24)),
        ]
    }
}

/// A channel of the vertices' colors.
#[inline(always)]
fn painted(weights: &Weights<f32>, a: u32, b: u32, c: u32, shift: u32) -> f32 {
    let part = |color: u32| (color >> shift & 255) as f32 * BYTE;
    // Weights sum to 1 but for rounding, and alpha may have to equal a cutoff.
    if a == b && b == c { part(a) } else { weights.mix(part(a), part(b), part(c)) }
}

/// Within 0 ..= 1.
#[inline(always)]
fn share(x: f32) -> f32 {
    flush(clamp(x, 0.0, 1.0))
}
