//! Pictures for textures: PNG, JPEG, WebP and KTX 2, and a placeholder.

use super::ktx2;
use image::{ImageReader, Limits};
use rtrt_core::scene::Image;
use std::io::Cursor;

/// The picture in these bytes (PNG, JPEG, WebP or KTX 2), 8 bits a channel.
///
/// # Errors
/// The reason, in one line.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    if ktx2::looks_like(bytes) {
        return ktx2::decode(bytes);
    }
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string())?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(Image::MAX_SIDE);
    limits.max_image_height = Some(Image::MAX_SIDE);
    // 16 bits a channel, four channels, at the largest size.
    limits.max_alloc = Some(8 * u64::from(Image::MAX_SIDE) * u64::from(Image::MAX_SIDE));
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| error.to_string().replace('\n', " "))?.into_rgba8();
    Ok(Image { width: picture.width(), height: picture.height(), rgba: picture.into_raw() })
}

/// How many texels the picture in these bytes has, as its header says; none if that is not read.
pub(super) fn texels(bytes: &[u8]) -> Option<u64> {
    let (width, height) = if ktx2::looks_like(bytes) {
        ktx2::size(bytes)?
    } else {
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()?.into_dimensions().ok()?
    };
    Some(u64::from(width) * u64::from(height))
}

/// The picture in place of one that cannot be read: an unmistakable checker of magenta and black.
pub(super) fn placeholder() -> Image {
    const SIDE: u32 = 8;
    let texel = |i: u32| {
        if (i % SIDE + i / SIDE).is_multiple_of(2) { [255, 0, 255, 255] } else { [0, 0, 0, 255] }
    };
    Image { width: SIDE, height: SIDE, rgba: (0..SIDE * SIDE).flat_map(texel).collect() }
}
