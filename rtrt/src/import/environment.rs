//! Environments: panoramas in Radiance's format.

use super::{ImportError, file};
use image::{ImageFormat, ImageReader, Limits};
use rtrt_core::scene::{Panorama, Scene};
use std::io::Cursor;
use std::path::Path;

/// The most columns or rows of a panorama.
const MAX_SIDE: u32 = 16_384;

/// Surrounds the scene with the panorama in a file: equirectangular, Radiance RGBE (`.hdr`).
///
/// # Errors
/// The file cannot be read, or is no such panorama.
pub fn surround(scene: &mut Scene, path: &Path) -> Result<(), ImportError> {
    let bytes = file::read(path, file::LONGEST)
        .map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })?;
    let refused = |why: String| ImportError::Environment { path: path.to_owned(), why };
    let panorama = decode(&bytes).map_err(refused)?;
    scene.set_environment(&panorama).map_err(|source| ImportError::Scene { path: path.to_owned(), source })
}

fn decode(bytes: &[u8]) -> Result<Panorama, String> {
    if !bytes.starts_with(b"#?") {
        return Err("it is not in the Radiance format (.hdr)".into());
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Hdr);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(12 * u64::from(MAX_SIDE) * u64::from(MAX_SIDE));
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| error.to_string().replace('\n', " "))?.into_rgb32f();
    let (width, height) = picture.dimensions();
    Ok(Panorama { width, height, rgb: picture.pixels().map(|pixel| pixel.0).collect() })
}
