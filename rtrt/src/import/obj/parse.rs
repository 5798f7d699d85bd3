//! OBJ: from text to polygons.
//!
//! Why not `tobj`: where faces with and without texture coordinates are mixed, as in one
//! of the classic scenes, it returns texture coordinates that belong to other vertices.

use crate::import::color::srgb_to_linear;
use crate::import::error::quoted;
use crate::import::marks::Marks;
use crate::import::polygon::face_normal;
use crate::import::text::{lines, numbers};
use glam::DVec3;
use std::collections::HashMap;

/// One corner of a polygon: vertex, texture coordinates and normal, or [`NONE`].
pub(super) type Corner = [u32; 3];

/// No texture coordinates, or no normal.
pub(super) const NONE: u32 = u32::MAX;

/// A polygon of `Obj::corners`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Polygon {
    pub first: usize,
    pub corners: usize,
    /// An index of `Obj::materials`; none before the first `usemtl`.
    pub material: Option<usize>,
    /// The smoothing group; 0 for none.
    pub smoothing: u32,
}

/// The content of an OBJ file.
#[derive(Debug, Default)]
pub(super) struct Obj {
    pub positions: Vec<[f32; 3]>,
    /// Linear RGB, one a position; empty if no vertex has a color.
    pub colors: Vec<[f32; 3]>,
    /// `v` pointing up.
    pub uvs: Vec<[f32; 2]>,
    pub normals: Vec<[f32; 3]>,
    pub corners: Vec<Corner>,
    pub polygons: Vec<Polygon>,
    /// Points, and lines between neighboring vertices, each with its material.
    pub marks: Vec<(Marks, Option<usize>)>,
    /// The names of materials in the order of their first use.
    pub materials: Vec<String>,
    /// The `mtllib` lines: each names one or several files with materials.
    pub libraries: Vec<String>,
    /// How many references to texture coordinates or normals have no target.
    pub unresolved: usize,
    /// How many references lead to texture coordinates or normals that are not finite.
    pub not_finite: usize,
    /// How many elements are curves or surfaces, or faces of fewer than three corners.
    pub skipped: usize,
}

/// The content of an OBJ file. Unknown keywords are ignored.
///
/// # Errors
/// A number cannot be read, or an index is out of range. The text names the line and the reason.
pub(super) fn parse(bytes: &[u8]) -> Result<Obj, String> {
    let mut obj = Obj::default();
    let (mut material, mut smoothing) = (None, 0);
    let mut names = HashMap::new();
    for (number, line) in lines(bytes) {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((&line, ""));
        let rest = rest.trim();
        let result = match key {
            "v" => obj.vertex(rest),
            "vt" => numbers(rest).map(|n| obj.uvs.push(n.first())),
            "vn" => numbers(rest).map(|n| obj.normals.push(n.first())),
            "f" => obj.face(rest, material, smoothing),
            "s" => {
                // `off` is 0.
                smoothing = rest.parse().unwrap_or(0);
                Ok(())
            }
            "usemtl" => {
                let next = names.len();
                material = Some(*names.entry(rest.to_owned()).or_insert_with(|| {
                    obj.materials.push(rest.to_owned());
                    next
                }));
                Ok(())
            }
            "mtllib" => {
                obj.libraries.push(rest.to_owned());
                Ok(())
            }
            "l" | "p" => obj.marks(key, rest).map(|marks| obj.marks.push((marks, material))),
            "curv" | "surf" => {
                obj.skipped += 1;
                Ok(())
            }
            _ => Ok(()),
        };
        result.map_err(|why| format!("line {number}: {why}"))?;
    }
    obj.check().map(|()| obj)
}

