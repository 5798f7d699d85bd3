//! Which instances cast shadows of a sun: all, or those near the camera.
//!
//! A light of infinite range has no reach to choose occluders by; the paper takes those within a
//! distance of the camera. Its other test, whether the cone from the light around an instance meets
//! the view's pyramid, gained nothing here (`docs/experiments.md`).

use crate::layout::{Instance, View};

/// Whether an instance is within the distance from the camera at which the sun's shadows end.
///
/// What counts is the nearest point of the instance's bounds, and the camera's place; the corner of
/// the picture for parallel rays. A distance of 0 is none.
#[inline(always)]
pub fn is_near(camera: &View, sun: &View, instance: &Instance) -> bool {
    let mut squared = 0.0;
    let mut i = 0;
    while i < 3 {
        let (below, above) = (instance.low[i] - camera.center[i], camera.center[i] - instance.high[i]);
        let gap = if below > above { below } else { above };
        squared += if gap > 0.0 { gap * gap } else { 0.0 };
        i += 1;
    }
    sun.shadow_distance == 0.0 || squared <= sun.shadow_distance * sun.shadow_distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn what_is_far_from_the_camera_is_not_near() {
        let instance = Instance { low: [-1.0, -1.0, -9.0], high: [1.0, 1.0, -5.0], ..Instance::zeroed() };
        let near = |shadow_distance| {
            is_near(&View::zeroed(), &View { shadow_distance, ..View::zeroed() }, &instance)
        };
        assert_eq!([near(0.0), near(4.9), near(5.0), near(50.0)], [true, false, true, true]);
    }
}
