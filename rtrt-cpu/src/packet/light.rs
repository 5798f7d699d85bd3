//! Light that comes from lamps.

use super::PacketState;
use crate::context::FrameContext;
use crate::shadows::Shadows;
use crate::wide::Wide;
use rtrt_core::grid::RayIndex;
use rtrt_core::layout::Frame;
use rtrt_core::stage::light::{self, ShadowTerms};

impl<L: Wide, const G: usize> PacketState<'_, L, G> {
    #[inline(always)]
    pub(super) fn light(&mut self, frame: &Frame, shadows: &Shadows) {
        let FrameContext { trace, maps, .. } = self.context;
        let Self { token, ray, first, directions, surfaces, incoming, mask, more_masks, groups, .. } = self;
        let (token, first) = (*token, *first);
        L::outlined(
            token,
            #[inline(always)]
            || {
                for g in 0..*groups {
                    let terms = ShadowTerms::new(
                        #[inline(always)]
                        |word| if word == 0 { mask[g] } else { more_masks[word as usize - 1][g] },
                        #[inline(always)]
                        |light| L::load(token, &shadows.transmittance(light)[first + g * L::WIDTH..]),
                    );
                    let ray = RayIndex(ray.0 + (g * L::WIDTH) as u32);
                    incoming[g] =
                        light::light(frame, trace.views, maps, &terms, ray, directions[g], &surfaces[g]);
                }
            },
        );
    }
}
