//! The brightness of an environment.

/// The brightest that a texel can be: 511/512 · 2¹⁶.
pub(super) const BRIGHTEST: f32 = 65_408.0;

/// A channel of a picture within 0 ..= [`BRIGHTEST`]; 0 for NaN.
pub(super) fn usable(channel: f32) -> f64 {
    if channel > 0.0 { f64::from(channel.min(BRIGHTEST)) } else { 0.0 }
}
