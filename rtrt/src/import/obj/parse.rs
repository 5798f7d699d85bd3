//! OBJ: from text to polygons.
//!
//! Why not `tobj`: where faces with and without texture coordinates are mixed, as in one
//! of the classic scenes, it returns texture coordinates that belong to other vertices.

/// One corner of a polygon: vertex, texture coordinates and normal, or [`NONE`].
pub(super) type Corner = [u32; 3];

/// No texture coordinates, or no normal.
pub(super) const NONE: u32 = u32::MAX;

/// A polygon of `Obj::corners`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Polygon {
    pub first: usize,
    pub corners: usize,
    /// Of `Obj::materials`; none before the first `usemtl`.
    pub material: Option<usize>,
}

/// What an OBJ file says.
#[derive(Debug, Default)]
pub(super) struct Obj {
    pub positions: Vec<[f32; 3]>,
    /// Linear RGB, one a position, or empty as long as no vertex has a color.
    pub colors: Vec<[f32; 3]>,
    /// `v` pointing up.
    pub uvs: Vec<[f32; 2]>,
    pub normals: Vec<[f32; 3]>,
    pub corners: Vec<Corner>,
    pub polygons: Vec<Polygon>,
    /// Names in the order in which they are first used.
    pub materials: Vec<String>,
    /// Files with materials.
    pub libraries: Vec<String>,
    /// Texture coordinates and normals that corners refer to and that are not there.
    pub unresolved: usize,
    /// Lines, points, curves and other things that are not polygons.
    pub skipped: usize,
}

/// Reads an OBJ file. Lines that this format does not know are passed over.
///
/// # Errors
/// A number cannot be read or an index is out of range: the line, and why.
pub(super) fn parse(bytes: &[u8]) -> Result<Obj, String> {
    let mut obj = Obj::default();
    let mut material = None;
    let mut names = std::collections::HashMap::new();
    for (number, line) in lines(bytes) {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((&line, ""));
        let rest = rest.trim();
        let result = match key {
            "v" => obj.vertex(rest),
            "vt" => numbers(rest).map(|n| obj.uvs.push([n.first(), n.second()])),
            "vn" => numbers(rest).map(|n| obj.normals.push([n.first(), n.second(), n.third()])),
            "f" => obj.face(rest, material),
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
            "l" | "p" | "curv" | "surf" => {
                obj.skipped += 1;
                Ok(())
            }
            _ => Ok(()),
        };
        result.map_err(|why| format!("line {number}: {why}"))?;
    }
    obj.check().map(|()| obj)
}

impl Obj {
    /// `x y z`, then maybe a weight (of no use to polygons), or a color.
    fn vertex(&mut self, rest: &str) -> Result<(), String> {
        let n = numbers(rest)?;
        if n.count < 3 {
            return Err("a vertex needs three coordinates".into());
        }
        self.positions.push([n.first(), n.second(), n.third()]);
        if n.count >= 6 {
            self.colors.resize(self.positions.len() - 1, [1.0; 3]);
            self.colors.push([n.values[3], n.values[4], n.values[5]]);
        }
        Ok(())
    }

    /// Corners as `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn face(&mut self, rest: &str, material: Option<usize>) -> Result<(), String> {
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
                return Err(format!("{} is not a corner", super::quoted(corner)));
            }
            self.corners.push(indices);
        }
        let corners = self.corners.len() - first;
        if corners >= 3 {
            self.polygons.push(Polygon { first, corners, material });
        } else {
            self.corners.truncate(first);
            self.skipped += 1;
        }
        Ok(())
    }

    /// Whether every corner has its vertex, which may come later in the file than the face.
    /// Texture coordinates and normals that are not there are not needed either.
    fn check(&mut self) -> Result<(), String> {
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 3]);
        }
        for (polygon, place) in self.polygons.iter().enumerate() {
            for [vertex, uv, normal] in &mut self.corners[place.first..place.first + place.corners] {
                if *vertex as usize >= self.positions.len() {
                    let (vertex, count) = (u64::from(*vertex) + 1, self.positions.len());
                    return Err(format!("face {} uses vertex {vertex} of {count}", polygon + 1));
                }
                for (index, count) in [(uv, self.uvs.len()), (normal, self.normals.len())] {
                    if *index != NONE && *index as usize >= count {
                        *index = NONE;
                        self.unresolved += 1;
                    }
                }
            }
        }
        Ok(())
    }
}

/// From 1, or counted back from the last one before the face.
fn reference(text: &str, count: usize) -> Result<u32, String> {
    let wrong = || format!("{} is not an index", super::quoted(text));
    let number: i64 = text.parse().map_err(|_| wrong())?;
    let index = if number < 0 { count as i64 + number } else { number - 1 };
    match u32::try_from(index) {
        Ok(index) if index != NONE => Ok(index),
        _ => Err(wrong()),
    }
}

/// Up to eight numbers.
pub(super) struct Numbers {
    values: [f32; 8],
    pub count: usize,
}

impl Numbers {
    pub fn first(&self) -> f32 {
        self.values[0]
    }
    pub fn second(&self) -> f32 {
        self.values[1]
    }
    pub fn third(&self) -> f32 {
        self.values[2]
    }
}

/// The numbers in a line; those that are not there are 0.
pub(super) fn numbers(rest: &str) -> Result<Numbers, String> {
    let mut numbers = Numbers { values: [0.0; 8], count: 0 };
    for (text, value) in rest.split_whitespace().zip(&mut numbers.values) {
        *value = text.parse().map_err(|_| format!("{} is not a number", super::quoted(text)))?;
        numbers.count += 1;
    }
    Ok(numbers)
}

/// Lines with their numbers, without comments and blanks around; one that ends in a
/// backslash goes on in the next.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, String)> {
    let mut rest = bytes.split(|&b| b == b'\n').enumerate();
    std::iter::from_fn(move || {
        let (number, line) = rest.next()?;
        let mut text = String::from_utf8_lossy(line).trim().to_owned();
        while text.ends_with('\\') {
            text.pop();
            let Some((_, line)) = rest.next() else { break };
            text.push(' ');
            text.push_str(String::from_utf8_lossy(line).trim());
        }
        // Names may have the sign within.
        let starts = |&(at, _): &(usize, &str)| at == 0 || text[..at].ends_with(char::is_whitespace);
        if let Some((comment, _)) = text.match_indices('#').find(starts) {
            text.truncate(text[..comment].trim_end().len());
        }
        Some((number + 1, text))
    })
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
    fn what_is_wrong_is_said_with_its_line() {
        assert_eq!(parse(b"v 0 0 0\nv 1 x 0").unwrap_err(), "line 2: \"x\" is not a number");
        assert_eq!(parse(b"f 0 1 2").unwrap_err(), "line 1: \"0\" is not an index");
        assert_eq!(parse(b"v 0 0 0\nf 1 1 2").unwrap_err(), "face 1 uses vertex 2 of 1");
        assert!(parse(b"f 1/2/3/4 1 1").is_err() && parse(b"f -1 -1 -1").is_err());
    }

    #[test]
    fn lines_go_on_after_a_backslash_and_end_at_a_comment() {
        let text: Vec<_> = lines(b"f 1 \\\n 2 # three\r\n\nusemtl a#b\nv\\").collect();
        assert_eq!(
            text,
            [(1, "f 1  2".into()), (3, String::new()), (4, "usemtl a#b".into()), (5, "v".into())]
        );
    }
}
