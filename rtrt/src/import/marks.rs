//! Points and lines: small solid shapes in the scene, so that they have shadows, depth and order as all else.
//!
//! A point is an octahedron, or in clouds of many points a tetrahedron that covers as much, which takes half the memory. A
//! line is a prism with a tip at each end. Their diameter is a length of the scene. Without
//! one, it is 1/250 of the diagonal of what a file holds: about three pixels in a picture of all of it.

use super::geometry::{Geometry, Tangents};
use glam::{DVec3, Vec3};
use rtrt_core::layout::Attribute;
use rtrt_core::scene::Mesh;

/// The default diameter, as a share of the diagonal.
const SHARE: f64 = 1.0 / 250.0;

/// The triangles of an octahedron over its corners +x, −x, +y, −y, +z, −z; seen from outside they run counterclockwise.
const OCTAHEDRON: [[u32; 3]; 8] =
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

/// The most points of a mesh that are octahedra.
const OCTAHEDRA: usize = 1 << 17;

/// The corners of a tetrahedron, and its triangles. Seen from everywhere, a convex body covers a quarter of its surface on
/// average (Cauchy). An octahedron of radius r has 4√3 r²; so has this tetrahedron times r / √2, whose edges are 2 r.
const TETRAHEDRON_CORNERS: [Vec3; 4] =
    [Vec3::new(1., 1., 1.), Vec3::new(1., -1., -1.), Vec3::new(-1., 1., -1.), Vec3::new(-1., -1., 1.)];
const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];

/// The triangles of a prism: corners 0 to 2 are around its start, 3 to 5 around its end, 6 and 7 are the tips.
const PRISM: [[u32; 3]; 12] = [
    [0, 1, 4],
    [0, 4, 3],
    [1, 2, 5],
    [1, 5, 4],
    [2, 0, 3],
    [2, 3, 5],
    [1, 0, 6],
    [2, 1, 6],
    [0, 2, 6],
    [3, 4, 7],
    [4, 5, 7],
    [5, 3, 7],
];

/// What is to be drawn of some vertices.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Marks {
    Points(Vec<u32>),
    /// The vertices at both ends of each line.
    Lines(Vec<[u32; 2]>),
}

/// The diameter of points and lines of a file with these bounds. `asked` is that of the caller.
pub(super) fn diameter(asked: Option<f32>, low: DVec3, high: DVec3) -> f64 {
    let diagonal = libm::sqrt((high - low).length_squared());
    let found = if diagonal > 0.0 && diagonal.is_finite() { diagonal * SHARE } else { 1.0 };
    asked.map_or(found, f64::from)
}

/// The bounds of the positions that are finite; empty bounds at 0 if there are none.
pub(super) fn bounds(positions: impl IntoIterator<Item = [f32; 3]>) -> (DVec3, DVec3) {
    let positions = positions.into_iter().map(|p| DVec3::from(p.map(f64::from)));
    let both = positions.filter(|p| p.is_finite()).fold(None, |both: Option<(DVec3, DVec3)>, p| {
        Some(both.map_or((p, p), |(low, high)| (low.min(p), high.max(p))))
    });
    both.unwrap_or_default()
}

