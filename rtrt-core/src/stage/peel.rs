//! Peel: the surfaces behind a transparent one, nearest first.
//!
//! A layer goes through the same stages as the first surface. In place of the paper's list of surfaces
//! there is a search for each layer: the closest hit behind the last one (depth peeling). Colors are
//! summed from front to back, so a ray ends when nothing shines through.

use crate::grid::RayIndex;
use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::geometry::Geometry;
use crate::kernel::hit_filter::HitFilter;
use crate::kernel::packet::PacketHits;
use crate::kernel::ray::Ray;
use crate::kernel::transparency::{alpha_mode, passes_mask, tint_and_alpha};
use crate::kernel::triangle::Intersection;
use crate::lane::{Bits, Lane, Mask, Select, groups};
use crate::layout::{AlphaKind, Frame, NONE};
use crate::num::flush;
use crate::stage::context::Context;
use crate::stage::visibility::{rays, trace, unfound};

/// How much farther than a surface another one of the same instance is at least: 1 + 2⁻²⁰.
///
/// Rays through the edge between two triangles hit both; without this the edges in a transparent surface
/// would be visible.
const MIN_SEPARATION: f32 = 1.0 + 1.0 / 1_048_576.0;

/// Accepts the least hit by `(t, instance, triangle)` behind a surface, outside the holes of masks. Hits on
/// the surface's own instance must be [`MIN_SEPARATION`] behind it.
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
        triangle: u32,
        intersection: &Intersection<L>,
        closest: &mut ClosestHit<L>,
    ) -> bool {
        let t = intersection.t;
        let number = self.instance.broadcast(instance);
        let own = self.instance.eq(number);
        let apart = t.gt(self.t * MIN_SEPARATION);
        let later = t.gt(self.t) | (t.ge(self.t) & number.gt(self.instance));
        let mut mask = intersection.mask & ((own & apart) | (!own & later));
        let placed = &geometry.instances[instance as usize];
        if mask.any() && alpha_mode(placed, geometry.mesh_data) == AlphaKind::Mask as u32 {
            let [_, _, _, alpha] = tint_and_alpha(geometry, instance, triangle, intersection);
            mask = mask & passes_mask(geometry, instance, alpha);
        }
        if !mask.any() {
            return false;
        }
        closest.keep_closest(intersection, mask, instance, triangle);
        true
    }
}

/// The closest hits behind the `last` ones of the rays numbered from `first` on, all in one block. A ray
/// that has hit nothing is not traced; one whose last `t` is 0 has not been traced yet.
#[inline(always)]
pub fn peel<L: Lane, const G: usize>(
    token: L::Token,
    context: &Context<'_>,
    first: RayIndex,
    last: &[ClosestHit<L>; G],
) -> [ClosestHit<L>; G] {
    let (frame, camera) = (context.frame, context.camera());
    let inside = unfound::<L, G>(token, frame, first);
    let closest: [ClosestHit<L>; G] = groups(
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
    let mut hits = PacketHits::new(closest);
    let rays: [Ray<L>; G] = rays::<L, G>(token, frame, camera, first);
    trace(context, camera.list(frame.grid().block(first)), &rays, &mut hits, &mut filters);
    hits.closest
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
/// layer of a ray counts as opaque, unless rays that hit nothing have an alpha of 0: it then covers what it hits.
#[inline(always)]
pub fn blend<L: Lane>(frame: &Frame, before: [L; 4], shaded: [L; 4]) -> [L; 4] {
    let one = before[3].broadcast(1.0);
    let done = is_covered(before[3]);
    let alpha = if frame.layers != 1 {
        shaded[3]
    } else if !frame.shows_sky() {
        shaded[3].gt(one.broadcast(0.0)).select(one, shaded[3])
    } else {
        one
    };
    let share = (one - before[3]) * alpha;
    let sum = |before: L, shaded: L| done.select(before, before + flush(shaded * share));
    let covered = alpha.ge(one).select(one, before[3] + share);
    [
        sum(before[0], shaded[0]),
        sum(before[1], shaded[1]),
        sum(before[2], shaded[2]),
        done.select(before[3], covered),
    ]
}

/// Whether the layers so far cover everything behind them.
#[inline(always)]
pub fn is_covered<L: Lane>(covered: L) -> L::Mask {
    covered.ge(covered.broadcast(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Hit;
    use crate::scene::{Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, square_at};
    use bytemuck::Zeroable;
    use std::vec::Vec;

    #[test]
    fn each_peel_finds_the_next_surface() {
        let mut scene = Scene::new();
        add_square(&mut scene, Material::default(), square_at(4.0, [0.0; 3]));
        add_square(&mut scene, Material::default().blend(0.5), square_at(4.0, [0.0, 0.0, 2.0]));
        add_square(&mut scene, Material::default().blend(0.5), square_at(4.0, [0.0, 0.0, 1.0]));
        let prepared = Prepared::new(scene, |request| request.layers(4));
        let ray = prepared.frame().grid().index([8, 8]);
        let mut last = [ClosestHit::new(&Hit::zeroed())];
        let layers: Vec<u32> = (0..4)
            .map(|_| {
                last = peel::<f32, 1>((), &prepared.context(), ray, &last);
                last[0].rows().hit(0).instance
            })
            .collect();
        assert_eq!(layers, [1, 2, 0, NONE]);
        // Nothing follows a miss.
        assert_eq!(peel::<f32, 1>((), &prepared.context(), ray, &last)[0].t, -1.0);
    }

    #[test]
    fn layers_cover_what_those_before_left() {
        let frame = |layers| Frame { layers, ..Frame::zeroed() };
        let first = blend(&frame(3), [0.0_f32; 4], [1.0, 0.5, 0.0, 0.5]);
        assert_eq!(first, [0.5, 0.25, 0.0, 0.5]);
        // Half of a half.
        assert_eq!(blend(&frame(2), first, [0.0, 1.0, 4.0, 0.5]), [0.5, 0.5, 1.0, 0.75]);
        // What is opaque, and the last layer, cover the rest.
        let rest = [0.5, 0.75, 2.0, 1.0];
        assert_eq!(blend(&frame(2), first, [0.0, 1.0, 4.0, 1.0]), rest);
        assert_eq!(blend(&frame(1), first, [0.0, 1.0, 4.0, 0.5]), rest);
        assert_eq!(blend(&frame(2), rest, [9.0; 4]), rest);
        // What hits nothing covers nothing, unless an environment shows there.
        assert_eq!(blend(&frame(1), first, [0.0; 4]), first);
        let sky = Frame { sky_first: 1, ..frame(1) };
        assert_eq!(blend(&sky, first, [0.0, 1.0, 4.0, 0.0]), rest);
        assert!(is_covered(1.0_f32) && !is_covered(0.999_f32));
    }
}
