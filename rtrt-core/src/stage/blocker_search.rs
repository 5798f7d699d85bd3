//! Blocker search: the transmittance of a light with a radius, and the radii of its penumbras.
//!
//! One shadow ray a ray and light goes to the light's middle. It finds the transmittance and the nearest
//! occluder, whose distance gives the radius of the penumbra. The
//! [`penumbra_filter`](super::penumbra_filter) makes soft shadows of both.

use crate::grid::RayIndex;
use crate::kernel::lists::BlockLists;
use crate::kernel::penumbra::Nearest;
use crate::kernel::traverse::Geometry;
use crate::lane::{Bits, Lane, Select, V3, groups};
use crate::layout::{Frame, View};
use crate::stage::occlusion::cross;

/// Where what is left of a light at a ray is, in the words of a band's shadows: one for each ray
/// and light.
#[inline(always)]
pub fn transmittance_at(frame: &Frame, ray: u32, light: u32) -> usize {
    (ray * frame.lights + light) as usize
}

/// Where the size of the penumbra is: behind those, one for each ray and light.
#[inline(always)]
pub fn penumbra_at(frame: &Frame, ray: u32, light: u32) -> usize {
    (frame.rays * frame.lights) as usize + transmittance_at(frame, ray, light)
}

/// What is left of a light at a group of surfaces, and the sizes of the penumbras there: those
/// of [`Nearest`] where the surfaces ask for the light (see [`potentially_lit`](super::occlusion::potentially_lit)), 0
/// and −1 elsewhere.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn blocker_search<L: Lane, const G: usize>(
    frame: &Frame,
    views: &[View],
    lists: &BlockLists<'_>,
    geometry: &Geometry<'_>,
    light: u32,
    first: RayIndex,
    origins: &[V3<L>; G],
    asked: &[L::Bits; G],
) -> [(L::Bits, L); G] {
    let mut filters: [Nearest<L>; G] = groups(
        #[inline(always)]
        |g| Nearest::new(origins[g].x),
    );
    cross(frame, views, lists, geometry, light, first, origins, asked, &mut filters);
    let light = &views[frame.light_view(light) as usize];
    groups(
        #[inline(always)]
        |g| answer(light, asked[g], &filters[g]),
    )
}

/// [`near`] of a group.
#[inline(always)]
fn answer<L: Lane>(light: &View, asked: L::Bits, search: &Nearest<L>) -> (L::Bits, L) {
    let none = asked.broadcast(0);
    let is_asked = asked.gt(none);
    let size = search.penumbra(light);
    (is_asked.select(search.word(), none), is_asked.select(size, size.broadcast(-1.0)))
}
