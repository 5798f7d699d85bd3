//! Prepare: bounds on the screen, in parallel.

use crate::parallel;
use alloc::vec::Vec;
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::layout::{Frame, Instance, View};
use rtrt_core::stage::prepare;

/// Computes the bounds on the screen for the camera and, unless their lists are reused, for lights.
pub fn prepare(
    frame: &Frame,
    views: &[View],
    instances: &[Instance],
    screen_bounds: &mut Vec<ScreenBounds>,
    keeps_lights: bool,
) {
    screen_bounds.resize(prepare::count(frame) as usize, ScreenBounds::NONE);
    let wanted = if keeps_lights { frame.seen as usize } else { screen_bounds.len() };
    parallel::each(&mut screen_bounds[..wanted], 256, |index, cover| {
        *cover = prepare::prepare(frame, views, instances, index as u32);
    });
}
