//! The text of OBJ and MTL files: encodings, lines, numbers.

use crate::import::error::quoted;
use std::borrow::Cow;

/// The bytes as UTF-8 without a byte order mark. A mark says which encoding the file has: UTF-8, or UTF-16 in either
/// byte order.
pub(super) fn utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        Cow::Owned(String::from_utf16_lossy(&units).into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ => Cow::Borrowed(bytes),
    }
}

/// The lines of a file with their numbers, without comments and surrounding blanks. A line that ends in a backslash
/// continues on the next one.
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
        // A # within a word is part of a name.
        let starts = |&(at, _): &(usize, &str)| at == 0 || text[..at].ends_with(char::is_whitespace);
        if let Some((comment, _)) = text.match_indices('#').find(starts) {
            text.truncate(text[..comment].trim_end().len());
        }
        Some((number + 1, text))
    })
}

/// Up to eight numbers of a line.
pub(super) struct Numbers {
    /// The numbers, then zeros.
    pub values: [f32; 8],
    pub count: usize,
}

impl Numbers {
    /// The first `N` numbers, `N` ≤ 8.
    pub fn first<const N: usize>(&self) -> [f32; N] {
        core::array::from_fn(|i| self.values[i])
    }
}

/// The numbers in a line.
///
/// # Errors
/// A word is not a number.
pub(super) fn numbers(rest: &str) -> Result<Numbers, String> {
    let mut numbers = Numbers { values: [0.0; 8], count: 0 };
    for (text, value) in rest.split_whitespace().zip(&mut numbers.values) {
        *value = number(text).ok_or_else(|| format!("{} is not a number", quoted(text)))?;
        numbers.count += 1;
    }
    Ok(numbers)
}

/// A number. `1.#QNAN`, `-nan(ind)` and the like, which C libraries write, are NaN or infinite.
pub(super) fn number(text: &str) -> Option<f32> {
    text.parse().ok().or_else(|| {
        let name = text.trim_start_matches(['+', '-']).to_ascii_lowercase();
        let name = name.strip_prefix("1.#").unwrap_or(&name);
        let is_nan = ["nan", "qnan", "snan", "ind"].iter().any(|nan| name.starts_with(nan));
        if is_nan {
            Some(f32::NAN)
        } else {
            name.starts_with("inf").then_some(if text.starts_with('-') {
                -f32::INFINITY
            } else {
                f32::INFINITY
            })
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_continue_after_a_backslash_and_end_at_a_comment() {
        let text: Vec<_> = lines(b"f 1 \\\n 2 # three\r\n\nusemtl a#b\nv\\").collect();
        assert_eq!(
            text,
            [(1, "f 1  2".into()), (3, String::new()), (4, "usemtl a#b".into()), (5, "v".into())]
        );
    }

    #[test]
    fn byte_order_marks_name_the_encoding() {
        let text = "v 1 2 3\nusemtl é\n";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let marked = |mark: &[u8], bytes: &[u8]| utf8(&[mark, bytes].concat()).into_owned();
        for bytes in [
            marked(&[], text.as_bytes()),
            marked(&[0xef, 0xbb, 0xbf], text.as_bytes()),
            marked(&[0xff, 0xfe], &little),
            marked(&[0xfe, 0xff], &big),
        ] {
            assert_eq!(bytes, text.as_bytes());
        }
    }

    #[test]
    fn what_c_libraries_write_for_nan_is_nan() {
        for text in ["nan", "-nan", "NaN", "-nan(ind)", "nan(snan)", "1.#QNAN", "-1.#IND", "1.#SNAN0"] {
            assert!(number(text).is_some_and(f32::is_nan), "{text}");
        }
        assert_eq!([number("1.#INF"), number("-1.#INF")], [Some(f32::INFINITY), Some(-f32::INFINITY)]);
        assert_eq!([number("x"), number("1.#"), number("")], [None; 3]);
    }
}
