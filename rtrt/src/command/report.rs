//! What several commands report: machines, times, hashes.

use rtrt_core::backend::{Description, Picture, STAGES};
use serde::ser::{Serialize, Serializer};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt;

/// Where a frame was rendered.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Machine {
    backend: String,
    adapter: String,
    lanes: u32,
    threads: u32,
}

#[cfg(feature = "viewer")]
impl Machine {
    /// `"cpu"` or `"gpu"`.
    pub fn kind(&self) -> &str {
        &self.backend
    }
}

impl From<Description> for Machine {
    fn from(d: Description) -> Self {
        Self { backend: d.kind, adapter: d.adapter, lanes: d.lanes, threads: d.threads }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { backend, adapter, lanes, threads } = self;
        write!(f, "{backend}, {adapter}")?;
        if *threads > 0 {
            write!(f, ", {}, {}", counted(*lanes, "lane"), counted(*threads, "thread"))?;
        }
        Ok(())
    }
}

/// `1 lane`, `8 lanes`.
pub fn counted(count: u32, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Something for each stage: a map from its name, in the order of the stages.
#[derive(Debug, Clone)]
pub struct PerStage<T>(pub [T; STAGES.len()]);

impl<T: Serialize> Serialize for PerStage<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(STAGES.iter().zip(&self.0))
    }
}

/// The SHA-256 of these bytes, in hex.
fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The SHA-256 of the pixels.
pub fn pixel_hash(picture: &Picture) -> String {
    sha256(picture.bytes())
}

/// The SHA-256 of each deferred buffer; none if they were not kept.
pub fn buffer_hashes(picture: &Picture) -> Option<BTreeMap<&'static str, String>> {
    let deferred = picture.deferred.as_ref()?;
    let buffers: [(_, &[u8]); 8] = [
        ("lists", bytemuck::cast_slice(&deferred.lists)),
        ("hits", bytemuck::cast_slice(&deferred.hits)),
        ("surfaces", bytemuck::cast_slice(&deferred.surfaces)),
        ("masks", bytemuck::cast_slice(&deferred.masks)),
        ("tints", bytemuck::cast_slice(&deferred.tints)),
        ("lit", bytemuck::cast_slice(&deferred.lit)),
        ("colors", bytemuck::cast_slice(&deferred.colors)),
        ("layers", bytemuck::cast_slice(&deferred.layers)),
    ];
    Some(buffers.map(|(name, bytes)| (name, sha256(bytes))).into())
}
