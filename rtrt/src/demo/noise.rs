//! Noise from integers: the same on every host.

/// A number in 0 ..= 1 for each cell, without pattern.
pub(super) fn hash(x: u32, y: u32, seed: u32) -> f32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ seed.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ h >> 12).wrapping_mul(0x297a_2d39);
    ((h ^ h >> 15) >> 8) as f32 / 16_777_216.0
}

/// Smooth noise in 0 ..= 1 with `cells` cells each way.
pub(super) struct Smooth {
    cells: [u32; 2],
    /// At the corners of the cells, row by row, one more each way than there are cells.
    corners: Vec<f32>,
}

impl Smooth {
    pub fn new(cells: [u32; 2], seed: u32) -> Self {
        let row = |y: u32| (0..=cells[0]).map(move |x| hash(x % cells[0], y % cells[1], seed));
        Self { cells, corners: (0..=cells[1]).flat_map(row).collect() }
    }

    /// The noise at a place, repeating where `u` or `v` (at least 0) is a whole number.
    pub fn at(&self, u: f32, v: f32) -> f32 {
        let [columns, rows] = self.cells;
        let (x, y) = (u * columns as f32, v * rows as f32);
        let (x0, y0) = (x as u32, y as u32);
        let ease = |t: f32| t * t * (3.0 - 2.0 * t);
        let (tx, ty) = (ease(x - x0 as f32), ease(y - y0 as f32));
        let first = (y0 % rows * (columns + 1) + x0 % columns) as usize;
        let row = |first: usize| self.corners[first] + (self.corners[first + 1] - self.corners[first]) * tx;
        let (upper, lower) = (row(first), row(first + columns as usize + 1));
        upper + (lower - upper) * ty
    }
}

/// Four octaves of [`Smooth`], in 0 ..= 1.
pub(super) struct Cloudy([Smooth; 4]);

impl Cloudy {
    pub fn new(cells: [u32; 2], seed: u32) -> Self {
        Self([0, 1, 2, 3].map(|n| Smooth::new(cells.map(|c| c << n), seed + n)))
    }

    /// The noise at a place, repeating as [`Smooth::at`].
    pub fn at(&self, u: f32, v: f32) -> f32 {
        let octave = |n: usize| self.0[n].at(u, v) / (2 << n) as f32;
        (octave(0) + octave(1) + octave(2) + octave(3)) * (16.0 / 15.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_and_stays_in_range() {
        for i in 0..200 {
            let (u, v) = (hash(i, 0, 1), hash(i, 1, 1));
            let noise = Cloudy::new([5, 3], 9).at(u, v);
            assert!((0.0..=1.0).contains(&noise));
            let smooth = Smooth::new([4, 4], 2);
            assert!((smooth.at(u, 1.0) - smooth.at(u, 0.0)).abs() < 1e-6);
        }
    }
}
