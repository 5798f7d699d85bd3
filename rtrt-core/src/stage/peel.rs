//! Peel: the surfaces behind a transparent one, nearest first.
//!
//! A layer goes through the same stages as the first surface. In place of the paper's list of surfaces
//! there is a search for each layer: the closest hit behind the last one (depth peeling). Colors are
//! summed from front to back, so a ray ends when nothing shines through.

use crate::grid::RayIndex;
use crate::kernel::lists::BlockLists;
use crate::kernel::ray::Ray;
use crate::kernel::transparency::{cutoff, mode, tint_and_alpha};
use crate::kernel::traverse::{ClosestHit, Geometry, HitFilter, keep_closest};
use crate::kernel::triangle::Intersection;
use crate::lane::{Bits, Lane, Mask, Select, groups};
use crate::layout::{AlphaKind, Backdrop, Frame, NONE, View};
use crate::num::flush;
use crate::stage::visibility::{closest, rays, unfound};

/// How much farther than a surface another one of the same instance is at least: 1 + 2⁻²⁰.
///
/// Rays through the edge between two triangles meet both; without this the edges of a pane
/// would be seen.
const MIN_SEPARATION: f32 = 1.0 + 1.0 / 1_048_576.0;

/// The least hit, by `(t, instance, triangle)`, behind a surface, of what is not cut out by a
/// mask. Of the surface's own instance, what is not [`MIN_SEPARATION`] from it is left out.
#[derive(Clone, Copy)]
struct BehindLast<L: Lane> {
    t: L,
    instance: L::Bits,
}

impl<L: Lane> HitFilter<L> for BehindLast<L> {
    const TERMINATES: bool = false;
    const CULLS_BACK_FACES: bool = true;

    #[inline(always)]
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        id: u32,
        found: &Intersection<L>,
        best: &mut ClosestHit<L>,
    ) -> bool {
        let number = self.instance.broadcast(instance);
        let own = self.instance.eq(number);
        let apart = (self.t * MIN_SEPARATION).lt(found.t);
        let later = self.t.lt(found.t) | (self.t.le(found.t) & self.instance.lt(number));
        let mut mask = found.mask & ((own & apart) | (!own & later));
        if mask.any() && mode(geometry, instance) == AlphaKind::Mask as u32 {
            let [_, _, _, alpha] = tint_and_alpha(geometry, instance, id, found);
            mask = mask & alpha.broadcast(cutoff(geometry, instance)).le(alpha);
        }
        if !mask.any() {
            return false;
        }
        keep_closest(found, mask, instance, id, best);
        true
    }
}

/// Of the rays numbered from `first` on, all in one block, the closest hits behind the `last`
/// ones. A ray that had hit nothing looks for nothing; one whose last `t` is 0 has not looked
/// for anything yet.
#[inline(always)]
pub fn peel<L: Lane, const G: usize>(
    token: L::Token,
    frame: &Frame,
    views: &[View],
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
    first: RayIndex,
    last: &[ClosestHit<L>; G],
) -> [ClosestHit<L>; G] {
    let camera = &views[Frame::CAMERA as usize];
    let inside = unfound::<L, G>(token, frame, first);
    let mut best: [ClosestHit<L>; G] = groups(
        #[inline(always)]
        |g| {
            let ended = last[g].instance.eq(last[g].instance.broadcast(NONE));
            ClosestHit { t: ended.select(inside[g].t.broadcast(-1.0), inside[g].t), ..inside[g] }
        },
    );
    let mut filters: [BehindLast<L>; G] = groups(
        #[inline(always)]
        |g| BehindLast { t: last[g].t, instance: last[g].instance },
    );
    let rays: [Ray<L>; G] = rays::<L, G>(token, frame, camera, first);
    let block = camera.list(frame.grid().block(first));
    closest(lists, geometry, block, &rays, &mut filters, &mut best);
    best
}

/// The color of a group of rays, where `before` is that of the layers before this one, and
/// `shaded` that of this one. Alpha is how much is covered.
///
/// ```text
/// share = (1 − covered) · alpha
/// color + share · this color,  covered + share
/// ```
///
/// which is the usual blending from back to front, summed in the order of the layers. The last
/// layer that a ray may look at counts as opaque, but for [`Backdrop::Nothing`].
#[inline(always)]
pub fn blend<L: Lane>(frame: &Frame, before: [L; 4], shaded: [L; 4]) -> [L; 4] {
    let one = before[3].broadcast(1.0);
    let done = is_covered(before[3]);
    let alpha = if frame.layers != 1 {
        shaded[3]
    } else if frame.backdrop == Backdrop::Nothing as u32 {
        shaded[3].gt(one.broadcast(0.0)).select(one, shaded[3])
    } else {
        one
    };
    let share = (one - before[3]) * alpha;
    let sum = |before: L, shaded: L| done.select(before, before + flush(shaded * share));
    let covered = one.le(alpha).select(one, before[3] + share);
    [
        sum(before[0], shaded[0]),
        sum(before[1], shaded[1]),
        sum(before[2], shaded[2]),
        done.select(before[3], covered),
    ]
}

/// Whether nothing behind the layers so far can be seen.
#[inline(always)]
pub fn is_covered<L: Lane>(covered: L) -> L::Mask {
    covered.ge(covered.broadcast(1.0))
}
