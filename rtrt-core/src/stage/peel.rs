//! Peel: the surfaces behind a transparent one, nearest first.
//!
//! A layer goes through the same stages as the first surface. In place of the paper's list of surfaces
//! there is a search for each layer: the closest hit behind the last one (depth peeling). Colors are
//! summed from front to back, so a ray ends when nothing shines through.

use crate::grid::RayIndex;
use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::geometry::Geometry;
use crate::kernel::hit_filter::{Faces, HitFilter};
use crate::kernel::packet::PacketHits;
use crate::kernel::ray::Ray;
use crate::kernel::transparency::{alpha_mode, passes_mask, tint_and_alpha};
use crate::kernel::triangle::Intersection;
use crate::lane::{Bits, Lane, Mask, Select, V3, groups};
use crate::layout::{AlphaKind, Frame, NONE};
use crate::num::flush;
use crate::stage::beyond::Beyond;
use crate::stage::context::Context;
use crate::stage::shade::Shaded;
use crate::stage::visibility::{rays, trace, unfound};

/// How much farther than a surface another one of the same instance is at least: 1 + 2⁻²⁰.
///
/// Rays through the edge between two triangles hit both; without this the edges in a transparent surface
/// would be visible.
const MIN_SEPARATION: f32 = 1.0 + 1.0 / 1_048_576.0;
/// For the mean of three channels.
const THIRD: f32 = 1.0 / 3.0;

/// Accepts the least hit by `(t, instance, triangle)` behind a surface, outside the holes of masks. Hits on
/// the surface's own instance must be [`MIN_SEPARATION`] behind it.
#[derive(Clone, Copy)]
struct BehindLast<L: Lane> {
    t: L,
    instance: L::Bits,
}

impl<L: Lane> HitFilter<L> for BehindLast<L> {
    const TERMINATES: bool = false;
    const FACES: Faces = Faces::TowardOrigin;

    /// Of copies, in the order of their numbers, the first has the least hits of all, and the one after the last
    /// surface's own has those that are as near as that surface.
    #[inline(always)]
    fn needs_copy(&self, before: u32, number: u32) -> bool {
        let (last, after) = (self.instance, self.instance.broadcast(number));
        (!last.lt(last.broadcast(before)) & last.lt(after)).any()
    }

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
/// that has hit nothing is not traced; one whose last `t` is 0 has not been traced yet, and starts behind the frame's
/// near plane. The `t` of a camera's ray is the depth of planes.
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
        |g| {
            let ClosestHit { t, instance, .. } = last[g];
            let is_new = t.le(t.broadcast(0.0));
            // No instance has this number, and none is behind it in the order of equals.
            let plane = instance.broadcast(NONE - 1);
            BehindLast {
                t: is_new.select(t.broadcast(frame.near), t),
                instance: is_new.select(plane, instance),
            }
        },
    );
    let mut hits = PacketHits::new(closest);
    let rays: [Ray<L>; G] = rays::<L, G>(token, frame, camera, first);
    let block = camera.list(frame.grid().block(first));
    trace(context, block, &rays, &mut { rays }, &mut hits, &mut filters);
    hits.closest
}

/// What a group of rays has seen of the layers so far.
#[derive(Clone, Copy)]
pub struct LayerSum<L> {
    /// Linear RGB, and how much is covered.
    pub color: [L; 4],
    /// The share of what is behind that reaches the camera, a channel. In frames without
    /// [colored layers](Frame::has_colored_layers) it is what `color` does not cover.
    pub through: V3<L>,
    /// Where that comes from.
    pub beyond: Beyond<L>,
}

impl<L: Lane> LayerSum<L> {
    /// Nothing seen yet by rays in this direction.
    #[inline(always)]
    pub fn new(direction: V3<L>) -> Self {
        let none = direction.x.broadcast(0.0);
        let one = none.broadcast(1.0);
        Self { color: [none; 4], through: V3 { x: one, y: one, z: one }, beyond: Beyond::new(direction) }
    }

