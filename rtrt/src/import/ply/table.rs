//! The vertices and faces of a PLY file.

use super::header::{Element, Header, Property, Type};
use super::reader::Reader;
use crate::import::color::srgb_to_linear;
use glam::DVec3;
use rtrt_core::layout::Attribute;

/// What a file holds. A list of normals, texture coordinates or colors is empty if the file has none.
#[derive(Debug, Default)]
pub(super) struct Ply {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    /// `v` pointing up.
    pub uvs: Vec<[f32; 2]>,
    /// Linear, packed.
    pub colors: Vec<[u32; 2]>,
    pub faces: Faces,
    /// How many faces have fewer than three corners.
    pub skipped: usize,
    /// The vertices of each edge, in range.
    pub edges: Vec<[u32; 2]>,
}

/// Polygons with their corners.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// The vertices of all corners, in range.
    pub corners: Vec<u32>,
    /// Where the corners of each face end.
    pub ends: Vec<usize>,
    /// One for each corner.
    pub uvs: Vec<[f32; 2]>,
    /// One for each face.
    pub colors: Vec<[u32; 2]>,
}

/// What a property means.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Meaning {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Color(usize),
    /// The vertices of a face or of strips.
    Corners,
    CornerUvs,
    /// A vertex of an edge.
    End(usize),
    Nothing,
}

impl Meaning {
    fn of(property: &Property) -> Self {
        use Meaning::{Color, CornerUvs, Corners, End, Normal, Nothing, Position, Uv};
        let is_list = property.length.is_some();
        match property.name.as_str() {
            "vertex_indices" | "vertex_index" if is_list => Corners,
            "texcoord" if is_list => CornerUvs,
            _ if is_list => Nothing,
            "vertex1" => End(0),
            "vertex2" => End(1),
            "x" => Position(0),
            "y" => Position(1),
            "z" => Position(2),
            "nx" => Normal(0),
            "ny" => Normal(1),
            "nz" => Normal(2),
            "u" | "s" | "texture_u" => Uv(0),
            "v" | "t" | "texture_v" => Uv(1),
            "red" | "r" | "diffuse_red" => Color(0),
            "green" | "g" | "diffuse_green" => Color(1),
            "blue" | "b" | "diffuse_blue" => Color(2),
            "alpha" | "a" | "diffuse_alpha" => Color(3),
            _ => Nothing,
        }
    }
}

/// The columns of an element.
struct Columns<'a> {
    properties: Vec<(&'a Property, Meaning)>,
    /// The linear value of each sRGB byte.
    linear: Vec<f32>,
}

/// A row of an element: its numbers and lists.
struct Row {
    position: [f64; 3],
    normal: [f64; 3],
    uv: [f64; 2],
    /// Linear, but for alpha.
    color: [f32; 4],
    corners: Vec<f64>,
    corner_uvs: Vec<f64>,
    ends: [f64; 2],
}

impl<'a> Columns<'a> {
    fn new(element: &'a Element) -> Self {
        let properties = element.properties.iter().map(|property| (property, Meaning::of(property)));
        let linear = (0..=u8::MAX).map(|byte| srgb_to_linear(f64::from(byte) / 255.0));
        Self { properties: properties.collect(), linear: linear.collect() }
    }

    fn has(&self, meanings: &[Meaning]) -> bool {
        meanings.iter().all(|meaning| self.properties.iter().any(|(_, has)| has == meaning))
    }

    /// Reads a row into `row`, where it replaces what its columns have.
    fn read(&self, reader: &mut Reader<'_>, row: &mut Row) -> Result<(), String> {
        for &(property, meaning) in &self.properties {
            if let Some(length) = property.length {
                let length = reader.number(length)?;
                if !(length >= 0.0 && length.fract() == 0.0) {
                    return Err(format!("a list has the length {length}"));
                }
                let mut nowhere = Vec::new();
                let list = match meaning {
                    Meaning::Corners => &mut row.corners,
                    Meaning::CornerUvs => &mut row.corner_uvs,
                    _ => &mut nowhere,
                };
                list.clear();
                for _ in 0..length as u64 {
                    let number = reader.number(property.of)?;
                    if meaning != Meaning::Nothing {
                        list.push(number);
                    }
                }
                continue;
            }
            let number = reader.number(property.of)?;
            match meaning {
                Meaning::Position(i) => row.position[i] = number,
                Meaning::Normal(i) => row.normal[i] = number,
                Meaning::Uv(i) => row.uv[i] = number,
                Meaning::End(i) => row.ends[i] = number,
                Meaning::Color(3) => row.color[3] = (number / property.of.full()) as f32,
                Meaning::Color(i) if property.of == Type::U8 => {
                    row.color[i] = self.linear.get(number as usize).copied().unwrap_or(1.0);
                }
                Meaning::Color(i) => {
                    row.color[i] = srgb_to_linear((number / property.of.full()).clamp(0.0, 1.0));
                }
                Meaning::Corners | Meaning::CornerUvs | Meaning::Nothing => {}
            }
        }
        Ok(())
    }
}

