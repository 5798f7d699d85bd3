//! Prepare: the bounds on the screen of an instance in a view.

use crate::kernel::screen_bounds::{ScreenBounds, screen_bounds};
use crate::kernel::shadow_distance::is_near;
use crate::layout::{Frame, Instance, View, ViewKind};

/// How many covers a frame makes: one for each instance of each view; the camera's may be parts of
/// instances.
#[inline(always)]
pub fn count(frame: &Frame) -> u32 {
    frame.seen + (frame.views - 1) * frame.instances
}

/// The cover with this index; see [`Frame::of_screen_bounds`].
#[inline(always)]
pub fn prepare(frame: &Frame, views: &[View], instances: &[Instance], index: u32) -> ScreenBounds {
    let [view, instance] = frame.of_screen_bounds(index);
    let instance = &instances[instance as usize];
    // What shows a light stands around it, and would keep all of it from leaving.
    if view != Frame::CAMERA && instance.shows((view - 1) / Frame::VIEWS_PER_LIGHT) {
        return ScreenBounds::NONE;
    }
    let (camera, view) = (&views[Frame::CAMERA as usize], &views[view as usize]);
    if view.kind == ViewKind::Sun as u32 && !is_near(camera, view, instance) {
        return ScreenBounds::NONE;
    }
    screen_bounds(view, instance, frame.magnitude)
}
