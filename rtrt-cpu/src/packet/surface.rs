//! Where rays meet surfaces, and the detail of their maps.

use super::PacketState;
use crate::context::FrameContext;
use crate::wide::Wide;
use rtrt_core::stage::{detail, surface};

impl<L: Wide, const G: usize> PacketState<'_, L, G> {
    #[inline(always)]
    pub(super) fn surface(&mut self) {
        let FrameContext { trace, attributes, .. } = self.context;
        let (camera, geometry) = (trace.camera(), &trace.geometry);
        let Self { directions, closest, surfaces, groups, .. } = self;
        L::outlined(
            self.token,
            #[inline(always)]
            || {
                for g in 0..*groups {
                    surfaces[g] = surface::surface(camera, geometry, attributes, directions[g], &closest[g]);
                }
            },
        );
    }

    #[inline(always)]
    pub(super) fn detail(&mut self) {
        let FrameContext { trace, attributes, maps } = self.context;
        let (frame, vertices) = (trace.frame, trace.vertices(attributes));
        let Self { closest, surfaces, groups, .. } = self;
        L::outlined(
            self.token,
            #[inline(always)]
            || {
                for g in 0..*groups {
                    surfaces[g] = detail::detail(frame, maps, &vertices, &closest[g], &surfaces[g]);
                }
            },
        );
    }
}
