//! STL: triangles, binary or as text.
//!
//! The format has neither units nor axes. Coordinates are taken as they are: one unit of the file is one of the scene,
//! and +y is up, as in glTF.
//!
//! Facets are flat. They share no corners, so nothing says where a surface is smooth. The side from which the corners
//! run counterclockwise is the front, as the format demands; the normal that a facet states has no effect, because
//! exporters often write 0 0 0.

use super::builder::Builder;
use super::geometry::Geometry;
use super::origin::{Bounds, relative};
use super::{ImportError, text};
use glam::Mat4;
use rtrt_core::layout::Attribute;
use rtrt_core::scene::{Join, Material};
use std::collections::HashMap;

/// The bytes before the facets of a binary file: a comment, and the number of facets.
const HEADER: usize = 84;
/// The bytes of a facet: normal, three corners, and a word whose meaning the format leaves open.
const FACET: usize = 50;

type Facet = [[f32; 3]; 3];

/// What a file holds.
#[derive(Debug, Default, PartialEq)]
struct Stl {
    facets: Vec<Facet>,
    /// Whether the open word of a facet is not 0. Some programs write colors there.
    has_words: bool,
    /// Whether the text ends without `endsolid`.
    is_open: bool,
}

/// Whether the bytes begin as text of this format does, or are as long as a binary file says of itself.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    is_text(bytes) || (bytes.len() > HEADER && binary_length(bytes) == Some(bytes.len() as u64))
}

/// Adds the facets of a file to the scene as one object.
pub(super) fn load<J: Join>(builder: &mut Builder<'_, J>, bytes: &[u8]) -> Result<(), ImportError> {
    let mut stl = parse(bytes).map_err(|why| builder.invalid(why))?;
    builder.origin = Bounds::of(stl.facets.as_flattened()).origin();
    relative(stl.facets.as_flattened_mut(), builder.origin);
    if stl.has_words {
        builder.not_drawn.insert("colors of STL facets");
    }
    if stl.is_open {
        builder.warn("the text ends without \"endsolid\"; the end of the file may be missing".into());
    }
    let name = "the facets";
    let mesh = builder.add_mesh(name, geometry(&stl.facets))?;
    let material = builder.add_material(Material::new([0.7; 3]).roughness(0.8))?;
    builder.name_material("default".into());
    let object = builder.add_instance(name, mesh, material, Mat4::IDENTITY)?;
    builder.label_file(object, "facets");
    Ok(())
}

/// The facets of a file.
///
/// A file is binary if it is long enough for the number of facets that a binary header would state. Four letters there
/// would be a number of facets that no file can hold, so text is never taken for binary; and a binary file may begin
/// with `solid`, which some do.
///
/// # Errors
/// The file is cut off, or is no STL file. The text names the place and the reason.
fn parse(bytes: &[u8]) -> Result<Stl, String> {
    let stl = match binary_length(bytes) {
        Some(length) if length <= bytes.len() as u64 => binary(bytes),
        _ if is_text(bytes) => as_text(&text::utf8(bytes))?,
        Some(length) => {
            let (facets, has) = ((length - HEADER as u64) / FACET as u64, bytes.len());
            return Err(format!("{facets} facets need {length} bytes; the file has {has}"));
        }
        None => return Err(format!("{} bytes are no STL file", bytes.len())),
    };
    if stl.facets.is_empty() { Err("it has no facets".into()) } else { Ok(stl) }
}

fn is_text(bytes: &[u8]) -> bool {
    let start = text::utf8(&bytes[..bytes.len().min(1024) & !1]);
    start.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// The length of a binary file with this header, bytes.
fn binary_length(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
    Some(HEADER as u64 + u64::from(count) * FACET as u64)
}

/// The facets of a binary file, which is at least as long as its header says.
fn binary(bytes: &[u8]) -> Stl {
    let count = binary_length(bytes).map_or(0, |length| (length as usize - HEADER) / FACET);
    let records = || bytes[HEADER..].chunks_exact(FACET).take(count);
    let number =
        |record: &[u8], at: usize| f32::from_le_bytes([0, 1, 2, 3].map(|byte| record[12 + 4 * at + byte]));
    let facet =
        |record: &[u8]| [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| number(record, 3 * corner + axis)));
    Stl {
        facets: records().map(facet).collect(),
        has_words: records().any(|record| record[FACET - 2..] != [0, 0]),
        is_open: false,
    }
}

/// The facets of a text.
fn as_text(bytes: &[u8]) -> Result<Stl, String> {
    let mut stl = Stl { is_open: true, ..Stl::default() };
    let mut corners: Vec<[f32; 3]> = Vec::with_capacity(4);
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        let line = line.trim();
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let failed = |why: String| format!("line {}: {why}", number + 1);
        match key {
            _ if key.eq_ignore_ascii_case("vertex") => {
                let numbers = text::numbers(rest).map_err(failed)?;
                if numbers.count != 3 {
                    return Err(failed("a corner needs three coordinates".into()));
                }
                if corners.len() == 3 {
                    return Err(failed("a facet has more than three corners".into()));
                }
                corners.push(numbers.first());
            }
            _ if key.eq_ignore_ascii_case("endloop") => {
                let facet = corners[..].try_into();
                stl.facets.push(facet.map_err(|_| failed(format!("a facet has {} corners", corners.len())))?);
                corners.clear();
            }
            _ if key.eq_ignore_ascii_case("endsolid") => stl.is_open = false,
            _ => {}
        }
    }
    if corners.is_empty() { Ok(stl) } else { Err("the text ends within a facet".into()) }
}

