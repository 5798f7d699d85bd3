//! Exposure: by how many stops light is raised or lowered before it is tone mapped, and a meter
//! that finds them.
//!
//! The meter works on integers: the bits of a positive `f32`, shifted, are its logarithm in steps of
//! 1/32 stop, straight between powers of two (at most 0.09 stops off). Every backend gives it the
//! same linear colors, so it gives the same stops everywhere.

use crate::grid::Grid;
use crate::layout::{Hit, NONE};
use crate::request::Request;
use alloc::vec;

/// Pixels along the longer side of the picture that is metered.
const SIDE: u32 = 160;
/// Bits of a luminance below a step.
const SHIFT: u32 = 18;
/// Steps in a stop.
const STOP: u32 = 1 << (23 - SHIFT);
/// Steps up to infinity.
const STEPS: usize = 0x7f80_0000 >> SHIFT;
/// Luminances below this (2⁻⁶⁴) count as none.
const LEAST: u32 = (127 - 64) << (23 - SHIFT);
/// How far below the bright end of the picture the mean reaches.
const RANGE: u32 = 8 * STOP;
/// What the mean becomes: middle gray.
const GRAY: i32 = step(0.18);
/// What the bright end becomes at least, and at most.
const ENDS: [i32; 2] = [step(0.7), step(4.0)];

/// The step of a positive luminance.
const fn step(luminance: f32) -> i32 {
    (luminance.to_bits() >> SHIFT) as i32
}

/// The request for the picture that is metered: of at most 160 pixels along its longer side, of one
/// sample a pixel, with the deferred buffers.
pub fn metering<'a>(request: &Request<'a>) -> Request<'a> {
    let longest = request.size[0].max(request.size[1]).max(1);
    let side = longest.min(SIDE);
    let size = request.size.map(|pixels| (pixels * side).div_ceil(longest));
    request.size(size).samples(1).deferred(true)
}

/// The exposure that suits a picture of one sample a pixel, in stops; 0 for a black one. `hits` and
/// `colors` are its deferred buffers.
///
/// Only rays count that find a surface, or all if hardly any (less than 1 in 256) does. The *bright
/// end* is the luminance that 1 in 64 exceeds. The mean of the logarithms from 8 stops below it up to it
/// becomes middle gray (0.18); but the bright end becomes 0.7 at least, as in a picture of one white
/// wall, and 4 at most.
pub fn stops(size: [u32; 2], hits: &[Hit], colors: &[[f32; 4]]) -> f32 {
    let [width, height] = size;
    let grid = Grid { width, height, side: 1 };
    let Some((bright, mean)) = measured(grid, hits, colors) else { return 0.0 };
    let steps = (GRAY - mean).clamp(ENDS[0] - bright, ENDS[1] - bright);
    steps as f32 * (1.0 / STOP as f32)
}

