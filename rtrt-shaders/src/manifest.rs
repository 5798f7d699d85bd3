//! Which sources the committed module was compiled from.
//!
//! `rtrt.manifest` has the format of `sha256sum`: one line per file, hash and path from the repository's root.
//! A test recomputes it, so a change to a source without a rebuilt module is found without the shader compiler.

use std::path::{Path, PathBuf};
use std::{fs, io};

use sha2::{Digest, Sha256};

/// What decides the module's bytes: every file of these folders, and these files.
const SOURCES: &[&str] = &[
    "rtrt-core/Cargo.toml",
    "rtrt-core/src",
    "rtrt-shaders/Cargo.toml",
    "rtrt-shaders/builder/src",
    "rtrt-shaders/src",
];

/// The manifest of the module `spirv` and of the sources now under `root`, the root of the repository.
///
/// Line endings are hashed as LF, so that a checkout with CRLF has the same manifest.
///
/// # Errors
///
/// A source cannot be read.
pub fn manifest(root: &Path, spirv: &[u8]) -> io::Result<String> {
    let mut files = Vec::new();
    for source in SOURCES {
        list(&root.join(source), &mut files)?;
    }
    let mut lines = Vec::new();
    for file in files {
        let text = String::from_utf8_lossy(&fs::read(&file)?).replace("\r\n", "\n");
        let path = file.strip_prefix(root).expect("listed under root");
        let parts: Vec<_> = path.iter().map(|part| part.to_string_lossy()).collect();
        lines.push((parts.join("/"), hash(text.as_bytes())));
    }
    lines.push(("rtrt-shaders/rtrt.spv".to_owned(), hash(spirv)));
    lines.sort();
    Ok(lines.into_iter().map(|(path, hash)| format!("{hash}  {path}\n")).collect())
}

/// Appends `path` if it is a file, otherwise the files below it.
fn list(path: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    if path.is_dir() {
        for entry in fs::read_dir(path)? {
            list(&entry?.path(), files)?;
        }
    } else {
        files.push(path.to_owned());
    }
    Ok(())
}

fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
