//! Transmittance: the color of a light behind transparent surfaces.

use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::geometry::Geometry;
use crate::kernel::hit_filter::{Faces, HitFilter};
use crate::kernel::transparency::{alpha_mode, passes_mask, tint_and_alpha};
use crate::kernel::triangle::Intersection;
use crate::lane::{Bits, Lane, Mask, Select, V3};
use crate::layout::AlphaKind;
use crate::num::{clamp, floor, from_integer, recip, sqrt, to_integer};

/// All of a light, as a word.
pub const WHITE: u32 = (1 << 30) - 1;

/// What counts as 1 in sums.
const ONE: u32 = 1 << 16;
/// The largest number of a channel in a word.
const MOST: f32 = 1023.0;
/// What one in a sum stands for.
const UNIT: f32 = 1.0 / ONE as f32;
/// What one in a channel stands for.
const STEP: f32 = 1.0 / MOST;

/// The filter of shadow rays between surfaces and a light: everything that is not opaque everywhere dims it, and what is
/// opaque ends the ray. With `BLOCKER`, also how near the nearest of it is.
///
/// Alphas, and tints times alphas, are summed as whole numbers of 2⁻¹⁶, so that no order of traversal can
/// change the sums. Without `BLOCKER`, a ray also ends where its alphas reach 1: what is then missing from
/// the sums no longer matters. With it, a ray goes on to the nearest opaque surface, and to nothing behind
/// that: what lies there changes neither the light nor the nearest blocker.
#[derive(Clone, Copy)]
pub struct Transmittance<L: Lane, const BLOCKER: bool> {
    alpha: L::Bits,
    red: L::Bits,
    green: L::Bits,
    blue: L::Bits,
    /// Not 0 where no light arrives.
    dark: L::Bits,
    /// Where on the ray the nearest blocker is; `f32::MAX` without one.
    blocker: L,
}

impl<L: Lane, const BLOCKER: bool> Transmittance<L, BLOCKER> {
    /// Nothing crossed yet; `like` is any group of the same width.
    #[inline(always)]
    pub fn new(like: L) -> Self {
        let none = like.broadcast_bits(0);
        Self {
            alpha: none,
            red: none,
            green: none,
            blue: none,
            dark: none,
            blocker: like.broadcast(f32::MAX),
        }
    }

    /// The transmittance of the ray, as a word of three channels of 10 bits, red lowest; each channel is
    /// the square root of its share.
    ///
    /// ```text
    /// A     = Σ alpha
    /// tint  = Σ (tint · alpha) / A
    /// share = (1 − A) · (1 − A + A · tint)
    /// ```
    ///
    /// The paper's rule: the colors of transparent surfaces are averaged, the average is blended with the
    /// color of the light, and the light is scaled by what the alphas together do not cover.
    /// Departure: an average weighted by alpha, so that a surface that cannot be seen does not count.
    #[inline(always)]
    pub fn word(&self) -> L::Bits {
        let none = self.dark.broadcast(0);
        let sum: L = from_integer(self.alpha);
        let inverse = recip(sum.max(sum.broadcast(1.0)));
        let alpha = sum * UNIT;
        let uncovered = clamp(sum.broadcast(1.0) - alpha, 0.0, 1.0);
        let word = packed([
            share(self.red, inverse, alpha, uncovered),
            share(self.green, inverse, alpha, uncovered),
            share(self.blue, inverse, alpha, uncovered),
        ]);
        self.dark.eq(none).select(word, none)
    }

    /// Where on the ray its nearest blocker is; `f32::MAX` without one. What an alpha of 0 leaves
    /// invisible is none.
    #[inline(always)]
    pub fn blocker(&self) -> L {
        self.blocker
    }

    /// Adds a surface of this tint and alpha; all 0 in the lanes that do not hit it.
    #[inline(always)]
    pub fn add(&mut self, [red, green, blue, alpha]: [L; 4]) {
        self.alpha = self.alpha + fixed(alpha);
        self.red = self.red + fixed(red * alpha);
        self.green = self.green + fixed(green * alpha);
        self.blue = self.blue + fixed(blue * alpha);
    }
}

