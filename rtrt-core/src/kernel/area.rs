//! Lights with a radius, sampled: each sub-ray of a pixel takes another point of the light.
//!
//! The paper splits a light into as many points as a pixel has sub-rays, and tests each sub-ray
//! against one of them. Here a light is a ball that every surface sees as a disc. The disc is split
//! into parts of equal area, one a sub-ray; the point is the middle of its part or, with jitter, any
//! point in it.
//!
//! # One list serves all points
//!
//! The lists of a light are built for its middle `c`. A ray from `p` to the point `c + r` is, at the
//! share `s` of its length, `s · r` away from the segment from `p` to `c`. So binning pads every box by
//! the light's radius: the segment then hits every padded box that the ray hits, and the list of the
//! block of the light that `p` lies in holds it. Views for every point were refused: they need as many times the lists, and
//! cannot serve jittered points.

use crate::grid::RayIndex;
use crate::lane::{Lane, Select, V3};
use crate::layout::{Frame, View};
use crate::num::{from_integer, normalize, recip, sine_and_cosine};

/// A direction that defines up across the light. It is no axis: points turn around it, and many surfaces
/// of scenes face along an axis.
const HELPER: [f32; 3] = [0.48, 0.64, 0.6];

/// The value of 1 in 16 bits.
const STEP: f32 = 1.0 / 65_536.0;

/// The vector from a light's middle to the point that each of the rays numbered from `first` on samples:
/// across `way`, at most `disc` long.
#[inline(always)]
pub fn light_offset<L: Lane>(frame: &Frame, light: &View, first: RayIndex, way: V3<L>) -> V3<L> {
    let token = way.x.token();
    let [u, v]: [L; 2] = part(token, frame, light, first);
    let [a, b] = disc(u * 2.0 - 1.0, v * 2.0 - 1.0);
    let toward = normalize(way);
    let right = normalize(toward.cross(V3::splat(token, HELPER)));
    let up = right.cross(toward);
    right.scale(a * light.disc) + up.scale(b * light.disc)
}

/// The place of each ray's point in a square, 0 ..= 1.
#[inline(always)]
fn part<L: Lane>(token: L::Token, frame: &Frame, light: &View, first: RayIndex) -> [L; 2] {
    let grid = frame.grid();
    let [x, y] = L::gather(
        token,
        #[inline(always)]
        |lane| {
            let [x, y] = grid.ray(RayIndex(first.0 + lane as u32));
            [(x % grid.side) as f32, (y % grid.side) as f32]
        },
    );
    // One, two or four: a power of two, so the share is exact.
    let share = if grid.side == 1 {
        1.0
    } else if grid.side == 2 {
        0.5
    } else {
        0.25
    };
    if light.jitter == 0 {
        return [(x + 0.5) * share, (y + 0.5) * share];
    }
    let key = light.jitter;
    let bits = L::bits_from_fn(
        token,
        #[inline(always)]
        |lane| hash((first.0 + lane as u32) ^ key),
    );
    let within = |bits: L::Bits| from_integer::<L>(bits) * STEP + STEP * 0.5;
    [(x + within(bits >> 16)) * share, (y + within((bits << 16) >> 16)) * share]
}

/// The point of the unit disc for a point of the square −1 ..= 1. Equal areas stay equal.
///
/// Shirley and Chiu, "A Low Distortion Map Between Disk and Square" (1997): the square's
/// edges become circles, and its quarters keep their angles,
///
/// ```text
/// r = the coordinate of larger magnitude, angle = π/4 · the other one / r
/// ```
#[inline(always)]
pub fn disc<L: Lane>(a: L, b: L) -> [L; 2] {
    let is_wide = a.abs().ge(b.abs());
    let (radius, other) = (is_wide.select(a, b), is_wide.select(b, a));
    let [sine, cosine] = sine_and_cosine(other * recip(radius));
    let (along, across) = (radius * cosine, radius * sine);
    [is_wide.select(along, across), is_wide.select(across, along)]
}

/// Bits that look random: "lowbias32" (Chris Wellons, Prospecting for Hash Functions, 2018;
/// public domain).
#[inline(always)]
pub const fn hash(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_parts_of_the_square_are_equal_parts_of_the_disc() {
        let side = 512;
        let at = |i: i32| (i as f32 + 0.5) * (2.0 / side as f32) - 1.0;
        // Of 16 rings of equal area and 16 sectors, how many points each has.
        let mut counts = [[0_u32; 16]; 16];
        for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
            let [a, b] = disc(at(x), at(y)).map(f64::from);
            let (square, turn) = (a * a + b * b, libm::atan2(b, a) / core::f64::consts::TAU + 0.5);
            assert!(square < 1.0 + 1e-6);
            counts[((square * 16.0) as usize).min(15)][((turn * 16.0) as usize).min(15)] += 1;
        }
        let even = (side * side / 256) as f64;
        for count in counts.as_flattened() {
            assert!((f64::from(*count) / even - 1.0).abs() < 0.12, "{counts:?}");
        }
        assert_eq!(disc(0.0_f32, 0.0), [0.0; 2]);
    }

    #[test]
    fn points_are_across_the_way_and_not_farther_than_the_radius() {
        use bytemuck::Zeroable;
        let frame = Frame { width: 16, height: 16, side: 4, ..Frame::zeroed() };
        for jitter in [0, 1, 77] {
            let light = View { disc: 0.25, jitter, ..View::zeroed() };
            let mut sum = [0.0_f32; 3];
            for ray in 0..256 {
                let way = V3::<f32>::splat((), [1.0, -2.0, 3.0]);
                let point = light_offset(&frame, &light, RayIndex(ray), way);
                assert!(point.dot(point) <= 0.0625 * 1.001 && point.dot(way).abs() < 1e-5);
                sum = [sum[0] + point.x, sum[1] + point.y, sum[2] + point.z];
            }
            assert!(sum.iter().all(|sum| sum.abs() < 256.0 * 0.01), "{jitter} {sum:?}");
        }
    }
}
