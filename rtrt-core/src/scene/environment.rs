//! From a panorama or a cube to the blurred squares of an environment map.

use crate::kernel::environment::{IRRADIANCE_SIDE, LEAST_SIDE, octahedral};
use crate::lane::V3;
use crate::layout::Sky;
use crate::scene::brightness::{BRIGHTEST, usable};
use crate::scene::{Cube, CubeError};
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};
use glam::DVec3;

/// Light from all around: an equirectangular picture, linear RGB. Its rows run from straight
/// up (+y) to straight down; its middle column is +x, columns go on toward +z.
#[derive(Debug, Clone, PartialEq)]
pub struct Panorama {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row. Negative numbers and NaN count as 0, larger ones than 65,408 as 65,408.
    pub rgb: Vec<[f32; 3]>,
}

/// Why a panorama was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{pixels} pixels do not make a panorama of {width} x {height}, each within 1 .. 16384")]
pub struct PanoramaError {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The number of pixels.
    pub pixels: usize,
}

/// Directions that a texel of a narrow lobe is the mean of.
const SAMPLES: u32 = 64;
/// The side of the square whose texels a texel of a wide lobe is the mean of.
const WIDE_SOURCE: u32 = 64;

impl Panorama {
    /// Appends the squares to `texels`, and says where they are.
    pub(super) fn append(&self, texels: &mut Vec<u32>) -> Result<Sky, PanoramaError> {
        let &Self { width, height, ref rgb } = self;
        let sides = 1..=16_384;
        let fits = rgb.len() as u64 == u64::from(width) * u64::from(height);
        if !fits || !sides.contains(&width) || !sides.contains(&height) {
            return Err(PanoramaError { width, height, pixels: rgb.len() });
        }
        Ok(append(width / 2, |d| self.toward(d), texels))
    }

    /// The light from a direction of unit length, bilinear.
    pub(super) fn toward(&self, d: DVec3) -> DVec3 {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let x = (libm::atan2(d.z, d.x) / TAU + 0.5) * width - 0.5;
        let y = libm::acos(d.y.clamp(-1.0, 1.0)) / PI * height - 0.5;
        let (left, upper) = (libm::floor(x), libm::floor(y));
        let column = |x: f64| (x as i64).rem_euclid(i64::from(self.width)) as usize;
        let row = |y: f64| y.clamp(0.0, height - 1.0) as usize * self.width as usize;
        let at = |x: f64, y: f64| DVec3::from(self.rgb[row(y) + column(x)].map(usable));
        let above = at(left, upper).lerp(at(left + 1.0, upper), x - left);
        let below = at(left, upper + 1.0).lerp(at(left + 1.0, upper + 1.0), x - left);
        above.lerp(below, y - upper)
    }
}

impl Cube {
    /// Appends the squares to `texels`, and says where they are.
    pub(super) fn append(&self, texels: &mut Vec<u32>) -> Result<Sky, CubeError> {
        self.check()?;
        Ok(append(2 * self.side, |d| self.toward(d), texels))
    }
}

/// Appends the squares of a picture with `half_turn` pixels in half a turn; returns their place.
///
/// All is computed in `f64`, by `libm`, in one order: every host gets the same words.
fn append(half_turn: u32, toward: impl Fn(DVec3) -> DVec3, texels: &mut Vec<u32>) -> Sky {
    // Around the horizon a square of half the width has 1.4 times as many texels.
    let side = half_turn.next_power_of_two().clamp(64, 1024);
    let mut sources = vec![sharp(side, toward)];
    while let Some(last) = sources.last().filter(|square| square.side > 4) {
        sources.push(last.halved());
    }
    let first = texels.len();
    let levels = side.ilog2() - 1;
    texels.resize(first + levels as usize + 1, 0);
    for level in 0..=levels {
        texels[first + level as usize] = texels.len() as u32;
        let alpha = libm::exp2(f64::from(level + 1) - f64::from(levels));
        let square = match side >> level {
            _ if level == levels => mean(&sources, IRRADIANCE_SIDE, |cosine| cosine),
            _ if level == 0 => Square::new(side, |at| sources[0].texel(at)),
            side if side > LEAST_SIDE => blurred(&sources, side, alpha),
            _ => mean(&sources, LEAST_SIDE, |cosine| lobe(cosine, alpha)),
        };
        texels.extend(square.texels.iter().map(|&texel| encode(texel)));
    }
    Sky { first: first as u32, side, levels, ..Sky::default() }
}

