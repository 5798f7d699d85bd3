//! Whether a picture is the one in a file.

use super::Error;
use std::path::Path;

/// Compares pixels (red, green, blue, alpha, row by row) with those of a PNG file; each channel may be off by
/// `tolerance` steps.
pub fn compare(path: &Path, pixels: &[u8], frame: [u32; 2], tolerance: u8) -> Result<(), Error> {
    let refused = |why: String| Error::Reference { path: path.to_owned(), why };
    let file = image::ImageReader::open(path).map_err(|error| refused(error.to_string()))?;
    let file = file.with_guessed_format().map_err(|error| refused(error.to_string()))?;
    let reference =
        file.decode().map_err(|error| refused(error.to_string().replace('\n', " ")))?.into_rgba8();
    if reference.dimensions() != frame.into() {
        return Err(Error::Size { path: path.to_owned(), has: reference.dimensions().into(), frame });
    }
    let (is, expected) = (pixels.as_chunks::<4>().0, reference.as_raw().as_chunks::<4>().0);
    let is_off = |(_, (a, b)): &(usize, (&[u8; 4], &[u8; 4]))| {
        a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > tolerance)
    };
    let mut differing = is.iter().zip(expected).enumerate().filter(is_off);
    let Some((number, (&is, &expected))) = differing.next() else { return Ok(()) };
    let at = [number as u32 % frame[0], number as u32 / frame[0]];
    Err(Error::Differs { path: path.to_owned(), pixels: 1 + differing.count(), at, is, expected })
}
