//! What `rtrt --version` tells.

use std::sync::LazyLock;

/// Version, features, and the hash of the shaders: what two people compare first whose pictures differ.
pub fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        let features: Vec<&str> =
            [("gpu", cfg!(feature = "gpu")), ("import", cfg!(feature = "import")), ("command", true)]
                .iter()
                .filter_map(|(name, is_on)| is_on.then_some(*name))
                .collect();
        let shaders = rtrt::hash::of(rtrt_gpu::SHADERS);
        let (version, features) = (env!("CARGO_PKG_VERSION"), features.join(", "));
        format!("{version}\nfeatures: {features}\nshaders: {shaders}")
    });
    &LONG
}
