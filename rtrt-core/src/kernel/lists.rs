//! The lists of the 2D structure: for each block, the instances that its rays may hit.
//!
//! The paper has linked lists. These are the same lists without gaps: count the entries of each block,
//! add up the counts, scatter the entries. No list overflows, and any number of workers may scatter at
//! once: the order by `(key, instance)` afterwards is unique. One worker sorts a block's list in place
//! ([`sort`]); many workers each find the [`rank`] of an entry and store it there.

/// The lists as one run of words: the start of each block and the end of the last, then two words an entry.
#[derive(Clone, Copy)]
pub struct BlockLists<'a> {
    /// The words.
    pub data: &'a [u32],
    /// The number of blocks.
    pub blocks: u32,
}

/// An instance in a list.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ListEntry {
    /// Bits of the least depth of a hit on the instance, not negative; 0 if the order does not matter.
    pub key: u32,
    /// The instance, or the part of one.
    pub instance: u32,
}

impl BlockLists<'_> {
    /// Words taken by the starts.
    #[inline(always)]
    pub fn header(blocks: u32) -> u32 {
        blocks + 1
    }
    /// The first entry of a block and the one after its last.
    #[inline(always)]
    pub fn range(&self, block: u32) -> [u32; 2] {
        [self.data[block as usize], self.data[block as usize + 1]]
    }
    /// Whether a block has no entry.
    #[inline(always)]
    pub fn is_empty(&self, block: u32) -> bool {
        let [first, last] = self.range(block);
        first == last
    }
    /// An entry.
    #[inline(always)]
    pub fn entry(&self, index: u32) -> ListEntry {
        load(self.data, Self::header(self.blocks), index)
    }
}

/// Reads an entry.
#[inline(always)]
fn load(lists: &[u32], header: u32, index: u32) -> ListEntry {
    let at = (header + 2 * index) as usize;
    ListEntry { key: lists[at], instance: lists[at + 1] }
}

/// Writes an entry.
#[inline(always)]
pub fn store(lists: &mut [u32], header: u32, index: u32, entry: ListEntry) {
    let at = (header + 2 * index) as usize;
    lists[at] = entry.key;
    lists[at + 1] = entry.instance;
}

/// The number of blocks that each of `workers` workers of the scan adds up.
#[inline(always)]
pub fn scan_share(blocks: u32, workers: u32) -> u32 {
    blocks.div_ceil(workers)
}

/// The number of entries of blocks `first .. last`.
#[inline(always)]
pub fn scan_total(counts: &[u32], first: u32, last: u32) -> u32 {
    let mut total = 0;
    let mut block = first;
    while block < last {
        total += counts[block as usize];
        block += 1;
    }
    total
}

/// Turns the counts of blocks `first .. last` into starts, from `start` on, and zeroes
/// the counts: they count again while entries are placed.
#[inline(always)]
pub fn scan_starts(counts: &mut [u32], lists: &mut [u32], first: u32, last: u32, start: u32) {
    let mut next = start;
    let mut block = first;
    while block < last {
        lists[block as usize] = next;
        next += counts[block as usize];
        counts[block as usize] = 0;
        block += 1;
    }
    lists[block as usize] = next;
}

/// Whether `a` comes before `b`.
#[inline(always)]
fn precedes(a: ListEntry, b: ListEntry) -> bool {
    a.key < b.key || (a.key == b.key && a.instance < b.instance)
}

/// The block that the entry with this index belongs to: the last that starts at it or before.
#[inline(always)]
fn block_of(starts: &[u32], blocks: u32, index: u32) -> u32 {
    let (mut block, mut beyond) = (0, blocks);
    while beyond - block > 1 {
        let middle = block + (beyond - block) / 2;
        if starts[middle as usize] <= index {
            block = middle;
        } else {
            beyond = middle;
        }
    }
    block
}

/// Copies entry `index` of `placed`, which has two words an entry and no starts, to its place in the sorted
/// list of its block in `lists`, which has the starts. The place is the number of entries that precede it.
///
/// A worker an entry takes as many steps as the block has entries, whereas a worker that
/// sorts the block's whole list takes more than some devices allow (see `NUMERICS.md`).
#[inline(always)]
pub fn rank(placed: &[u32], lists: &mut [u32], blocks: u32, index: u32) {
    let block = block_of(lists, blocks, index);
    let (first, last) = (lists[block as usize], lists[block as usize + 1]);
    let entry = load(placed, 0, index);
    let mut place = first;
    let mut other = first;
    while other < last {
        if precedes(load(placed, 0, other), entry) {
            place += 1;
        }
        other += 1;
    }
    store(lists, BlockLists::header(blocks), place, entry);
}

/// Sorts the entries of a block by `(key, instance)`; for a worker that has a block for itself.
pub fn sort(lists: &mut [u32], blocks: u32, block: u32) {
    let header = BlockLists::header(blocks) as usize;
    let range = [block, block + 1].map(|block| header + 2 * lists[block as usize] as usize);
    lists[range[0]..range[1]].as_chunks_mut::<2>().0.sort_unstable();
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_block_is_sorted_by_key_then_instance_and_the_others_stay() {
        let unsorted = [9, 1, 3, 7, 3, 2, 5, 0];
        // Starts of three blocks, and where the last ends.
        let mut lists: Vec<u32> = [0, 0, 3, 4].into_iter().chain(unsorted).collect();
        for block in [0, 1, 2] {
            sort(&mut lists, 3, block);
        }
        assert_eq!(lists, [0, 0, 3, 4, 3, 2, 3, 7, 9, 1, 5, 0]);
    }

    #[test]
    fn ranks_give_the_sorted_lists() {
        let starts = [0, 0, 40, 41, 41, 640, 640];
        let (blocks, entries) = (6, 640);
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        let mut placed = std::vec![0; 2 * entries as usize];
        for i in 0..entries {
            // An instance is in a list once.
            store(&mut placed, 0, i, ListEntry { key: next() % 50, instance: (i * 769) % 1024 });
        }
        let mut sorted: Vec<u32> = starts.iter().chain(&placed).copied().collect();
        for block in 0..blocks {
            sort(&mut sorted, blocks, block);
        }
        let mut ranked = std::vec![u32::MAX; sorted.len()];
        ranked[..starts.len()].copy_from_slice(&starts);
        for index in 0..entries {
            rank(&placed, &mut ranked, blocks, index);
        }
        assert_eq!(ranked, sorted);
    }

    #[test]
    fn starts_are_running_totals_whatever_the_share() {
        for workers in [1, 3, 7] {
            let mut counts = [3_u32, 0, 5, 1, 1, 0, 2];
            let mut lists = [0; 8];
            let share = scan_share(7, workers);
            let mut start = 0;
            for w in 0..workers {
                let (first, last) = ((w * share).min(7), ((w + 1) * share).min(7));
                let total = scan_total(&counts, first, last);
                scan_starts(&mut counts, &mut lists, first, last, start);
                start += total;
            }
            assert_eq!(lists, [0, 3, 3, 8, 9, 10, 10, 12]);
            assert_eq!(counts, [0; 7]);
        }
    }
}
