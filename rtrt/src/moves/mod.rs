//! Moves of a camera. A camera that cannot make a move is returned unchanged.

pub mod hand;

use glam::DVec3;
use rtrt_core::scene::{Camera, Projection};
use std::f64::consts::PI;

/// The least angle between the view and the vertical, radians.
const POLE: f64 = 0.01;
/// The factor of the focal length per notch of the wheel.
const NOTCH: f64 = 1.1;
/// The range of focal lengths, in units of half the picture's height: fields of view from about 169 to 0.6
/// degrees.
const FOCAL: [f64; 2] = [0.1, 200.0];

/// The camera's axes, of length 1 and at right angles to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// To the right in the picture.
    pub right: DVec3,
    /// Up in the picture.
    pub up: DVec3,
    /// Along the view.
    pub forward: DVec3,
}

/// The axes; none for a degenerate camera.
pub fn axes(camera: &Camera) -> Option<Axes> {
    let forward = unit(camera.look_at.as_dvec3() - camera.eye.as_dvec3())?;
    let right = unit(forward.cross(unit(camera.up.as_dvec3())?))?;
    Some(Axes { right, up: right.cross(forward), forward })
}

/// The camera moved by `[right, up, forward]` of its own axes, world units.
pub fn moved(camera: &Camera, [right, up, forward]: [f64; 3]) -> Camera {
    let Some(axes) = axes(camera) else { return *camera };
    let by = axes.right * right + axes.up * up + axes.forward * forward;
    let shifted = |place: glam::Vec3| (place.as_dvec3() + by).as_vec3();
    usable(camera, Camera { eye: shifted(camera.eye), look_at: shifted(camera.look_at), ..*camera })
}

/// The camera turned where it stands: by `yaw` to the left around its up, and by `pitch` upward, radians.
pub fn turned(camera: &Camera, yaw: f64, pitch: f64) -> Camera {
    let Some(forward) = forward_turned(camera, yaw, pitch) else { return *camera };
    looking(camera, camera.eye.as_dvec3(), forward)
}

/// The camera tilted by an angle, radians: its right side goes down.
pub fn tilted(camera: &Camera, angle: f64) -> Camera {
    let Some(Axes { up, forward, .. }) = axes(camera) else { return *camera };
    usable(camera, Camera { up: rotated(up, forward, angle).as_vec3(), ..*camera })
}

/// The camera with its focal length longer by so many notches of a wheel.
pub fn zoomed(camera: &Camera, notches: f64) -> Camera {
    let scale = libm::pow(NOTCH, notches);
    let projection = match camera.projection {
        Projection::Perspective { fov_y } => {
            let focal = scale / libm::tan(f64::from(fov_y) * 0.5);
            let fov_y = 2.0 * libm::atan(1.0 / focal.clamp(FOCAL[0], FOCAL[1]));
            Projection::Perspective { fov_y: fov_y as f32 }
        }
        Projection::OffCenter { left, right, bottom, top } => {
            let [left, right, bottom, top] =
                [left, right, bottom, top].map(|edge| (f64::from(edge) / scale) as f32);
            Projection::OffCenter { left, right, bottom, top }
        }
        Projection::Orthographic { height } => {
            Projection::Orthographic { height: (f64::from(height) / scale) as f32 }
        }
    };
    usable(camera, Camera { projection, ..*camera })
}

/// A view of the ball around `center` from the direction `from`, with `up` at the top, for a picture of this
/// `aspect` (width / height).
pub fn standard(
    camera: &Camera,
    (center, radius): (DVec3, f64),
    aspect: f64,
    from: DVec3,
    up: DVec3,
) -> Camera {
    let (projection, distance) = standard_distance(camera, radius, aspect);
    let eye = (center + from * distance).as_vec3();
    usable(camera, Camera { eye, look_at: center.as_vec3(), up: up.as_vec3(), projection })
}

/// The projection, and the distance of the center, with which a ball is in view.
fn standard_distance(camera: &Camera, radius: f64, aspect: f64) -> (Projection, f64) {
    match camera.projection {
        Projection::Perspective { fov_y } => {
            let tangent = libm::tan(f64::from(fov_y) * 0.5) * aspect.min(1.0);
            (camera.projection, radius / libm::sin(libm::atan(tangent)))
        }
        Projection::OffCenter { left, right, bottom, top } => {
            let tangent = [-left, right, -bottom, top].into_iter().fold(f32::MAX, f32::min).max(0.01);
            (camera.projection, radius / libm::sin(libm::atan(f64::from(tangent))))
        }
        Projection::Orthographic { .. } => {
            let height = (2.0 * radius / aspect.min(1.0)) as f32;
            (Projection::Orthographic { height }, 2.0 * radius)
        }
    }
}

/// The distance of the center of a scene in front of the camera, at least a twentieth of its radius.
pub fn pivot(camera: &Camera, (center, radius): (DVec3, f64)) -> f64 {
    let Some(Axes { forward, .. }) = axes(camera) else { return radius };
    (center - camera.eye.as_dvec3()).dot(forward).max(radius * 0.05)
}

/// How far a point is in front of the camera, along the view.
pub fn depth(camera: &Camera, point: DVec3) -> f64 {
    axes(camera).map_or(0.0, |axes| (point - camera.eye.as_dvec3()).dot(axes.forward))
}

/// The height of the picture at a distance in front of the camera, world units.
pub fn height_at(camera: &Camera, distance: f64) -> f64 {
    match camera.projection {
        Projection::Perspective { fov_y } => 2.0 * distance * libm::tan(f64::from(fov_y) * 0.5),
        Projection::OffCenter { bottom, top, .. } => distance * (f64::from(top) - f64::from(bottom)),
        Projection::Orthographic { height } => f64::from(height),
    }
}