/// The word that stands for these shares of white light, linear RGB.
#[inline(always)]
pub(crate) fn packed<L: Lane>([red, green, blue]: [L; 3]) -> L::Bits {
    channel(red) | channel(green) << 10 | channel(blue) << 20
}

/// The transmittance of a channel: see [`Transmittance::word`].
#[inline(always)]
fn share<L: Lane>(tints: L::Bits, inverse: L, alpha: L, uncovered: L) -> L {
    uncovered * (uncovered + alpha * (from_integer::<L>(tints) * inverse))
}

/// A channel of a word.
#[inline(always)]
fn channel<L: Lane>(share: L) -> L::Bits {
    to_integer(floor(sqrt(clamp(share, 0.0, 1.0)) * MOST + 0.5))
}

/// A share of 1, as a whole number for sums.
#[inline(always)]
fn fixed<L: Lane>(share: L) -> L::Bits {
    to_integer(floor(share * ONE as f32 + 0.5))
}

/// The color that a word stands for, linear RGB.
#[inline(always)]
pub fn color<L: Lane>(word: L::Bits) -> V3<L> {
    let channel = |shift: u32| {
        let root = from_integer::<L>((word >> shift) & word.broadcast(1023)) * STEP;
        root * root
    };
    V3 { x: channel(0), y: channel(10), z: channel(20) }
}

impl<L: Lane, const BLOCKER: bool> HitFilter<L> for Transmittance<L, BLOCKER> {
    const TERMINATES: bool = !BLOCKER;
    const FACES: Faces = Faces::TowardEnd;

    #[inline(always)]
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool {
        // The lanes in which there is something, and those in which it ends the ray.
        let (mut visible, mut ended) = (intersection.mask, intersection.mask);
        let mode = alpha_mode(&geometry.instances[instance as usize], geometry.mesh_data);
        if mode != AlphaKind::Opaque as u32 {
            let surface = tint_and_alpha(geometry, instance, triangle, intersection);
            let alpha = surface[3];
            if mode == AlphaKind::Mask as u32 {
                visible = visible & passes_mask(geometry, instance, alpha);
                ended = visible;
            } else {
                self.add(surface);
                visible = visible & alpha.gt(alpha.broadcast(0.0));
                let covered = !self.alpha.lt(self.alpha.broadcast(ONE));
                ended = if BLOCKER { visible & !visible } else { ended & covered };
            }
        }
        self.dark = ended.select(self.dark.broadcast(1), self.dark);
        if BLOCKER {
            self.blocker = visible.select(intersection.t.min(self.blocker), self.blocker);
            closest.t = ended.select(intersection.t, closest.t);
        } else {
            closest.t = ended.select(closest.t.broadcast(-1.0), closest.t);
        }
        ended.any()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crossed(surfaces: &[([f32; 3], f32)]) -> [f32; 3] {
        let mut transmittance = Transmittance::<f32, false>::new(0.0);
        for &([red, green, blue], alpha) in surfaces {
            transmittance.add([red, green, blue, alpha]);
        }
        let V3 { x, y, z } = color::<f32>(transmittance.word());
        [x, y, z]
    }

    #[test]
    fn light_that_crosses_nothing_stays_as_it_is() {
        assert_eq!(Transmittance::<f32, false>::new(0.0).word().0, WHITE);
        assert_eq!(crossed(&[]), [1.0; 3]);
        assert_eq!(crossed(&[([0.3, 0.0, 1.0], 0.0)]), [1.0; 3]);
    }

    #[test]
    fn surfaces_commute_average_and_add_up() {
        let (red, blue) = (([1.0, 0.0, 0.0], 0.25), ([0.0, 0.0, 1.0], 0.5));
        assert_eq!(crossed(&[red, blue]), crossed(&[blue, red]));
        // A = 0.75, tint = (1/3, 0, 2/3).
        let expected = [0.25 * (0.25 + 0.25), 0.25 * 0.25, 0.25 * (0.25 + 0.5)];
        for (share, expected) in crossed(&[red, blue]).into_iter().zip(expected) {
            assert!((share - expected).abs() < 1.5e-3, "{share} {expected}");
        }
        assert_eq!(crossed(&[red, ([1.0; 3], 0.75)]), [0.0; 3]);
    }
}