    /// That of rays in this direction with these records, of which the frame's first [`Frame::records`] count.
    #[inline(always)]
    pub fn load(
        frame: &Frame,
        direction: V3<L>,
        [color, through, toward, entry]: [[L; 4]; Frame::RECORDS],
    ) -> Self {
        let uncovered = color[3].broadcast(1.0) - color[3];
        let [x, y, z, _] = if frame.has_colored_layers() { through } else { [uncovered; 4] };
        let beyond = Beyond::load(frame, direction, [toward, entry]);
        Self { color, through: V3 { x, y, z }, beyond }
    }

    /// The sum with a layer behind those before.
    ///
    /// ```text
    /// color + through · alpha · this color
    /// through · (1 − alpha · (1 − what this layer lets through))
    /// ```
    ///
    /// which is the usual blending from back to front, summed in the order of the layers. The last layer of a ray
    /// counts as opaque, unless rays that hit nothing have an alpha of 0: it then covers what it hits.
    #[inline(always)]
    pub fn blend(&self, frame: &Frame, shaded: &Shaded<L>) -> Self {
        let Self { color: before, through, beyond } = *self;
        let one = before[3].broadcast(1.0);
        let done = is_covered(before[3]);
        let is_last = frame.layers == 1;
        let alpha = if !is_last {
            shaded.alpha
        } else if !frame.shows_sky() {
            shaded.alpha.gt(one.broadcast(0.0)).select(one, shaded.alpha)
        } else {
            one
        };
        let sum = |before: L, through: L, shaded: L| {
            done.select(before, before + flush(shaded * (through * alpha)))
        };
        let mut next = Self {
            color: [
                sum(before[0], through.x, shaded.color.x),
                sum(before[1], through.y, shaded.color.y),
                sum(before[2], through.z, shaded.color.z),
                before[3],
            ],
            through,
            beyond,
        };
        if !frame.has_colored_layers() {
            let covered = alpha.ge(one).select(one, before[3] + through.x * alpha);
            next.color[3] = done.select(before[3], covered);
            return next;
        }
        let most = shaded.through.x.max(shaded.through.y).max(shaded.through.z);
        let is_clear = if is_last { one.broadcast(0.0) } else { most };
        let ends = alpha.ge(one) & is_clear.le(one.broadcast(0.0));
        let rest = |through: L, clear: L| {
            let left = flush(through * (one - alpha * (one - clear)));
            ends.select(one.broadcast(0.0), left)
        };
        let clear = shaded.through;
        let left =
            V3 { x: rest(through.x, clear.x), y: rest(through.y, clear.y), z: rest(through.z, clear.z) };
        next.through = V3::select(done, through, left);
        if frame.has_deflecting_layers() {
            next.beyond = Beyond::select(done, beyond, shaded.beyond);
        }
        let covered = one - (next.through.x + next.through.y + next.through.z) * THIRD;
        next.color[3] = done.select(before[3], ends.select(one, covered));
        next
    }

    /// The record with this number, below [`Frame::records`]: the color, what goes through, and where that comes from.
    #[inline(always)]
    pub fn record(&self, number: u32) -> [L; 4] {
        let [toward, entry] = self.beyond.records();
        match number {
            0 => self.color,
            1 => [self.through.x, self.through.y, self.through.z, self.through.x.broadcast(0.0)],
            2 => toward,
            _ => entry,
        }
    }
}

