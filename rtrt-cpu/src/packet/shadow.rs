//! What lies between surfaces and lights.

use super::PacketState;
use crate::cells::{self, RAYS};
use crate::wide::Wide;
use rtrt_core::grid::RayIndex;
use rtrt_core::lane::{V3, groups};
use rtrt_core::stage::context::Context;
use rtrt_core::stage::occlusion::{self, Arrival};
use rtrt_core::stage::origin_box::OriginBox;

impl<L: Wide, const G: usize> PacketState<'_, L, G> {
    #[inline(always)]
    pub(super) fn occlusion(&mut self, context: &Context<'_>) {
        self.more_masks.clear();
        let around = OriginBox::new(&self.surfaces);
        for word in 0..context.frame.mask_words {
            let mask = L::outlined(
                self.token,
                #[inline(always)]
                || occlusion::word::<L, G>(context, word, self.ray, &self.surfaces, &around),
            );
            if word == 0 {
                self.mask = mask;
            } else {
                self.more_masks.push(mask);
            }
        }
    }

    /// What arrives of a light at the packet.
    #[inline(always)]
    fn arrivals<const BLOCKER: bool>(&self, context: &Context<'_>, light: u32) -> [Arrival<L>; G] {
        let origins = groups(
            #[inline(always)]
            |g| self.surfaces[g].origin,
        );
        let active = groups(
            #[inline(always)]
            |g| {
                let first = RayIndex(self.ray.0 + (g * L::WIDTH) as u32);
                occlusion::potentially_lit(context.frame, context.views, light, first, &self.surfaces[g])
            },
        );
        L::outlined(
            self.token,
            #[inline(always)]
            || occlusion::transmittance::<L, BLOCKER, G>(context, light, self.ray, &origins, &active),
        )
    }

    #[inline(always)]
    pub(super) fn transmittance(&self, context: &Context<'_>, transmittance: &mut [u32]) {
        let around = OriginBox::new(&self.surfaces);
        // A loop, not an iterator: a callback is not compiled for the instruction set.
        for light in 0..context.frame.lights {
            let plane = light as usize * RAYS + self.first;
            if !around.is_within_reach(context.light(light)) {
                transmittance[plane..plane + G * L::WIDTH].fill(0);
                continue;
            }
            let arrivals = self.arrivals::<false>(context, light);
            for (g, arrival) in arrivals.into_iter().enumerate() {
                L::store(arrival.transmittance, &mut transmittance[plane + g * L::WIDTH..]);
            }
        }
    }

    #[inline(always)]
    pub(super) fn blocker_search(&self, context: &Context<'_>, cells: &mut [u32]) {
        for g in 0..G {
            let (origin, normal) = (self.surfaces[g].origin, self.surfaces[g].normal);
            for (first, V3 { x, y, z }) in [(cells::ORIGIN, origin), (cells::NORMAL, normal)] {
                for (plane, number) in (first..).zip([x, y, z]) {
                    L::store(number.to_bits(), &mut cells[plane * RAYS + self.first + g * L::WIDTH..]);
                }
            }
        }
        let around = OriginBox::new(&self.surfaces);
        for (light, (transmittance, radii)) in (0..).zip(cells::lights_mut(cells)) {
            if !around.is_within_reach(context.light(light)) {
                self.clear_light(transmittance, radii);
                continue;
            }
            let arrivals = self.arrivals::<true>(context, light);
            for (g, arrival) in arrivals.into_iter().enumerate() {
                let at = self.first + g * L::WIDTH;
                L::store(arrival.transmittance, &mut transmittance[at..]);
                L::store(arrival.penumbra_radius.to_bits(), &mut radii[at..]);
            }
        }
    }

    /// Leaves what a search finds for rays that ask for no light.
    #[inline(always)]
    pub(super) fn clear(&self, cells: &mut [u32]) {
        for (transmittance, radii) in cells::lights_mut(cells) {
            self.clear_light(transmittance, radii);
        }
    }

    /// Leaves that for one light.
    #[inline(always)]
    fn clear_light(&self, transmittance: &mut [u32], radii: &mut [u32]) {
        let range = self.first..self.first + G * L::WIDTH;
        transmittance[range.clone()].fill(0);
        radii[range].fill((-1.0_f32).to_bits());
    }
}
