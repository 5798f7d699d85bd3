//! SHA-256 of frames, in hex. Two machines compare it in place of pictures.
//!
//! ```
//! use rtrt_core::backend::Picture;
//!
//! let picture = Picture { width: 1, height: 1, pixels: vec![0xff00_0000], ..Picture::default() };
//! assert_eq!(rtrt::hash::pixels(&picture), rtrt::hash::of(&[0, 0, 0, 255]));
//! ```

use rtrt_core::backend::Picture;
use sha2::{Digest, Sha256};

/// The hash of these bytes.
pub fn of(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The hash of the pixels: red, green, blue, alpha, row by row.
pub fn pixels(picture: &Picture) -> String {
    of(&picture.bytes())
}

/// The hash of each deferred buffer, in the order of the stages that write them; none without them.
pub fn buffers(picture: &Picture) -> Option<[(&'static str, String); 10]> {
    let buffers = picture.deferred.as_ref()?.buffers();
    Some(buffers.map(|(name, bytes)| (name, of(&bytes))))
}
