//! Alpha, tint and cutoff of a surface that is not opaque everywhere.
//!
//! Searches need them before the closest surface is known. So they lie in the scene's mesh data, which
//! searches bind anyway: a record for each such instance, and texture coordinates and colors for the
//! vertices of its mesh. Only the texels lie elsewhere. (A search that bound materials and attributes
//! would exceed the eight storage buffers that WebGPU promises.)

use crate::kernel::interpolate::Weights;
use crate::kernel::sphere::{longitude_and_latitude, point};
use crate::kernel::texture::{BYTE, FinestLevel, finest};
use crate::kernel::traverse::Geometry;
use crate::kernel::triangle::Intersection;
use crate::lane::{Lane, Mask, Row};
use crate::layout::Instance;
use crate::num::{clamp, flush};

/// Words of a record.
pub const RECORD: u32 = 18;
/// Words of a vertex: texture coordinates, color.
pub const VERTEX: u32 = 3;

/// In a record: the [`crate::layout::AlphaKind`].
pub const MODE: u32 = 0;
/// In a record: the least alpha of what is there, in a mask.
pub const CUTOFF: u32 = 1;
/// In a record: linear RGB and alpha of the material.
pub const BASE: u32 = 2;
/// In a record: where the first of the mesh's vertices is in the scene's mesh_data.
pub const VERTICES: u32 = 6;
/// In a record: what [`crate::layout::Texture`] says of the base color's texture. Where it
/// starts, columns, rows (0 without a texture), wrapping, `turn`, `shift`.
pub const TEXTURE: u32 = 7;

/// A number in the scene's mesh_data.
#[inline(always)]
fn number(geometry: &Geometry<'_>, at: u32) -> f32 {
    f32::from_bits(geometry.mesh_data[at as usize])
}

/// The least alpha of what is there of an instance that is masked.
#[inline(always)]
pub fn cutoff(geometry: &Geometry<'_>, instance: u32) -> f32 {
    number(geometry, geometry.instances[instance as usize].transparency + CUTOFF)
}

/// The [`crate::layout::AlphaKind`] of an instance, as a number.
#[inline(always)]
pub fn mode(geometry: &Geometry<'_>, instance: u32) -> u32 {
    alpha_mode_of(&geometry.instances[instance as usize], geometry.mesh_data)
}

/// The same of an instance, where `mesh_data` are the scene's.
#[inline(always)]
pub fn alpha_mode_of(instance: &Instance, mesh_data: &[u32]) -> u32 {
    if instance.transparency == 0 { 0 } else { mesh_data[(instance.transparency + MODE) as usize] }
}

/// Where rays have met a triangle of an instance that is not opaque.
struct Met<L: Lane> {
    instance: u32,
    triangle: u32,
    lanes: u32,
    u: L::Row,
    v: L::Row,
}

/// Tint (linear RGB, 0 ..= 1) and alpha (0 ..= 1) of an instance with a pane, where rays have met
/// its triangle; all 0 in the other lanes.
///
/// ```text
/// material · texture · vertex color
/// ```
///
/// The texture is taken at its finest level, bilinear: a search knows no footprint.
#[inline(always)]
pub fn tint_and_alpha<L: Lane>(
    geometry: &Geometry<'_>,
    instance: u32,
    triangle: u32,
    found: &Intersection<L>,
) -> [L; 4] {
    let met = Met::<L> { instance, triangle, lanes: found.mask.bits(), u: found.u.row(), v: found.v.row() };
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
        let instance = &geometry.instances[self.instance as usize];
        let pane = instance.transparency;
        let [a, b, c] = geometry.corners(instance, self.triangle);
        let first = geometry.mesh_data[(pane + VERTICES) as usize];
        let a = first + VERTEX * (a - instance.first_vertex);
        let b = first + VERTEX * (b - instance.first_vertex);
        let c = first + VERTEX * (c - instance.first_vertex);
        let weights = Weights::new(self.u.at(lane), self.v.at(lane));
        let [u, v] = if instance.is_sphere() {
            longitude_and_latitude(point(self.u.at(lane), self.v.at(lane)))
        } else {
            [
                weights.mix(number(geometry, a), number(geometry, b), number(geometry, c)),
                weights.mix(number(geometry, a + 1), number(geometry, b + 1), number(geometry, c + 1)),
            ]
        };
        let (a, b, c) = (
            geometry.mesh_data[a as usize + 2],
            geometry.mesh_data[b as usize + 2],
            geometry.mesh_data[c as usize + 2],
        );
        let t = pane + TEXTURE;
        let uv = [
            flush(u * number(geometry, t + 5) + v * number(geometry, t + 6) + number(geometry, t + 9)),
            flush(u * number(geometry, t + 7) + v * number(geometry, t + 8) + number(geometry, t + 10)),
        ];
        let texture = FinestLevel {
            first: geometry.mesh_data[t as usize],
            width: geometry.mesh_data[t as usize + 1],
            height: geometry.mesh_data[t as usize + 2],
            wrap_u: geometry.mesh_data[t as usize + 3],
            wrap_v: geometry.mesh_data[t as usize + 4],
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
