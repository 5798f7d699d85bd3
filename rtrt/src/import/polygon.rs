//! Polygons to triangles.

use earcut::Earcut;
use glam::DVec3;

/// Splits polygons into triangles. Its memory is reused from polygon to polygon.
pub(super) struct Splitter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    triangles: Vec<u32>,
}

impl Splitter {
    pub fn new() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), triangles: Vec::new() }
    }

    /// The triangles of the polygon: three indices of its corners each, with its orientation.
    ///
    /// The polygon is projected along the axis in which its normal is longest (Newell's: the sum of the cross
    /// products of neighboring corners), and ear clipping splits it. Unlike a fan, this also splits concave
    /// polygons. A polygon without area, or with corners that are not finite, becomes a fan.
    pub fn split(&mut self, corners: &[[f32; 3]]) -> &[u32] {
        let count = corners.len() as u32;
        self.triangles.clear();
        if count > 3 && self.project(corners) {
            self.earcut.earcut_slice(&self.flat, &[], &mut self.triangles);
        }
        if self.triangles.is_empty() {
            self.triangles.extend((2..count).flat_map(|i| [0, i - 1, i]));
        }
        &self.triangles
    }

    /// Projects the polygon into `flat`, counterclockwise. Returns whether it has an area.
    fn project(&mut self, corners: &[[f32; 3]]) -> bool {
        let outline: Vec<DVec3> = corners.iter().map(|corner| DVec3::from(corner.map(f64::from))).collect();
        let normal = vector_area(&outline);
        let size = normal.abs();
        let (axis, length) =
            (0..3).map(|axis| (axis, size[axis])).fold((2, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        if !(length > 0.0 && length.is_finite()) {
            return false;
        }
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (u, v) = if normal[axis] > 0.0 { (u, v) } else { (v, u) };
        self.flat.clear();
        self.flat.extend(outline.iter().map(|corner| corner - outline[0]).map(|c| [c[u], c[v]]));
        true
    }
}

/// The unit normal of a polygon ([`vector_area`]); 0 for one without area.
pub(super) fn face_normal(outline: &[DVec3]) -> DVec3 {
    unit(vector_area(outline))
}

/// `v` at length 1; 0 for a vector without a length.
pub(super) fn unit(v: DVec3) -> DVec3 {
    let length = libm::sqrt(v.length_squared());
    if length > 0.0 && length.is_finite() { v / length } else { DVec3::ZERO }
}

/// A vector along the normal of a polygon, with twice its area as length (Newell's: the sum of the cross products of
/// neighboring corners, seen from the first).
fn vector_area(outline: &[DVec3]) -> DVec3 {
    let Some(&origin) = outline.first() else { return DVec3::ZERO };
    outline.windows(2).map(|edge| (edge[0] - origin).cross(edge[1] - origin)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vector area of a polygon, and the sum of those of its triangles, and of their
    /// sizes. All agree if the triangles cover it once and turn as it does.
    fn areas(corners: &[[f32; 3]]) -> (DVec3, DVec3, f64) {
        let at = |i: usize| DVec3::from(corners[i % corners.len()].map(f64::from));
        let whole: DVec3 = (0..corners.len()).map(|i| at(i).cross(at(i + 1)) * 0.5).sum();
        let mut splitter = Splitter::new();
        let parts = splitter.split(corners).chunks_exact(3).map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| at(i as usize));
            (b - a).cross(c - a) * 0.5
        });
        let parts: Vec<DVec3> = parts.collect();
        (whole, parts.iter().sum(), parts.iter().map(|a| a.length()).sum())
    }

    #[track_caller]
    fn covers_once(corners: &[[f32; 3]]) {
        let (whole, sum, sizes) = areas(corners);
        assert!((whole - sum).length() < 1e-6 * whole.length(), "{whole} {sum}");
        assert!((sizes - whole.length()).abs() < 1e-6 * sizes, "{whole} {sizes}");
    }

    #[test]
    fn concave_polygons_are_covered_once_whichever_way_they_face() {
        let star: Vec<[f32; 2]> = (0..24)
            .map(|i| {
                let (sin, cos) = libm::sincosf(i as f32 * core::f32::consts::TAU / 24.0);
                let radius = if i % 2 == 0 { 2.0 } else { 0.7 };
                [cos * radius, sin * radius]
            })
            .collect();
        let comb = [
            [0., 0.],
            [5., 0.],
            [5., 3.],
            [4., 3.],
            [4., 1.],
            [3., 1.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [1., 1.],
            [1., 3.],
            [0., 3.],
        ];
        let dart = [[0., 0.], [2., 1.], [0., 2.], [0.5, 1.]];
        for shape in [&star[..], &comb, &dart] {
            for reversed in [false, true] {
                let mut shape = shape.to_vec();
                if reversed {
                    shape.reverse();
                }
                covers_once(&shape.iter().map(|p| [p[0], p[1], 1.0]).collect::<Vec<_>>());
                covers_once(&shape.iter().map(|p| [7.0, p[0], p[1]]).collect::<Vec<_>>());
                covers_once(&shape.iter().map(|p| [p[0], p[0] - 2.0 * p[1], p[1]]).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn polygons_without_area_become_a_fan() {
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.5, 0.0, 0.0]];
        assert_eq!(Splitter::new().split(&line), [0, 1, 2, 0, 2, 3]);
        let mut broken = line;
        broken[2][1] = f32::NAN;
        assert_eq!(Splitter::new().split(&broken).len(), 6);
    }
}