/// The picture as a square; each texel is the mean of four places in it.
fn sharp(side: u32, toward: impl Fn(DVec3) -> DVec3) -> Square {
    Square::new(side, |[x, y]| {
        let mut sum = DVec3::ZERO;
        for (dx, dy) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let place = [f64::from(x) + dx, f64::from(y) + dy].map(|c| c / f64::from(side));
            sum += toward(direction(place));
        }
        sum * 0.25
    })
}

/// An octahedral map with its border.
struct Square {
    side: u32,
    texels: Vec<DVec3>,
}

impl Square {
    /// The square of these texels, and the border that they make.
    fn new(side: u32, texel: impl Fn([u32; 2]) -> DVec3) -> Self {
        let width = side as usize + 2;
        let mut texels = vec![DVec3::ZERO; width * width];
        for y in 0..side {
            for x in 0..side {
                texels[(y as usize + 1) * width + x as usize + 1] = texel([x, y]);
            }
        }
        // An edge continues in itself, mirrored at its middle.
        let last = width - 1;
        for i in 1..last {
            let opposite = last - i;
            texels[i] = texels[width + opposite];
            texels[last * width + i] = texels[(last - 1) * width + opposite];
            texels[i * width] = texels[opposite * width + 1];
            texels[i * width + last] = texels[opposite * width + last - 1];
        }
        // All corners are straight down.
        for (corner, inside) in [
            (0, last * width - 2),
            (last, (last - 1) * width + 1),
            (last * width, width + last - 1),
            (last * width + last, width + 1),
        ] {
            texels[corner] = texels[inside];
        }
        Self { side, texels }
    }

    fn texel(&self, [x, y]: [u32; 2]) -> DVec3 {
        self.texels[(y as usize + 1) * (self.side as usize + 2) + x as usize + 1]
    }

    /// Half as large, each texel the mean of four, by their solid angles: a sun stays as bright as it is.
    fn halved(&self) -> Self {
        Self::new(self.side / 2, |[x, y]| {
            let (mut sum, mut total) = (DVec3::ZERO, 0.0);
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let at = [2 * x + dx, 2 * y + dy];
                let (_, angle) = toward_and_angle(self.side, at);
                sum += self.texel(at) * angle;
                total += angle;
            }
            sum / total
        })
    }

    /// The light from a direction of unit length, bilinear.
    fn toward(&self, d: DVec3) -> DVec3 {
        let direction = V3::<f32>::splat((), [d.x as f32, d.y as f32, d.z as f32]);
        let at = octahedral(direction).map(|c| (f64::from(c) * f64::from(self.side) + 0.5).max(0.0));
        let (x, y) = ((at[0] as usize).min(self.side as usize), (at[1] as usize).min(self.side as usize));
        let width = self.side as usize + 2;
        let row = |y: usize| {
            let from = y * width + x;
            self.texels[from].lerp(self.texels[from + 1], at[0] - x as f64)
        };
        row(y).lerp(row(y + 1), at[1] - y as f64)
    }
}

/// The point of the octahedron at a place of the square, `0 ..= 1` each.
fn point([u, v]: [f64; 2]) -> DVec3 {
    let (x, z) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let y = 1.0 - x.abs() - z.abs();
    if y >= 0.0 {
        return DVec3::new(x, y, z);
    }
    let sign = |c: f64| if c < 0.0 { -1.0 } else { 1.0 };
    DVec3::new((1.0 - z.abs()) * sign(x), y, (1.0 - x.abs()) * sign(z))
}

/// The direction there, of unit length.
fn direction(place: [f64; 2]) -> DVec3 {
    let p = point(place);
    p / libm::sqrt(p.length_squared())
}

