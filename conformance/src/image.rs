//! Pictures of failures.

use crate::suite::Failed;
use rtrt_core::backend::Picture;
use std::borrow::Cow;
use std::fs::{create_dir_all, write};
use std::io;
use std::path::{Path, PathBuf};

/// Writes the expected and the actual picture of a failed case, and where they differ (white
/// on black), as PNG; returns the folder.
///
/// It is `target/conformance/CASE/VARIANT` in the folder of the workspace.
///
/// # Errors
/// A file cannot be written.
pub fn leave_images(failed: &Failed, variant: &str) -> io::Result<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/conformance");
    let folder = folder.join(failed.case.name).join(variant.replace([' ', '/'], "_"));
    create_dir_all(&folder)?;
    for (name, picture) in pictures(failed) {
        if let Some(bytes) = png(&picture)? {
            write(folder.join(format!("{name}.png")), bytes)?;
        }
    }
    Ok(folder)
}

/// The expected and the actual picture of a failed case, and where they differ (white on black).
pub(crate) fn pictures(failed: &Failed) -> [(&'static str, Cow<'_, Picture>); 3] {
    let [expected, actual] = [&failed.expected, &failed.actual];
    let pairs = expected.pixels.iter().zip(&actual.pixels);
    let pixels = pairs.map(|(a, b)| if a == b { 0xff00_0000 } else { u32::MAX }).collect();
    let difference = Picture { pixels, deferred: None, ..*expected };
    [
        ("expected", Cow::Borrowed(expected)),
        ("actual", Cow::Borrowed(actual)),
        ("difference", Cow::Owned(difference)),
    ]
}

/// The picture as a PNG file; `None` for invalid pixels, which a failing backend may return.
pub(crate) fn png(picture: &Picture) -> io::Result<Option<Vec<u8>>> {
    let Picture { width, height, ref pixels, .. } = *picture;
    if pixels.is_empty() || pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return Ok(None);
    }
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(&picture.bytes())?;
    Ok(Some(bytes))
}
