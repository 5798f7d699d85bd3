//! Reading files: only real ones, and no more than is asked for.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The longest file that is read, in bytes: 4 GiB.
pub(super) const LONGEST: u64 = 1 << 32;

/// The files that a scene consists of, also those that were looked for and are not there.
#[derive(Debug, Clone, Default)]
pub(crate) struct Files(Rc<RefCell<BTreeSet<PathBuf>>>);

impl Files {
    /// [`read`], and keeps in mind what was read.
    pub fn read(&self, path: &Path, limit: u64) -> io::Result<Vec<u8>> {
        self.0.borrow_mut().insert(path.to_owned());
        read(path, limit)
    }

    /// All of them.
    pub fn list(&self) -> Vec<PathBuf> {
        self.0.borrow().iter().cloned().collect()
    }
}

/// The bytes of a file of at most `limit` bytes.
///
/// # Errors
/// The file cannot be read, is longer, or is no file: a pipe or a device might have no end.
pub(super) fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a file"));
    }
    if metadata.len() > limit {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("it has {} bytes, and {limit} are read at most", metadata.len()),
        ));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A file named by another, relative to that one's folder. Separators may be those of
/// Windows.
pub(super) fn beside(path: &Path, name: &str) -> PathBuf {
    let folder = path.parent().unwrap_or(Path::new(""));
    let exact = folder.join(name);
    if name.contains('\\') && !exact.exists() { folder.join(name.replace('\\', "/")) } else { exact }
}