/// The direction of the view after a turn.
fn forward_turned(camera: &Camera, yaw: f64, pitch: f64) -> Option<DVec3> {
    let Axes { right, forward, .. } = axes(camera)?;
    let up = unit(camera.up.as_dvec3())?;
    let [right, forward] = [right, forward].map(|axis| rotated(axis, up, yaw));
    let polar = libm::acos(forward.dot(up).clamp(-1.0, 1.0));
    unit(rotated(forward, right, polar - (polar - pitch).clamp(POLE, PI - POLE)))
}

/// The camera with another position and direction. The point that it looks at is so far away that rounding keeps
/// the direction.
fn looking(camera: &Camera, eye: DVec3, forward: DVec3) -> Camera {
    let distance = camera.look_at.as_dvec3().distance(camera.eye.as_dvec3());
    let look_at = eye + forward * distance.max(eye.abs().max_element());
    usable(camera, Camera { eye: eye.as_vec3(), look_at: look_at.as_vec3(), ..*camera })
}

/// `next`, or `camera` if `next` is degenerate.
fn usable(camera: &Camera, next: Camera) -> Camera {
    let finite = next.eye.is_finite() && next.look_at.is_finite() && next.up.is_finite();
    let height = match next.projection {
        Projection::Perspective { .. } | Projection::OffCenter { .. } => 1.0,
        Projection::Orthographic { height } => height,
    };
    let is_usable = finite && height > 1e-9 && height < 1e9 && axes(&next).is_some();
    if is_usable { next } else { *camera }
}

/// `v` turned around an axis of length 1, counterclockwise where the axis points to the viewer.
fn rotated(v: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos))
}

/// `v` at length 1; none for a vector without length.
fn unit(v: DVec3) -> Option<DVec3> {
    let length = libm::sqrt(v.length_squared());
    (length > 1e-9 && length.is_finite()).then(|| v / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Looks along −z from z = 4, y is up, x to the right.
    pub const FRONT: Camera = Camera {
        eye: Vec3::new(0.0, 0.0, 4.0),
        look_at: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 1.0 },
    };

    fn forward(camera: &Camera) -> DVec3 {
        axes(camera).unwrap().forward
    }

    #[test]
    fn moves_along_its_own_axes() {
        let left = turned(&FRONT, PI / 2.0, 0.0);
        assert!(forward(&left).distance(-DVec3::X) < 1e-6);
        let moved = moved(&left, [1.0, 2.0, 3.0]);
        assert!(moved.eye.distance(Vec3::new(-3.0, 2.0, 3.0)) < 1e-5, "{}", moved.eye);
        assert!(forward(&moved).distance(-DVec3::X) < 1e-6);
    }

    #[test]
    fn never_looks_straight_up() {
        let up = turned(&FRONT, 0.0, 99.0);
        assert!(forward(&up).y > 0.999 && axes(&up).is_some());
        assert!(forward(&turned(&up, 0.0, -99.0)).y < -0.999);
    }

    #[test]
    fn tilts_the_picture_and_not_the_view() {
        let tilted = tilted(&FRONT, PI / 2.0);
        assert!(forward(&tilted).distance(forward(&FRONT)) < 1e-9);
        assert!(tilted.up.distance(Vec3::X) < 1e-6, "{}", tilted.up);
    }

    #[test]
    fn the_wheel_changes_the_focal_length_and_goes_back() {
        let fov_y = |camera: &Camera| match camera.projection {
            Projection::Perspective { fov_y } => fov_y,
            Projection::OffCenter { top, .. } => top,
            Projection::Orthographic { height } => height,
        };
        let near = zoomed(&FRONT, 3.0);
        assert!(fov_y(&near) < 0.8 && (fov_y(&zoomed(&near, -3.0)) - 1.0).abs() < 1e-6);
        let flat = Camera { projection: Projection::Orthographic { height: 2.0 }, ..FRONT };
        assert!((fov_y(&zoomed(&flat, 1.0)) - 2.0 / 1.1).abs() < 1e-6);
        let (far, near) = (zoomed(&FRONT, -1e3), zoomed(&FRONT, 1e3));
        assert!(fov_y(&far) < 3.0 && fov_y(&near) > 0.005);
    }

    #[test]
    fn a_standard_view_has_the_whole_scene_in_it() {
        for aspect in [0.5, 1.0, 2.0] {
            let camera = standard(&FRONT, (DVec3::new(5.0, 0.0, 0.0), 3.0), aspect, DVec3::Y, -DVec3::Z);
            assert!(forward(&camera).distance(-DVec3::Y) < 1e-6 && axes(&camera).unwrap().right.x > 0.999);
            let half = libm::atan(libm::tan(0.5) * aspect.min(1.0));
            assert!((f64::from(camera.eye.y) * libm::sin(half) - 3.0).abs() < 1e-4);
        }
    }

    #[test]
    fn degenerate_cameras_do_not_change() {
        let blind = Camera { look_at: FRONT.eye, ..FRONT };
        assert_eq!(turned(&blind, 1.0, 1.0), blind);
        assert_eq!(moved(&FRONT, [f64::INFINITY, 0.0, 0.0]), FRONT);
        assert_eq!(standard(&FRONT, (DVec3::ZERO, 0.0), 1.0, DVec3::Z, DVec3::Y), FRONT);
    }
}
