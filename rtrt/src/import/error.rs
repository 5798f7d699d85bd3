//! Why a scene could not be loaded.

use rtrt_core::scene::{MeshError, SceneError};
use std::io;
use std::path::PathBuf;

/// Why a scene could not be loaded. Each is one line: what, which file, why.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A file that the scene consists of cannot be read.
    #[error("cannot read the scene: {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file is none that can be imported.
    #[error("not a scene: {}: neither glTF 2.0 (.glb, .gltf) nor OBJ (.obj)", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The file breaks its format's rules where they matter for drawing it.
    #[error("invalid scene: {}: {why}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where in the file.
        why: String,
    },
    /// The file cannot be drawn without an extension that is not implemented.
    #[error("unsupported scene: {}: it requires the extension {extension}", path.display())]
    Extension {
        /// The file.
        path: PathBuf,
        /// The name of the extension.
        extension: String,
    },
    /// The bytes of a buffer are not there.
    #[error("missing buffer: {}: buffer {buffer}: {why}", path.display())]
    Buffer {
        /// The scene's file.
        path: PathBuf,
        /// Which buffer.
        buffer: usize,
        /// Where it was looked for, and what was found.
        why: String,
    },
    /// A mesh has numbers or indices that cannot be drawn.
    #[error("mesh refused: {}: {mesh}: {source}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// The mesh, as the file calls it.
        mesh: String,
        /// Why.
        source: MeshError,
    },
    /// The scene has more of something than is allowed to be loaded.
    #[error("scene too large: {}: more than {limit} {what}", path.display())]
    Limit {
        /// The file.
        path: PathBuf,
        /// Of what.
        what: &'static str,
        /// The most there may be.
        limit: u64,
    },
    /// The environment is no picture that can be read.
    #[error("environment refused: {}: {why}", path.display())]
    Environment {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// The scene cannot hold what the file has.
    #[error("scene refused: {}: {source}", path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// Why.
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