impl Row {
    fn new() -> Self {
        Self {
            position: [0.0; 3],
            normal: [0.0; 3],
            uv: [0.0; 2],
            color: [1.0; 4],
            corners: Vec::new(),
            corner_uvs: Vec::new(),
            ends: [0.0; 2],
        }
    }
}

/// What the file with this header holds, with positions relative to an origin.
///
/// # Errors
/// The file is cut off, a number cannot be read, or an index is out of range. The text names the place and the reason.
pub(super) fn read(header: &Header, bytes: &[u8], origin: DVec3) -> Result<Ply, String> {
    let mut reader = Reader::new(&bytes[header.body..], header.encoding);
    let mut ply = Ply::default();
    // An element without properties has no bytes, however often it is there.
    for element in header.elements.iter().filter(|element| !element.properties.is_empty()) {
        let columns = Columns::new(element);
        let mut row = Row::new();
        match element.name.as_str() {
            "vertex" => ply.prepare(&columns, element.count.min(reader.most() as u64) as usize)?,
            "face" | "tristrips" if !columns.has(&[Meaning::Corners]) => {
                return Err(format!("the elements \"{}\" have no vertex_indices", element.name));
            }
            "edge" if !columns.has(&[Meaning::End(0), Meaning::End(1)]) => {
                return Err("the edges have no vertex1 and vertex2".into());
            }
            _ => {}
        }
        for number in 0..element.count {
            let failed = |why: String| format!("{} {number}: {why}", element.name.escape_debug());
            columns.read(&mut reader, &mut row).map_err(failed)?;
            match element.name.as_str() {
                "vertex" => ply.add_vertex(&columns, &row, origin),
                "face" => ply.add_face(&columns, &row).map_err(failed)?,
                "edge" => {
                    let [a, b] = row.ends.map(index);
                    ply.edges.push([a.map_err(failed)?, b.map_err(failed)?]);
                }
                "tristrips" => ply.add_strips(&row.corners).map_err(failed)?,
                _ => {}
            }
        }
    }
    if u32::try_from(ply.faces.corners.len()).is_err() || u32::try_from(ply.positions.len()).is_err() {
        return Err("it has more than 4 billion corners or vertices".into());
    }
    let vertices = ply.positions.len();
    let mut used = ply.faces.corners.iter().chain(ply.edges.as_flattened());
    match used.find(|&&vertex| vertex as usize >= vertices) {
        Some(vertex) => Err(format!("a face or an edge uses vertex {vertex} of {vertices}")),
        None => Ok(ply),
    }
}

const NORMAL: [Meaning; 3] = [Meaning::Normal(0), Meaning::Normal(1), Meaning::Normal(2)];
const UV: [Meaning; 2] = [Meaning::Uv(0), Meaning::Uv(1)];
const COLOR: [Meaning; 3] = [Meaning::Color(0), Meaning::Color(1), Meaning::Color(2)];

impl Ply {
    /// Checks the columns of vertices and makes room for `count`.
    fn prepare(&mut self, columns: &Columns<'_>, count: usize) -> Result<(), String> {
        if !columns.has(&[Meaning::Position(0), Meaning::Position(1), Meaning::Position(2)]) {
            return Err("the vertices have no x, y and z".into());
        }
        if !self.positions.is_empty() {
            return Err("it has two lists of vertices".into());
        }
        self.positions.reserve(count / columns.properties.len());
        Ok(())
    }

    fn add_vertex(&mut self, columns: &Columns<'_>, row: &Row, origin: DVec3) {
        self.positions.push((DVec3::from(row.position) - origin).as_vec3().to_array());
        if columns.has(&NORMAL) {
            self.normals.push(row.normal.map(|c| c as f32));
        }
        if columns.has(&UV) {
            self.uvs.push(row.uv.map(|c| c as f32));
        }
        if columns.has(&COLOR) {
            self.colors.push(Attribute::pack_color(row.color));
        }
    }

    fn add_face(&mut self, columns: &Columns<'_>, row: &Row) -> Result<(), String> {
        let corners = row.corners.len();
        if corners < 3 {
            self.skipped += 1;
            return Ok(());
        }
        for &corner in &row.corners {
            self.faces.corners.push(index(corner)?);
        }
        if columns.has(&[Meaning::CornerUvs]) {
            // Some faces have none.
            let uv =
                |corner: usize| [0, 1].map(|i| row.corner_uvs.get(2 * corner + i).map_or(0.0, |&c| c as f32));
            self.faces.uvs.extend((0..corners).map(uv));
        }
        if columns.has(&COLOR) {
            self.faces.colors.push(Attribute::pack_color(row.color));
        }
        self.faces.ends.push(self.faces.corners.len());
        Ok(())
    }

