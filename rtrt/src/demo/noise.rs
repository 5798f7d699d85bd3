//! Noise from integers: the same on every host.

/// A number in 0 ..= 1 for each cell, without pattern.
pub(super) fn hash(x: u32, y: u32, seed: u32) -> f32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ seed.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ h >> 12).wrapping_mul(0x297a_2d39);
    ((h ^ h >> 15) >> 8) as f32 / 16_777_216.0
}

/// Smooth noise in 0 ..= 1 with `cells` cells each way, repeating where `u` or `v` (at least
/// 0) is a whole number.
pub(super) fn smooth(u: f32, v: f32, cells: [u32; 2], seed: u32) -> f32 {
    let (x, y) = (u * cells[0] as f32, v * cells[1] as f32);
    let (x0, y0) = (x as u32, y as u32);
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (tx, ty) = (ease(x - x0 as f32), ease(y - y0 as f32));
    let at = |dx: u32, dy: u32| hash((x0 + dx) % cells[0], (y0 + dy) % cells[1], seed);
    let row = |dy: u32| at(0, dy) + (at(1, dy) - at(0, dy)) * tx;
    row(0) + (row(1) - row(0)) * ty
}

/// Four octaves of [`smooth`], in 0 ..= 1.
pub(super) fn cloudy(u: f32, v: f32, cells: [u32; 2], seed: u32) -> f32 {
    let octave = |n: u32| smooth(u, v, cells.map(|c| c << n), seed + n) / (2 << n) as f32;
    (octave(0) + octave(1) + octave(2) + octave(3)) * (16.0 / 15.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_and_stays_in_range() {
        for i in 0..200 {
            let (u, v) = (hash(i, 0, 1), hash(i, 1, 1));
            let noise = cloudy(u, v, [5, 3], 9);
            assert!((0.0..=1.0).contains(&noise));
            assert!((smooth(u, 1.0, [4, 4], 2) - smooth(u, 0.0, [4, 4], 2)).abs() < 1e-6);
        }
    }
}
