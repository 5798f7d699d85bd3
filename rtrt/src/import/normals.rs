//! Normals that follow from the triangles.

use super::polygon::unit;
use glam::DVec3;

/// A normal for each vertex, from the triangles that share it; 0 for a vertex of none.
///
/// ```text
/// normal(vertex) = Σ over its triangles: angle of the corner · normal of the triangle
/// ```
///
/// The angle as a weight makes the normal independent of how polygons are split (Thürmer and Wüthrich, "Computing
/// Vertex Normals from Polygonal Facets", 1998). Indices must be in range.
pub(super) fn angle_weighted(positions: &[[f32; 3]], triangles: &[u32]) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles.chunks_exact(3) {
        let corners = [0, 1, 2].map(|i| DVec3::from(positions[triangle[i] as usize].map(f64::from)));
        let sides = [0, 1, 2].map(|i| unit(corners[(i + 1) % 3] - corners[i]));
        let normal = unit(sides[0].cross(sides[1]));
        for i in 0..3 {
            let angle = libm::acos(sides[i].dot(-sides[(i + 2) % 3]).clamp(-1.0, 1.0));
            sums[triangle[i] as usize] += normal * angle;
        }
    }
    sums.into_iter().map(|sum| finite(unit(sum).as_vec3().to_array())).collect()
}

/// The normal, or 0 if it is not finite.
pub(super) fn finite(normal: [f32; 3]) -> [f32; 3] {
    if normal.iter().all(|c| c.is_finite()) { normal } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_of_a_cube_points_along_its_diagonal_however_its_sides_are_split() {
        // Three sides of a cube meet at the first vertex; two are split so that it has two triangles of 45° each.
        let at = |x: u8, y: u8, z: u8| [x, y, z].map(f32::from);
        let positions = [
            at(0, 0, 0),
            at(1, 0, 0),
            at(0, 1, 0),
            at(0, 0, 1),
            at(1, 1, 0),
            at(0, 1, 1),
            at(1, 0, 1),
            [9.0; 3],
        ];
        // Seen from outside, where the cube lies toward +x, +y, +z.
        let triangles = [0, 2, 4, 0, 4, 1, 0, 3, 5, 0, 5, 2, 0, 1, 3, 1, 6, 3];
        let normals = angle_weighted(&positions, &triangles);
        let expected = -(1.0_f32 / 3.0).sqrt();
        assert!(normals[0].iter().all(|c| (c - expected).abs() < 1e-6), "{:?}", normals[0]);
        assert_eq!(normals[4], [0.0, 0.0, -1.0]);
        assert_eq!(normals[7], [0.0; 3]);
        // Triangles without area, and numbers that are not finite, give no normal.
        assert_eq!(angle_weighted(&[[f32::NAN; 3], [0.0; 3]], &[0, 1, 1]), [[0.0; 3]; 2]);
    }
}
