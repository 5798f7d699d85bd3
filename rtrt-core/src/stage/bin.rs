//! Bin: the lists of all blocks of all views. Count, add up, place, order.

use crate::kernel::lists::ListEntry;
use crate::kernel::screen_bounds::{ScreenBounds, sphere_in_block};
use crate::layout::{Frame, Instance, View};

/// Calls `visit(block, entry)` for every block that the instance of the cover with this
/// index belongs to: those of its rectangle whose rays can meet its sphere.
#[inline(always)]
pub fn each_block(
    frame: &Frame,
    views: &[View],
    instances: &[Instance],
    screen_bounds: &[ScreenBounds],
    index: u32,
    visit: impl FnMut(u32, ListEntry),
) {
    each_block_of_share(frame, views, instances, screen_bounds, index, [0, 1], visit);
}

/// [`each_block`] for one of several workers that share a cover: number `share` takes every
/// `shares`-th row, so that an instance that fills the view does not keep one worker busy for
/// the whole frame.
#[inline(always)]
pub fn each_block_of_share(
    frame: &Frame,
    views: &[View],
    instances: &[Instance],
    screen_bounds: &[ScreenBounds],
    index: u32,
    [share, shares]: [u32; 2],
    mut visit: impl FnMut(u32, ListEntry),
) {
    let [view, instance_index] = frame.of_screen_bounds(index);
    let view = &views[view as usize];
    let instance = &instances[instance_index as usize];
    let cover = &screen_bounds[index as usize];
    let entry = ListEntry { key: cover.key, instance: instance_index };
    let mut row = cover.y0 + share;
    while row < cover.y1 {
        let mut column = cover.x0;
        while column < cover.x1 {
            if sphere_in_block(view, instance, frame.magnitude, column, row) {
                visit(view.first_block + row * view.width + column, entry);
            }
            column += 1;
        }
        row += shares;
    }
}
