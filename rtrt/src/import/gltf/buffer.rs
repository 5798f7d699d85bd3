//! The bytes that accessors and images read.

use crate::import::file::Files;
use crate::import::{ImportError, file};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json::{Index, Root, buffer};
use std::borrow::Cow;
use std::path::Path;

/// The buffers of a file, all read: an accessor then borrows from them.
pub(super) struct Buffers<'a> {
    /// The scene's file.
    pub path: &'a Path,
    files: Files,
    bytes: Vec<Result<Cow<'a, [u8]>, String>>,
}

impl<'a> Buffers<'a> {
    /// Reads them. One that cannot be read is an error only once something is in it.
    pub fn new(path: &'a Path, root: &Root, binary: Option<&'a [u8]>, files: Files) -> Self {
        // All together, so that naming one long file many times is of no use.
        let mut left = file::LONGEST;
        let bytes = root.buffers.iter().enumerate().map(|(index, buffer)| {
            let size = buffer.byte_length.0;
            let bytes = match &buffer.uri {
                Some(uri) => {
                    let bytes = fetch(path, &files, uri, left)?;
                    left = left.saturating_sub(bytes.len() as u64);
                    Cow::Owned(bytes)
                }
                None if index == 0 => {
                    Cow::Borrowed(binary.ok_or("it has no URI, and the file no binary chunk")?)
                }
                None => return Err("it has no URI".into()),
            };
            if (bytes.len() as u64) < size {
                return Err(format!("it has {} bytes instead of {size}", bytes.len()));
            }
            Ok(bytes)
        });
        let bytes = bytes.collect();
        Self { path, files, bytes }
    }

    /// The bytes behind a URI of an image.
    ///
    /// # Errors
    /// What is wrong, in one line.
    pub fn fetch(&self, uri: &str) -> Result<Vec<u8>, String> {
        fetch(self.path, &self.files, uri, file::LONGEST)
    }

    /// The bytes of a buffer view, and its stride.
    pub fn view(
        &self,
        root: &Root,
        index: Index<buffer::View>,
    ) -> Result<(&[u8], Option<usize>), ImportError> {
        let invalid = |why: String| ImportError::Invalid { path: self.path.to_owned(), why };
        let number = index.value();
        let view = root.get(index).ok_or_else(|| invalid(format!("there is no buffer view {number}")))?;
        let buffer = view.buffer.value();
        let bytes = match self.bytes.get(buffer) {
            None => {
                return Err(invalid(format!(
                    "buffer view {number} is of buffer {buffer}, which is not there"
                )));
            }
            Some(Err(why)) => {
                let path = self.path.to_owned();
                return Err(ImportError::Buffer { path, buffer, why: why.clone() });
            }
            Some(Ok(bytes)) => bytes,
        };
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0);
        let range = end.filter(|&end| end <= bytes.len() as u64).map(|end| start as usize..end as usize);
        let range = range.ok_or_else(|| invalid(format!("buffer view {number} is not within its buffer")))?;
        Ok((&bytes[range], view.byte_stride.map(|stride| stride.0)))
    }
}

/// The bytes behind a URI: within it (`data:`), or in a file of at most `limit` bytes beside
/// the scene's.
///
/// # Errors
/// What is wrong, in one line.
fn fetch(path: &Path, files: &Files, uri: &str, limit: u64) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, data) = data.split_once(";base64,").ok_or("its data URI is not in base64")?;
        return STANDARD.decode(data).map_err(|error| format!("its data URI: {error}"));
    }
    if uri.contains("://") {
        return Err(format!("{} is not beside the scene", crate::import::error::quoted(uri)));
    }
    // Names with a percent sign in them, not encoded, exist too.
    let exact = file::beside(path, uri);
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let place = if exact.is_file() { exact } else { file::beside(path, &decoded) };
    files.read(&place, limit).map_err(|error| format!("{}: {error}", place.display()))
}
