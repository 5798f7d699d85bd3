//! Arrays of NumPy: `.npy`, and many of them in an `.npz`.
//!
//! Formats: NumPy's NEP 1 (version 1.0), and PKWARE's APPNOTE for archives whose members are stored as they are.

use rtrt::layers::Layers;

/// An array of 32-bit numbers, with its name.
pub struct Array<'a> {
    pub name: &'static str,
    rows: u32,
    columns: u32,
    /// Numbers a pixel; none for a plane of single numbers.
    components: Option<usize>,
    kind: &'static str,
    words: Words<'a>,
}

enum Words<'a> {
    Floats(&'a [f32]),
    Whole(&'a [u32]),
}

impl<'a> Array<'a> {
    /// Numbers, so many a pixel.
    pub fn floats<const N: usize>(name: &'static str, layers: &Layers, pixels: &'a [[f32; N]]) -> Self {
        let Layers { width: columns, height: rows, .. } = *layers;
        let words = Words::Floats(pixels.as_flattened());
        Self { name, rows, columns, components: Some(N), kind: "<f4", words }
    }

    /// A number a pixel.
    pub fn plane(name: &'static str, layers: &Layers, pixels: &'a [f32]) -> Self {
        let Layers { width: columns, height: rows, .. } = *layers;
        Self { name, rows, columns, components: None, kind: "<f4", words: Words::Floats(pixels) }
    }

    /// A whole number a pixel.
    pub fn numbers(name: &'static str, layers: &Layers, pixels: &'a [u32]) -> Self {
        let Layers { width: columns, height: rows, .. } = *layers;
        Self { name, rows, columns, components: None, kind: "<u4", words: Words::Whole(pixels) }
    }

    /// The array as a `.npy` file.
    pub fn npy(&self) -> Vec<u8> {
        let Self { rows, columns, kind, .. } = self;
        let last = self.components.map_or(String::new(), |count| format!(", {count}"));
        let mut header =
            format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({rows}, {columns}{last}), }}");
        // The numbers begin at a multiple of 64.
        let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
        header.push_str(&" ".repeat(length - 1 - header.len()));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((length as u16).to_le_bytes());
        bytes.extend(header.bytes());
        match self.words {
            Words::Floats(numbers) => bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes())),
            Words::Whole(numbers) => bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes())),
        }
        bytes
    }
}

/// The arrays as an `.npz` file.
///
/// # Errors
/// It would have 4 GiB or more, which this form of archive cannot number.
pub fn npz(arrays: &[Array<'_>]) -> Result<Vec<u8>, &'static str> {
    /// 1 January 1980, the first date there is, so that equal arrays are equal files.
    const DATE: u16 = 1 << 5 | 1;
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for array in arrays {
        let (name, data) = (format!("{}.npy", array.name), array.npy());
        let too_large = |_| "the arrays have 4 GiB or more";
        let (at, size) = (u32::try_from(bytes.len()), u32::try_from(data.len()));
        let (at, size) = (at.map_err(too_large)?, size.map_err(too_large)?);
        // Version, flags, method (stored), time, date, check sum, both sizes, lengths of name and extra field.
        let mut header = Vec::new();
        header.extend([20_u16, 0, 0, 0, DATE].into_iter().flat_map(u16::to_le_bytes));
        header.extend([crc32fast::hash(&data), size, size].into_iter().flat_map(u32::to_le_bytes));
        header.extend([name.len() as u16, 0].into_iter().flat_map(u16::to_le_bytes));
        bytes.extend(b"PK\x03\x04");
        bytes.extend(&header);
        bytes.extend(name.bytes());
        bytes.extend(data);
        // Version that made it; then as before; comment, disk, attributes, place.
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&header);
        directory.extend([0_u8; 10]);
        directory.extend(at.to_le_bytes());
        directory.extend(name.bytes());
    }
    let at = u32::try_from(bytes.len()).map_err(|_| "the arrays have 4 GiB or more")?;
    bytes.extend(&directory);
    bytes.extend(b"PK\x05\x06\x00\x00\x00\x00");
    bytes.extend([arrays.len() as u16; 2].into_iter().flat_map(u16::to_le_bytes));
    bytes.extend([directory.len() as u32, at].into_iter().flat_map(u32::to_le_bytes));
    bytes.extend([0, 0]);
    Ok(bytes)
}

#[test]
fn an_array_has_the_header_of_the_format() {
    let layers = Layers { width: 3, height: 1, object: vec![1, 2, 258], ..Layers::default() };
    let bytes = Array::numbers("object", &layers, &layers.object).npy();
    assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
    let header = std::str::from_utf8(&bytes[10..128]).unwrap();
    assert_eq!(header.trim_end(), "{'descr': '<u4', 'fortran_order': False, 'shape': (1, 3), }");
    assert!(header.ends_with('\n'));
    assert_eq!(&bytes[128..], [1, 0, 0, 0, 2, 0, 0, 0, 2, 1, 0, 0]);
}
