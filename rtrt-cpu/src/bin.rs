//! Bin: count, add up, place, sort. Lists of lights are kept while nothing changes that they depend
//! on.

use rayon::prelude::*;
use rtrt_core::kernel::cover::Cover;
use rtrt_core::kernel::lists::{Entry, Lists, scan_starts, sort, store};
use rtrt_core::layout::{Frame, Object, View};
use rtrt_core::scene::{Kept, Scene, Setup, Source};
use rtrt_core::stage::bin::each_block;
use std::ops::Range;

/// Covers that a worker takes at a time.
const SHARE: usize = 8;

/// The lists and what they are built with.
#[derive(Debug, Default)]
pub struct Bins {
    /// See [`Lists`].
    pub words: Vec<u32>,
    camera: Part,
    lights: Part,
    source: Source,
}

impl Bins {
    /// Whether the lists of lights are those of the frame before: the covers of lights are not
    /// looked at then.
    pub fn keeps_lights(&mut self, setup: &Setup, scene: &Scene) -> bool {
        self.source.kept(setup, scene) != Kept::Nothing
    }

    /// Rebuilds the lists, those of lights unless they are kept.
    pub fn fill(&mut self, job: &Binning<'_>, keeps_lights: bool) {
        let Self { words, camera, lights, .. } = self;
        let Binning { frame, views, covers, .. } = job;
        let blocks = views[Frame::CAMERA as usize].first_block;
        let seen = covers.len().min(frame.seen as usize);
        rayon::join(
            || camera.fill(job, 0..seen, blocks..frame.blocks),
            || {
                if !keeps_lights {
                    lights.fill(job, seen..covers.len(), 0..blocks);
                }
            },
        );
        let (light_starts, light_entries) = lights.words.split_at(blocks as usize);
        let (starts, entries) = camera.words.split_at((frame.blocks - blocks) as usize + 1);
        words.clear();
        words.extend_from_slice(light_starts);
        words.extend(starts.iter().map(|start| light_entries[0] + start));
        words.extend_from_slice(&light_entries[1..]);
        words.extend_from_slice(entries);
    }
}

/// What lists are made of.
pub struct Binning<'a> {
    pub frame: &'a Frame,
    pub views: &'a [View],
    pub objects: &'a [Object],
    pub covers: &'a [Cover],
}

/// The lists of some blocks that follow one another.
#[derive(Debug, Default)]
struct Part {
    /// As in [`Lists`], for these blocks alone.
    words: Vec<u32>,
    counts: Vec<u32>,
    /// The blocks and entries of each share of the covers.
    found: Vec<Vec<(u32, Entry)>>,
}

impl Part {
    fn fill(&mut self, job: &Binning<'_>, covers: Range<usize>, blocks: Range<u32>) {
        let Self { words, counts, found } = self;
        let Binning { frame, views, objects, covers: all } = job;
        found.resize_with(covers.len().div_ceil(SHARE), Vec::new);
        found.par_iter_mut().enumerate().for_each(|(share, found)| {
            found.clear();
            let first = covers.start + share * SHARE;
            for index in first..covers.end.min(first + SHARE) {
                each_block(frame, views, objects, all, index as u32, |block, entry| {
                    found.push((block - blocks.start, entry));
                });
            }
        });
        let count = blocks.end - blocks.start;
        let header = Lists::header(count);
        counts.clear();
        counts.resize(count as usize, 0);
        for (block, _) in found.iter().flatten() {
            counts[*block as usize] += 1;
        }
        words.resize(header as usize, 0);
        scan_starts(counts, words, 0, count, 0);
        let entries = words[count as usize];
        words.resize((header + 2 * entries) as usize, 0);
        for &(block, entry) in found.iter().flatten() {
            let at = words[block as usize] + counts[block as usize];
            counts[block as usize] += 1;
            store(words, header, at, entry);
        }
        for block in 0..count {
            sort(words, count, block);
        }
    }
}
