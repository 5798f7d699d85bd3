//! Images in KTX 2 containers: Basis Universal (ETC1S and UASTC) and plain texels.
//!
//! The container's numbers are checked here, against one another and the length of the file, before anything is decoded:
//! the decoder takes the sizes that they state.

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use rtrt_core::scene::Image;
use ruzstd::StreamingDecoder;
use std::io::Read;
use std::panic::catch_unwind;

const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// The bytes before the list of levels, and those of a level in it.
const HEADER: usize = 80;
const LEVEL: usize = 24;
/// The most levels that an image of the largest size may have.
const LEVELS: u32 = Image::MAX_SIDE.ilog2() + 1;

/// A container's supercompression, by its number.
mod scheme {
    pub const NONE: u32 = 0;
    pub const BASIS_LZ: u32 = 1;
    pub const ZSTANDARD: u32 = 2;
}

pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Columns and rows of the largest level.
pub(super) fn size(bytes: &[u8]) -> Option<(u32, u32)> {
    Container::new(bytes).ok().map(|container| (container.width, container.height))
}

/// The largest level of an image, 8 bits a channel.
///
/// # Errors
/// The reason, in one line.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let container = Container::new(bytes)?;
    let (width, height) = (container.width, container.height);
    let texels = width as usize * height as usize;
    let rgba = match container.format {
        0 => basis(bytes)?,
        // Unsigned numbers of 8 bits, linear or sRGB.
        23 | 29 => {
            let rgb = container.plain(3 * texels)?;
            rgb.as_chunks().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect()
        }
        37 | 43 => container.plain(4 * texels)?,
        format => {
            return Err(format!(
                "its texels have the Vulkan format {format}; Basis Universal and 8 bits a channel (RGB, RGBA) are read"
            ));
        }
    };
    if rgba.len() == 4 * texels { Ok(Image { width, height, rgba }) } else { Err(CUT.into()) }
}

const CUT: &str = "its sizes and the length of its file contradict each other";

/// The numbers of a container, which fit together.
struct Container<'a> {
    /// A number of Vulkan; 0 for Basis Universal.
    format: u32,
    width: u32,
    height: u32,
    scheme: u32,
    /// The bytes of the largest level.
    first: &'a [u8],
}

impl<'a> Container<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, String> {
        let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
        let long = |at: usize| Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
        let number = |index: usize| word(12 + 4 * index).ok_or(CUT);
        let (format, [width, height]) = (number(0)?, [number(2)?, number(3)?]);
        let [depth, layers, faces] = [number(4)?, number(5)?, number(6)?];
        let (levels, scheme) = (number(7)?.max(1), number(8)?);
        let sides = 1..=Image::MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) || levels > LEVELS {
            return Err(format!("it has {width} by {height} texels and {levels} levels"));
        }
        if depth > 1 || layers > 1 || faces != 1 {
            return Err("it is no plain picture, but has a depth, layers or faces".into());
        }
        if scheme > scheme::ZSTANDARD || (scheme == scheme::BASIS_LZ && format != 0) {
            return Err(format!("it has the supercompression {scheme}"));
        }
        let mut first = None;
        for level in 0..levels {
            let at = HEADER + LEVEL * level as usize;
            let numbers = || Some([long(at)?, long(at + 8)?, long(at + 16)?]);
            let [offset, length, unpacked] = numbers().ok_or(CUT)?;
            let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64).ok_or(CUT)?;
            let blocks = [width, height].map(|side| u64::from((side >> level).max(1).div_ceil(4)));
            let needed = 16 * blocks[0] * blocks[1];
            let fits = match scheme {
                _ if format != 0 => true,
                scheme::NONE => length == needed,
                scheme::ZSTANDARD => unpacked == needed,
                _ => true,
            };
            if !fits {
                return Err(CUT.into());
            }
            first.get_or_insert(&bytes[offset as usize..end as usize]);
        }
        Ok(Self { format, width, height, scheme, first: first.unwrap_or_default() })
    }

    /// The bytes of the largest level, `length` of them.
    fn plain(&self, length: usize) -> Result<Vec<u8>, String> {
        if self.scheme == scheme::NONE {
            return Ok(self.first.get(..length).ok_or(CUT)?.to_vec());
        }
        let refused = |error: String| format!("Zstandard: {}", error.replace('\n', " "));
        let mut decoder = StreamingDecoder::new(self.first).map_err(|error| refused(error.to_string()))?;
        let mut bytes = Vec::new();
        let read = Read::take(&mut decoder, length as u64).read_to_end(&mut bytes);
        read.map_err(|error| refused(error.to_string()))?;
        Ok(bytes)
    }
}

