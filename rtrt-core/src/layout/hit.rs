//! The deferred buffers: the result of each stage, one record a ray.

use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// The id of no instance and no triangle.
pub const NONE: u32 = u32::MAX;

/// The closest surface on a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Hit {
    /// The parameter of the hit on the ray, in lengths of the direction; `f32::MAX` for no hit.
    /// For a camera ray it is the depth, world units.
    pub t: f32,
    /// The instance, or [`NONE`].
    pub instance: u32,
    /// The triangle of the instance's mesh, or [`NONE`].
    pub triangle: u32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
}
const _: () = assert!(size_of::<Hit>() == 20 && offset_of!(Hit, v) == 16);

impl Hit {
    /// No hit.
    pub const MISS: Self = Self { t: f32::MAX, instance: NONE, triangle: NONE, u: 0.0, v: 0.0 };
}

/// The surface at a hit; all zero for no hit.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Surface {
    /// The origin of rays that leave the surface on the viewer's side, world space.
    pub origin: [f32; 3],
    /// 1 + the material, or 0 for no hit.
    pub material: u32,
    /// Unit normal on the viewer's side, world space.
    pub normal: [f32; 3],
    /// Vertex color, linear RGBA, 16 bits each (see [`Attribute::color`](crate::layout::Attribute::color)).
    pub color: [u32; 2],
    /// Texture coordinates.
    pub uv: [f32; 2],
    /// Side of a ray's footprint on the surface, in texture coordinates.
    pub footprint: f32,
    /// The second set of texture coordinates, where the mesh has one.
    pub second_uv: [f32; 2],
    /// Side of the footprint in them.
    pub second_footprint: f32,
    /// How much the normals within the footprint vary; see `kernel::variance`.
    pub variance: f32,
    /// The normal of a clear coat, in frames that have coats; see `kernel::tangent::pack_direction`.
    pub coat_normal: u32,
    /// The direction along which a brushed surface is steeper, in frames that have such.
    pub tangent: u32,
}
const _: () = assert!(size_of::<Surface>() == 72 && offset_of!(Surface, footprint) == 44);

/// The light that arrives at a surface, before its material colors it: sums over lights of illuminance (color ×
/// falloff × Lambert's cosine), linear RGB, each times a share (see `microfacet`).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Lit {
    /// Of `(1 − (1 − v·h)⁵) / π`, which the diffuse color multiplies.
    pub diffuse: [f32; 3],
    /// Of the lobe × `(1 − (1 − v·h)⁵)`, which the color mirrored head-on multiplies.
    pub specular: [f32; 3],
    /// Of the lobe × `(1 − v·h)⁵`, which is mirrored at grazing angles.
    pub grazing: [f32; 3],
    /// What coats and sheens send to the viewer.
    pub coating: [f32; 3],
}
const _: () = assert!(size_of::<Lit>() == 48);
