//! Colors as files give them.

/// The linear light of an sRGB value of 0 ..= 1 (IEC 61966-2-1).
///
/// Computed in `f64` by `libm`, so that hosts agree.
pub(super) fn srgb_to_linear(encoded: f64) -> f32 {
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) };
    linear as f32
}
