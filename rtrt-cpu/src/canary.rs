//! The kernels on edge values, with several lanes.

use crate::instruction_set::{InstructionSet, LaneTask};
use crate::wide::Wide;
use rtrt_core::kernel::canary::{Fixture, OUTPUTS, canary};
use rtrt_core::lane::Bits;

/// The answers of every instruction set that is here and has several lanes, by its name, to
/// [`rtrt_core::kernel::canary::canary`] for every index of `words`.
pub fn kernels(words: &[u32]) -> Vec<(&'static str, Vec<[u32; OUTPUTS]>)> {
    InstructionSet::wide().into_iter().map(|level| (level.name(), level.run(Kernels { words }))).collect()
}

struct Kernels<'a> {
    words: &'a [u32],
}

impl LaneTask for Kernels<'_> {
    type Output = Vec<[u32; OUTPUTS]>;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Self::Output {
        let fixture = Fixture::default();
        let mut answers = vec![[0; OUTPUTS]; self.words.len()];
        for (packet, answers) in answers.chunks_mut(L::WIDTH).enumerate() {
            let found = canary::<L>(token, self.words, &fixture.given(), (packet * L::WIDTH) as u32);
            for (output, bits) in found.into_iter().enumerate() {
                for (lane, answer) in answers.iter_mut().enumerate() {
                    answer[output] = bits.lane(lane);
                }
            }
        }
        answers
    }
}
