//! Scenes that are no regular files: standard input, and pipes.

use super::parse::is_standard;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The most bytes: 4 GiB, as of files.
const LONGEST: u64 = 1 << 32;

/// Whether this scene can be read only once.
pub fn is_stream(scene: &Path) -> bool {
    is_standard(scene) || is_pipe(scene)
}

#[cfg(unix)]
fn is_pipe(scene: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(scene).is_ok_and(|metadata| metadata.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}

/// All bytes of a stream.
pub fn read(scene: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let from: &mut dyn Read =
        if is_standard(scene) { &mut io::stdin().lock() } else { &mut File::open(scene)? };
    from.take(LONGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LONGEST {
        let why = format!("it has more than {LONGEST} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, why));
    }
    Ok(bytes)
}
