//! Bin: count, add up, place, sort.

use rayon::prelude::*;
use rtrt_core::kernel::cover::Cover;
use rtrt_core::kernel::lists::{Entry, Lists, scan_starts, sort, store};
use rtrt_core::layout::{Frame, Object, View};
use rtrt_core::stage::bin::each_block;

/// Covers that a worker takes at a time.
const SHARE: usize = 8;

/// The lists and what they are built with.
#[derive(Debug, Default)]
pub struct Bins {
    /// See [`Lists`].
    pub words: Vec<u32>,
    counts: Vec<u32>,
    /// The blocks and entries of each share of the covers.
    found: Vec<Vec<(u32, Entry)>>,
}

impl Bins {
    /// Rebuilds the lists.
    pub fn fill(&mut self, frame: &Frame, views: &[View], objects: &[Object], covers: &[Cover]) {
        let Self { words, counts, found } = self;
        let blocks = frame.blocks;
        let header = Lists::header(blocks);
        found.resize_with(covers.len().div_ceil(SHARE), Vec::new);
        found.par_iter_mut().enumerate().for_each(|(share, found)| {
            found.clear();
            for index in share * SHARE..covers.len().min((share + 1) * SHARE) {
                each_block(frame, views, objects, covers, index as u32, |block, entry| {
                    found.push((block, entry));
                });
            }
        });
        counts.clear();
        counts.resize(blocks as usize, 0);
        for (block, _) in found.iter().flatten() {
            counts[*block as usize] += 1;
        }
        words.resize(header as usize, 0);
        scan_starts(counts, words, 0, blocks, 0);
        let entries = words[blocks as usize];
        words.resize((header + 2 * entries) as usize, 0);
        for &(block, entry) in found.iter().flatten() {
            let at = words[block as usize] + counts[block as usize];
            counts[block as usize] += 1;
            store(words, header, at, entry);
        }
        for block in 0..blocks {
            sort(words, blocks, block);
        }
    }
}
