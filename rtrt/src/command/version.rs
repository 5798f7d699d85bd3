//! The output of `rtrt --version`.

use std::sync::LazyLock;

/// Version, features, and the hash of the shaders. If the pictures of two machines differ, these are the first
/// things to compare.
pub fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        // The command needs the other features.
        let viewer = if cfg!(feature = "viewer") { ", viewer" } else { "" };
        let shaders = rtrt::hash::of(rtrt_gpu::SHADERS);
        let version = env!("CARGO_PKG_VERSION");
        format!("{version}\nfeatures: gpu, import, command{viewer}\nshaders: {shaders}")
    });
    &LONG
}
