//! Comparison with a picture in a file.

use super::console::Console;
use super::output::{self, png};
use super::render::encode;
use super::{Error, parse};
use image::ExtendedColorType::Rgba8;
use image::ImageReader;
use rtrt::difference::{Difference, difference, picture};
use rtrt::hash;
use std::fmt::Display;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// The JSON of a difference.
#[derive(serde::Serialize)]
struct DifferenceReport<'a> {
    reference: &'a Path,
    /// The picture that differs from it, if it was written.
    picture: Option<&'a Path>,
    size: [u32; 2],
    /// Steps by which channels may differ.
    tolerance: u8,
    /// Pixels that differ by more.
    pixels: usize,
    /// The most steps.
    most: u8,
    /// Left, top, and the first column and row beyond them.
    bounds: [u32; 4],
    /// Column and row of the first of them.
    first: [u32; 2],
    is: [u8; 4],
    expected: [u8; 4],
    /// SHA-256 of the pixels.
    hash: String,
    expected_hash: String,
}

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
/// `tolerance` steps. A difference is an error, and is written as a picture and as JSON, beside the `output` if there
/// is one, else beside the reference.
pub fn compare(
    path: &Path,
    output: Option<&Path>,
    pixels: &[u8],
    frame: [u32; 2],
    tolerance: u8,
    console: &Console,
) -> Result<(), Error> {
    check(path, frame)?;
    let reference = open(path)?.decode().map_err(|error| refused(path, &error))?.into_rgba8();
    let (is, expected) = (pixels.as_chunks::<4>().0, reference.as_raw().as_chunks::<4>().0);
    let Some(found) = difference(is, expected, frame[0], tolerance) else { return Ok(()) };
    let output = output.filter(|output| !parse::is_standard(output));
    let Difference { pixels: count, most, bounds, first, is: here, expected: there } = found;
    let report = DifferenceReport {
        reference: path,
        picture: output,
        size: frame,
        tolerance,
        pixels: count,
        most,
        bounds,
        first,
        is: here,
        expected: there,
        hash: hash::of(pixels),
        expected_hash: hash::of(reference.as_raw()),
    };
    let [shown, numbers] = ["png", "json"].map(|ending| beside(output.unwrap_or(path), ending));
    let written = png(picture(is, expected).as_flattened(), frame, Rgba8)
        .map_err(encode(&shown))
        .and_then(|bytes| output::write(&shown, &bytes))
        .and_then(|()| output::write(&numbers, output::json(&report)?.as_bytes()));
    match written {
        Ok(()) => console.say(format_args!("difference: {} and {}", shown.display(), numbers.display())),
        // That the pictures differ matters more.
        Err(error) => console.say(format_args!("warning: {error}")),
    }
    Err(Error::Differs { path: path.to_owned(), pixels: count, at: first, is: here, expected: there })
}

/// `out.png` becomes `out.difference.png`.
fn beside(path: &Path, ending: &str) -> PathBuf {
    path.with_extension(format!("difference.{ending}"))
}

fn open(path: &Path) -> Result<ImageReader<BufReader<File>>, Error> {
    let file = ImageReader::open(path).map_err(|error| refused(path, &error))?;
    file.with_guessed_format().map_err(|error| refused(path, &error))
}

fn refused(path: &Path, why: &impl Display) -> Error {
    Error::Reference { path: path.to_owned(), why: why.to_string().replace('\n', " ") }
}