    /// Adds the triangles of strips, every other one turned. A negative index ends a strip.
    fn add_strips(&mut self, corners: &[f64]) -> Result<(), String> {
        for strip in corners.split(|&corner| corner < 0.0) {
            for (number, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = [index(corners[0])?, index(corners[1])?, index(corners[2])?];
                self.faces.corners.extend(if number % 2 == 0 { [a, b, c] } else { [b, a, c] });
                self.faces.ends.push(self.faces.corners.len());
            }
        }
        Ok(())
    }
}

/// A number as an index.
fn index(number: f64) -> Result<u32, String> {
    let index = number as u32;
    if f64::from(index) == number { Ok(index) } else { Err(format!("{number} is not an index")) }
}

#[cfg(test)]
mod tests {
    use super::super::header;
    use super::*;

    fn table(text: &str) -> Result<Ply, String> {
        read(&header::parse(text.as_bytes()).unwrap(), text.as_bytes(), DVec3::ZERO)
    }

    /// A file with a triangle, with more properties of vertices and of the face, and what stands after these words.
    fn triangle(vertex: &str, face: &str, body: &str) -> String {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n{vertex}\
             element face 1\nproperty list uchar int vertex_index\n{face}end_header\n{body}"
        )
    }

    #[test]
    fn properties_are_known_by_their_names() {
        let more = "property float quality\nproperty list uchar int spare\nproperty ushort red\nproperty float green\n\
                    property uchar blue\nproperty uchar alpha\nproperty float nx\nproperty float ny\nproperty float nz\n\
                    property float s\nproperty float t\n";
        let body = "0 0 0 9 2 7 7 65535 0.5 188 51 0 0 1 0.25 0.75\n1 0 0 9 0 0 2 300 0 0 1 0 0 0\n\
                    0 1 0 9 1 5 0 0 0 0 0 0 1 1 1\n3 0 1 2";
        let ply = table(&triangle(more, "", body)).unwrap();
        assert_eq!(ply.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!((ply.normals[1], ply.uvs[0]), ([0.0, 1.0, 0.0], [0.25, 0.75]));
        // sRGB 1 is 1 in linear light, 0.5 is 0.2140, 188 of 255 is 0.5029; alpha is linear. 255 of each are full.
        assert_eq!(ply.colors[0], [65_535 | 14_028 << 16, 32_957 | 13_107 << 16]);
        assert_eq!(ply.colors[1], [65_535 << 16, 65_535]);
        assert_eq!((ply.faces.corners, ply.faces.ends), (vec![0, 1, 2], vec![3]));
    }

    #[test]
    fn corners_may_have_texture_coordinates_and_strips_may_be_several() {
        let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1\n";
        let ply = table(&triangle("", "property list uchar float texcoord\n", body)).unwrap();
        assert_eq!(ply.faces.uvs, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        let strips =
            triangle("", "", "0 0 0\n1 0 0\n0 1 0\n9 0 1 2 0 -1 2 1 0 -1\n").replace("face", "tristrips");
        assert_eq!(table(&strips).unwrap().faces.corners, [0, 1, 2, 2, 1, 0, 2, 1, 0]);
    }

    #[test]
    fn errors_name_their_place() {
        let refused = |body: &str| table(&triangle("", "", body)).unwrap_err();
        assert_eq!(refused("0 0 0 1 0"), "vertex 1: the file ends");
        assert_eq!(refused("0 0 0 1 0 z 0 0 0"), "vertex 1: \"z\" is not a number");
        assert_eq!(refused("0 0 0 1 0 0 0 1 0 3 0 1"), "face 0: the file ends");
        assert_eq!(refused("0 0 0 1 0 0 0 1 0 3 0 1 3"), "a face or an edge uses vertex 3 of 3");
        assert_eq!(refused("0 0 0 1 0 0 0 1 0 3 0 1 -1"), "face 0: -1 is not an index");
        assert_eq!(refused("0 0 0 1 0 0 0 1 0 -3 0 1 2"), "face 0: a list has the length -3");
        assert_eq!(refused("0 0 0 1 0 0 0 1 0 4294967295 0 1 2"), "face 0: the file ends");
        let without = triangle("", "", "").replace("double z", "double depth");
        assert_eq!(table(&without).unwrap_err(), "the vertices have no x, y and z");
        let without = triangle("", "", "0 0 0 0 0 0 0 0 0").replace("vertex_index", "corners");
        assert_eq!(table(&without).unwrap_err(), "the elements \"face\" have no vertex_indices");
        assert_eq!(table(&triangle("", "", "0 0 0 1 0 0 0 1 0 2 0 1")).unwrap().skipped, 1);
    }

    #[test]
    fn a_count_alone_takes_no_memory() {
        let vast = triangle("", "", "0 0 0").replace("vertex 3", "vertex 18446744073709551615");
        assert_eq!(table(&vast).unwrap_err(), "vertex 1: the file ends");
        let empty = "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n";
        assert!(table(empty).unwrap().positions.is_empty());
    }
}
