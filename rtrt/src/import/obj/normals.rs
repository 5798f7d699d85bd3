//! Normals that follow from the faces.

use super::parse::{NONE, Obj, Polygon};
use crate::import::polygon::{face_normal, unit};
use glam::DVec3;
use std::collections::HashMap;

/// Gives the corners of smoothing groups their normals.
///
/// ```text
/// normal(vertex, group) = Σ over the group's faces at the vertex: angle of the corner · normal of the face
/// ```
///
/// The angle as a weight makes the normal independent of how faces are split (Thürmer and Wüthrich, "Computing Vertex
/// Normals from Polygonal Facets", 1998). A face that has normals in the file keeps them.
pub(super) fn smooth(obj: &mut Obj) {
    let polygons: Vec<Polygon> = obj
        .polygons
        .iter()
        .copied()
        .filter(|polygon| polygon.smoothing != 0 && lacks_normals(obj, polygon))
        .collect();
    let mut sums: HashMap<(u32, u32), DVec3> = HashMap::new();
    for polygon in &polygons {
        let outline = obj.outline(polygon);
        let normal = face_normal(&outline);
        for (corner, at) in (polygon.first..polygon.first + polygon.corners).zip(0..) {
            let vertex = obj.corners[corner][0];
            *sums.entry((polygon.smoothing, vertex)).or_default() += normal * angle(&outline, at);
        }
    }
    let mut places = HashMap::new();
    for polygon in &polygons {
        for corner in polygon.first..polygon.first + polygon.corners {
            let key = (polygon.smoothing, obj.corners[corner][0]);
            obj.corners[corner][2] = *places.entry(key).or_insert_with(|| {
                let normal = sums.get(&key).copied().unwrap_or_default();
                obj.normals.push(unit(normal).as_vec3().to_array());
                obj.normals.len() as u32 - 1
            });
        }
    }
}

/// Whether a corner of the polygon has no normal.
pub(super) fn lacks_normals(obj: &Obj, polygon: &Polygon) -> bool {
    obj.corners[polygon.first..polygon.first + polygon.corners].iter().any(|corner| corner[2] == NONE)
}

/// The angle at a corner of an outline, radians.
fn angle(outline: &[DVec3], at: usize) -> f64 {
    let count = outline.len();
    let [before, after] = [at + count - 1, at + 1].map(|i| unit(outline[i % count] - outline[at]));
    libm::acos(before.dot(after).clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::super::parse::parse;
    use super::*;

    /// A roof of two rectangles that share the ridge from (0, 0, 1) to (0, 2, 1), each 45° steep. The left one is split
    /// into two triangles.
    const ROOF: &str = "v -1 0 0\nv 0 0 1\nv 0 2 1\nv -1 2 0\nv 1 0 0\nv 1 2 0\n";

    fn normals(faces: &str) -> Vec<[f32; 3]> {
        let mut obj = parse(format!("{ROOF}{faces}").as_bytes()).unwrap();
        smooth(&mut obj);
        obj.corners.iter().map(|c| obj.normals.get(c[2] as usize).copied().unwrap_or_default()).collect()
    }

    #[test]
    fn a_ridge_between_faces_of_one_group_points_up() {
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let (left, right) = ([-half, 0.0, half], [half, 0.0, half]);
        let near = |a: &[f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        // The corners of the left rectangle are split 45° and 45° at one end of the ridge, and whole at the other.
        let smooth = normals("s 1\nf 1 2 3\nf 1 3 4\nf 2 5 6 3\n");
        for (place, expected) in
            [(0, left), (1, [0.0, 0.0, 1.0]), (2, [0.0, 0.0, 1.0]), (5, left), (7, right)]
        {
            assert!(near(&smooth[place], expected), "{place}: {:?}", smooth[place]);
        }
        let apart = normals("s 1\nf 1 2 3 4\ns 2\nf 2 5 6 3\n");
        assert!(near(&apart[1], left) && near(&apart[4], right), "{apart:?}");
        for off in ["", "s off\n", "s 0\n", "s 1\ns off\n"] {
            assert_eq!(normals(&format!("{off}f 1 2 3 4\nf 2 5 6 3\n")), [[0.0; 3]; 8], "{off}");
        }
    }
}
