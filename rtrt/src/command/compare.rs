//! Comparison with a picture in a file.

use super::Error;
use image::ImageReader;
use std::fmt::Display;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Checks that the file is a picture of the frame's size, before the frame is rendered.
pub fn check(path: &Path, frame: [u32; 2]) -> Result<(), Error> {
    let has = open(path)?.into_dimensions().map_err(|error| refused(path, &error))?;
    if has == frame.into() {
        Ok(())
    } else {
        Err(Error::Size { path: path.to_owned(), has: has.into(), frame })
    }
}

/// Compares pixels (red, green, blue, alpha, row by row) with those of a PNG file. Channels may differ by
/// `tolerance` steps.
pub fn compare(path: &Path, pixels: &[u8], frame: [u32; 2], tolerance: u8) -> Result<(), Error> {
    check(path, frame)?;
    let reference = open(path)?.decode().map_err(|error| refused(path, &error))?.into_rgba8();
    let (is, expected) = (pixels.as_chunks::<4>().0, reference.as_raw().as_chunks::<4>().0);
    let is_off = |(_, (a, b)): &(usize, (&[u8; 4], &[u8; 4]))| {
        a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > tolerance)
    };
    let mut differing = is.iter().zip(expected).enumerate().filter(is_off);
    let Some((number, (&is, &expected))) = differing.next() else { return Ok(()) };
    let at = [number as u32 % frame[0], number as u32 / frame[0]];
    Err(Error::Differs { path: path.to_owned(), pixels: 1 + differing.count(), at, is, expected })
}

fn open(path: &Path) -> Result<ImageReader<BufReader<File>>, Error> {
    let file = ImageReader::open(path).map_err(|error| refused(path, &error))?;
    file.with_guessed_format().map_err(|error| refused(path, &error))
}

fn refused(path: &Path, why: &impl Display) -> Error {
    Error::Reference { path: path.to_owned(), why: why.to_string().replace('\n', " ") }
}
