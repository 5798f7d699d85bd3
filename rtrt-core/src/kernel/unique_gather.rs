//! Gathers that read each distinct record of a group once.

use crate::lane::{Lane, Mask, Select};

/// The largest number of distinct records that are read once and broadcast; more are gathered lane by
/// lane.
const MOST: usize = 4;

/// The lanes of a group that read the same record: neighbors mostly hit the same triangle.
#[derive(Clone, Copy)]
pub struct UniqueGather<L: Lane> {
    token: L::Token,
    /// A lane that reads each of the records.
    lanes: [usize; MOST],
    /// All lanes that read it.
    masks: [L::Mask; MOST],
    /// The number of distinct records; `MOST + 1` for more than `MOST`.
    count: usize,
}

impl<L: Lane> UniqueGather<L> {
    /// The records of the lanes in `wanted`; `same(lane)` is the mask of the lanes that read the record of
    /// `lane`.
    #[inline(always)]
    pub fn of(token: L::Token, wanted: L::Mask, same: impl Fn(usize) -> L::Mask) -> Self {
        let mut found = Self { token, lanes: [0; MOST], masks: [wanted; MOST], count: 0 };
        if L::WIDTH == 1 {
            return found;
        }
        let mut left = wanted;
        while found.count < MOST && left.any() {
            let lane = left.bits().trailing_zeros() as usize;
            let mask = left & same(lane);
            found.lanes[found.count] = lane;
            found.masks[found.count] = mask;
            found.count += 1;
            left = left & !mask;
        }
        if left.any() {
            found.count = MOST + 1;
        }
        found
    }

    /// The numbers of each lane's record, by fours: `record(lane)`. Lanes outside `wanted` get the value of
    /// `record` or 0.
    #[inline(always)]
    pub fn gather<const N: usize>(&self, record: impl Fn(usize) -> [[f32; 4]; N]) -> [[L; 4]; N] {
        if L::WIDTH == 1 || self.count > MOST {
            return L::gather_fours(self.token, record);
        }
        let mut all = [[L::splat(self.token, 0.0); 4]; N];
        let mut i = 0;
        while i < self.count {
            let numbers = record(self.lanes[i]);
            let mut n = 0;
            while n < N {
                let (numbers, four) = (numbers[n], all[n]);
                let mut k = 0;
                while k < 4 {
                    all[n][k] = self.masks[i].select(L::splat(self.token, numbers[k]), four[k]);
                    k += 1;
                }
                n += 1;
            }
            i += 1;
        }
        all
    }

    /// [`UniqueGather::gather`] of words.
    #[inline(always)]
    pub fn bits(&self, record: impl Fn(usize) -> [u32; 4]) -> [L::Bits; 4] {
        if L::WIDTH == 1 || self.count > MOST {
            return L::gather_bits(self.token, record);
        }
        let zero = L::splat(self.token, 0.0);
        let mut all = [zero.broadcast_bits(0); 4];
        let mut i = 0;
        while i < self.count {
            let words = record(self.lanes[i]);
            let mut n = 0;
            while n < 4 {
                all[n] = self.masks[i].select(zero.broadcast_bits(words[n]), all[n]);
                n += 1;
            }
            i += 1;
        }
        all
    }
}
