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
    let part = Part::new(path);
    let mut file = OpenOptions::new().write(true).create_new(true).open(part.path())?;
    file.write_all(bytes).and_then(|()| file.sync_all())?;
    drop(file);
    part.keep(path)
}

/// Checks that [`replace`] may write beside `path`, by an empty file that is gone afterwards.
///
/// # Errors
/// The error of the system.
pub fn check(path: &Path) -> io::Result<()> {
    let part = Part::new(path);
    OpenOptions::new().write(true).create_new(true).open(part.path()).map(drop)
}

/// A file that is being written beside the one that it will be. It is removed unless it is kept.
#[derive(Debug)]
pub struct Part(PathBuf);

impl Part {
    /// The part of a file at `path`. Nothing is there yet.
    pub fn new(path: &Path) -> Self {
        let beside = beside(path);
        parts().push(beside.clone());
        Self(beside)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Makes it the file at `path`.
    ///
    /// # Errors
    /// The error of the system. `path` has not changed then.
    pub fn keep(self, path: &Path) -> io::Result<()> {
        fs::rename(&self.0, path)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // It is not there if it was kept. Where it cannot be removed, another error is already known.
        fs::remove_file(&self.0).ok();
        parts().retain(|part| *part != self.0);
    }
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

/// Ends the process at once: partial files are removed, and nothing that a library does at the end of a process is done. A
/// graphics driver would wait for its frame, and a thread that works is not waited for either.
pub fn leave(code: u8) -> ! {
    abandon();
    // Standard output may be closed.
    io::stdout().flush().ok();
    #[cfg(unix)]
    _exit(code.into());
    #[cfg(not(unix))]
    std::process::exit(code.into())
}

#[cfg(unix)]
// SAFETY: POSIX declares it so; it may be called at any time.
unsafe extern "C" {
    safe fn _exit(status: std::ffi::c_int) -> !;
}

/// The folder of a file.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
