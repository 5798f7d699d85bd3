//! Occlusion: which lights reach a surface.

use crate::grid::RayIndex;
use crate::kernel::area::light_offset;
use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::cone::cone;
use crate::kernel::hit_filter::{Any, HitFilter};
use crate::kernel::packet::PacketHits;
use crate::kernel::penumbra::penumbra_radius;
use crate::kernel::ray::Ray;
use crate::kernel::transmittance::Transmittance;
use crate::kernel::view::light_block;
use crate::lane::{Bits, Lane, Mask, Row, Select, V3, groups};
use crate::layout::{Frame, View, ViewKind};
use crate::num::normalize;
use crate::stage::context::Context;
use crate::stage::surface::Surfaces;
use crate::stage::visibility::trace;

/// Lights in one word of the shadow mask.
pub const LIGHTS_PER_WORD: u32 = 32;

/// Where the bit of `light` is in the shadow masks of rays that follow one another: the
/// word, and the bit in it.
#[inline(always)]
pub fn place(frame: &Frame, ray: u32, light: u32) -> (u32, u32) {
    (ray * frame.mask_words + light / LIGHTS_PER_WORD, light % LIGHTS_PER_WORD)
}

/// One word of the shadow mask for each group of surfaces: bit `i` is 1 in the lanes that
/// light `word · 32 + i` reaches. The rays that hit the surfaces are numbered from `first` on.
#[inline(always)]
pub fn word<L: Lane, const G: usize>(
    context: &Context<'_>,
    word: u32,
    first: RayIndex,
    surfaces: &[Surfaces<L>; G],
) -> [L::Bits; G] {
    let mut mask: [L::Bits; G] = groups(
        #[inline(always)]
        |g| surfaces[g].material.broadcast(0),
    );
    let mut light = word * LIGHTS_PER_WORD;
    let mut bit = 0;
    while bit < LIGHTS_PER_WORD && light < context.frame.lights {
        let lit = occlusion::<L, G>(context, light, first, surfaces);
        let mut g = 0;
        while g < G {
            mask[g] = mask[g] | (lit[g] << bit);
            g += 1;
        }
        light += 1;
        bit += 1;
    }
    mask
}

/// For each group of surfaces, 1 in the lanes that the light reaches, else 0: the surface
/// faces the light, is within its reach and cone, and nothing stands between them. The rays that
/// hit the surfaces are numbered from `first` on.
#[inline(always)]
pub fn occlusion<L: Lane, const G: usize>(
    context: &Context<'_>,
    light: u32,
    first: RayIndex,
    surfaces: &[Surfaces<L>; G],
) -> [L::Bits; G] {
    let origins = groups(
        #[inline(always)]
        |g| surfaces[g].origin,
    );
    let active = groups(
        #[inline(always)]
        |g| potentially_lit(context.frame, context.views, light, group::<L>(first, g), &surfaces[g]),
    );
    shadow_rays(context, light, first, &origins, &active, &mut [Any; G])
}

/// What arrives of a light at a group of surfaces.
#[derive(Clone, Copy)]
pub struct Arrival<L: Lane> {
    /// The transmittance of the shadow rays, as words (see [`Transmittance::word`]); 0 where the surfaces
    /// cannot be lit.
    pub transmittance: L::Bits,
    /// The radii of the penumbras there (see [`penumbra_radius`]); −1 where there is none.
    pub penumbra_radius: L,
}

