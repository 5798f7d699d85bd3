//! The radius of the penumbra that an occluder casts.

use crate::kernel::transmittance::Transmittance;
use crate::kernel::transparency::{cutoff, mode, tint_and_alpha};
use crate::kernel::traverse::{ClosestHit, Geometry, HitFilter};
use crate::kernel::triangle::Intersection;
use crate::lane::{Bits, Lane, Mask, Select};
use crate::layout::{AlphaKind, View, ViewKind};
use crate::num::{clamp, flush, recip};

/// The least share of a shadow ray that is left behind an occluder, as far as penumbras are
/// concerned: what touches the light would cast one without end.
const LEAST: f32 = 1.0 / 1024.0;
/// The largest size of a penumbra: its square is a number, too.
const MOST: f32 = f32::from_bits((127 + 40) << 23);

/// A search for everything between a surface and a light, as [`Transmittance`], and for the nearest
/// of it. A ray looks no farther than what is opaque: what is behind that changes neither.
#[derive(Clone, Copy)]
pub struct Nearest<L: Lane> {
    crossing: Transmittance<L>,
    t: L,
    dark: L::Bits,
}

impl<L: Lane> Nearest<L> {
    /// Nothing met yet; shaped like `like`.
    #[inline(always)]
    pub fn new(like: L) -> Self {
        Self { crossing: Transmittance::new(like), t: like.broadcast(f32::MAX), dark: like.broadcast_bits(0) }
    }

    /// What is left of the light, as a word (see [`crate::kernel::transmittance`]).
    #[inline(always)]
    pub fn word(&self) -> L::Bits {
        let none = self.dark.broadcast(0);
        self.dark.eq(none).select(self.crossing.word(), none)
    }

    /// Radius of the penumbra that the nearest occluder casts on the surface, world units, across
    /// the light's way; −1 where there is none.
    ///
    /// ```text
    /// light radius · occluder distance / light distance
    /// ```
    ///
    /// The paper's formula (Analytical soft shadows). The occluder's distance is that from the
    /// surface, the light's that from the occluder: then the formula is the theorem of
    /// intersecting lines, and exact for an edge across the light's way. Both are shares of the
    /// shadow ray, whose length cancels. For a sun, radius over distance is the tangent of its
    /// radius.
    #[inline(always)]
    pub fn penumbra(&self, light: &View) -> L {
        let size = if light.kind == ViewKind::Sun as u32 {
            self.t * light.radius
        } else {
            let left = self.t.broadcast(1.0) - self.t;
            self.t * light.radius * recip(left.max(left.broadcast(LEAST)))
        };
        let is_lit = self.t.broadcast(f32::MAX).le(self.t);
        is_lit.select(self.t.broadcast(-1.0), flush(clamp(size, 0.0, MOST)))
    }
}

impl<L: Lane> HitFilter<L> for Nearest<L> {
    const TERMINATES: bool = false;
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
        let (mut met, mut ended) = (found.mask, found.mask);
        if mode != AlphaKind::Opaque as u32 {
            let [red, green, blue, alpha] = tint_and_alpha(geometry, instance, id, found);
            if mode == AlphaKind::Mask as u32 {
                met = met & alpha.broadcast(cutoff(geometry, instance)).le(alpha);
                ended = met;
            } else {
                self.crossing.add([red, green, blue, alpha]);
                met = met & alpha.gt(alpha.broadcast(0.0));
                ended = met & !met;
            }
        }
        self.t = met.select(found.t.min(self.t), self.t);
        self.dark = ended.select(self.dark.broadcast(1), self.dark);
        best.t = ended.select(found.t, best.t);
        ended.any()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn is_the_theorem_of_intersecting_lines() {
        let at = |kind: ViewKind, t: f32| {
            let light = View { kind: kind as u32, radius: 0.5, ..View::zeroed() };
            Nearest { t, ..Nearest::new(0.0_f32) }.penumbra(&light)
        };
        // A quarter of the way: three times as far from the light as from the surface.
        assert!((at(ViewKind::Point, 0.25) - 0.5 / 3.0).abs() < 1e-7);
        assert!((at(ViewKind::Point, 0.5) - 0.5).abs() < 1e-7);
        assert_eq!((at(ViewKind::Point, 0.0), at(ViewKind::Point, 1.0).round()), (0.0, 512.0));
        assert_eq!((at(ViewKind::Sun, 3.0), at(ViewKind::Sun, f32::MAX)), (1.5, -1.0));
    }
}
