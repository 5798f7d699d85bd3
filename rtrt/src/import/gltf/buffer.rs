//! The bytes of accessors and images.

use crate::import::file::Files;
use crate::import::{ImportError, file};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json::{Index, Root, buffer};
use std::borrow::Cow;
use std::path::Path;

/// The buffers of a file. Accessors borrow from them.
pub(super) struct Buffers<'a> {
    /// The scene's file.
    pub path: &'a Path,
    files: Files,
    bytes: Vec<Result<Cow<'a, [u8]>, String>>,
}

impl<'a> Buffers<'a> {
    /// Reads the buffers. One that cannot be read is an error when something in it is needed.
    pub fn new(path: &'a Path, root: &Root, binary: Option<&'a [u8]>, files: Files) -> Self {
        // One limit for all buffers: they may name the same file many times.
        let mut remaining = file::LONGEST;
        let bytes = root.buffers.iter().enumerate().map(|(index, buffer)| {
            let size = buffer.byte_length.0;
            let bytes = match &buffer.uri {
                Some(uri) => {
                    let bytes = fetch(path, &files, uri, remaining)?;
                    remaining = remaining.saturating_sub(bytes.len() as u64);
                    Cow::Owned(bytes)
                }
                None if index == 0 => {
                    Cow::Borrowed(binary.ok_or("it has no URI, and the file has no binary chunk")?)
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
    /// The reason, in one line.
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

/// The bytes of a URI: its own data (`data:`), or those of a file of at most `limit` bytes, relative to
/// the scene's file.
///
/// # Errors
/// The reason, in one line.
fn fetch(path: &Path, files: &Files, uri: &str, limit: u64) -> Result<Vec<u8>, String> {
    // Schemes of URIs have no case.
    if let Some(data) = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:")).map(|_| &uri[5..])
    {
        let (_, data) = data.split_once(";base64,").ok_or("its data URI is not in base64")?;
        return STANDARD.decode(data).map_err(|error| format!("its data URI: {error}"));
    }
    if uri.contains("://") {
        return Err(format!("{} is not beside the scene", crate::import::error::quoted(uri)));
    }
    // Some exporters do not encode a percent sign.
    let exact = file::relative(path, uri);
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let place = if exact.is_file() { exact } else { file::relative(path, &decoded) };
    files.read(&place, limit).map_err(|error| format!("{}: {error}", place.display()))
}