/// The texels of Basis Universal.
///
/// The decoder indexes out of range in a few damaged streams out of a million. That is caught here.
fn basis(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let decode = || Transcoder::new(bytes)?.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE);
    match catch_unwind(decode) {
        Ok(decoded) => decoded.map_err(|error| format!("Basis Universal: {error:?}")),
        Err(_) => Err("Basis Universal: its data are damaged".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A container of two texels in a row.
    fn container(format: u32, scheme: u32, level: &[u8]) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([format, 1, 2, 1, 0, 0, 1, 1, scheme].iter().flat_map(|n| n.to_le_bytes()));
        bytes.resize(HEADER, 0);
        bytes.extend([104, level.len() as u64, 0].iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(level);
        bytes
    }

    /// A Zstandard frame with these bytes in a raw block.
    fn zstandard(content: &[u8]) -> Vec<u8> {
        let block = ((content.len() as u32) << 3 | 1).to_le_bytes();
        [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, content.len() as u8], &block[..3], content].concat()
    }

    #[test]
    fn plain_texels_are_read() {
        let (rgb, rgba) = ([1, 2, 3, 4, 5, 6], [1, 2, 3, 255, 4, 5, 6, 255]);
        for bytes in [
            container(23, 0, &rgb),
            container(43, 0, &rgba),
            container(29, 2, &zstandard(&rgb)),
            container(37, 2, &zstandard(&rgba)),
        ] {
            let image = decode(&bytes).unwrap();
            assert_eq!((image.width, image.height, &image.rgba[..]), (2, 1, &rgba[..]));
        }
    }

    #[test]
    fn what_is_not_read_is_named() {
        let refused = |bytes: &[u8]| decode(bytes).map(|image| image.rgba.len()).unwrap_err();
        let whole = container(43, 0, &[9; 8]);
        let with = |at: usize, number: u32| {
            let mut bytes = whole.clone();
            bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
            refused(&bytes)
        };
        for length in 0..whole.len() {
            refused(&whole[..length]);
        }
        assert_eq!(with(12, 98).split_once(';').unwrap().0, "its texels have the Vulkan format 98");
        assert_eq!(with(20, 1 << 20), "it has 1048576 by 1 texels and 1 levels");
        assert_eq!(with(20, 0), "it has 0 by 1 texels and 1 levels");
        assert_eq!(with(40, 99), "it has 2 by 1 texels and 99 levels");
        assert_eq!(with(36, 6), "it is no plain picture, but has a depth, layers or faces");
        assert_eq!(with(44, 3), "it has the supercompression 3");
        assert_eq!(with(80, u32::MAX), CUT);
        assert_eq!(with(20, 3), CUT);
        assert!(with(44, 2).starts_with("Zstandard: "));
        assert_eq!(refused(&container(37, 2, &zstandard(&[1]))), CUT);
        // No Basis Universal in it.
        assert_eq!(refused(&container(0, 1, &[0; 8])), "Basis Universal: InvalidData");
        // A level that claims more than its texels need.
        let mut vast = container(0, 2, &[0; 8]);
        vast[96..104].fill(0x7f);
        assert_eq!(refused(&vast), CUT);
    }
}
