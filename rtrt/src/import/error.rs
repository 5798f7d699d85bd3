//! Why a scene could not be loaded.

use rtrt_core::scene::{MeshError, SceneError};
use std::io;
use std::path::PathBuf;

/// Why a scene could not be loaded. Each message is one line: problem, file, reason.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A file of the scene cannot be read.
    #[error("cannot read the scene: {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The file has an unknown format.
    #[error("not a scene: {}: it is none of glTF 2.0 (.glb, .gltf), OBJ, STL and PLY", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The file breaks a rule of its format in content that would be drawn.
    #[error("invalid scene: {}: {why}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The error, and its place in the file.
        why: String,
    },
    /// The file requires an extension that is not supported.
    #[error("unsupported scene: {}: it requires the extension {extension}", path.display())]
    Extension {
        /// The file.
        path: PathBuf,
        /// The name of the extension.
        extension: String,
    },
    /// The bytes of a buffer are missing.
    #[error("missing buffer: {}: buffer {buffer}: {why}", path.display())]
    Buffer {
        /// The scene's file.
        path: PathBuf,
        /// The number of the buffer.
        buffer: usize,
        /// The place of the bytes, and the reason.
        why: String,
    },
    /// A mesh has invalid numbers or indices.
    #[error("mesh refused: {}: {mesh}: {source}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// The name of the mesh in the file.
        mesh: String,
        /// The reason.
        source: MeshError,
    },
    /// The scene exceeds a limit.
    #[error("scene too large: {}: more than {limit} {what}", path.display())]
    Limit {
        /// The file.
        path: PathBuf,
        /// The kind of things.
        what: &'static str,
        /// The limit.
        limit: u64,
    },
    /// The environment is invalid.
    #[error("environment refused: {}: {why}", path.display())]
    Environment {
        /// The file.
        path: PathBuf,
        /// The reason.
        why: String,
    },
    /// The scene refuses something of the file.
    #[error("scene refused: {}: {source}", path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: SceneError,
    },
}

/// A name from a file, for a message: in quotes, shortened, with no line breaks in it.
pub(super) fn quoted(name: &str) -> String {
    const LONGEST: usize = 80;
    let short: String = name.chars().take(LONGEST).collect();
    let dots = if short.len() < name.len() { "…" } else { "" };
    format!("\"{}{dots}\"", short.escape_debug())
}