/// The middle of a texel.
fn middle(side: u32, [x, y]: [u32; 2]) -> [f64; 2] {
    [x, y].map(|c| (f64::from(c) + 0.5) / f64::from(side))
}

/// The direction of a texel's middle, and the solid angle of the texel, in proportion to that of others: 1/|p|³
/// at the point `p` of the octahedron.
fn toward_and_angle(side: u32, at: [u32; 2]) -> (DVec3, f64) {
    let p = point(middle(side, at));
    let length = libm::sqrt(p.length_squared());
    (p / length, 1.0 / (length * length * length))
}

/// What light at this cosine from the mirrored ray counts for a lobe of this width: GGX (Walter et al. 2007) of
/// the half vector, and the cosine, of a surface seen head-on (Karis, "Real Shading in Unreal Engine 4", 2013).
fn lobe(cosine: f64, alpha: f64) -> f64 {
    let half2 = (1.0 + cosine) * 0.5;
    let spread = half2 * (alpha * alpha - 1.0) + 1.0;
    cosine / (spread * spread)
}

/// The light that a surface with lobes of width `alpha` mirrors: the mean of the light from 64 directions, as
/// [`lobe`] distributes them, each taken from a square as coarse as the directions lie apart (Křivánek and
/// Colbert, "Real-time Shading with Filtered Importance Sampling", 2008).
fn blurred(sources: &[Square], side: u32, alpha: f64) -> Square {
    let finest = f64::from(sources[0].side);
    // Directions around +y, their weights, and the squares that they are looked up in.
    let directions: Vec<(DVec3, f64, usize)> = (0..SAMPLES)
        .filter_map(|i| {
            let (turn, height) =
                (f64::from(i) / f64::from(SAMPLES), f64::from(i.reverse_bits()) / 4_294_967_296.0);
            let cos2 = (1.0 - height) / (1.0 + (alpha * alpha - 1.0) * height);
            let (cos, sin) = (libm::sqrt(cos2), libm::sqrt(1.0 - cos2));
            let (s, c) = libm::sincos(TAU * turn);
            let half = DVec3::new(sin * c, cos, sin * s);
            let light = half * (2.0 * half.y) - DVec3::Y;
            let spread = cos2 * (alpha * alpha - 1.0) + 1.0;
            let density = alpha * alpha / (PI * spread * spread) / 4.0;
            let apart = 1.0 / (f64::from(SAMPLES) * density);
            let level = 0.5 * libm::log2(apart * finest * finest / (4.0 * PI)) + 1.0;
            let level = (level.max(0.0) as usize).min(sources.len() - 1);
            (light.y > 0.0).then_some((light, light.y, level))
        })
        .collect();
    let total: f64 = directions.iter().map(|(_, weight, _)| weight).sum();
    Square::new(side, |at| {
        let (up, _) = toward_and_angle(side, at);
        let (right, ahead) = up.any_orthonormal_pair();
        let light = directions
            .iter()
            .map(|(d, weight, level)| sources[*level].toward(right * d.x + up * d.y + ahead * d.z) * *weight);
        light.sum::<DVec3>() / total
    })
}

/// The mean of the light from the hemisphere around each direction, by a weight of the cosine to it: of all
/// texels of a coarse source, by their solid angles.
fn mean(sources: &[Square], side: u32, weight: impl Fn(f64) -> f64) -> Square {
    let source = sources.iter().rev().find(|square| square.side >= WIDE_SOURCE).unwrap_or(&sources[0]);
    let places = (0..source.side).flat_map(|y| (0..source.side).map(move |x| [x, y]));
    let lights: Vec<(DVec3, f64, DVec3)> = places
        .map(|at| {
            let (toward, angle) = toward_and_angle(source.side, at);
            (toward, angle, source.texel(at))
        })
        .collect();
    Square::new(side, |at| {
        let (middle, _) = toward_and_angle(side, at);
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (toward, angle, light) in &lights {
            let cosine = middle.dot(*toward);
            if cosine > 0.0 {
                let weight = weight(cosine) * angle;
                sum += *light * weight;
                total += weight;
            }
        }
        sum / total
    })
}

