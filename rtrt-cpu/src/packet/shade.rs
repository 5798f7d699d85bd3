//! Colors.

use super::PacketState;
use crate::block::RAYS;
use crate::wide::Wide;
use rtrt_core::lane::{Lane, Row, groups};
use rtrt_core::layout::Frame;
use rtrt_core::schedule::{Pass, Step};
use rtrt_core::stage::ambient;
use rtrt_core::stage::peel::LayerSum;
use rtrt_core::stage::shade::shade;

impl<L: Wide, const G: usize> PacketState<'_, L, G> {
    #[inline(always)]
    pub(super) fn shade(
        &self,
        step: Step,
        frame: &Frame,
        colors: &mut [[f32; 4]],
        ambient: &[ambient::Record],
    ) {
        let Self { directions, surfaces, incoming, token, .. } = self;
        let maps = &self.context.maps;
        L::outlined(
            *token,
            #[inline(always)]
            || {
                for g in 0..self.groups {
                    let at = |number: u32| number as usize * RAYS + self.first + g * L::WIDTH;
                    let share = ambient::share::<L>(
                        *token,
                        frame,
                        (self.first + g * L::WIDTH) as u32,
                        #[inline(always)]
                        |ray| ambient[ray as usize],
                    );
                    let direction = directions[g];
                    let mut before = LayerSum::new(direction);
                    if step.pass == Pass::Blend {
                        let mut records = [before.color; Frame::RECORDS];
                        for number in 0..frame.records() {
                            let from = &colors[at(number)..];
                            [records[number as usize]] = L::gather_fours(
                                *token,
                                #[inline(always)]
                                |lane| [from[lane]],
                            );
                        }
                        before = LayerSum::load(frame, direction, records);
                    }
                    let (beyond, incoming) = (&before.beyond, &incoming[g]);
                    let shaded = shade(frame, maps, direction, beyond, &surfaces[g], incoming, share);
                    if !frame.has_layers() {
                        store(&shaded.record(), &mut colors[at(0)..]);
                        continue;
                    }
                    let sum = before.blend(frame, &shaded);
                    for number in 0..frame.records() {
                        store(&sum.record(number), &mut colors[at(number)..]);
                    }
                }
            },
        );
    }
}

/// Writes the records of a group, lane after lane.
#[inline(always)]
fn store<L: Lane>(numbers: &[L; 4], records: &mut [[f32; 4]]) {
    let [red, green, blue, alpha] = groups(
        #[inline(always)]
        |channel| numbers[channel].row(),
    );
    for (lane, record) in records[..L::WIDTH].iter_mut().enumerate() {
        *record = [red.at(lane), green.at(lane), blue.at(lane), alpha.at(lane)];
    }
}
