//! Without the feature `gpu`.

use super::{Missing, Variant};

/// The GPU's variants: one, which is missing.
pub fn gpu() -> Vec<Variant> {
    let reason = "built without the feature `gpu`".into();
    vec![Variant { name: "gpu", backend: Err(Missing { reason, is_required: true }) }]
}

pub(crate) fn driver(_: &str) -> String {
    String::new()
}

pub(crate) fn shaders() -> String {
    String::new()
}
