//! Files that are written completely or not at all.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The partial files of writes in progress.
static PARTS: Mutex<Vec<PathBuf>> = Mutex::new(vec![]);

fn parts() -> MutexGuard<'static, Vec<PathBuf>> {
    PARTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Replaces the file at `path` by these bytes. They are written to a file beside it, which is renamed once
/// all bytes are on disk. So no reader ever gets a part of them.
///
/// # Errors
/// The error of the system. `path` has not changed then.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = beside(path);
    parts().push(beside.clone());
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&beside)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&beside, path));
    if written.is_err() {
        // The error matters more than a partial file that cannot be removed.
        fs::remove_file(&beside).ok();
    }
    parts().retain(|part| *part != beside);
    written
}

/// Checks that [`replace`] may write beside `path`, by an empty file that is gone afterwards.
///
/// # Errors
/// The error of the system.
pub fn check(path: &Path) -> io::Result<()> {
    let beside = beside(path);
    parts().push(beside.clone());
    let made = OpenOptions::new().write(true).create_new(true).open(&beside);
    let checked = made.and_then(|_| fs::remove_file(&beside));
    parts().retain(|part| *part != beside);
    checked
}

/// Where the bytes of a file are until all of them are there.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    folder(path).join(format!(".{name}.{}.part", std::process::id()))
}

/// Removes partial files, before the process ends. It must not write anything afterwards.
pub fn abandon() {
    for part in parts().iter() {
        fs::remove_file(part).ok();
    }
}

/// The folder of a file.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
