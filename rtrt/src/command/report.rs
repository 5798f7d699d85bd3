//! Results that several commands print: machines, times, hashes.

use rtrt_core::backend::{Description, Picture};
use rtrt_core::schedule::Stage;
use serde::ser::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;

/// The backend and the hardware of a frame.
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

    /// The processor or adapter.
    pub fn adapter(&self) -> &str {
        &self.adapter
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
pub fn counted(count: impl Into<u64>, what: &str) -> String {
    let count = count.into();
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A value for each stage. It is serialized as a map from the stages' names, in their order.
#[derive(Debug, Clone)]
pub struct PerStage<T>(pub [T; Stage::COUNT]);

impl<T: Serialize> Serialize for PerStage<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(Stage::ALL.map(Stage::name).iter().zip(&self.0))
    }
}

/// The SHA-256 of each deferred buffer, by name; none for a picture without them.
pub fn buffer_hashes(picture: &Picture) -> Option<BTreeMap<&'static str, String>> {
    Some(rtrt::hash::buffers(picture)?.into())
}
