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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::plain::{Plain, PlainMask};
    use core::cell::Cell;

    /// Record `r` is [[r, 10 r, 100 r, -r]].
    fn record(r: f32) -> [[f32; 4]; 1] {
        [[r, 10.0 * r, 100.0 * r, -r]]
    }

    /// The records of the lanes that are wanted, and how many were read, of floats and of words.
    fn gathered(records: [u8; 8], wanted: [bool; 8]) -> ([[f32; 8]; 2], [u32; 2]) {
        let (wanted, read) = (PlainMask(wanted), Cell::new([0; 2]));
        let gather =
            UniqueGather::<Plain<8>>::of((), wanted, |lane| PlainMask(records.map(|r| r == records[lane])));
        let [[first, _, _, last]] = gather.gather(|lane| {
            read.set([read.get()[0] + 1, read.get()[1]]);
            record(f32::from(records[lane]))
        });
        let [_, word, _, _] = gather.bits(|lane| {
            read.set([read.get()[0], read.get()[1] + 1]);
            [0, u32::from(records[lane]), 0, 0]
        });
        assert_eq!(first.0, last.0.map(|x| -x));
        ([first.0, word.0.map(|word| word as f32)], read.get())
    }

    #[test]
    fn each_lane_gets_its_record_and_each_record_is_read_once() {
        let ([numbers, words], read) = gathered([3, 3, 7, 3, 7, 7, 3, 1], [true; 8]);
        assert_eq!((numbers, words), ([3.0, 3.0, 7.0, 3.0, 7.0, 7.0, 3.0, 1.0], numbers));
        assert_eq!(read, [3, 3]);
    }

    #[test]
    fn lanes_that_want_nothing_have_no_record_read_for_them() {
        let wanted = [false, true, false, false, true, false, false, false];
        let ([numbers, words], read) = gathered([9, 2, 9, 9, 2, 9, 9, 9], wanted);
        assert_eq!((numbers[1], numbers[4], words[1], words[4], read), (2.0, 2.0, 2.0, 2.0, [1, 1]));
        assert_eq!(gathered([9; 8], [false; 8]).1, [0, 0]);
    }

    #[test]
    fn many_records_are_gathered_lane_by_lane() {
        let records = [1, 2, 3, 4, 5, 5, 5, 5];
        let ([numbers, words], _) = gathered(records, [true; 8]);
        assert_eq!((numbers, words), (records.map(f32::from), numbers));
    }
}
