//! Occlusion: which lights reach a surface.

use crate::grid::RayIndex;
use crate::kernel::area::light_offset;
use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::cone::cone;
use crate::kernel::hit_filter::{Any, HitFilter};
use crate::kernel::packet::{PacketHits, tile_of_group};
use crate::kernel::penumbra::penumbra_radius;
use crate::kernel::ray::Ray;
use crate::kernel::transmittance::Transmittance;
use crate::kernel::view::light_block;
use crate::lane::{Bits, Lane, Mask, Row, Select, V3, groups};
use crate::layout::{Frame, View, ViewKind};
use crate::num::normalize;
use crate::stage::context::Context;
use crate::stage::origin_box::OriginBox;
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
/// light `word · 32 + i` reaches. The rays that hit the surfaces are numbered from `first` on; `around` is their
/// [`OriginBox`].
#[inline(always)]
pub fn word<L: Lane, const G: usize>(
    context: &Context<'_>,
    word: u32,
    first: RayIndex,
    surfaces: &[Surfaces<L>; G],
    around: &OriginBox,
) -> [L::Bits; G] {
    let mut mask: [L::Bits; G] = groups(
        #[inline(always)]
        |g| surfaces[g].material.broadcast(0),
    );
    let mut light = word * LIGHTS_PER_WORD;
    let mut bit = 0;
    while bit < LIGHTS_PER_WORD && light < context.frame.lights {
        if around.is_within_reach(context.light(light)) {
            let lit = occlusion::<L, G>(context, light, first, surfaces);
            let mut g = 0;
            while g < G {
                mask[g] = mask[g] | (lit[g] << bit);
                g += 1;
            }
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
    let limits: [L; G] = groups(
        #[inline(always)]
        |g| {
            let limit = arrival(light, origins[g]);
            active[g].gt(none).select(limit, limit.broadcast(-1.0))
        },
    );
    let mut lit = *active;
    let tiles = pending_tiles(&limits);
    if frame.shadows == 0 || tiles == 0 {
        return lit;
    }
    let idle = Ray::idle(origins[0].x.token());
    let rays: [Ray<L>; G] = groups(
        #[inline(always)]
        |g| {
            if tiles >> tile_of_group::<L, G>(g) & 1 == 0 {
                return idle;
            }
            Ray::new(origins[g], to_light(frame, light, group::<L>(first, g), origins[g]).0)
        },
    );
    let ends = trace_by_block(context, light, origins, &rays, &limits, filters);
    let mut g = 0;
    while g < G {
        let zero = limits[g].broadcast(0.0);
        let ended = limits[g].gt(zero) & ends[g].lt(zero);
        lit[g] = ended.select(none, lit[g]);
        g += 1;
    }
    lit
}

/// Traces rays from `origins` toward a view, up to `limits`, and returns where on them their filters have left their
/// limits. A ray whose limit is not above 0 is not traced.
#[inline(always)]
pub(super) fn trace_by_block<L: Lane, F: HitFilter<L>, const G: usize>(
    context: &Context<'_>,
    view: &View,
    origins: &[V3<L>; G],
    rays: &[Ray<L>; G],
    limits: &[L; G],
    filters: &mut [F; G],
) -> [L; G] {
    let blocks: [L::Bits; G] = groups(
        #[inline(always)]
        |g| {
            if G > 1 && !is_pending(limits[g]) {
                return limits[g].broadcast_bits(0);
            }
            light_block(view, origins[g])
        },
    );
    let (mut pending, mut ends) = (*limits, *limits);
    let mut local_rays = *rays;
    while let Some(block) = first_pending(&pending, &blocks) {
        let here: [L; G] = groups(
            #[inline(always)]
            |g| blocks[g].eq(blocks[g].broadcast(block)).select(pending[g], pending[g].broadcast(-1.0)),
        );
        let mut hits = PacketHits::new(groups(
            #[inline(always)]
            |g| ClosestHit::none(here[g]),
        ));
        trace(context, block, rays, &mut local_rays, &mut hits, filters);
        let mut g = 0;
        while g < G {
            let zero = pending[g].broadcast(0.0);
            let traced = here[g].gt(zero);
            ends[g] = traced.select(hits.closest[g].t, ends[g]);
            pending[g] = traced.select(zero.broadcast(-1.0), pending[g]);
            g += 1;
        }
    }
    ends
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

/// The tiles with a ray to be traced; of a packet of one group, its tile.
#[inline(always)]
fn pending_tiles<L: Lane, const G: usize>(limits: &[L; G]) -> u32 {
    let (mut tiles, mut g) = (0, 0);
    while g < G {
        tiles |= (is_pending(limits[g]) as u32) << tile_of_group::<L, G>(g);
        g += 1;
    }
    tiles
}

/// Whether any ray of a group is still to be traced.
#[inline(always)]
fn is_pending<L: Lane>(pending: L) -> bool {
    pending.gt(pending.broadcast(0.0)).any()
}

/// The block of the first ray that is still to be traced.
#[inline(always)]
fn first_pending<L: Lane, const G: usize>(pending: &[L; G], blocks: &[L::Bits; G]) -> Option<u32> {
    let mut g = 0;
    while g < G {
        if is_pending(pending[g]) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::plain::Plain;
    use crate::request::{Request, Shadows};
    use crate::scene::{Light, Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, square_at, surfaces};
    use std::vec::Vec;

    /// For each ray, in the order of its number, whether the light reaches what it hits.
    fn lit<L: Lane<Token = ()>, const G: usize>(prepared: &Prepared) -> Vec<bool> {
        let (context, rays) = (prepared.context(), (L::WIDTH * G) as u32);
        let packets = (0..prepared.frame().rays).step_by(rays as usize).map(RayIndex);
        let all = packets.flat_map(|first| {
            let lit = occlusion::<L, G>(&context, 0, first, &surfaces::<L, G>(prepared, first));
            (0..rays as usize).map(move |ray| lit[ray / L::WIDTH].lane(ray % L::WIDTH) == 1)
        });
        all.collect()
    }

    /// A floor at z = 0, and a square from −1 to 1 at z = 2.
    fn prepared(light: Light, shadows: Shadows) -> Prepared {
        let mut scene = Scene::new();
        add_square(&mut scene, Material::default(), square_at(6.0, [0.0; 3]));
        add_square(&mut scene, Material::default(), square_at(1.0, [0.0, 0.0, 2.0]));
        scene.add_light(light);
        Prepared::new(scene, move |request: Request<'_>| request.shadows(shadows))
    }

    /// The rays that reach the floor, or the square, without light.
    fn dark(prepared: &Prepared) -> Vec<[f32; 2]> {
        let lit = lit::<f32, 1>(prepared);
        let grid = prepared.frame().grid();
        let places = (0..prepared.frame().rays).map(|ray| grid.ray(RayIndex(ray)));
        let places = places.map(|[column, row]| [column as f32 - 7.5, 7.5 - row as f32]);
        let on_floor = places.zip(lit).filter(|([x, y], _)| x.abs() < 6.0 && y.abs() < 6.0);
        let mut dark: Vec<_> = on_floor.filter(|(_, lit)| !lit).map(|(place, _)| place).collect();
        dark.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap());
        dark
    }

    #[test]
    fn a_shadow_falls_where_something_stands_in_the_way_of_the_light() {
        // Two units down are two units to the right.
        let sun = Light::sun([1.0, 0.0, -1.0]);
        let shadow = [[1.5, -0.5], [1.5, 0.5], [2.5, -0.5], [2.5, 0.5]];
        assert_eq!(dark(&prepared(sun, Shadows::Hard)), shadow);
        assert_eq!(dark(&prepared(sun, Shadows::Off)), [[0.0; 2]; 0]);
        // Lights without shadows.
        let lamp = Light::spot([0.0, 0.0, 4.0], [0.0, 0.0, -1.0], 1.5);
        for light in [sun, lamp, Light::point([0.0, 0.0, 4.0]).radius(0.2)] {
            for shadows in [Shadows::Hard, Shadows::Area { jitter: Some(3) }] {
                assert!(!dark(&prepared(light, shadows)).is_empty());
                assert_eq!(dark(&prepared(light.casts_shadows(false), shadows)), [[0.0; 2]; 0]);
            }
        }
        // From twice the square's height, the shadow is twice as large, but for what the square hides.
        let lamp = Light::point([0.0, 0.0, 4.0]);
        let shadow = dark(&prepared(lamp, Shadows::Hard));
        assert_eq!(shadow.len(), 16 - 4, "{shadow:?}");
        assert!(shadow.iter().all(|[x, y]| x.abs() < 2.0 && y.abs() < 2.0));
    }

    #[test]
    fn surfaces_that_turn_away_or_are_out_of_reach_are_dark() {
        assert_eq!(dark(&prepared(Light::sun([0.0, 0.0, 1.0]), Shadows::Off)).len(), 144);
        // (0.5, 0.5) is 0.71 aside of the light, (1.5, 0.5) is 1.58; both 4 below it. The square is nearer.
        let lamp = Light::point([0.0, 0.0, 4.0]).reach(4.1);
        assert_eq!(dark(&prepared(lamp, Shadows::Off)).len(), 144 - 4);
    }

    #[test]
    fn packets_find_the_shadows_of_single_rays() {
        for light in [Light::sun([0.4, 0.3, -1.0]), Light::point([3.0, 1.0, 3.0])] {
            let prepared = prepared(light, Shadows::Hard);
            let single = lit::<f32, 1>(&prepared);
            assert!(single.contains(&true) && single.contains(&false));
            assert_eq!(lit::<Plain<8>, 32>(&prepared), single);
            assert_eq!(lit::<Plain<16>, 16>(&prepared), single);
        }
    }

    #[test]
    fn masks_have_a_bit_for_each_light() {
        let frame = Frame { mask_words: 2, lights: 34, ..bytemuck::Zeroable::zeroed() };
        assert_eq!(
            [place(&frame, 5, 0), place(&frame, 5, 31), place(&frame, 5, 33)],
            [(10, 0), (10, 31), (11, 1)]
        );
        let word =
            |word: u32| mask(&frame, word, crate::lane::Word(0), |light| crate::lane::Word(light % 3)).0;
        let expected = (0..32).filter(|light| light % 3 != 0).map(|light| 1 << light).sum::<u32>();
        // Of the second word, lights 32 and 33.
        assert_eq!([word(0), word(1)], [expected, 0b01]);
    }
}
