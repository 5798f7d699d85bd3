//! What camera rays meet.

use super::PacketState;
use crate::wide::Wide;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::peel;
use rtrt_core::stage::visibility::visibility;

impl<L: Wide, const G: usize> PacketState<'_, L, G> {
    #[inline(always)]
    pub(super) fn visibility(&mut self, context: &Context<'_>) {
        let ray = self.ray;
        self.closest = L::outlined(
            self.token,
            #[inline(always)]
            || visibility::<L, G>(self.token, context, ray),
        );
    }

    #[inline(always)]
    pub(super) fn peel(&mut self, context: &Context<'_>) {
        let last = &self.closest;
        self.closest = L::outlined(
            self.token,
            #[inline(always)]
            || peel::peel::<L, G>(self.token, context, self.ray, last),
        );
    }
}
