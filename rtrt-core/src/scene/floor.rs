//! The smallest numbers of a scene: smaller ones become 0.

/// Numbers of a scene that are smaller than this in magnitude (2⁻⁶⁰) become 0: some devices
/// flush denormals and others keep them, and no difference of two coordinates, and no product
/// of two colors, may be one.
const FLOOR: f32 = f32::from_bits((127 - 60) << 23);

/// The number, or 0 if it is too small to count.
pub(super) fn floored(value: f32) -> f32 {
    if value.abs() < FLOOR { 0.0 } else { value }
}
