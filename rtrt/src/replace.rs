//! Files that are never half written.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The files that are being written.
static PARTS: Mutex<Vec<PathBuf>> = Mutex::new(vec![]);

fn parts() -> MutexGuard<'static, Vec<PathBuf>> {
    PARTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes `path` a file of these bytes. They are written beside it and moved there when all
/// are on disk, so that nobody ever sees half of them.
///
/// # Errors
/// What the system says; `path` is then as it was.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = folder(path).join(format!(".{name}.{}.part", std::process::id()));
    parts().push(beside.clone());
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&beside)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&beside, path));
    if written.is_err() {
        // The error says enough; a leftover that cannot be removed adds nothing to it.
        fs::remove_file(&beside).ok();
    }
    parts().retain(|part| *part != beside);
    written
}

/// Removes what is half written. For a program that is told to end: it must not write any more afterwards.
pub fn abandon() {
    for part in parts().iter() {
        fs::remove_file(part).ok();
    }
}

/// The folder that a file lies in.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
