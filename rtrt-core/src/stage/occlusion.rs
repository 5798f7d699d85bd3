//! Occlusion: which lights reach a surface.

use crate::grid::RayIndex;
use crate::kernel::area::light_offset;
use crate::kernel::cone::cone;
use crate::kernel::lists::BlockLists;
use crate::kernel::ray::Ray;
use crate::kernel::transmittance::Transmittance;
use crate::kernel::traverse::{Any, ClosestHit, Geometry, HitFilter};
use crate::kernel::view::light_block;
use crate::lane::{Bits, Lane, Mask, Row, Select, V3, groups};
use crate::layout::{Frame, View, ViewKind};
use crate::num::normalize;
use crate::stage::surface::Surfaces;
use crate::stage::visibility::closest;

/// Lights in one word of the shadow mask.
pub const LIGHTS_PER_WORD: u32 = 32;

/// Where the bit of `light` is in the shadow masks of rays that follow one another: the
/// word, and the bit in it.
#[inline(always)]
pub fn place(frame: &Frame, ray: u32, light: u32) -> (u32, u32) {
    (ray * frame.mask_words + light / LIGHTS_PER_WORD, light % LIGHTS_PER_WORD)
}

/// One word of the shadow mask for each group of surfaces: bit `i` is 1 in the lanes that
/// light `word · 32 + i` reaches. The rays that found the surfaces are numbered from `first` on.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn word<L: Lane, const G: usize>(
    frame: &Frame,
    views: &[View],
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
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
    while bit < LIGHTS_PER_WORD && light < frame.lights {
        let lit = occlusion::<L, G>(frame, views, lists, geometry, light, first, surfaces);
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
/// found the surfaces are numbered from `first` on.
///
/// The shadow rays of a packet are sorted by the block of the light that they end in, and
/// each block's list, which holds every instance that the light sees there, is asked once
/// for all of its rays.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn occlusion<L: Lane, const G: usize>(
    frame: &Frame,
    views: &[View],
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
    light: u32,
    first: RayIndex,
    surfaces: &[Surfaces<L>; G],
) -> [L::Bits; G] {
    let light = &views[frame.light_view(light) as usize];
    let (one, none) = (surfaces[0].material.broadcast(1), surfaces[0].material.broadcast(0));
    let mut pending: [L; G] = groups(
        #[inline(always)]
        |g| limit(frame, light, group::<L>(first, g), &surfaces[g]),
    );
    let mut lit: [L::Bits; G] = groups(
        #[inline(always)]
        |g| {
            let zero = pending[g].broadcast(0.0);
            pending[g].gt(zero).select(one, none)
        },
    );
    if frame.shadows == 0 || !any_pending(&pending) {
        return lit;
    }
    let rays: [Ray<L>; G] = groups(
        #[inline(always)]
        |g| {
            let origin = surfaces[g].origin;
            Ray::new(origin, to_light(frame, light, group::<L>(first, g), origin).0)
        },
    );
    let blocks: [L::Bits; G] = groups(
        #[inline(always)]
        |g| light_block(light, surfaces[g].origin),
    );
    let mut filters = [Any; G];
    cast(lists, geometry, &rays, &blocks, &mut filters, &mut pending, &mut lit);
    lit
}

/// What is left of the light where it reaches a group of surfaces (`asked` is 1, see
/// [`potentially_lit`]), as a word (see [`crate::kernel::transmittance`]); 0 elsewhere. Of the surfaces only the
/// origins are needed.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn transmittance<L: Lane, const G: usize>(
    frame: &Frame,
    views: &[View],
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
    light: u32,
    first: RayIndex,
    origins: &[V3<L>; G],
    asked: &[L::Bits; G],
) -> [L::Bits; G] {
    let mut filters: [Transmittance<L>; G] = groups(
        #[inline(always)]
        |g| Transmittance::new(origins[g].x),
    );
    let lit = cross(frame, views, lists, geometry, light, first, origins, asked, &mut filters);
    let none = asked[0].broadcast(0);
    groups(
        #[inline(always)]
        |g| lit[g].gt(none).select(filters[g].word(), none),
    )
}

/// Casts the shadow rays from the origins that ask for the light (`asked` is 1), each for its
/// group's search: 1 in the lanes in which no ray was ended, else 0.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub(super) fn cross<L: Lane, S: HitFilter<L>, const G: usize>(
    frame: &Frame,
    views: &[View],
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
    light: u32,
    first: RayIndex,
    origins: &[V3<L>; G],
    asked: &[L::Bits; G],
    filters: &mut [S; G],
) -> [L::Bits; G] {
    let light = &views[frame.light_view(light) as usize];
    let none = asked[0].broadcast(0);
    let mut pending: [L; G] = groups(
        #[inline(always)]
        |g| {
            let limit = arrival(light, origins[g]);
            asked[g].gt(none).select(limit, limit.broadcast(-1.0))
        },
    );
    let mut lit: [L::Bits; G] = groups(
        #[inline(always)]
        |g| asked[g],
    );
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
    cast(lists, geometry, &rays, &blocks, filters, &mut pending, &mut lit);
    lit
}

