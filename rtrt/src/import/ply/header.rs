//! The header of a PLY file: what its body holds, and how.

use crate::import::error::quoted;

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// The number that stands for the full brightness of a color: the largest integer, or 1.
    pub fn full(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// A property of an element: a number or a list of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Property {
    pub name: String,
    pub of: Type,
    /// The type of a list's length; none if the property is a number.
    pub length: Option<Type>,
}

/// A kind of elements that the body holds one after another.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// A header.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The images that `comment TextureFile` lines name, as MeshLab writes them.
    pub textures: Vec<String>,
    /// Where the body begins.
    pub body: usize,
}

/// Whether the bytes begin as a PLY file does.
pub(in crate::import) fn looks_like(bytes: &[u8]) -> bool {
    matches!(bytes, [b'p', b'l', b'y', b'\r' | b'\n', ..])
}

/// The header of a file.
///
/// # Errors
/// It is not one. The text names the line and the reason.
pub(super) fn parse(bytes: &[u8]) -> Result<Header, String> {
    if !looks_like(bytes) {
        return Err("its first line is not \"ply\"".into());
    }
    // Lines of old Macs end in a carriage return alone.
    let end_of_line = if bytes[3] == b'\r' && bytes.get(4) != Some(&b'\n') { b'\r' } else { b'\n' };
    let mut encoding = None;
    let (mut elements, mut textures) = (Vec::<Element>::new(), Vec::new());
    let (mut at, mut number) = (0, 0);
    loop {
        let rest = &bytes[at..];
        let length = rest.iter().position(|&byte| byte == end_of_line).ok_or("the header has no end")?;
        let line = String::from_utf8_lossy(&rest[..length]);
        (at, number) = (at + length + 1, number + 1);
        let failed = |why: &str| format!("line {number} of the header: {why}");
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["end_header"] => break,
            ["format", name, ..] => {
                encoding = Some(match name {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(failed(&format!("{} is not a format", quoted(name)))),
                });
            }
            ["element", name, count] => {
                let count =
                    count.parse().map_err(|_| failed(&format!("{} is not a number", quoted(count))))?;
                elements.push(Element { name: name.into(), count, properties: Vec::new() });
            }
            ["property", ref words @ ..] => {
                let of = |name: &str| {
                    Type::named(name).ok_or_else(|| failed(&format!("{} is not a type", quoted(name))))
                };
                let property = match *words {
                    ["list", length, kind, name] => {
                        Property { name: name.into(), of: of(kind)?, length: Some(of(length)?) }
                    }
                    [kind, name] => Property { name: name.into(), of: of(kind)?, length: None },
                    _ => return Err(failed("a property has a type and a name")),
                };
                let element =
                    elements.last_mut().ok_or_else(|| failed("a property stands before an element"))?;
                element.properties.push(property);
            }
            ["comment", "TextureFile", ..] => {
                let name = line.split_once("TextureFile").map_or("", |(_, name)| name.trim());
                textures.push(name.to_owned());
            }
            ["ply" | "comment" | "obj_info", ..] | [] => {}
            [word, ..] => return Err(failed(&format!("{} is not a keyword", quoted(word)))),
        }
    }
    let encoding = encoding.ok_or("the header names no format")?;
    Ok(Header { encoding, elements, textures, body: at })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "ply\nformat binary_big_endian 1.0\ncomment made here\ncomment TextureFile my wood.png\n\
                          element vertex 2\nproperty float x\nproperty uchar red\nobj_info none\nelement face 1\n\
                          property list uint8 int32 vertex_indices\nend_header\n";

    #[test]
    fn lines_end_in_any_way() {
        let unix = parse(format!("{HEADER}\n\r").as_bytes()).unwrap();
        assert_eq!(
            (unix.encoding, unix.textures.as_slice()),
            (Encoding::Big, &["my wood.png".to_owned()][..])
        );
        assert_eq!(unix.body, HEADER.len());
        let property = |name: &str, of, length| Property { name: name.into(), of, length };
        let vertex = vec![property("x", Type::F32, None), property("red", Type::U8, None)];
        let face = vec![property("vertex_indices", Type::I32, Some(Type::U8))];
        let element = |name: &str, count, properties| Element { name: name.into(), count, properties };
        assert_eq!(unix.elements, [element("vertex", 2, vertex), element("face", 1, face)]);
        for end in ["\r", "\r\n"] {
            let header = HEADER.replace('\n', end);
            let found = parse(format!("{header}\n").as_bytes()).unwrap();
            assert_eq!(found, Header { body: header.len(), ..parse(HEADER.as_bytes()).unwrap() });
        }
    }

    #[test]
    fn errors_name_their_line() {
        let refused = |from: &str, to: &str| parse(HEADER.replace(from, to).as_bytes()).unwrap_err();
        assert_eq!(refused("ply\n", "PLY\n"), "its first line is not \"ply\"");
        assert_eq!(refused("end_header\n", "end_header"), "the header has no end");
        assert_eq!(refused("big", "odd"), "line 2 of the header: \"binary_odd_endian\" is not a format");
        assert_eq!(refused("vertex 2", "vertex -2"), "line 5 of the header: \"-2\" is not a number");
        assert_eq!(refused("float x", "real x"), "line 6 of the header: \"real\" is not a type");
        assert_eq!(refused("float x", "float"), "line 6 of the header: a property has a type and a name");
        assert_eq!(
            refused("element vertex 2\n", ""),
            "line 5 of the header: a property stands before an element"
        );
        assert_eq!(refused("obj_info", "info"), "line 8 of the header: \"info\" is not a keyword");
        assert_eq!(refused("format binary_big_endian 1.0\n", ""), "the header names no format");
    }
}
