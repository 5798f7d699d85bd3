//! Alpha, tint and cutoff of a surface that is not opaque everywhere.
//!
//! Searches need them before the closest surface is known. So they lie in the scene's mesh data, which
//! searches bind anyway: a record for each such instance, and texture coordinates and colors for the
//! vertices of its mesh. Only the texels lie elsewhere. (A search that bound materials and attributes
//! would exceed the eight storage buffers that WebGPU promises.)

use crate::kernel::geometry::Geometry;
use crate::kernel::interpolate::Weights;
use crate::kernel::sphere::{longitude_and_latitude, point};
use crate::kernel::texture::finest;
use crate::kernel::triangle::Intersection;
use crate::kernel::vertex_color::STEP;
use crate::lane::{Lane, Mask, Row};
use crate::layout::{AlphaKind, Instance, Transparency, TransparencyVertex};
use crate::num::{clamp, flush};

/// The [`AlphaKind`] of an instance, as a number; `mesh_data` is the scene's.
#[inline(always)]
pub fn alpha_mode(instance: &Instance, mesh_data: &[u32]) -> u32 {
    if instance.transparency == 0 {
        AlphaKind::Opaque as u32
    } else {
        Transparency::load_alpha_mode(mesh_data, instance.transparency)
    }
}

/// The lanes in which the mask of an instance with [`AlphaKind::Mask`] leaves a surface of this alpha in
/// place.
///
/// ```text
/// alpha ≥ cutoff
/// ```
///
/// NaN is cut out.
#[inline(always)]
pub fn passes_mask<L: Lane>(geometry: &Geometry<'_>, instance: u32, alpha: L) -> L::Mask {
    let at = geometry.instances[instance as usize].transparency;
    alpha.ge(alpha.broadcast(Transparency::load_cutoff(geometry.mesh_data, at)))
}

/// Linear RGB (0 ..= 1) and alpha (0 ..= 1) of an instance that is not opaque everywhere, where rays hit
/// a triangle of it; all 0 in the other lanes.
///
/// ```text
/// material · texture · vertex color
/// ```
///
/// The texture is sampled at its finest level, bilinear: a ray in traversal has no footprint.
#[inline(always)]
pub fn tint_and_alpha<L: Lane>(
    geometry: &Geometry<'_>,
    instance: u32,
    triangle: u32,
    intersection: &Intersection<L>,
) -> [L; 4] {
    let instance = &geometry.instances[instance as usize];
    let [a, b, c] = geometry.corners(instance, triangle);
    let hits = TriangleHits::<L> {
        lanes: intersection.mask.bits(),
        u: intersection.u.row(),
        v: intersection.v.row(),
        corners: [a - instance.first_vertex, b - instance.first_vertex, c - instance.first_vertex],
        is_sphere: instance.is_sphere(),
        record: Transparency::load(geometry.mesh_data, instance.transparency),
    };
    L::gather(
        intersection.t.token(),
        #[inline(always)]
        |lane| hits.tint_and_alpha(geometry, lane),
    )
}

/// Where a group of rays hits a triangle.
struct TriangleHits<L: Lane> {
    /// The lanes that do, as bits.
    lanes: u32,
    u: L::Row,
    v: L::Row,
    /// The triangle's corners, among the mesh's vertices.
    corners: [u32; 3],
    is_sphere: bool,
    record: Transparency,
}

impl<L: Lane> TriangleHits<L> {
    /// [`tint_and_alpha`] in one lane.
    #[inline(always)]
    fn tint_and_alpha(&self, geometry: &Geometry<'_>, lane: usize) -> [f32; 4] {
        if self.lanes >> lane & 1 == 0 {
            return [0.0; 4];
        }
        let Transparency { base, first_vertex, texture, .. } = self.record;
        let mesh_data = geometry.mesh_data;
        // Moved: shaders cannot load through a pointer in a closure.
        let vertex = move |corner: u32| {
            TransparencyVertex::load(mesh_data, first_vertex + TransparencyVertex::WORDS * corner)
        };
        let [a, b, c] = self.corners;
        let (a, b, c) = (vertex(a), vertex(b), vertex(c));
        let weights = Weights::new(self.u.at(lane), self.v.at(lane));
        let [u, v] = if self.is_sphere {
            longitude_and_latitude(point(self.u.at(lane), self.v.at(lane)))
        } else {
            [weights.mix(a.uv[0], b.uv[0], c.uv[0]), weights.mix(a.uv[1], b.uv[1], c.uv[1])]
        };
        let ([to_u, to_v], shift) = (texture.turn, texture.shift);
        let uv = [flush(u * to_u[0] + v * to_u[1] + shift[0]), flush(u * to_v[0] + v * to_v[1] + shift[1])];
        let texel = if texture.height == 0 { [1.0; 4] } else { finest(geometry.texels, &texture, uv) };
        let red_green = [a.color[0], b.color[0], c.color[0]];
        let blue_alpha = [a.color[1], b.color[1], c.color[1]];
        [
            share(base[0] * texel[0] * vertex_channel(&weights, red_green, 0)),
            share(base[1] * texel[1] * vertex_channel(&weights, red_green, 16)),
            share(base[2] * texel[2] * vertex_channel(&weights, blue_alpha, 0)),
            share(base[3] * texel[3] * vertex_channel(&weights, blue_alpha, 16)),
        ]
    }
}

/// Within 0 ..= 1.
#[inline(always)]
fn share(x: f32) -> f32 {
    flush(clamp(x, 0.0, 1.0))
}

/// A channel of the vertices' colors, interpolated; `shift` is where it is in its word.
#[inline(always)]
fn vertex_channel(weights: &Weights<f32>, [a, b, c]: [u32; 3], shift: u32) -> f32 {
    let channel = |word: u32| (word >> shift & 0xffff) as f32 * STEP;
    let (a, b, c) = (channel(a), channel(b), channel(c));
    // Weights sum to 1 but for rounding, and alpha may have to equal a cutoff.
    if a == b && b == c { a } else { weights.mix(a, b, c) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, square_at};

    /// Tint and alpha in the middle of a square's first triangle, or of one that is missed.
    fn of(material: Material, mask: bool) -> ([f32; 4], bool) {
        let mut scene = Scene::new();
        add_square(&mut scene, material, square_at(1.0, [0.0; 3]));
        let prepared = Prepared::new(scene, |request| request);
        let geometry = prepared.context().geometry;
        let found = tint_and_alpha(&geometry, 0, 0, &Intersection { mask, t: 1.0_f32, u: 0.25, v: 0.25 });
        (found, passes_mask(&geometry, 0, found[3]))
    }

    #[test]
    fn without_texture_and_color_it_is_the_materials() {
        let glass = Material::new([0.25, 0.5, 1.0]).blend(0.125);
        assert_eq!(of(glass, true).0, [0.25, 0.5, 1.0, 0.125]);
        assert_eq!(of(glass, false).0, [0.0; 4]);
        // Within 0 ..= 1.
        assert_eq!(of(Material::new([4.0, -1.0, 1.0]).blend(3.0), true).0, [1.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn a_mask_leaves_what_is_not_below_its_cutoff() {
        let passes = |alpha: f32| of(Material::default().mask(0.5).alpha(alpha), true).1;
        assert_eq!([passes(0.49), passes(0.5), passes(0.75)], [false, true, true]);
    }

    #[test]
    fn an_instance_without_a_record_is_opaque() {
        assert_eq!(alpha_mode(&bytemuck::Zeroable::zeroed(), &[]), AlphaKind::Opaque as u32);
    }
}
