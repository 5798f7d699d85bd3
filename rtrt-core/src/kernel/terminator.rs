//! The terminator of smooth surfaces: where rays leave a triangle that stands for a curved surface.
//!
//! Corners' normals make the shading of a coarse mesh smooth; its shadows are those of flat triangles, and light that
//! fades toward the terminator ends at an edge. Rays that start on the surface that the normals mean see the same
//! horizon as the shading: each corner's tangent plane is a guess of that surface, and the start is lifted to the mean of
//! the three (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4). It needs no neighbors, is
//! continuous across edges, which have the same two corners from both sides, and changes nothing where normals are those of
//! the triangle.

use crate::kernel::interpolate::Weights;
use crate::lane::{Lane, Select, V3};
use crate::num::recip;

/// How far a point of a triangle is lifted to the curved surface, on the viewer's side alone:
///
/// ```text
/// Σ wᵢ · max(0, (cornerᵢ − point) · nᵢ) · nᵢ / (nᵢ · nᵢ)
/// ```
///
/// `normals` have any length and are on the viewer's side, as `flat` is, the triangle's own; a corner whose normal points
/// away from that has no share.
#[inline(always)]
pub fn lift<L: Lane>(
    weights: &Weights<L>,
    point: V3<L>,
    corners: &[V3<L>; 3],
    normals: &[V3<L>; 3],
    flat: V3<L>,
) -> V3<L> {
    let [a, b, c] = [corners[0] - point, corners[1] - point, corners[2] - point];
    weights.mix3(to_plane(a, normals[0], flat), to_plane(b, normals[1], flat), to_plane(c, normals[2], flat))
}

/// The way to the tangent plane of the corner that is this far away, if it leads away from the triangle.
#[inline(always)]
fn to_plane<L: Lane>(corner: V3<L>, normal: V3<L>, flat: V3<L>) -> V3<L> {
    let depth = corner.dot(normal);
    let zero = depth.broadcast(0.0);
    let outward = normal.dot(flat).gt(zero) & depth.gt(zero);
    normal.scale(outward.select(depth * recip(normal.dot(normal)), zero))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lifted(u: f32, v: f32, normals: [[f32; 3]; 3]) -> [f32; 3] {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|p| V3::<f32>::splat((), p));
        let weights = Weights::new(u, v);
        let point = weights.mix3(corners[0], corners[1], corners[2]);
        let normals = normals.map(|n| V3::splat((), n));
        lift(&weights, point, &corners, &normals, V3::splat((), [0.0, 0.0, 1.0])).lane(0)
    }

    #[test]
    fn a_point_is_lifted_to_the_mean_of_the_corners_tangent_planes() {
        // Two corners whose normals lean apart by 45° each, and the middle of their edge: it is 1/2 · sin 45° below
        // both planes, and their mean is 1/4 above it.
        let apart = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(near(lifted(0.5, 0.0, apart), [0.0, 0.0, 0.25]));
        // Lengths of normals do not matter; corners stay.
        let longer = [[-4.0, 0.0, 4.0], [0.5, 0.0, 0.5], [0.0, 0.0, 9.0]];
        assert!(near(lifted(0.5, 0.0, longer), [0.0, 0.0, 0.25]));
        assert!(near(lifted(1.0, 0.0, apart), [0.0; 3]));
        // Flat and hollow surfaces stay where they are, and normals that face away count for nothing.
        assert_eq!(lifted(0.25, 0.25, [[0.0, 0.0, 2.0]; 3]), [0.0; 3]);
        assert_eq!(lifted(0.5, 0.0, [[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]), [0.0; 3]);
        assert_eq!(lifted(0.5, 0.0, [[1.0, 0.0, -1.0], [-1.0, 0.0, -1.0], [0.0, 0.0, -1.0]]), [0.0; 3]);
    }
}
