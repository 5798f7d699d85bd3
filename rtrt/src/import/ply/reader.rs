//! The numbers of a PLY file's body.

use super::header::{Encoding, Type};
use crate::import::text;

/// The bytes of a body from the next number on.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    encoding: Encoding,
}

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8], encoding: Encoding) -> Self {
        Self { bytes, encoding }
    }

    /// The most numbers that may follow: each has a byte, or in a text two.
    pub fn most(&self) -> usize {
        self.bytes.len()
    }

    /// The next number. `f64` holds each type exactly.
    ///
    /// # Errors
    /// The reason, in one line.
    pub fn number(&mut self, of: Type) -> Result<f64, String> {
        match (self.encoding, of) {
            (Encoding::Text, _) => self.word(),
            (_, Type::I8) => Ok(i8::from_le_bytes(self.take()?).into()),
            (_, Type::U8) => Ok(u8::from_le_bytes(self.take()?).into()),
            (_, Type::I16) => Ok(i16::from_le_bytes(self.take()?).into()),
            (_, Type::U16) => Ok(u16::from_le_bytes(self.take()?).into()),
            (_, Type::I32) => Ok(i32::from_le_bytes(self.take()?).into()),
            (_, Type::U32) => Ok(u32::from_le_bytes(self.take()?).into()),
            (_, Type::F32) => Ok(f32::from_le_bytes(self.take()?).into()),
            (_, Type::F64) => Ok(f64::from_le_bytes(self.take()?)),
        }
    }

    /// The next `N` bytes, the least significant one first.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (first, rest) = self.bytes.split_first_chunk().ok_or(END)?;
        self.bytes = rest;
        let mut number: [u8; N] = *first;
        if self.encoding == Encoding::Big {
            number.reverse();
        }
        Ok(number)
    }

    /// The next word of a text, as a number.
    fn word(&mut self) -> Result<f64, String> {
        let bytes = self.bytes.trim_ascii_start();
        let end = bytes.iter().position(u8::is_ascii_whitespace).unwrap_or(bytes.len());
        let (word, rest) = bytes.split_at(end);
        if word.is_empty() {
            return Err(END.into());
        }
        self.bytes = rest;
        let word = String::from_utf8_lossy(word);
        let number = word.parse().ok().or_else(|| text::number(&word).map(f64::from));
        number.ok_or_else(|| format!("{} is not a number", crate::import::error::quoted(&word)))
    }
}

const END: &str = "the file ends";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_the_same_in_every_encoding() {
        let read = |bytes: &[u8], encoding| {
            let mut reader = Reader::new(bytes, encoding);
            let numbers = [Type::I8, Type::U16, Type::I32, Type::U32, Type::F32, Type::F64]
                .map(|of| reader.number(of).unwrap());
            assert_eq!(reader.number(Type::U8), Err(END.into()));
            numbers
        };
        let expected = [-3.0, 513.0, -70_000.0, 4_000_000_000.0, 0.5, 0.1];
        let mut little = vec![0xfd];
        little.extend(513_u16.to_le_bytes());
        little.extend((-70_000_i32).to_le_bytes());
        little.extend(4_000_000_000_u32.to_le_bytes());
        little.extend(0.5_f32.to_le_bytes());
        little.extend(0.1_f64.to_le_bytes());
        let mut big = vec![0xfd];
        big.extend(513_u16.to_be_bytes());
        big.extend((-70_000_i32).to_be_bytes());
        big.extend(4_000_000_000_u32.to_be_bytes());
        big.extend(0.5_f32.to_be_bytes());
        big.extend(0.1_f64.to_be_bytes());
        assert_eq!(read(&little, Encoding::Little), expected);
        assert_eq!(read(&big, Encoding::Big), expected);
        assert_eq!(read(b"-3 513\n-70000\t4000000000\r\n5e-1 0.1 \n", Encoding::Text), expected);
        let mut reader = Reader::new(b"nan x", Encoding::Text);
        assert!(reader.number(Type::F32).unwrap().is_nan());
        assert_eq!(reader.number(Type::F32), Err("\"x\" is not a number".into()));
    }
}
