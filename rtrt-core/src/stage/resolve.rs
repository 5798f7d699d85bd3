//! Resolve: the sub-rays of a pixel become its color.

use crate::grid::{Grid, RayIndex};
use crate::num::{floor, srgb_encode, to_integer};

/// The pixel at column `x` and row `y`: the average of its sub-rays' linear colors, summed
/// row by row, encoded as sRGB with 8 bits a channel, red lowest. `color(ray)` is the
/// color that a ray brought back.
#[inline(always)]
pub fn resolve(grid: Grid, [x, y]: [u32; 2], color: impl Fn(RayIndex) -> [f32; 4]) -> u32 {
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
    byte(srgb_encode(sum[0] * weight))
        | byte(srgb_encode(sum[1] * weight)) << 8
        | byte(srgb_encode(sum[2] * weight)) << 16
        | byte(sum[3] * weight) << 24
}

/// The nearest of 256 steps.
#[inline(always)]
fn byte(value: f32) -> u32 {
    to_integer(floor(value * 255.0 + 0.5)).0
}
