//! The output of `rtrt --version`.

use super::gpus;
use std::sync::LazyLock;

/// Version, features, and the hash of the shaders. If the pictures of two machines differ, these are the first
/// things to compare.
pub fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        let viewer = if cfg!(feature = "viewer") { ", viewer" } else { "" };
        let shaders = gpus::shaders().map_or(String::new(), |hash| format!("\nshaders: {hash}"));
        let version = env!("CARGO_PKG_VERSION");
        format!("{version}\nfeatures: {}import, command{viewer}{shaders}", gpus::FEATURE)
    });
    &LONG
}
