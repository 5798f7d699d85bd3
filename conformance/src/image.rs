//! Pictures of what failed.

use crate::suite::Failed;
use rtrt_core::backend::Picture;
use std::fs::{File, create_dir_all};
use std::io::{self, BufWriter};
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
    let [expected, actual] = [&failed.expected, &failed.actual];
    write(&folder.join("expected.png"), expected)?;
    write(&folder.join("actual.png"), actual)?;
    let pairs = expected.pixels.iter().zip(&actual.pixels);
    let pixels = pairs.map(|(a, b)| if a == b { 0xff00_0000 } else { u32::MAX }).collect();
    write(&folder.join("difference.png"), &Picture { pixels, ..expected.clone() })?;
    Ok(folder)
}

fn write(path: &Path, picture: &Picture) -> io::Result<()> {
    // A backend that failed may have left anything.
    if picture.pixels.is_empty()
        || picture.pixels.len() as u64 != u64::from(picture.width) * u64::from(picture.height)
    {
        return Ok(());
    }
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), picture.width, picture.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(picture.bytes())?;
    Ok(())
}
