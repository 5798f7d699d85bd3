//! Transmittance: the color of a light behind transparent surfaces.

use crate::kernel::transparency::{cutoff, mode, tint_and_alpha};
use crate::kernel::traverse::{ClosestHit, Geometry, HitFilter};
use crate::kernel::triangle::Intersection;
use crate::lane::{Bits, Lane, Mask, Select, V3};
use crate::layout::AlphaKind;
use crate::num::{clamp, floor, from_integer, recip, sqrt, to_integer};

/// Light that nothing has taken from, as a word.
pub const WHITE: u32 = (1 << 30) - 1;

/// What counts as 1 in sums.
const ONE: u32 = 1 << 16;
/// The largest number of a channel in a word.
const MOST: f32 = 1023.0;
/// What one in a sum stands for.
const UNIT: f32 = 1.0 / ONE as f32;
/// What one in a channel stands for.
const STEP: f32 = 1.0 / MOST;

/// A search for everything between a surface and a light: the panes' alphas, and their transmittance
/// times their alphas, summed as whole numbers of 2⁻¹⁶, so that no order of the panes and no
/// order of the search can change them. A ray is done at what is opaque, and when the alphas
/// reach 1: what is then missing from the sums no longer matters.
#[derive(Clone, Copy)]
pub struct Transmittance<L: Lane> {
    alpha: L::Bits,
    red: L::Bits,
    green: L::Bits,
    blue: L::Bits,
}

impl<L: Lane> Transmittance<L> {
    /// Nothing crossed yet; shaped like `like`.
    #[inline(always)]
    pub fn new(like: L) -> Self {
        let none = like.broadcast_bits(0);
        Self { alpha: none, red: none, green: none, blue: none }
    }

    /// What is left of white light, as a word of three channels of 10 bits, red lowest; each
    /// channel is the square root of its share.
    ///
    /// ```text
    /// A     = Σ alpha
    /// tint  = Σ (tint · alpha) / A
    /// share = (1 − A) · (1 − A + A · tint)
    /// ```
    ///
    /// The paper's rule: the colors of the panes are averaged, the average is blended with the
    /// color of the light, and the light is scaled by what the alphas together leave of it.
    /// Departure: an average weighted by alpha, so that a pane that cannot be seen has no say.
    #[inline(always)]
    pub fn word(&self) -> L::Bits {
        let sum: L = from_integer(self.alpha);
        let inverse = recip(sum.max(sum.broadcast(1.0)));
        let alpha = sum * UNIT;
        let left = clamp(sum.broadcast(1.0) - alpha, 0.0, 1.0);
        packed([
            share(self.red, inverse, alpha, left),
            share(self.green, inverse, alpha, left),
            share(self.blue, inverse, alpha, left),
        ])
    }

    /// Adds a pane of this tint and alpha; all 0 in the lanes that have met nothing.
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
pub fn packed<L: Lane>([red, green, blue]: [L; 3]) -> L::Bits {
    channel(red) | channel(green) << 10 | channel(blue) << 20
}

/// A channel of a word.
#[inline(always)]
fn channel<L: Lane>(share: L) -> L::Bits {
    to_integer(floor(sqrt(clamp(share, 0.0, 1.0)) * MOST + 0.5))
}

/// What is left of a channel of white light: see [`Transmittance::word`].
#[inline(always)]
fn share<L: Lane>(transmittance: L::Bits, inverse: L, alpha: L, left: L) -> L {
    left * (left + alpha * (from_integer::<L>(transmittance) * inverse))
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

impl<L: Lane> HitFilter<L> for Transmittance<L> {
    const TERMINATES: bool = true;
    const CULLS_BACK_FACES: bool = false;

    #[inline(always)]
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        id: u32,
        found: &Intersection<L>,
        best: &mut ClosestHit<L>,
    ) -> bool {
        if !found.mask.any() {
            return false;
        }
        let mode = mode(geometry, instance);
        let mut ended = found.mask;
        if mode != AlphaKind::Opaque as u32 {
            let pane = tint_and_alpha(geometry, instance, id, found);
            if mode == AlphaKind::Mask as u32 {
                ended = ended & pane[3].broadcast(cutoff(geometry, instance)).le(pane[3]);
            } else {
                self.add(pane);
                ended = ended & !self.alpha.lt(self.alpha.broadcast(ONE));
            }
        }
        best.t = ended.select(best.t.broadcast(-1.0), best.t);
        ended.any()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crossed(panes: &[([f32; 3], f32)]) -> [f32; 3] {
        let mut crossing = Transmittance::new(0.0_f32);
        for &([red, green, blue], alpha) in panes {
            crossing.add([red, green, blue, alpha]);
        }
        let V3 { x, y, z } = color::<f32>(crossing.word());
        [x, y, z]
    }

    #[test]
    fn light_that_crosses_nothing_stays_as_it_is() {
        assert_eq!(Transmittance::new(0.0_f32).word().0, WHITE);
        assert_eq!(crossed(&[]), [1.0; 3]);
        assert_eq!(crossed(&[([0.3, 0.0, 1.0], 0.0)]), [1.0; 3]);
    }

    #[test]
    fn panes_commute_average_and_add_up() {
        let (red, blue) = (([1.0, 0.0, 0.0], 0.25), ([0.0, 0.0, 1.0], 0.5));
        assert_eq!(crossed(&[red, blue]), crossed(&[blue, red]));
        // A = 0.75, tint = (1/3, 0, 2/3).
        let expected = [0.25 * (0.25 + 0.25), 0.25 * 0.25, 0.25 * (0.25 + 0.5)];
        for (found, expected) in crossed(&[red, blue]).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1.5e-3, "{found} {expected}");
        }
        assert_eq!(crossed(&[red, ([1.0; 3], 0.75)]), [0.0; 3]);
    }
}