/// The texel nearest to this light; see [`crate::kernel::environment::decode`].
fn encode(light: DVec3) -> u32 {
    let light = light.to_array().map(|c| c.min(f64::from(BRIGHTEST)));
    let most = light.iter().fold(0.0, |a: f64, &b| a.max(b));
    // The least exponent whose mantissas hold the largest channel.
    let exponent = (0..31).find(|&e| libm::round(most / libm::exp2(f64::from(e) - 24.0)) <= 511.0);
    let exponent = exponent.unwrap_or(31);
    let scale = libm::exp2(f64::from(exponent) - 24.0);
    let [r, g, b] = light.map(|c| (libm::round(c / scale) as u32).min(511));
    r | g << 9 | b << 18 | (exponent as u32) << 27
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::environment::{arriving, decode, mirrored};
    use crate::kernel::texture::Maps;

    /// Up is 4, down is 1; toward −x there is a sun.
    fn panorama() -> Panorama {
        let (width, height) = (64, 32);
        let light = |i: u32| {
            let (x, y) = (i % width, i / width);
            let sun = (x == 0 || x == width - 1) && (y == 15 || y == 16);
            if sun {
                [900.0, 800.0, 700.0]
            } else if y < 16 {
                [4.0; 3]
            } else {
                [1.0; 3]
            }
        };
        Panorama { width, height, rgb: (0..width * height).map(light).collect() }
    }

    #[test]
    fn numbers_of_a_texel_come_back() {
        for light in [[0.0; 3], [1.0, 0.5, 0.25], [65_000.0, 3.0, 0.0], [1e-6, 2e-6, 0.0], [511.9, 1.0, 77.0]]
        {
            let most = light.iter().fold(0.0_f64, |a, &b| a.max(b));
            let found = decode(encode(DVec3::from(light)));
            for (a, b) in found.iter().zip(light) {
                assert!((f64::from(*a) - b).abs() <= most / 511.0 + 1e-7, "{light:?} {found:?}");
            }
        }
    }

    #[test]
    fn mirrors_show_what_is_there_and_rough_ones_its_mean() {
        let mut texels = vec![7; 3];
        let sky = panorama().append(&mut texels).unwrap();
        let maps = Maps { materials: &[], texels: &texels };
        let at = |d: [f32; 3], roughness| mirrored::<f32>(&maps, sky, V3::splat((), d), roughness).x;
        assert!(
            (at([0.1, 3.0, 0.1], 0.0) - 4.0).abs() < 0.05 && (at([0.0, -1.0, 0.0], 0.0) - 1.0).abs() < 0.01
        );
        assert!(at([-1.0, 0.0, 0.0], 0.0) > 400.0 && at([1.0, 0.5, 0.0], 0.0) < 5.0);
        assert!(at([-1.0, 0.0, 0.0], 0.5) < at([-1.0, 0.0, 0.0], 0.2));
        let on = |n: [f32; 3]| arriving::<f32>(&maps, sky, V3::splat((), n)).x;
        assert!(on([0.0, 1.0, 0.0]) > on([0.0, -1.0, 0.0]) && on([-1.0, 0.0, 0.0]) > on([1.0, 0.0, 0.0]));
    }

    #[test]
    fn light_from_everywhere_stays_what_it_is() {
        let panorama = Panorama { width: 8, height: 4, rgb: vec![[2.0, 0.5, 8.0]; 32] };
        let mut texels = vec![];
        let sky = panorama.append(&mut texels).unwrap();
        let pixels = texels[texels[sky.first as usize] as usize..].iter().map(|&texel| decode(texel));
        assert!(pixels.into_iter().all(|p| p == [2.0, 0.5, 8.0]));
    }

    #[test]
    fn refuses_pixels_that_do_not_fit() {
        let panorama = Panorama { width: 8, height: 4, rgb: vec![[1.0; 3]; 31] };
        assert!(panorama.append(&mut vec![]).is_err());
    }
}
