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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Kind;
    use bytemuck::Zeroable;

    #[test]
    fn an_instance_casts_shadows_of_lights_that_it_does_not_show_and_whose_shadows_reach_it() {
        let one_list = |kind| View { kind: kind as u32, one_list: 1, ..View::zeroed() };
        let mut views = [one_list(ViewKind::Off); 13];
        // A camera, a point light, a sun.
        views[0].kind = ViewKind::Camera as u32;
        views[1].kind = ViewKind::Point as u32;
        views[7] = View { shadow_distance: 2.0, ..one_list(ViewKind::Sun) };
        let at = |x: f32, kind| Instance { low: [x; 3], high: [x; 3], kind, ..Instance::zeroed() };
        let instances = [at(1.0, Kind::Mesh as u32), at(1.0, Kind::Light as u32), at(9.0, Kind::Mesh as u32)];
        let frame = Frame { views: 13, instances: 3, seen: 3, ..Frame::zeroed() };
        assert_eq!(count(&frame), 3 + 12 * 3);
        let covers = |view: u32| {
            [0, 1, 2].map(|i| prepare(&frame, &views, &instances, view * 3 + i) != ScreenBounds::NONE)
        };
        assert_eq!(covers(0), [true; 3]);
        assert_eq!(covers(1), [true, false, true]);
        assert_eq!(covers(2), [false; 3]);
        assert_eq!(covers(7), [true, true, false]);
    }
}
