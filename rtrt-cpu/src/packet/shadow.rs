//! What lies between surfaces and lights.

use super::{PacketState, Rays};
use crate::block::RAYS;
use crate::shadows::Shadows;
use crate::wide::Wide;
use core::ops::Range;
use rtrt_core::grid::RayIndex;
use rtrt_core::lane::groups;
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

    /// Its rays, among those of a block.
    #[inline(always)]
    pub(super) fn range(&self) -> Range<usize> {
        self.first..self.first + G * L::WIDTH
    }

    #[inline(always)]
    pub(super) fn transmittance(&self, context: &Context<'_>, shadows: &mut Shadows) {
        let around = OriginBox::new(&self.surfaces);
        // A loop, not an iterator: a callback is not compiled for the instruction set.
        for light in 0..context.frame.lights {
            if !around.is_within_reach(context.light(light)) {
                shadows.clear(light, self.range());
                continue;
            }
            let arrivals = self.arrivals::<false>(context, light);
            let transmittance = &mut shadows.planes_mut(light)[0];
            for (g, arrival) in arrivals.into_iter().enumerate() {
                L::store(arrival.transmittance, &mut transmittance[self.first + g * L::WIDTH..]);
            }
        }
    }

    #[inline(always)]
    pub(super) fn blocker_search(&self, context: &Context<'_>, rays: &mut Rays<'_>) {
        let Rays { shadows, places, .. } = rays;
        for g in 0..G {
            let (origin, normal) = (self.surfaces[g].origin, self.surfaces[g].normal);
            let numbers = [origin.x, origin.y, origin.z, normal.x, normal.y, normal.z];
            for (plane, number) in numbers.into_iter().enumerate() {
                L::store(number.to_bits(), &mut places[plane * RAYS + self.first + g * L::WIDTH..]);
            }
        }
        let around = OriginBox::new(&self.surfaces);
        for light in 0..context.frame.lights {
            if !around.is_within_reach(context.light(light)) {
                shadows.clear(light, self.range());
                continue;
            }
            let arrivals = self.arrivals::<true>(context, light);
            let planes = shadows.planes_mut(light);
            for (g, arrival) in arrivals.into_iter().enumerate() {
                let at = self.first + g * L::WIDTH;
                L::store(arrival.transmittance, &mut planes[0][at..]);
                L::store(arrival.penumbra_radius.to_bits(), &mut planes[1][at..]);
            }
        }
    }
}