/// The triangles. Equal corners share a vertex, and none has a normal: the renderer then takes those of the triangles.
fn geometry(facets: &[Facet]) -> Geometry {
    let mut geometry = Geometry::default();
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    for corner in facets.as_flattened() {
        let vertex = *known.entry(corner.map(f32::to_bits)).or_insert_with(|| {
            geometry.positions.push(*corner);
            geometry.positions.len() as u32 - 1
        });
        geometry.indices.push(vertex);
    }
    let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
    geometry.attributes = vec![attribute; geometry.positions.len()];
    geometry
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACETS: [Facet; 2] =
        [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0], [1.0, 1.5e2, 0.0], [0.0, 1.0, 0.0]]];

    fn binary_file(word: u16) -> Vec<u8> {
        let mut bytes = b"solid in name only".to_vec();
        bytes.resize(80, 0);
        bytes.extend(2_u32.to_le_bytes());
        for facet in FACETS {
            bytes.extend([7.0_f32; 3].map(f32::to_le_bytes).as_flattened());
            bytes.extend(facet.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
            bytes.extend(word.to_le_bytes());
        }
        bytes
    }

    const TEXT: &str = "Solid a thing\r\n facet normal 0 0 1\r\n  OUTER LOOP\r\n   vertex 0 0 0\r\n   vertex 1 0 0\r\n   \
                        vertex 0 1e0 0\r\n  endloop\r\n endfacet\r\nfacet normal nan nan nan\nouter loop\nvertex 1 0 0\n\
                        vertex 1 1.5E+02 0\n\tVERTEX 0 1 -0\nendloop\nendfacet\nendsolid a thing\n";

    #[test]
    fn text_and_binary_files_give_the_same_facets() {
        let binary = parse(&binary_file(0)).unwrap();
        assert_eq!(binary, Stl { facets: FACETS.into(), ..Stl::default() });
        assert_eq!(parse(TEXT.as_bytes()).unwrap().facets, binary.facets);
        assert!(parse(&binary_file(0x8010)).unwrap().has_words);
        // Some programs append something.
        assert_eq!(parse(&[&binary_file(0)[..], b"more"].concat()).unwrap(), binary);
        let marked = [b"\xef\xbb\xbf", TEXT.as_bytes()].concat();
        assert_eq!(parse(&marked).unwrap().facets, binary.facets);
    }

    #[test]
    fn corners_are_shared_and_have_no_normals() {
        let geometry = geometry(&FACETS);
        assert_eq!(geometry.indices, [0, 1, 2, 1, 3, 2]);
        assert_eq!(geometry.positions.len(), 4);
        assert!(geometry.attributes.iter().all(|attribute| attribute.normal == [0.0; 3]));
    }

    #[test]
    fn cut_files_are_refused_with_the_reason() {
        let refused = |bytes: &[u8]| parse(bytes).unwrap_err();
        let mut cut = binary_file(0);
        cut[..5].fill(0);
        cut.truncate(183);
        assert_eq!(refused(&cut), "2 facets need 184 bytes; the file has 183");
        cut.truncate(50);
        assert_eq!(refused(&cut), "50 bytes are no STL file");
        cut = binary_file(0);
        cut[80..84].fill(0);
        assert_eq!(refused(&cut), "it has no facets");
        assert_eq!(refused(b"solid x\nendsolid x\n"), "it has no facets");
        assert_eq!(refused(b"solid x\nouter loop\nvertex 0 0 0"), "the text ends within a facet");
        assert_eq!(refused(b"solid x\nvertex 0 0\n"), "line 2: a corner needs three coordinates");
        assert_eq!(refused(b"solid x\nvertex 0 0 y\n"), "line 2: \"y\" is not a number");
        assert_eq!(refused(b"solid x\nvertex 0 0 0\nendloop\n"), "line 3: a facet has 1 corners");
        let endless = "solid\n".to_owned() + &"vertex 0 0 0\n".repeat(4);
        assert_eq!(refused(endless.as_bytes()), "line 5: a facet has more than three corners");
        // A text that ends between facets is drawn, with a word.
        let cut = TEXT.split_once("facet normal nan").unwrap().0;
        let stl = parse(cut.as_bytes()).unwrap();
        assert_eq!((stl.facets.len(), stl.is_open), (1, true));
    }

    #[test]
    fn formats_are_told_apart() {
        assert!(looks_like(TEXT.as_bytes()) && looks_like(&binary_file(0)));
        assert!(!looks_like(b"v 0 0 0\n") && !looks_like(b"") && !looks_like(&[0; 84]));
    }
}
