//! Bin: count, add up, place, rank.

use crate::{SCANNERS, SHARES, index};
use rtrt_core::kernel::lists::{rank as rank_entry, scan_share, scan_starts, scan_total, store};
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::layout::{Frame, Instance, View};
use rtrt_core::stage;
use spirv_std::arch::atomic_i_add;
use spirv_std::glam::UVec3;
use spirv_std::memory::{Scope, Semantics};
use spirv_std::spirv;

/// Atomically adds 1 to a word; returns its old value.
fn take(mesh_data: &mut [u32], at: u32) -> u32 {
    // SAFETY: the word is in a storage buffer, and every other access to it during the
    // dispatch goes through here.
    unsafe {
        atomic_i_add::<u32, { Scope::Device as u32 }, { Semantics::NONE.bits() }>(
            &mut mesh_data[at as usize],
            1,
        )
    }
}

/// How many entries each block has: [`SHARES`] invocations a cover.
#[spirv(compute(threads(64), entry_point_name = "count"))]
pub fn count(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] screen_bounds: &[ScreenBounds],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] counts: &mut [u32],
) {
    let (cover, share) = (index(id) / SHARES, index(id) % SHARES);
    if cover < stage::prepare::count(frame) {
        stage::bin::each_block_of_share(
            frame,
            views,
            instances,
            screen_bounds,
            cover,
            [share, SHARES],
            |block, _| {
                take(counts, block);
            },
        );
    }
}

/// The number of entries of each share of the blocks, behind the counts of blocks: [`SCANNERS`] invocations.
#[spirv(compute(threads(64), entry_point_name = "scan_totals"))]
pub fn scan_totals(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] counts: &mut [u32],
) {
    let share = index(id);
    if share < SCANNERS {
        let [first, last] = blocks_of(frame, share);
        counts[(frame.blocks + share) as usize] = scan_total(counts, first, last);
    }
}

/// Where each block's entries start: [`SCANNERS`] invocations, which share the blocks. BlockLists that
/// are kept stay where they are, before those that are made.
///
/// The totals were added up by a dispatch before: a barrier between both would have to be passed by all invocations
/// alike, and checks of indices are branches that WebGPU cannot see to be so.
#[spirv(compute(threads(64), entry_point_name = "scan"))]
pub fn scan(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] counts: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &mut [u32],
) {
    let share = index(id);
    if share < SCANNERS {
        let mut start = 0;
        if frame.first_block > 0 {
            start = lists[frame.first_block as usize];
        }
        let mut before = 0;
        while before < share {
            start += counts[(frame.blocks + before) as usize];
            before += 1;
        }
        let [first, last] = blocks_of(frame, share);
        scan_starts(counts, lists, first, last, start);
    }
}

/// The first of the blocks that an invocation of the scan adds up, and the first behind them.
#[inline(always)]
fn blocks_of(frame: &Frame, share: u32) -> [u32; 2] {
    let length = scan_share(frame.blocks - frame.first_block, SCANNERS);
    let first = (frame.first_block + share * length).min(frame.blocks);
    [first, (first + length).min(frame.blocks)]
}

/// Puts every entry among those of its block, where there is room: [`SHARES`] invocations a
/// cover. If there is not, the host sees it by the total, and does the frame again.
#[spirv(compute(threads(64), entry_point_name = "scatter"))]
pub fn scatter(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] screen_bounds: &[ScreenBounds],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] counts: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] placed: &mut [u32],
) {
    let (cover, share) = (index(id) / SHARES, index(id) % SHARES);
    if cover < stage::prepare::count(frame) {
        stage::bin::each_block_of_share(
            frame,
            views,
            instances,
            screen_bounds,
            cover,
            [share, SHARES],
            |block, entry| {
                let place = lists[block as usize] + take(counts, block);
                if place < frame.capacity {
                    store(placed, 0, place, entry);
                }
            },
        );
    }
}

/// Copies the entries to their lists, each block's in order: one invocation an entry of lists that
/// are made.
#[spirv(compute(threads(64), entry_point_name = "rank"))]
pub fn rank(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] placed: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &mut [u32],
) {
    let entry = lists[frame.first_block as usize] + index(id);
    let entries = lists[frame.blocks as usize];
    if entry < entries && entries <= frame.capacity {
        rank_entry(placed, lists, frame.blocks, entry);
    }
}