impl Marks {
    /// What they are called.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Points(_) => "points",
            Self::Lines(_) => "lines",
        }
    }

    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }

    fn count(&self) -> usize {
        match self {
            Self::Points(points) => points.len(),
            Self::Lines(lines) => lines.len(),
        }
    }

    /// The triangles, which have the attributes of their vertices in `source`. A vertex without a normal gets none.
    ///
    /// # Errors
    /// There are too many, or a vertex is not there. The text gives the reason.
    pub fn geometry(&self, source: &Geometry, diameter: f64) -> Result<Geometry, String> {
        let (shape, what) = match self {
            Self::Points(points) if points.len() <= OCTAHEDRA => (&OCTAHEDRON[..], "points"),
            Self::Points(_) => (&TETRAHEDRON[..], "points"),
            Self::Lines(_) => (&PRISM[..], "lines"),
        };
        let most = Mesh::MAX_TRIANGLES / shape.len();
        if self.count() > most {
            return Err(format!("{} {what} are more than a mesh may have ({most})", self.count()));
        }
        let vertices = source.positions.len();
        let missing = |vertex: &&u32| **vertex as usize >= vertices;
        let used = match self {
            Self::Points(points) => points,
            Self::Lines(lines) => lines.as_flattened(),
        };
        if let Some(vertex) = used.iter().find(missing) {
            return Err(format!("{what} use vertex {vertex} of {vertices}"));
        }
        let radius = (0.5 * diameter) as f32;
        let mut drawn = Geometry::default();
        // The vertex that each corner belongs to.
        let mut from = Vec::new();
        for number in 0..self.count() {
            let first = from.len() as u32;
            let mut corner = |vertex: u32, offset: Vec3| {
                from.push(vertex);
                drawn.positions.push((Vec3::from(source.positions[vertex as usize]) + offset).to_array());
            };
            match self {
                Self::Points(points) if shape.len() == TETRAHEDRON.len() => {
                    for offset in TETRAHEDRON_CORNERS {
                        corner(points[number], offset * (radius * core::f32::consts::FRAC_1_SQRT_2));
                    }
                }
                Self::Points(points) => {
                    for offset in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z] {
                        corner(points[number], offset * radius);
                    }
                }
                Self::Lines(lines) => {
                    let [start, end] = lines[number];
                    let [a, b] = [start, end].map(|i| Vec3::from(source.positions[i as usize]).as_dvec3());
                    let (along, around) = frame(b - a, f64::from(radius));
                    around.iter().for_each(|&offset| corner(start, offset));
                    around.iter().for_each(|&offset| corner(end, offset));
                    corner(start, -along);
                    corner(end, along);
                }
            }
            drawn.indices.extend(shape.as_flattened().iter().map(|corner| first + corner));
        }
        let at = |vertex: &u32| *vertex as usize;
        drawn.attributes =
            from.iter().map(|vertex| source.attributes[at(vertex)]).collect::<Vec<Attribute>>();
        drawn.second_uv =
            source.second_uv.as_ref().map(|uv| from.iter().map(|vertex| uv[at(vertex)]).collect());
        drawn.tangents = match &source.tangents {
            Tangents::Given(given) => Tangents::Given(from.iter().map(|vertex| given[at(vertex)]).collect()),
            other => other.clone(),
        };
        drawn.deform = source.deform.select(&from);
        Ok(drawn)
    }
}

