//! Prepare: which blocks of which view an object covers.

use crate::kernel::cover::{Cover, cover};
use crate::layout::{Frame, Object, View};

/// How many covers a frame has: one for each view and object.
#[inline(always)]
pub fn count(frame: &Frame) -> u32 {
    frame.views * frame.objects
}

/// The cover with this index; views are outer, objects inner.
#[inline(always)]
pub fn prepare(frame: &Frame, views: &[View], objects: &[Object], index: u32) -> Cover {
    let (view, object) = (index / frame.objects, &objects[(index % frame.objects) as usize]);
    // What shows a light stands around it, and would keep all of it from leaving.
    if view != Frame::CAMERA && object.shows((view - 1) / Frame::VIEWS_PER_LIGHT) {
        return Cover::NONE;
    }
    cover(&views[view as usize], object, frame.magnitude)
}
