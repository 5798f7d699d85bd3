//! What `rtrt --version` tells.

use std::sync::LazyLock;

/// Version, features, and the hash of the shaders: what two people compare first whose pictures differ.
pub fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        // Without the other ones there is no command.
        let viewer = if cfg!(feature = "viewer") { ", viewer" } else { "" };
        let shaders = rtrt::hash::of(rtrt_gpu::SHADERS);
        let version = env!("CARGO_PKG_VERSION");
        format!("{version}\nfeatures: gpu, import, command{viewer}\nshaders: {shaders}")
    });
    &LONG
}