/// One word of the shadow mask of a group of surfaces, where `transmittance(light)` is what is left of
/// each light: bit `i` is 1 in the lanes that anything of light `word · 32 + i` reaches.
/// `none` is 0.
#[inline(always)]
pub fn mask<B: Bits>(frame: &Frame, word: u32, none: B, transmittance: impl Fn(u32) -> B) -> B
where
    B::Mask: Select<B>,
{
    let mut mask = none;
    let mut light = word * LIGHTS_PER_WORD;
    let mut bit = 0;
    while bit < LIGHTS_PER_WORD && light < frame.lights {
        mask = mask | none.lt(transmittance(light)).select(none.broadcast(1 << bit), none);
        light += 1;
        bit += 1;
    }
    mask
}

/// 1 in the lanes of a group of surfaces that the light would reach if nothing stood between
/// them, else 0. The rays that found the surfaces are numbered from `first` on.
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

/// Casts the shadow rays that are pending, block after block of the light, and makes `lit` 0
/// where one of them is ended.
#[inline(always)]
fn cast<L: Lane, S: HitFilter<L>, const G: usize>(
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
    rays: &[Ray<L>; G],
    blocks: &[L::Bits; G],
    filters: &mut [S; G],
    pending: &mut [L; G],
    lit: &mut [L::Bits; G],
) {
    let none = lit[0].broadcast(0);
    loop {
        let Some(block) = first_pending(pending, blocks) else {
            return;
        };
        let mut best: [ClosestHit<L>; G] = groups(
            #[inline(always)]
            |g| {
                let here = blocks[g].eq(none.broadcast(block));
                let zero = pending[g].broadcast(0.0);
                ClosestHit {
                    t: here.select(pending[g], pending[g].broadcast(-1.0)),
                    instance: none,
                    triangle: none,
                    u: zero,
                    v: zero,
                }
            },
        );
        let asked: [L; G] = groups(
            #[inline(always)]
            |g| best[g].t,
        );
        closest(lists, geometry, block, rays, filters, &mut best);
        let mut g = 0;
        while g < G {
            let zero = pending[g].broadcast(0.0);
            let here = asked[g].gt(zero);
            let met = here & best[g].t.lt(zero);
            lit[g] = met.select(none, lit[g]);
            pending[g] = here.select(zero.broadcast(-1.0), pending[g]);
            g += 1;
        }
    }
}

/// How far each surface's shadow ray goes; −1 where the light cannot reach anyway: nothing
/// was hit, the surface faces away, or is beyond the light's reach or outside of its cone. The
/// rays that found the surfaces are numbered from `first` on.
#[inline(always)]
pub fn limit<L: Lane>(frame: &Frame, light: &View, first: RayIndex, surfaces: &Surfaces<L>) -> L {
    let (to_light, limit) = to_light(frame, light, first, surfaces.origin);
    let zero = limit.broadcast(0.0);
    let faces = zero.lt(surfaces.normal.dot(to_light));
    let reach = if light.kind == ViewKind::Sun as u32 { f32::MAX } else { light.reach_squared };
    let within = to_light.dot(to_light).lt(zero.broadcast(reach));
    let mut reached = surfaces.material.gt(surfaces.material.broadcast(0)) & faces & within;
    if light.cone_scale != 0.0 {
        // As the light stage computes it, so that no light arrives without having been asked for.
        reached = reached & zero.lt(cone(light, normalize(to_light)));
    }
    reached.select(limit, zero.broadcast(-1.0))
}

/// The vector to the light, and the `t` at which a ray along it has arrived. To its middle, or,
/// of an area light, to the point that each ray takes (see `light_offset`); the rays are numbered from
/// `first` on.
#[inline(always)]
pub fn to_light<L: Lane>(frame: &Frame, light: &View, first: RayIndex, from: V3<L>) -> (V3<L>, L) {
    let way = to_middle(light, from);
    let way = if light.disc == 0.0 { way } else { way + light_offset(frame, light, first, way) };
    (way, arrival(light, from))
}

/// The vector to the light's middle.
#[inline(always)]
pub fn to_middle<L: Lane>(light: &View, from: V3<L>) -> V3<L> {
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

/// Whether any ray waits for its answer.
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

/// The block of the first ray that still waits for its answer.
#[inline(always)]
fn first_pending<L: Lane, const G: usize>(pending: &[L; G], blocks: &[L::Bits; G]) -> Option<u32> {
    let mut g = 0;
    while g < G {
        if pending[g].gt(pending[g].broadcast(0.0)).any() {
            let (waits, blocks) = (pending[g].row(), blocks[g].row());
            let mut lane = 0;
            while lane < L::WIDTH {
                if waits.at(lane) > 0.0 {
                    return Some(blocks.at(lane));
                }
                lane += 1;
            }
        }
        g += 1;
    }
    None
}