/// The positions of a file that [`parse`] reads, relative to an origin: their digits count as far as double precision
/// goes.
pub(super) fn relative_positions(bytes: &[u8], origin: DVec3) -> Vec<[f32; 3]> {
    let words = |line: String| {
        let mut words = line.split_whitespace().map(str::to_owned).collect::<Vec<_>>().into_iter();
        (words.next().as_deref() == Some("v")).then_some(words)
    };
    let position = |words: std::vec::IntoIter<String>| {
        let mut numbers = words.map(|word| word.parse().unwrap_or(f64::NAN));
        let [x, y, z] = [0; 3].map(|_| numbers.next().unwrap_or(f64::NAN));
        (DVec3::new(x, y, z) - origin).as_vec3().to_array()
    };
    lines(bytes).filter_map(|(_, line)| words(line)).map(position).collect()
}

impl Obj {
    /// Reads `x y z`, perhaps followed by a weight, which polygons do not use, and by a color of 0 ..= 1 in sRGB.
    fn vertex(&mut self, rest: &str) -> Result<(), String> {
        let n = numbers(rest)?;
        if n.count < 3 {
            return Err("a vertex needs three coordinates".into());
        }
        self.positions.push(n.first());
        let color = match n.count {
            6 => Some([n.values[3], n.values[4], n.values[5]]),
            7.. => Some([n.values[4], n.values[5], n.values[6]]),
            _ => None,
        };
        if let Some(color) = color {
            self.colors.resize(self.positions.len() - 1, [1.0; 3]);
            self.colors.push(color.map(|c| srgb_to_linear(f64::from(c.clamp(0.0, 1.0)))));
        }
        Ok(())
    }

    /// Reads corners as `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn face(&mut self, rest: &str, material: Option<usize>, smoothing: u32) -> Result<(), String> {
        let first = self.corners.len();
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        for corner in rest.split_whitespace() {
            let mut parts = corner.split('/');
            let mut indices = [NONE; 3];
            for (index, count) in indices.iter_mut().zip(counts) {
                match parts.next() {
                    Some(part) if !part.is_empty() => *index = reference(part, count)?,
                    _ => {}
                }
            }
            if indices[0] == NONE || parts.next().is_some() {
                return Err(format!("{} is not a corner", quoted(corner)));
            }
            self.corners.push(indices);
        }
        let corners = self.corners.len() - first;
        if corners >= 3 {
            self.polygons.push(Polygon { first, corners, material, smoothing });
        } else {
            self.corners.truncate(first);
            self.skipped += 1;
        }
        Ok(())
    }

    /// Reads the vertices of points (`p`) or of a line (`l`), which may have texture coordinates.
    fn marks(&self, key: &str, rest: &str) -> Result<Marks, String> {
        let vertex = |word: &str| reference(word.split('/').next().unwrap_or(word), self.positions.len());
        let vertices = rest.split_whitespace().map(vertex).collect::<Result<Vec<u32>, _>>()?;
        Ok(if key == "p" {
            Marks::Points(vertices)
        } else {
            Marks::Lines(vertices.windows(2).map(|ends| [ends[0], ends[1]]).collect())
        })
    }

    /// Checks that every corner has its vertex, which may stand after the face. Texture coordinates that are missing or
    /// not finite are removed from their corners, and so are missing normals. A normal that is not finite is replaced by
    /// the normal of the face.
    fn check(&mut self) -> Result<(), String> {
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 3]);
        }
        let is_finite = |numbers: &[f32]| numbers.iter().all(|n| n.is_finite());
        let uvs: Vec<bool> = self.uvs.iter().map(|uv| is_finite(uv)).collect();
        let normals: Vec<bool> = self.normals.iter().map(|normal| is_finite(normal)).collect();
        for (number, polygon) in self.polygons.clone().into_iter().enumerate() {
            let mut face_normal = None;
            for place in polygon.first..polygon.first + polygon.corners {
                let [vertex, uv, normal] = self.corners[place];
                if vertex as usize >= self.positions.len() {
                    let (vertex, count) = (u64::from(vertex) + 1, self.positions.len());
                    return Err(format!("face {} uses vertex {vertex} of {count}", number + 1));
                }
                match uvs.get(uv as usize) {
                    Some(true) => {}
                    found => {
                        self.not_finite += usize::from(found.is_some());
                        self.unresolved += usize::from(found.is_none() && uv != NONE);
                        self.corners[place][1] = NONE;
                    }
                }
                self.corners[place][2] = match normals.get(normal as usize) {
                    Some(true) => normal,
                    Some(false) => {
                        self.not_finite += 1;
                        *face_normal.get_or_insert_with(|| self.add_face_normal(&polygon))
                    }
                    None => {
                        self.unresolved += usize::from(normal != NONE);
                        NONE
                    }
                };
            }
        }
        Ok(())
    }

    /// The index of a new normal: that of a polygon whose vertices exist.
    pub fn add_face_normal(&mut self, polygon: &Polygon) -> u32 {
        let normal = face_normal(&self.outline(polygon));
        self.normals.push(normal.as_vec3().to_array());
        self.normals.len() as u32 - 1
    }

    /// The positions of a polygon's corners.
    pub fn outline(&self, polygon: &Polygon) -> Vec<DVec3> {
        let corners = &self.corners[polygon.first..polygon.first + polygon.corners];
        corners.iter().map(|corner| DVec3::from(self.positions[corner[0] as usize].map(f64::from))).collect()
    }
}

