//! Bin: count, add up, scatter, sort. Lists of lights are reused while they would stay the same.

use crate::parallel;
use alloc::vec::Vec;
use core::ops::Range;
use rtrt_core::kernel::lists::{BlockLists, ListEntry, scan_starts, sort, store};
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::layout::{Frame, Instance, View};
use rtrt_core::scene::{ListCacheKey, ReusableLists, Scene, Setup};
use rtrt_core::stage::bin::each_block;

/// ScreenBounds that a worker takes at a time.
const SHARE: usize = 8;

/// The lists, and the memory they are built in.
#[derive(Debug, Default)]
pub struct Bins {
    /// See [`BlockLists`].
    pub lists: Vec<u32>,
    camera: BinShare,
    lights: BinShare,
    list_key: ListCacheKey,
}

impl Bins {
    /// Whether the lists of lights are those of the frame before: the covers of lights are not
    /// looked at then.
    pub fn keeps_lights(&mut self, setup: &Setup, scene: &Scene) -> bool {
        self.list_key.reusable(setup, scene) != ReusableLists::Nothing
    }

    /// Rebuilds the lists; those of lights unless they are reused.
    pub fn fill(&mut self, context: &Binning<'_>, keeps_lights: bool) {
        let Self { lists, camera, lights, .. } = self;
        let Binning { frame, views, screen_bounds, .. } = context;
        let blocks = views[Frame::CAMERA as usize].first_block;
        let seen = screen_bounds.len().min(frame.seen as usize);
        parallel::join(
            || camera.fill(context, 0..seen, blocks..frame.blocks),
            || {
                if !keeps_lights {
                    lights.fill(context, seen..screen_bounds.len(), 0..blocks);
                }
            },
        );
        let (light_starts, light_entries) = lights.lists.split_at(blocks as usize);
        let (starts, entries) = camera.lists.split_at((frame.blocks - blocks) as usize + 1);
        lists.clear();
        lists.extend_from_slice(light_starts);
        lists.extend(starts.iter().map(|start| light_entries[0] + start));
        lists.extend_from_slice(&light_entries[1..]);
        lists.extend_from_slice(entries);
    }
}

/// What lists are made of.
pub struct Binning<'a> {
    pub frame: &'a Frame,
    pub views: &'a [View],
    pub instances: &'a [Instance],
    pub screen_bounds: &'a [ScreenBounds],
}

/// The lists of some blocks that follow one another.
#[derive(Debug, Default)]
struct BinShare {
    /// As in [`BlockLists`], for these blocks alone.
    lists: Vec<u32>,
    counts: Vec<u32>,
    /// The blocks and entries of each share of the bounds.
    found: Vec<Vec<(u32, ListEntry)>>,
}

impl BinShare {
    fn fill(&mut self, context: &Binning<'_>, screen_bounds: Range<usize>, blocks: Range<u32>) {
        let Self { lists, counts, found } = self;
        let Binning { frame, views, instances, screen_bounds: all } = context;
        found.resize_with(screen_bounds.len().div_ceil(SHARE), Vec::new);
        parallel::each(found, 1, |share, found| {
            found.clear();
            let first = screen_bounds.start + share * SHARE;
            for index in first..screen_bounds.end.min(first + SHARE) {
                each_block(frame, views, instances, all, index as u32, |block, entry| {
                    found.push((block - blocks.start, entry));
                });
            }
        });
        let count = blocks.end - blocks.start;
        let header = BlockLists::header(count);
        counts.clear();
        counts.resize(count as usize, 0);
        for (block, _) in found.iter().flatten() {
            counts[*block as usize] += 1;
        }
        lists.resize(header as usize, 0);
        scan_starts(counts, lists, 0, count, 0);
        let entries = lists[count as usize];
        lists.resize((header + 2 * entries) as usize, 0);
        for &(block, entry) in found.iter().flatten() {
            let at = lists[block as usize] + counts[block as usize];
            counts[block as usize] += 1;
            store(lists, header, at, entry);
        }
        for block in 0..count {
            sort(lists, count, block);
        }
    }
}
