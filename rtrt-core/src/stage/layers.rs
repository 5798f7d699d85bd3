//! Layers: what is behind a surface that does not cover all of it.
//!
//! A layer goes through the same stages as the first surface. What follows the paper's list of
//! surfaces is a search for each entry: the closest surface behind the last one. Colors are
//! added up from front to back, so that a ray is done when nothing shines through any more.

use crate::grid::RayIndex;
use crate::kernel::lists::Lists;
use crate::kernel::pane::{cutoff, mode, pane};
use crate::kernel::ray::Ray;
use crate::kernel::traverse::{Best, Geometry, Search, keep};
use crate::kernel::triangle::Meeting;
use crate::lane::{Bits, Lane, Mask, Select, groups};
use crate::layout::{AlphaMode, Backdrop, Frame, NONE, View};
use crate::num::flush;
use crate::stage::visibility::{closest, rays, unfound};

/// How much farther than a surface another one of the same object is at least: 1 + 2⁻²⁰.
///
/// Rays through the edge between two triangles meet both; without this the edges of a pane
/// would be seen.
const APART: f32 = 1.0 + 1.0 / 1_048_576.0;

/// The least hit, by `(t, object, triangle)`, behind a surface, of what is not cut out by a
/// mask. Of the surface's own object, what is not [`APART`] from it is left out.
#[derive(Clone, Copy)]
struct Behind<L: Lane> {
    t: L,
    object: L::Bits,
}

impl<L: Lane> Search<L> for Behind<L> {
    const ENDS: bool = false;
    const FRONTS: bool = true;

    #[inline(always)]
    fn keep(
        &mut self,
        geometry: &Geometry<'_>,
        object: u32,
        id: u32,
        found: &Meeting<L>,
        best: &mut Best<L>,
    ) -> bool {
        let number = self.object.like(object);
        let own = self.object.equal(number);
        let apart = (self.t * APART).less_than(found.t);
        let later = self.t.less_than(found.t) | (self.t.less_equal(found.t) & self.object.less_than(number));
        let mut mask = found.mask & ((own & apart) | (!own & later));
        if mask.any() && mode(geometry, object) == AlphaMode::Mask as u32 {
            let [_, _, _, alpha] = pane(geometry, object, id, found);
            mask = mask & alpha.like(cutoff(geometry, object)).less_equal(alpha);
        }
        if !mask.any() {
            return false;
        }
        keep(found, mask, object, id, best);
        true
    }
}

/// Of the rays numbered from `first` on, all in one block, the closest hits behind the `last`
/// ones. A ray that had hit nothing looks for nothing; one whose last `t` is 0 has not looked
/// for anything yet.
#[inline(always)]
pub fn layer<L: Lane, const G: usize>(
    token: L::Token,
    frame: &Frame,
    views: &[View],
    lists: &Lists<'_>,
    geometry: &Geometry<'_>,
    first: RayIndex,
    last: &[Best<L>; G],
) -> [Best<L>; G] {
    let camera = &views[Frame::CAMERA as usize];
    let inside = unfound::<L, G>(token, frame, first);
    let mut best: [Best<L>; G] = groups(
        #[inline(always)]
        |g| {
            let ended = last[g].object.equal(last[g].object.like(NONE));
            Best { t: ended.select(inside[g].t.like(-1.0), inside[g].t), ..inside[g] }
        },
    );
    let mut searches: [Behind<L>; G] = groups(
        #[inline(always)]
        |g| Behind { t: last[g].t, object: last[g].object },
    );
    let rays: [Ray<L>; G] = rays::<L, G>(token, frame, camera, first);
    let block = camera.list(frame.grid().block(first));
    closest(lists, geometry, block, &rays, &mut searches, &mut best);
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
    let one = before[3].like(1.0);
    let done = is_covered(before[3]);
    let alpha = if frame.layers != 1 {
        shaded[3]
    } else if frame.backdrop == Backdrop::Nothing as u32 {
        one.like(0.0).less_than(shaded[3]).select(one, shaded[3])
    } else {
        one
    };
    let share = (one - before[3]) * alpha;
    let sum = |before: L, shaded: L| done.select(before, before + flush(shaded * share));
    let covered = one.less_equal(alpha).select(one, before[3] + share);
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
    covered.like(1.0).less_equal(covered)
}