/// What arrives of a light at groups of surfaces, of which only the origins are needed. `active` is 1 where
/// the light may reach them (see [`potentially_lit`]), else 0. The rays that hit the surfaces are numbered
/// from `first` on. Penumbras have a radius only with `BLOCKER`, which also finds the blockers.
#[inline(always)]
pub fn transmittance<L: Lane, const BLOCKER: bool, const G: usize>(
    context: &Context<'_>,
    light: u32,
    first: RayIndex,
    origins: &[V3<L>; G],
    active: &[L::Bits; G],
) -> [Arrival<L>; G] {
    let mut filters: [Transmittance<L, BLOCKER>; G] = groups(
        #[inline(always)]
        |g| Transmittance::new(origins[g].x),
    );
    shadow_rays(context, light, first, origins, active, &mut filters);
    let light = context.light(light);
    groups(
        #[inline(always)]
        |g| {
            let none = active[g].broadcast(0);
            let is_active = active[g].gt(none);
            let minus_one = origins[g].x.broadcast(-1.0);
            let radius = if BLOCKER { penumbra_radius(light, filters[g].blocker()) } else { minus_one };
            Arrival {
                transmittance: is_active.select(filters[g].word(), none),
                penumbra_radius: is_active.select(radius, minus_one),
            }
        },
    )
}

/// Traces the shadow rays of a light, from `origins` to where the rays numbered from `first` on take the
/// light, in the lanes in which `active` is 1 (see [`potentially_lit`]), and returns 1 where no filter has
/// ended them, else 0.
///
/// The rays are sorted by the block of the light that they end in: each block's list, which holds every
/// instance that the light sees there, is traversed once for all of its rays.
#[inline(always)]
fn shadow_rays<L: Lane, F: HitFilter<L>, const G: usize>(
    context: &Context<'_>,
    light: u32,
    first: RayIndex,
    origins: &[V3<L>; G],
    active: &[L::Bits; G],
    filters: &mut [F; G],
) -> [L::Bits; G] {
    let (frame, light) = (context.frame, context.light(light));
    let none = active[0].broadcast(0);
    let mut pending: [L; G] = groups(
        #[inline(always)]
        |g| {
            let limit = arrival(light, origins[g]);
            active[g].gt(none).select(limit, limit.broadcast(-1.0))
        },
    );
    let mut lit = *active;
    if frame.shadows == 0 || !any_pending(&pending) {
        return lit;
    }
    let rays: [Ray<L>; G] = groups(
        #[inline(always)]
        |g| Ray::new(origins[g], to_light(frame, light, group::<L>(first, g), origins[g]).0),
    );
    let blocks: [L::Bits; G] = groups(
        #[inline(always)]
        |g| light_block(light, origins[g]),
    );
    while let Some(block) = first_pending(&pending, &blocks) {
        let limits: [L; G] = groups(
            #[inline(always)]
            |g| blocks[g].eq(none.broadcast(block)).select(pending[g], pending[g].broadcast(-1.0)),
        );
        let mut hits = PacketHits::new(groups(
            #[inline(always)]
            |g| ClosestHit::none(limits[g]),
        ));
        trace(context, block, &rays, &mut hits, filters);
        let mut g = 0;
        while g < G {
            let zero = pending[g].broadcast(0.0);
            let traced = limits[g].gt(zero);
            let ended = traced & hits.closest[g].t.lt(zero);
            lit[g] = ended.select(none, lit[g]);
            pending[g] = traced.select(zero.broadcast(-1.0), pending[g]);
            g += 1;
        }
    }
    lit
}

/// One word of the shadow mask of a group of surfaces, where `transmittance(light)` is that of each light:
/// bit `i` is 1 in the lanes that anything of light `word · 32 + i` reaches. `none` is 0.
#[inline(always)]
pub fn mask<B: Bits>(frame: &Frame, word: u32, none: B, transmittance: impl Fn(u32) -> B) -> B
where
    B::Mask: Select<B>,
{
    let mut mask = none;
    let mut light = word * LIGHTS_PER_WORD;
    let mut bit = 0;
    while bit < LIGHTS_PER_WORD && light < frame.lights {
        mask = mask | transmittance(light).gt(none).select(none.broadcast(1 << bit), none);
        light += 1;
        bit += 1;
    }
    mask
}