/// Of a prism along `direction`: the offset of its tip, and those of the corners around an end. A line without a length
/// lies along x.
fn frame(direction: DVec3, radius: f64) -> (Vec3, [Vec3; 3]) {
    let unit = |v: DVec3| {
        let length = libm::sqrt(v.length_squared());
        if length > 0.0 && length.is_finite() { v / length } else { DVec3::X }
    };
    let along = unit(direction);
    // An axis that is not along it.
    let axis = if along.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
    let across = unit(along.cross(axis));
    let up = along.cross(across);
    let (half, height) = (0.5, 0.5 * libm::sqrt(3.0));
    let around = [across, up * height - across * half, -up * height - across * half];
    ((along * radius).as_vec3(), around.map(|offset| (offset * radius).as_vec3()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(positions: &[[f32; 3]]) -> Geometry {
        let attribute = |i: usize| Attribute { normal: [0.0; 3], uv: [i as f32, 0.0], color: [i as u32, 0] };
        let attributes = (0..positions.len()).map(attribute).collect();
        Geometry { positions: positions.into(), attributes, ..Geometry::default() }
    }

    /// The volume that triangles enclose, if they run counterclockwise seen from outside.
    fn volume(geometry: &Geometry) -> f64 {
        let corner = |i: u32| DVec3::from(geometry.positions[i as usize].map(f64::from));
        let parts =
            geometry.indices.chunks_exact(3).map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))));
        parts.sum::<f64>() / 6.0
    }

    #[test]
    fn points_are_octahedra_with_their_attributes() {
        let source = source(&[[9.0; 3], [1.0, 2.0, 3.0], [-4.0, 0.0, 0.5]]);
        let drawn = Marks::Points(vec![1, 2]).geometry(&source, 0.5).unwrap();
        assert_eq!((drawn.indices.len(), drawn.positions.len()), (2 * 24, 12));
        assert_eq!(
            bounds(drawn.positions[..6].iter().copied()),
            (DVec3::new(0.75, 1.75, 2.75), DVec3::new(1.25, 2.25, 3.25))
        );
        assert_eq!((drawn.attributes[5].color[0], drawn.attributes[6].color[0]), (1, 2));
        // Of an octahedron: 4/3 r³.
        assert!((volume(&drawn) - 2.0 * 4.0 / 3.0 / 64.0).abs() < 1e-5);
    }

    #[test]
    fn many_points_are_tetrahedra_that_cover_as_much() {
        let one = source(&[[0.0; 3]]);
        let surface = |geometry: &Geometry| -> f64 {
            let corner = |i: u32| DVec3::from(geometry.positions[i as usize].map(f64::from));
            let area =
                |t: &[u32]| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length() * 0.5;
            geometry.indices.chunks_exact(3).map(area).sum()
        };
        let few = Marks::Points(vec![0]).geometry(&one, 1.0).unwrap();
        let many = Marks::Points(vec![0; OCTAHEDRA + 1]).geometry(&one, 1.0).unwrap();
        assert_eq!(many.indices.len(), (OCTAHEDRA + 1) * 12);
        let alone = Geometry { indices: many.indices[..12].into(), ..many };
        assert!((surface(&few) - surface(&alone)).abs() < 1e-5, "{} {}", surface(&few), surface(&alone));
        // With edges of 2 r: (2 r)³ / (6√2).
        assert!((volume(&alone) - 1.0 / (6.0 * 2.0_f64.sqrt())).abs() < 1e-5, "{}", volume(&alone));
    }

    #[test]
    fn lines_are_closed_prisms_from_end_to_end() {
        for end in [[5.0, 0.0, 0.0], [0.0, 5.0, 0.0], [3.0, 0.0, -4.0], [-3.0, 4.0, 0.0]] {
            let drawn = Marks::Lines(vec![[0, 1]]).geometry(&source(&[[0.0; 3], end]), 0.2).unwrap();
            // A triangle of 3/4 √3 r², as long as the line, with two pyramids of height r.
            let triangle = 0.75 * 3.0_f64.sqrt() * 0.01;
            let expected = triangle * (5.0 + 2.0 * 0.1 / 3.0);
            assert!((volume(&drawn) - expected).abs() < 1e-5, "{} {expected}", volume(&drawn));
            let ends: Vec<u32> = drawn.attributes.iter().map(|attribute| attribute.color[0]).collect();
            assert_eq!(ends, [0, 0, 0, 1, 1, 1, 0, 1]);
        }
        let point = Marks::Lines(vec![[0, 0]]).geometry(&source(&[[0.0; 3]]), 2.0).unwrap();
        assert!(point.positions.iter().flatten().all(|c| c.is_finite()));
    }

    #[test]
    fn what_is_too_much_or_not_there_is_refused() {
        let one = source(&[[0.0; 3]]);
        assert_eq!(Marks::Lines(vec![[0, 7]]).geometry(&one, 1.0).unwrap_err(), "lines use vertex 7 of 1");
        let many = Marks::Points(vec![0; Mesh::MAX_TRIANGLES / 4 + 1]).geometry(&one, 1.0).unwrap_err();
        assert_eq!(many, "8388609 points are more than a mesh may have (8388608)");
    }

    #[test]
    fn the_diameter_is_a_share_of_the_diagonal_unless_asked_for() {
        let (low, high) = bounds([[0.0, 0.0, 0.0], [f32::NAN, 9.0, 9.0], [3.0, 4.0, 0.0]]);
        assert_eq!(diameter(None, low, high), 5.0 / 250.0);
        assert_eq!(diameter(Some(0.5), low, high), 0.5);
        assert_eq!(diameter(None, low, low), 1.0);
        assert_eq!(bounds([]), (DVec3::ZERO, DVec3::ZERO));
    }
}
