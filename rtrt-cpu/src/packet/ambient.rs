//! Light from all around.

use super::PacketState;
use crate::wide::Wide;
use rtrt_core::lane::Row;
use rtrt_core::stage::ambient;
use rtrt_core::stage::context::Context;

impl<L: Wide, const G: usize> PacketState<'_, L, G> {
    #[inline(always)]
    pub(super) fn ambient(&self, context: &Context<'_>, records: &mut [ambient::Record]) {
        let (surfaces, first) = (&self.surfaces, self.first);
        L::outlined(
            self.token,
            #[inline(always)]
            || {
                let found = ambient::ambient::<L, G>(context, self.ray, surfaces);
                for g in 0..G {
                    let [open, total] = [found[g][0].row(), found[g][1].row()];
                    for lane in 0..L::WIDTH {
                        let found = [open.at(lane), total.at(lane)];
                        records[first + g * L::WIDTH + lane] =
                            ambient::record(found, &surfaces[g].lane(lane));
                    }
                }
            },
        );
    }
}
