//! The bytes of accessors and images.

use super::extensions::MESHOPT;
use super::meshopt::Compressed;
use crate::import::file::Files;
use crate::import::{ImportError, file};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json::{Index, Root, buffer};
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};
use std::path::Path;

/// The buffers of a file. Accessors borrow from them.
pub(super) struct Buffers<'a> {
    /// The scene's file.
    pub path: &'a Path,
    files: Files,
    bytes: Vec<Result<Cow<'a, [u8]>, String>>,
    /// The decoded bytes of compressed views, each from its first use on.
    decoded: Vec<OnceCell<Result<Vec<u8>, String>>>,
    /// How many bytes may still be decoded: several views may name the same bytes.
    remaining: Cell<u64>,
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
        let decoded = root.buffer_views.iter().map(|_| OnceCell::new()).collect();
        Self { path, files, bytes, decoded, remaining: Cell::new(file::LONGEST) }
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
        let stride = view.byte_stride.map(|stride| stride.0);
        let length = view.byte_length.0;
        let others = view.extensions.as_ref().map(|extensions| &extensions.others);
        let found = |name: &'static str| Some((name, others?.get(name)?));
        let Some((name, extension)) = MESHOPT.into_iter().find_map(found) else {
            let bytes =
                self.range(number, view.buffer.value(), view.byte_offset.unwrap_or_default().0, length)?;
            return Ok((bytes, stride));
        };
        let failed = |why: &str| invalid(format!("buffer view {number}: {name}: {why}"));
        let compressed = Compressed::new(extension).map_err(|why| failed(&why))?;
        let buffer = usize::try_from(compressed.buffer).unwrap_or(usize::MAX);
        let bytes = self.range(number, buffer, compressed.offset, compressed.length)?;
        let cell = self.decoded.get(number).ok_or_else(|| failed("it is not there"))?;
        let decoded = cell.get_or_init(|| {
            let remaining = self.remaining.get().checked_sub(compressed.size() as u64);
            self.remaining.set(remaining.ok_or("more bytes are compressed than may be")?);
            Ok(compressed.decode(bytes)?)
        });
        let decoded = decoded.as_ref().map_err(|why| failed(why))?;
        let whole = usize::try_from(length).ok().and_then(|length| decoded.get(..length));
        Ok((whole.ok_or_else(|| failed("it has fewer bytes than its view"))?, stride))
    }

    /// A range of the bytes of a buffer, for the buffer view `view`.
    fn range(&self, view: usize, buffer: usize, start: u64, length: u64) -> Result<&[u8], ImportError> {
        let invalid = |why: &str| {
            let why = format!("buffer view {view} is {why}");
            ImportError::Invalid { path: self.path.to_owned(), why }
        };
        let bytes = match self.bytes.get(buffer) {
            None => return Err(invalid(&format!("of buffer {buffer}, which is not there"))),
            Some(Err(why)) => {
                let path = self.path.to_owned();
                return Err(ImportError::Buffer { path, buffer, why: why.clone() });
            }
            Some(Ok(bytes)) => bytes,
        };
        let end = start.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        let end = end.ok_or_else(|| invalid("not within its buffer"))?;
        Ok(&bytes[start as usize..end as usize])
    }
}

/// What stands behind the scheme of a URI that has its data in it.
pub(super) fn of_data(uri: &str) -> Option<&str> {
    let (scheme, data) = uri.split_once(':')?;
    scheme.eq_ignore_ascii_case("data").then_some(data)
}

/// The bytes of a URI: its own data (`data:`), or those of a file of at most `limit` bytes, relative to
/// the scene's file.
///
/// # Errors
/// The reason, in one line.
fn fetch(path: &Path, files: &Files, uri: &str, limit: u64) -> Result<Vec<u8>, String> {
    if let Some(data) = of_data(uri) {
        // Neither what stands before the comma nor the scheme has a case.
        let is_base64 = |(kind, _): &(&str, &str)| kind.to_ascii_lowercase().ends_with(";base64");
        let (_, data) = data.split_once(',').filter(is_base64).ok_or("its data URI is not in base64")?;
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
