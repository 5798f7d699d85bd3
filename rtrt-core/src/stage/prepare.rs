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
    let [view, number] = frame.of_screen_bounds(index);
    let instance = &instances[number as usize];
    // What is not opaque hides no light from all around.
    if instance.transparency != 0 && frame.has_ambient_rays() && view >= frame.ambient_view {
        return ScreenBounds::NONE;
    }
    // Every ray that hits an opaque copy hits the one before it, as near, and that has the lower number.
    if instance.transparency == 0
        && index > 0
        && frame.of_screen_bounds(index - 1)[0] == view
        && instance.is_copy_of(&instances[number as usize - 1])
    {
        return ScreenBounds::NONE;
    }
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
    fn of_opaque_copies_the_first_is_listed() {
        let mut views = [View { one_list: 1, ..View::zeroed() }; 7];
        (views[0].kind, views[1].kind) = (ViewKind::Camera as u32, ViewKind::Point as u32);
        let placed = |x: f32| {
            let mut placed = Instance { low: [1.0; 3], high: [1.0; 3], ..Instance::zeroed() };
            placed.to_world[1][2] = x;
            placed
        };
        let veil = Instance { transparency: 5, ..placed(2.0) };
        let instances = [placed(1.0), placed(1.0), placed(1.0), placed(2.0), veil, veil, placed(1.0)];
        let frame = Frame { views: 7, instances: 7, seen: 7, ..Frame::zeroed() };
        for view in [0, 1] {
            let listed = [0, 1, 2, 3, 4, 5, 6]
                .map(|i| prepare(&frame, &views, &instances, view * 7 + i) != ScreenBounds::NONE);
            assert_eq!(listed, [true, false, false, true, true, true, true]);
        }
        // Veils hide no light from all around.
        let frame = Frame { ambient_view: 1, ..frame };
        assert_eq!(prepare(&frame, &views, &instances, 7 + 4), ScreenBounds::NONE);
        assert_ne!(prepare(&frame, &views, &instances, 7 + 3), ScreenBounds::NONE);
    }

    #[test]
    fn an_instance_casts_shadows_of_lights_that_it_does_not_show_and_whose_shadows_reach_it() {
        let one_list = |kind| View { kind: kind as u32, one_list: 1, ..View::zeroed() };
        let mut views = [one_list(ViewKind::Off); 13];
        // A camera, a point light, a sun.
        views[0].kind = ViewKind::Camera as u32;
        views[1].kind = ViewKind::Point as u32;
        views[7] = View { shadow_distance: 2.0, ..one_list(ViewKind::Sun) };
        let at = |x: f32, kind| Instance {
            low: [x; 3],
            high: [x; 3],
            kind,
            start: x as u32,
            ..Instance::zeroed()
        };
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