/// 1 in the lanes of a group of surfaces that the light would reach if nothing stood between them, else 0.
/// The rays that hit the surfaces are numbered from `first` on.
#[inline(always)]
pub fn potentially_lit<L: Lane>(
    frame: &Frame,
    views: &[View],
    light: u32,
    first: RayIndex,
    surfaces: &Surfaces<L>,
) -> L::Bits {
    let limit = limit(frame, &views[frame.light_view(light) as usize], first, surfaces);
    limit.gt(limit.broadcast(0.0)).select(surfaces.material.broadcast(1), surfaces.material.broadcast(0))
}

/// How far each surface's shadow ray goes; −1 where the light cannot reach anyway: nothing
/// was hit, the surface faces away, or is beyond the light's reach or outside of its cone. The
/// rays that hit the surfaces are numbered from `first` on.
#[inline(always)]
pub fn limit<L: Lane>(frame: &Frame, light: &View, first: RayIndex, surfaces: &Surfaces<L>) -> L {
    let (to_light, limit) = to_light(frame, light, first, surfaces.origin);
    let zero = limit.broadcast(0.0);
    let faces = surfaces.normal.dot(to_light).gt(zero);
    let reach = if light.kind == ViewKind::Sun as u32 { f32::MAX } else { light.reach_squared };
    let within = to_light.dot(to_light).lt(zero.broadcast(reach));
    let mut reached = surfaces.material.gt(surfaces.material.broadcast(0)) & faces & within;
    if light.cone_scale != 0.0 {
        // As the light stage computes it, so that no light arrives whose shadow ray was not traced.
        reached = reached & cone(light, normalize(to_light)).gt(zero);
    }
    reached.select(limit, zero.broadcast(-1.0))
}

/// The vector to the light, and the `t` at which a ray along it has arrived. To its middle, or,
/// of an area light, to the point that each ray takes (see `light_offset`); the rays are numbered from
/// `first` on.
#[inline(always)]
pub fn to_light<L: Lane>(frame: &Frame, light: &View, first: RayIndex, from: V3<L>) -> (V3<L>, L) {
    let middle = to_middle(light, from);
    let to_light =
        if light.disc == 0.0 { middle } else { middle + light_offset(frame, light, first, middle) };
    (to_light, arrival(light, from))
}

/// The vector to the light's middle.
#[inline(always)]
pub(crate) fn to_middle<L: Lane>(light: &View, from: V3<L>) -> V3<L> {
    let token = from.x.token();
    if light.kind == ViewKind::Sun as u32 {
        -V3::splat(token, light.along)
    } else {
        V3::splat(token, light.center) - from
    }
}

/// The `t` at which a ray along the vector to the light has arrived.
#[inline(always)]
fn arrival<L: Lane>(light: &View, from: V3<L>) -> L {
    from.x.broadcast(if light.kind == ViewKind::Sun as u32 { f32::MAX } else { 1.0 })
}

/// The first ray of a group of those numbered from `first` on.
#[inline(always)]
fn group<L: Lane>(first: RayIndex, group: usize) -> RayIndex {
    RayIndex(first.0 + (group * L::WIDTH) as u32)
}

/// Whether any ray is still to be traced.
#[inline(always)]
fn any_pending<L: Lane, const G: usize>(pending: &[L; G]) -> bool {
    let mut g = 0;
    while g < G {
        if pending[g].gt(pending[g].broadcast(0.0)).any() {
            return true;
        }
        g += 1;
    }
    false
}

/// The block of the first ray that is still to be traced.
#[inline(always)]
fn first_pending<L: Lane, const G: usize>(pending: &[L; G], blocks: &[L::Bits; G]) -> Option<u32> {
    let mut g = 0;
    while g < G {
        if pending[g].gt(pending[g].broadcast(0.0)).any() {
            let (limits, blocks) = (pending[g].row(), blocks[g].row());
            let mut lane = 0;
            while lane < L::WIDTH {
                if limits.at(lane) > 0.0 {
                    return Some(blocks.at(lane));
                }
                lane += 1;
            }
        }
        g += 1;
    }
    None
}
