//! Resolve: the sub-rays of a pixel become its color.

use crate::grid::{RayIndex, number};
use crate::kernel::tone_map::tone_map;
use crate::lane::{Lane, Mask, Select, V3, times};
use crate::layout::{Backdrop, Frame};
use crate::num::{recip, srgb_byte_encode, to_integer};

/// A group of pixels: the average of each one's sub-rays' linear colors, summed row by row, [displayed] as
/// the frame says, in front of the background's color if it has one, and encoded as sRGB with 8 bits a channel,
/// red lowest.
///
/// ```text
/// displayed(color / alpha) · alpha + background · (1 − alpha)
/// ```
///
/// Sub-rays' colors are multiplied by their alphas. With [`Backdrop::Nothing`] a pixel keeps its alpha, by which
/// its color is not multiplied. `color(lane)` is the [`average`] of the colors that a pixel's rays brought back. In frames with
/// [colored layers](Frame::has_colored_layers) a share a channel takes the place of `1 − alpha`: `through(lane)`, the
/// average of what the layers of its rays let through.
#[inline(always)]
pub fn resolve<L: Lane>(
    token: L::Token,
    frame: &Frame,
    color: impl Fn(usize) -> [f32; 4],
    through: impl Fn(usize) -> [f32; 4],
) -> L::Bits {
    let [[r, g, b, a]] = L::gather_fours(
        token,
        #[inline(always)]
        |lane| [color(lane)],
    );
    let one = a.broadcast(1.0);
    let is_covered = a.ge(one);
    let is_partial = a.gt(a.broadcast(0.0)) & !is_covered;
    let color = V3 { x: r, y: g, z: b };
    let color = if is_partial.any() { color.scale(is_partial.select(recip(a), one)) } else { color };
    let shown = displayed(frame.exposure, frame.tone_map, color);
    if frame.backdrop == Backdrop::Nothing as u32 {
        return encoded(shown, a);
    }
    let in_front = if (!is_covered).any() {
        let mut rest = V3 { x: one - a, y: one - a, z: one - a };
        if frame.has_colored_layers() {
            let [[x, y, z, _]] = L::gather_fours(
                token,
                #[inline(always)]
                |lane| [through(lane)],
            );
            rest = V3 { x, y, z };
        }
        let behind = V3::splat(token, [frame.background_r, frame.background_g, frame.background_b]);
        V3::select(is_covered, shown, shown.scale(a) + times(behind, rest))
    } else {
        shown
    };
    encoded(in_front, one)
}

/// A color and its alpha as a pixel.
#[inline(always)]
fn encoded<L: Lane>(color: V3<L>, alpha: L) -> L::Bits {
    let [r, g, b] = [srgb_byte_encode(color.x), srgb_byte_encode(color.y), srgb_byte_encode(color.z)];
    r | g << 8 | b << 16 | to_integer(alpha * 255.0) << 24
}

/// Linear light as the linear color of a display: multiplied by the frame's exposure, then tone mapped.
#[inline(always)]
pub fn displayed<L: Lane>(exposure: f32, operator: u32, light: V3<L>) -> V3<L> {
    let V3 { x, y, z } = light;
    tone_map(operator, V3 { x: x * exposure, y: y * exposure, z: z * exposure })
}

