//! Prepare: which blocks of which view an object covers.

use crate::kernel::cover::{Cover, cover};
use crate::kernel::frustum::{is_near, is_shadow_seen};
use crate::layout::{Frame, Object, View, ViewKind};

/// How many covers a frame makes: one for each object of each view; the camera's may be parts of
/// objects.
#[inline(always)]
pub fn count(frame: &Frame) -> u32 {
    frame.seen + (frame.views - 1) * frame.objects
}

/// The cover with this index; see [`Frame::of_cover`].
#[inline(always)]
pub fn prepare(frame: &Frame, views: &[View], objects: &[Object], index: u32) -> Cover {
    let [view, object] = frame.of_cover(index);
    let object = &objects[object as usize];
    // What shows a light stands around it, and would keep all of it from leaving.
    if view != Frame::CAMERA && object.shows((view - 1) / Frame::VIEWS_PER_LIGHT) {
        return Cover::NONE;
    }
    let (camera, view) = (&views[Frame::CAMERA as usize], &views[view as usize]);
    if view.kind == ViewKind::Sun as u32 {
        let is_seen = view.seen_only == 0 || is_shadow_seen(camera, view, object.widened(frame.magnitude));
        if !is_seen || !is_near(camera, view, object) {
            return Cover::NONE;
        }
    }
    cover(view, object, frame.magnitude)
}
