//! Results: lines on standard output, and picture files.

use super::Error;
use super::parse::is_standard;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageResult};
use rtrt::replace::{self, folder, replace};
use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;

/// Writes a line of results.
pub fn print(line: impl Display) -> Result<(), Error> {
    Ok(writeln!(io::stdout(), "{line}")?)
}

/// Writes bytes of results.
pub fn print_bytes(bytes: &[u8]) -> Result<(), Error> {
    let mut to = io::stdout().lock();
    Ok(to.write_all(bytes).and_then(|()| to.flush())?)
}

/// The results as one JSON object on one line.
pub fn json(results: &impl serde::Serialize) -> Result<String, Error> {
    Ok(serde_json::to_string(results).map_err(io::Error::from)?)
}

/// Writes the results as one JSON object on one line.
pub fn print_json(results: &impl serde::Serialize) -> Result<(), Error> {
    print(json(results)?)
}

/// Checks that a picture can be written to this path, before it is rendered.
pub fn check(path: &Path) -> Result<(), Error> {
    if is_standard(path) {
        return Ok(());
    }
    let refused = |kind, why| Err(Error::Write { path: path.to_owned(), source: io::Error::new(kind, why) });
    if path.exists() && !path.is_file() {
        return refused(io::ErrorKind::AlreadyExists, "it exists, but is not a file");
    }
    if !folder(path).is_dir() {
        return refused(io::ErrorKind::NotFound, "its folder does not exist");
    }
    replace::check(path).map_err(|source| Error::Write { path: path.to_owned(), source })
}

/// The pixels, row by row, as a PNG file.
pub fn png(pixels: &[u8], [width, height]: [u32; 2], depth: ExtendedColorType) -> ImageResult<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(pixels, width, height, depth)?;
    Ok(bytes)
}

/// Writes a file, all of it or nothing, or to standard output.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    if is_standard(path) {
        return print_bytes(bytes);
    }
    replace(path, bytes).map_err(|source| Error::Write { path: path.to_owned(), source })
}