/// The average color of the pixel with this first ray, linear RGB and alpha, of `side` × `side` sub-rays.
#[inline(always)]
pub fn average(side: u32, first: RayIndex, color: impl Fn(RayIndex) -> [f32; 4]) -> [f32; 4] {
    if side == 1 {
        return color(first);
    }
    let mut sum = [0.0_f32; 4];
    let mut b = 0;
    while b < side {
        let mut a = 0;
        while a < side {
            let c = color(RayIndex(first.0 + number([a, b])));
            sum = [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2], sum[3] + c[3]];
            a += 1;
        }
        b += 1;
    }
    // A power of two, so the weight is exact.
    let weight = if side == 2 { 0.25 } else { 0.0625 };
    [sum[0] * weight, sum[1] * weight, sum[2] * weight, sum[3] * weight]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{MaterialRecord, ToneMap};
    use bytemuck::Zeroable;

    /// A frame of one pixel of one sample.
    fn one() -> Frame {
        Frame { width: 1, height: 1, side: 1, exposure: 1.0, ..Frame::zeroed() }
    }

    #[test]
    fn half_a_pixel_is_half_covered() {
        let backdrop = Backdrop::Nothing as u32;
        let frame = Frame { width: 1, height: 1, side: 2, exposure: 1.0, backdrop, ..Frame::zeroed() };
        let grid = frame.grid();
        let pixel = |colors: [[f32; 4]; 4]| {
            let color =
                |ray: RayIndex| colors[(0..4).find(|i| grid.index([i % 2, i / 2]) == ray).unwrap() as usize];
            resolve::<f32>((), &frame, |_| average(2, RayIndex(0), color), |_| [0.0; 4]).0.to_le_bytes()
        };
        let color = [0.25, 0.5, 0.75];
        let [r, g, b] = color.map(|value| srgb_byte_encode(value).0 as u8);
        let (full, none) = ([0.25, 0.5, 0.75, 1.0], [0.0; 4]);
        assert_eq!(pixel([full; 4]), [r, g, b, 255]);
        assert_eq!(pixel([full, none, full, none]), [r, g, b, 128]);
        assert_eq!(pixel([none; 4]), [0; 4]);
    }

    #[test]
    fn light_is_exposed_before_it_is_mapped_and_behind_what_covers_it_in_part() {
        let color = [0.09, 0.18, 0.36];
        for map in ToneMap::ALL.map(|(_, map)| map as u32) {
            let backdrop = Backdrop::Nothing as u32;
            let frame = Frame { exposure: 4.0, tone_map: map, backdrop, ..one() };
            let pixel = |c: [f32; 4]| resolve::<f32>((), &frame, |_| c, |_| [0.0; 4]).0.to_le_bytes();
            let V3 { x, y, z } = tone_map::<f32>(map, V3::splat((), color.map(|c| 4.0 * c)));
            let [r, g, b] = [x, y, z].map(|c| srgb_byte_encode(c).0 as u8);
            assert_eq!(pixel([0.09, 0.18, 0.36, 1.0]), [r, g, b, 255]);
            assert_eq!(pixel([0.045, 0.09, 0.18, 0.5]), [r, g, b, 128]);
        }
    }

    #[test]
    fn a_background_is_neither_exposed_nor_mapped() {
        let [r, g, b] = [0.25, 0.5, 1.0].map(|c| srgb_byte_encode(c).0 as u8);
        for (_, map) in ToneMap::ALL {
            let background = Frame { background_r: 0.25, background_g: 0.5, background_b: 1.0, ..one() };
            let frame = Frame { exposure: 64.0, tone_map: map as u32, ..background };
            let pixel = |c: [f32; 4]| resolve::<f32>((), &frame, |_| c, |_| [0.0; 4]).0.to_le_bytes();
            assert_eq!(pixel([0.0; 4]), [r, g, b, 255]);
            // A black surface that covers half of it.
            let [.., blue, alpha] = pixel([0.0, 0.0, 0.0, 0.5]);
            assert_eq!((blue.abs_diff(srgb_byte_encode(0.5).0 as u8) <= 1, alpha), (true, 255));
        }
    }

    #[test]
    fn glass_colors_the_background() {
        let background = Frame { background_r: 1.0, background_g: 1.0, background_b: 1.0, ..one() };
        let frame = Frame { layers: 1, extensions: MaterialRecord::TRANSMITS, ..background };
        let through = [0.75, 0.25, 0.0, 0.0];
        let covered = 1.0 - 1.0 / 3.0;
        let pixel = resolve::<f32>((), &frame, |_| [0.0, 0.0, 0.0, covered], |_| through);
        let [r, g, b] = [0.75, 0.25, 0.0].map(|c| srgb_byte_encode(c).0 as u8);
        assert_eq!(pixel.0.to_le_bytes(), [r, g, b, 255]);
    }
}
