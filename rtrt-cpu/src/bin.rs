//! Bin: count, add up, place, sort.

use rtrt_core::kernel::cover::Cover;
use rtrt_core::kernel::lists::{Lists, scan_starts, sort, store};
use rtrt_core::layout::{Frame, Object, View};
use rtrt_core::stage::bin::each_block;

/// The lists and what they are built with.
#[derive(Debug, Default)]
pub struct Bins {
    /// See [`Lists`].
    pub words: Vec<u32>,
    counts: Vec<u32>,
}

impl Bins {
    /// Rebuilds the lists.
    pub fn fill(&mut self, frame: &Frame, views: &[View], objects: &[Object], covers: &[Cover]) {
        let blocks = frame.blocks;
        let header = Lists::header(blocks);
        self.counts.clear();
        self.counts.resize(blocks as usize, 0);
        let counts = &mut self.counts;
        for index in 0..covers.len() as u32 {
            each_block(frame, views, objects, covers, index, |block, _| counts[block as usize] += 1);
        }
        self.words.resize(header as usize, 0);
        scan_starts(counts, &mut self.words, 0, blocks, 0);
        let entries = self.words[blocks as usize];
        self.words.resize((header + 2 * entries) as usize, 0);
        let words = &mut self.words;
        for index in 0..covers.len() as u32 {
            each_block(frame, views, objects, covers, index, |block, entry| {
                let at = words[block as usize] + counts[block as usize];
                counts[block as usize] += 1;
                store(words, header, at, entry);
            });
        }
        for block in 0..blocks {
            sort(words, blocks, block);
        }
    }
}
