//! Which instances may cast a visible shadow in the light of a sun.
//!
//! The paper limits the occluders of a light of infinite range by their distance from the camera, or by
//! a test of the cone from the light around an instance's sphere against the view's frustum. The cone of
//! a sun is a cylinder.

use crate::layout::{Instance, View};

/// The margin around the picture in which a shadow counts as visible, in blocks: more than the rounding
/// errors of columns and rows below 2¹¹.
const MARGIN: f32 = 1.0 / 64.0;
/// The least slope away from a plane, as a share of its row's length: by rounding, a shadow along a plane
/// may cross it far away.
const ALONG: f32 = 1.0 / 65536.0;

/// A box in world space, as seen from a camera.
#[derive(Clone, Copy)]
struct Extent {
    low: [f32; 3],
    high: [f32; 3],
}

/// Whether an instance is within the distance from the camera at which the sun's shadows end.
///
/// The distance is from the camera (for parallel rays, the corner of the picture) to the nearest point of
/// the instance's bounds. A distance of 0 means no limit.
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

/// Whether the shadow that an instance casts of a sun may fall on what the camera sees.
///
/// It does not where the instance is outside of one of the planes around the picture and the light
/// goes away from that plane: nothing that moves along the light comes back. `widened` are the
/// instance's bounds with room for the roundings of tracing.
#[inline(always)]
pub(crate) fn is_shadow_seen(camera: &View, sun: &View, (low, high): ([f32; 3], [f32; 3])) -> bool {
    if camera.one_list == 1 {
        return true;
    }
    let (c, m) = (&camera.center, sun.margin);
    let around = Extent {
        low: [low[0] - c[0] - m, low[1] - c[1] - m, low[2] - c[2] - m],
        high: [high[0] - c[0] + m, high[1] - c[1] + m, high[2] - c[2] + m],
    };
    let light = &sun.along;
    let (columns, rows) = (camera.width as f32 + MARGIN, camera.height as f32 + MARGIN);
    !(leaves(&camera.depth, 0.0, &around, light)
        || leaves(&edge(camera, &camera.x, -MARGIN, 1.0), MARGIN * camera.w_offset, &around, light)
        || leaves(&edge(camera, &camera.x, columns, -1.0), columns * camera.w_offset, &around, light)
        || leaves(&edge(camera, &camera.y, -MARGIN, 1.0), MARGIN * camera.w_offset, &around, light)
        || leaves(&edge(camera, &camera.y, rows, -1.0), rows * camera.w_offset, &around, light))
}

/// The plane at a column (or row) of the picture, positive inside of it: `side · (X − place · W)`.
#[inline(always)]
fn edge(camera: &View, axis: &[f32; 3], place: f32, side: f32) -> [f32; 3] {
    let w = &camera.w;
    [side * (axis[0] - place * w[0]), side * (axis[1] - place * w[1]), side * (axis[2] - place * w[2])]
}

/// Whether the box is behind the plane `row · p + offset`, and moves away from it.
#[inline(always)]
fn leaves(row: &[f32; 3], offset: f32, around: &Extent, along: &[f32; 3]) -> bool {
    let (mut most, mut speed, mut length) = (offset, 0.0, 0.0);
    let mut i = 0;
    while i < 3 {
        let (a, b) = (row[i] * around.low[i], row[i] * around.high[i]);
        most += if a < b { b } else { a };
        let step = row[i] * along[i];
        speed += step;
        length += if row[i] < 0.0 { -row[i] } else { row[i] };
        i += 1;
    }
    most < 0.0 && speed < -ALONG * length
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::layout::ViewKind;
    use bytemuck::Zeroable;

    /// A camera at the origin that looks along −z, with a picture of 2 by 2 blocks whose edges
    /// are at 45 degrees.
    fn camera() -> View {
        View {
            kind: ViewKind::Camera as u32,
            width: 2,
            height: 2,
            depth: [0.0, 0.0, -1.0],
            w: [0.0, 0.0, -1.0],
            x: [1.0, 0.0, -1.0],
            y: [0.0, -1.0, -1.0],
            ..View::zeroed()
        }
    }

    fn is_seen(center: [f32; 3], along: [f32; 3]) -> bool {
        let sun = View { kind: ViewKind::Sun as u32, along, ..View::zeroed() };
        let around = (center.map(|c| c - 0.5), center.map(|c| c + 0.5));
        is_shadow_seen(&camera(), &sun, around)
    }

    #[test]
    fn shadows_that_cannot_be_seen_are_left_out_and_no_others() {
        let down = [0.0, -1.0, 0.0];
        // In the picture, above it, below it.
        assert!(is_seen([0.0, 0.0, -5.0], down));
        assert!(is_seen([0.0, 20.0, -5.0], down));
        assert!(!is_seen([0.0, -20.0, -5.0], down));
        // Beside it and behind it, with light that goes by, or toward what is seen.
        assert!(!is_seen([20.0, 0.0, -5.0], [0.5, -1.0, 0.0]));
        assert!(is_seen([20.0, 0.0, -5.0], [-0.5, -1.0, 0.0]));
        assert!(!is_seen([0.0, 0.0, 5.0], [0.0, -1.0, 0.1]));
        assert!(is_seen([0.0, 5.0, 5.0], [0.0, -0.4, -1.0]));
        // Along the left edge of the picture: not clearly away.
        assert!(is_seen([-20.0, 0.0, -5.0], [-1.0, 0.0, -1.0]));
    }

    #[test]
    fn what_is_far_from_the_camera_is_not_near() {
        let instance = Instance { low: [-1.0, -1.0, -9.0], high: [1.0, 1.0, -5.0], ..Instance::zeroed() };
        let near =
            |shadow_distance| is_near(&camera(), &View { shadow_distance, ..View::zeroed() }, &instance);
        assert_eq!([near(0.0), near(4.9), near(5.0), near(50.0)], [true, false, true, true]);
    }
}
