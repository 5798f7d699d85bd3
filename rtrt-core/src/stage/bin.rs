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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::ViewKind;
    use bytemuck::Zeroable;
    use std::vec::Vec;

    /// The blocks that are visited for an instance, whose sphere is everywhere, that covers columns 1
    /// and 2 and rows 1 to 3 of a camera's 4 by 4 blocks, of which the first has number 100.
    fn blocks(radius: f32, shares: u32) -> Vec<Vec<u32>> {
        let camera = View {
            kind: ViewKind::Camera as u32,
            width: 4,
            height: 4,
            first_block: 100,
            along: [-2.0, -2.0, 1.0],
            along_x: [1.0, 0.0, 0.0],
            along_y: [0.0, 1.0, 0.0],
            ..View::zeroed()
        };
        let frame = Frame { seen: 8, first_seen: 5, ..Frame::zeroed() };
        let instance = Instance { radius, center: [0.5, 0.5, 1.0], ..Instance::zeroed() };
        let bounds = ScreenBounds { x0: 1, y0: 1, x1: 3, y1: 4, key: 9 };
        let all = (0..shares).map(|share| {
            let mut visited = Vec::new();
            each_block_of_share(
                &frame,
                &[camera],
                &[instance; 8],
                &[bounds; 3],
                2,
                [share, shares],
                |block, entry| {
                    // The third of those that the camera's lists choose from.
                    assert_eq!(entry, ListEntry { key: 9, instance: 7 });
                    visited.push(block);
                },
            );
            visited
        });
        all.collect()
    }

    #[test]
    fn an_instance_is_in_the_blocks_of_its_rectangle_whose_rays_can_meet_its_sphere() {
        assert_eq!(blocks(100.0, 1), [[105, 106, 109, 110, 113, 114]]);
        // The middle ray of column 2 and row 2 goes through its center.
        assert_eq!(blocks(0.1, 1), [[110]]);
    }

    #[test]
    fn workers_share_the_rows_of_an_instance() {
        assert_eq!(blocks(100.0, 2), [[105, 106, 113, 114].to_vec(), [109, 110].to_vec()]);
        assert_eq!(blocks(100.0, 5).concat().len(), 6);
    }
}