/// The index that a reference means: it counts from 1, or back from the last element before the face.
fn reference(text: &str, count: usize) -> Result<u32, String> {
    let wrong = || format!("{} is not an index", quoted(text));
    let number: i64 = text.parse().map_err(|_| wrong())?;
    let index = if number < 0 { count as i64 + number } else { number - 1 };
    match u32::try_from(index) {
        Ok(index) if index != NONE => Ok(index),
        _ => Err(wrong()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_count_from_one_or_back() {
        let obj = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1 2//1 -1\n").unwrap();
        assert_eq!(obj.corners, [[0, NONE, NONE], [1, NONE, 0], [2, NONE, NONE]]);
    }

    #[test]
    fn errors_name_their_line() {
        assert_eq!(parse(b"v 0 0 0\nv 1 x 0").unwrap_err(), "line 2: \"x\" is not a number");
        assert_eq!(parse(b"f 0 1 2").unwrap_err(), "line 1: \"0\" is not an index");
        assert_eq!(parse(b"v 0 0 0\nf 1 1 2").unwrap_err(), "face 1 uses vertex 2 of 1");
        assert!(parse(b"f 1/2/3/4 1 1").is_err() && parse(b"f -1 -1 -1").is_err());
    }

    #[test]
    fn vertex_colors_are_srgb() {
        // sRGB 0.5 is 0.2140 in linear light; values are clamped; the weight before a color is no color.
        let obj = parse(b"v 0 0 0 0.5 1 0\nv 0 0 0\nv 0 0 0 1 0.5 2 -1\n").unwrap();
        assert!((obj.colors[0][0] - 0.214_041).abs() < 1e-6);
        assert_eq!(obj.colors[0][1..], [1.0, 0.0]);
        assert_eq!(obj.colors[1], [1.0; 3]);
        assert_eq!(obj.colors[2], [obj.colors[0][0], 1.0, 0.0]);
    }

    #[test]
    fn corners_with_a_normal_that_is_not_finite_have_the_normal_of_the_face() {
        let obj = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn nan 0 0\nvn 0 1 0\nf 1//1 2//2 3//1\n").unwrap();
        let normals = [0, 1, 2].map(|corner: usize| obj.normals[obj.corners[corner][2] as usize]);
        assert_eq!(normals, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let obj = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1.#QNAN 0\nvt 1 1\nf 1/1 2/2 3/2\n").unwrap();
        assert_eq!(obj.corners.iter().map(|corner| corner[1]).collect::<Vec<_>>(), [NONE, 1, 1]);
        assert_eq!((obj.not_finite, obj.unresolved), (1, 0));
    }
}