/// Whether the layers so far cover everything behind them.
#[inline(always)]
pub fn is_covered<L: Lane>(covered: L) -> L::Mask {
    covered.ge(covered.broadcast(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Hit, MaterialRecord};
    use crate::scene::{Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, add_square_mesh, closest, square_at};
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
    fn copies_in_one_place_are_peeled_one_by_one() {
        let mut scene = Scene::new();
        let pane = square_at(4.0, [0.0; 3]);
        let veil = scene.add_material(Material::default().blend(0.1)).unwrap();
        let meshes = [add_square_mesh(&mut scene), add_square_mesh(&mut scene)];
        for mesh in [0, 1, 0, 0, 0, 0, 1, 0, 1, 1] {
            scene.add_instance(meshes[mesh], veil, pane).unwrap();
        }
        let prepared = Prepared::new(scene, |request| request.layers(12));
        let ray = prepared.frame().grid().index([8, 8]);
        let mut last = [ClosestHit::new(&Hit::zeroed())];
        let layers: Vec<u32> = (0..11)
            .map(|_| {
                last = peel::<f32, 1>((), &prepared.context(), ray, &last);
                last[0].rows().hit(0).instance
            })
            .collect();
        assert_eq!(layers, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, NONE]);
    }

    #[test]
    fn planes_hide_what_is_before_and_beyond_them() {
        // The camera of the fixture looks along −z: squares at these depths.
        let scene = || {
            let mut scene = Scene::new();
            for z in [1.0, 0.0, -1.0, -2.0] {
                add_square(&mut scene, Material::default(), square_at(4.0, [0.0, 0.0, z]));
            }
            scene
        };
        let nearest = Prepared::new(scene(), |request| request);
        let ray = nearest.frame().grid().index([8, 8]);
        let depth = closest::<f32, 1>(&nearest, ray)[0].t;
        let seen = |near: f32, far: f32| {
            let prepared = Prepared::new(scene(), |request| request.clip(depth + near, depth + far));
            let none = [ClosestHit::new(&Hit::zeroed())];
            peel::<f32, 1>((), &prepared.context(), ray, &none)[0].rows().hit(0).instance
        };
        assert_eq!([seen(-0.5, 9.0), seen(0.5, 9.0), seen(1.5, 9.0), seen(2.5, 9.0)], [0, 1, 2, 3]);
        assert_eq!([seen(-0.5, -0.25), seen(0.25, 0.75), seen(3.5, f32::INFINITY)], [NONE; 3]);
        // What lies in the far plane is seen, and what lies in the near one is not.
        assert_eq!([seen(0.0, 1.0), seen(0.0, 0.5)], [1, NONE]);
    }

    #[test]
    fn layers_cover_what_those_before_left() {
        let frame = |layers| Frame { layers, ..Frame::zeroed() };
        let blend = |frame: &Frame, before: [f32; 4], [r, g, b, alpha]: [f32; 4]| {
            let none = V3::splat((), [0.0; 3]);
            let (color, beyond) = (V3 { x: r, y: g, z: b }, Beyond::new(none));
            let shaded = Shaded { color, alpha, through: none, beyond };
            LayerSum::load(frame, none, [before, [0.0; 4], [0.0; 4], [0.0; 4]]).blend(frame, &shaded).color
        };
        let first = blend(&frame(3), [0.0; 4], [1.0, 0.5, 0.0, 0.5]);
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

    #[test]
    fn glass_colors_what_is_behind_it() {
        let frame = |layers| Frame { layers, extensions: MaterialRecord::TRANSMITS, ..Frame::zeroed() };
        let at = |v| V3::<f32>::splat((), v);
        let beyond = Beyond::new(at([0.0, 0.0, -1.0]));
        let glass = Shaded { color: at([0.1; 3]), alpha: 1.0, through: at([0.75, 0.5, 0.0]), beyond };
        let wall = Shaded { color: at([0.5; 3]), alpha: 1.0, through: at([0.0; 3]), beyond };
        let first = LayerSum::new(beyond.direction).blend(&frame(3), &glass);
        assert_eq!((first.color[0], first.through.lane(0)), (0.1, [0.75, 0.5, 0.0]));
        assert!((first.color[3] - 7.0 / 12.0).abs() < 1e-6);
        let behind = first.blend(&frame(2), &wall);
        assert_eq!(behind.color, [0.1 + 0.5 * 0.75, 0.1 + 0.5 * 0.5, 0.1, 1.0]);
        assert_eq!(behind.through.lane(0), [0.0; 3]);
        // Two panes, then half a pane, then nothing.
        let second = first.blend(&frame(3), &glass);
        assert_eq!(second.through.lane(0), [0.5625, 0.25, 0.0]);
        let half = second.blend(&frame(3), &Shaded { alpha: 0.5, ..wall });
        assert_eq!(half.through.lane(0), [0.28125, 0.125, 0.0]);
        // The last layer counts as opaque.
        assert_eq!(first.blend(&frame(1), &glass).color[3], 1.0);
    }
}