/// The steps of the bright end and of the mean.
fn measured(grid: Grid, hits: &[Hit], colors: &[[f32; 4]]) -> Option<(i32, i32)> {
    let rays = || (0..grid.width * grid.height).map(|number| grid.index(grid.pixel(number)).0 as usize);
    let surfaces = rays().filter(|&ray| hits[ray].instance != NONE).count() as u32;
    let has_surfaces = surfaces >= (grid.width * grid.height).div_ceil(256);
    let mut counts = vec![0_u32; STEPS];
    let mut all = 0_u32;
    for ray in rays().filter(|&ray| !has_surfaces || hits[ray].instance != NONE) {
        let [r, g, b, _] = colors[ray];
        // ITU-R BT.709.
        let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let step = luminance.max(0.0).to_bits() >> SHIFT;
        if step >= LEAST && (step as usize) < STEPS {
            counts[step as usize] += 1;
            all += 1;
        }
    }
    let mut above = 0;
    let bright = (0..STEPS).rev().find(|&step| {
        above += counts[step];
        above * 64 > all
    })?;
    let lowest = bright.saturating_sub(RANGE as usize);
    let (mut sum, mut count) = (0_u64, 0_u64);
    for (step, &n) in counts.iter().enumerate().take(bright + 1).skip(lowest) {
        sum += step as u64 * u64::from(n);
        count += u64::from(n);
    }
    Some((bright as i32, ((sum + count / 2) / count) as i32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Hit;
    use crate::scene::{Camera, Projection};
    use alloc::vec::Vec;
    use bytemuck::Zeroable;

    /// The stops of a picture whose pixels have these luminances; none is where no surface is.
    fn of(light: impl Fn(u32) -> Option<f32>) -> f32 {
        let (width, height) = (64, 32);
        let grid = Grid { width, height, side: 1 };
        let rays = grid.rays() as usize;
        let nothing = Hit { instance: NONE, ..Hit::zeroed() };
        let (mut hits, mut colors) = (vec![nothing; rays], vec![[0.0; 4]; rays]);
        for number in 0..width * height {
            let ray = grid.index(grid.pixel(number)).0 as usize;
            let luminance = light(number);
            hits[ray].instance = if luminance.is_some() { 0 } else { NONE };
            colors[ray] = [luminance.unwrap_or(1000.0); 4];
        }
        stops([width, height], &hits, &colors)
    }

    #[test]
    fn a_wall_becomes_bright_and_a_slope_has_gray_in_its_middle() {
        let wall = of(|_| Some(7.0));
        assert!((wall - (0.7_f32 / 7.0).log2()).abs() < 0.1, "{wall}");
        // Six stops, evenly.
        let slope = of(|i| Some((6.0 * (i % 64) as f32 / 63.0).exp2()));
        assert!((slope - (0.18_f32.log2() - 3.0)).abs() < 0.15, "{slope}");
    }

    #[test]
    fn neither_sky_nor_glints_nor_black_count() {
        let room = of(|i| (i % 3 != 0).then_some(0.02));
        let with_more = of(|i| match i {
            i if i % 3 == 0 => None,
            i if i % 97 == 0 => Some(500.0),
            i if i % 5 == 0 => Some(0.0),
            i if i % 7 == 0 => Some(1e-6),
            _ => Some(0.02),
        });
        assert_eq!(room, with_more);
    }

    #[test]
    fn a_doubling_of_light_is_a_stop() {
        let scene = |scale: f32| of(move |i| Some(scale * (1 + i % 50) as f32));
        for k in [-20, -1, 1, 7] {
            assert_eq!(scene((k as f32).exp2()), scene(1.0) - k as f32);
        }
    }

    #[test]
    fn bright_ends_are_held() {
        // Most is dark; a tenth is 10 stops brighter.
        let window = of(|i| Some(if i % 10 == 0 { 1024.0 } else { 8.0 }));
        assert!((window - (4.0_f32 / 1024.0).log2()).abs() < 0.1, "{window}");
    }

    #[test]
    fn what_is_black_or_no_number_stays() {
        for luminance in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30] {
            assert_eq!(of(|_| Some(luminance)), 0.0);
        }
        let sky: Vec<f32> = vec![of(|_| None), of(|_| Some(1000.0))];
        assert_eq!(sky[0], sky[1]);
    }

    #[test]
    fn the_metered_picture_is_small_and_of_the_same_shape() {
        let camera = Camera {
            eye: [0.0; 3].into(),
            look_at: [1.0; 3].into(),
            up: [0.0, 1.0, 0.0].into(),
            projection: Projection::Perspective { fov_y: 1.0 },
        };
        for (size, small) in [
            ([1280, 720], [160, 90]),
            ([100, 100], [100, 100]),
            ([16_384, 1], [160, 1]),
            ([3, 16_000], [1, 160]),
        ] {
            let request = metering(&Request::new(&camera, size).samples(16));
            assert_eq!((request.size, request.samples, request.deferred), (small, 1, true));
        }
    }
}
