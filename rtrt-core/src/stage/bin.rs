//! Bin: the lists of all blocks of all views. Count, add up, place, order.

use crate::kernel::cover::{Cover, sphere_in_block};
use crate::kernel::lists::Entry;
use crate::layout::{Frame, Object, View};

/// Calls `visit(block, entry)` for every block that the object of the cover with this
/// index belongs to: those of its rectangle whose rays can meet its sphere.
#[inline(always)]
pub fn each_block(
    frame: &Frame,
    views: &[View],
    objects: &[Object],
    covers: &[Cover],
    index: u32,
    visit: impl FnMut(u32, Entry),
) {
    each_block_of_share(frame, views, objects, covers, index, [0, 1], visit);
}

/// [`each_block`] for one of several workers that share a cover: number `share` takes every
/// `shares`-th row, so that an object that fills the view does not keep one worker busy for
/// the whole frame.
#[inline(always)]
pub fn each_block_of_share(
    frame: &Frame,
    views: &[View],
    objects: &[Object],
    covers: &[Cover],
    index: u32,
    [share, shares]: [u32; 2],
    mut visit: impl FnMut(u32, Entry),
) {
    let [view, object_index] = frame.of_cover(index);
    let view = &views[view as usize];
    let object = &objects[object_index as usize];
    let cover = &covers[index as usize];
    let entry = Entry { key: cover.key, object: object_index };
    let mut row = cover.y0 + share;
    while row < cover.y1 {
        let mut column = cover.x0;
        while column < cover.x1 {
            if sphere_in_block(view, object, frame.magnitude, column, row) {
                visit(view.first_block + row * view.width + column, entry);
            }
            column += 1;
        }
        row += shares;
    }
}
