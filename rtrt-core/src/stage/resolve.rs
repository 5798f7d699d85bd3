//! Resolve: the sub-rays of a pixel become its color.

use crate::grid::{Grid, RayIndex};
use crate::lane::Lane;
use crate::num::{floor, srgb_encode, to_integer};

/// A group of pixels: the average of each one's sub-rays' linear colors, summed row by
/// row, encoded as sRGB with 8 bits a channel, red lowest. `pixel(lane)` is the column and
/// row of a pixel, `color(ray)` the color that a ray brought back.
#[inline(always)]
pub fn resolve<L: Lane>(
    token: L::Token,
    grid: Grid,
    pixel: impl Fn(usize) -> [u32; 2],
    color: impl Fn(RayIndex) -> [f32; 4],
) -> L::Bits {
    let [r, g, b, a] = L::gather(
        token,
        #[inline(always)]
        |lane| average(grid, pixel(lane), &color),
    );
    byte(srgb_encode(r)) | byte(srgb_encode(g)) << 8 | byte(srgb_encode(b)) << 16 | byte(a) << 24
}

/// The average color of one pixel, linear RGB and alpha.
#[inline(always)]
pub fn average(grid: Grid, [x, y]: [u32; 2], color: &impl Fn(RayIndex) -> [f32; 4]) -> [f32; 4] {
    let mut sum = [0.0_f32; 4];
    let mut b = 0;
    while b < grid.side {
        let mut a = 0;
        while a < grid.side {
            let c = color(grid.index([x * grid.side + a, y * grid.side + b]));
            sum = [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2], sum[3] + c[3]];
            a += 1;
        }
        b += 1;
    }
    // One, four or sixteen: a power of two, so the weight is exact.
    let weight = if grid.side == 1 {
        1.0
    } else if grid.side == 2 {
        0.25
    } else {
        0.0625
    };
    [sum[0] * weight, sum[1] * weight, sum[2] * weight, sum[3] * weight]
}

/// The nearest of 256 steps.
#[inline(always)]
fn byte<L: Lane>(value: L) -> L::Bits {
    to_integer(floor(value * 255.0 + 0.5))
}
