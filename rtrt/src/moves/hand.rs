//! How a hand moves a camera: around a pivot, towards a point, into a view of everything. Functions of cameras and
//! points alone; a camera that cannot make a motion is returned unchanged.

use super::{axes, forward_turned, looking, rotated, standard_distance, unit, usable};
use glam::DVec3;
use rtrt_core::scene::{Camera, Projection};

/// The factor of the distance per notch of the wheel.
pub const NOTCH: f64 = 1.15;

/// What dragging with the left button does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Turns around the pivot and keeps the horizon.
    #[default]
    Turntable,
    /// Rolls around the pivot; the horizon may tilt.
    Trackball,
    /// Looks around from where the camera is.
    Fly,
}

impl Mode {
    /// All, with their names.
    pub const ALL: [(&'static str, Self); 3] =
        [("turntable", Self::Turntable), ("trackball", Self::Trackball), ("fly", Self::Fly)];

    /// The name.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }

    /// The next one.
    #[must_use]
    pub fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % Self::ALL.len()].1
    }
}

/// The camera turned about a point, which stays where it is in the picture: by `yaw` to the left around its up, and by
/// `pitch` upward, radians. It never looks straight up or down.
pub fn orbited(camera: &Camera, pivot: DVec3, yaw: f64, pitch: f64) -> Camera {
    let (Some(before), Some(up)) = (axes(camera), unit(camera.up.as_dvec3())) else { return *camera };
    let Some(forward) = forward_turned(camera, yaw, pitch) else { return *camera };
    // How far it pitches within the limits: the angle between the directions with the yaw undone.
    let level = rotated(forward, up, -yaw);
    let angle = libm::atan2(before.forward.cross(level).dot(before.right), before.forward.dot(level));
    let turned = |v: DVec3| rotated(rotated(v, before.right, angle), up, yaw);
    looking(camera, pivot + turned(camera.eye.as_dvec3() - pivot), forward)
}

/// The camera rolled about a point like a ball: by `x` around its own up, and by `y` around its right, radians.
pub fn rolled(camera: &Camera, pivot: DVec3, x: f64, y: f64) -> Camera {
    let Some(before) = axes(camera) else { return *camera };
    let turned = |v: DVec3| rotated(rotated(v, before.right, y), before.up, x);
    let up = turned(before.up).as_vec3();
    let eye = pivot + turned(camera.eye.as_dvec3() - pivot);
    looking(&Camera { up, ..*camera }, eye, turned(before.forward))
}

/// The camera moved towards a point by so many notches of a wheel, each of which takes 13 % of the distance, or of
/// `least` where the point is nearer: a wheel never gets stuck. The direction stays. With parallel rays the picture gets
/// larger around the point.
pub fn dollied(camera: &Camera, target: DVec3, notches: f64, least: f64) -> Camera {
    let Some(before) = axes(camera) else { return *camera };
    let eye = camera.eye.as_dvec3();
    let left = libm::pow(NOTCH, -notches);
    let way = target - eye;
    let (by, projection) = match camera.projection {
        Projection::Orthographic { height } => {
            let aside = way - before.forward * way.dot(before.forward);
            (aside * (1.0 - left), Projection::Orthographic { height: (f64::from(height) * left) as f32 })
        }
        projection => {
            let direction = unit(way).filter(|way| way.dot(before.forward) > 0.0).unwrap_or(before.forward);
            (direction * (way.length().max(least) * (1.0 - left)), projection)
        }
    };
    let shifted = |place: glam::Vec3| (place.as_dvec3() + by).as_vec3();
    usable(
        camera,
        Camera { eye: shifted(camera.eye), look_at: shifted(camera.look_at), up: camera.up, projection },
    )
}

/// The camera on its way by so many notches of a wheel, where it comes to a surface: each notch takes no more than 13 % of
/// the distance, so that it slows down, and it stops before it is nearer than `margin`. `free` is the distance to the next
/// surface from a point along a direction of length 1. Nothing stops a camera with parallel rays, or on its way back. Also
/// returns whether it was there before.
pub fn slowed(
    before: &Camera,
    after: &Camera,
    notches: f64,
    margin: f64,
    free: impl FnOnce(DVec3, DVec3) -> Option<f64>,
) -> (Camera, bool) {
    let (from, to) = (before.eye.as_dvec3(), after.eye.as_dvec3());
    let is_parallel = matches!(before.projection, Projection::Orthographic { .. });
    let (Some(direction), false) = (unit(to - from), is_parallel || notches <= 0.0) else {
        return (*after, false);
    };
    let Some(distance) = free(from, direction) else { return (*after, false) };
    let left = (distance - margin).max(0.0);
    let most = left.min(distance * (1.0 - libm::pow(NOTCH, -notches)));
    if from.distance(to) <= most {
        return (*after, false);
    }
    let by = direction * most;
    let shifted = |place: glam::Vec3| (place.as_dvec3() + by).as_vec3();
    let next = Camera { eye: shifted(before.eye), look_at: shifted(before.look_at), ..*after };
    (usable(before, next), left <= 0.5 * margin)
}

/// The camera in the same direction, with a ball in view.
pub fn framed(camera: &Camera, ball: (DVec3, f64), aspect: f64) -> Camera {
    let Some(before) = axes(camera) else { return *camera };
    let (projection, distance) = standard_distance(camera, ball.1, aspect);
    let eye = ball.0 - before.forward * distance;
    usable(camera, Camera { eye: eye.as_vec3(), look_at: ball.0.as_vec3(), projection, ..*camera })
}

/// The camera with parallel rays, or with rays from one point if it has parallel ones. What is at the distance keeps its
/// size.
pub fn parallel(camera: &Camera, distance: f64, fov_y: f32) -> Camera {
    let distance = distance.max(1e-6);
    let projection = match camera.projection {
        Projection::Perspective { fov_y } => {
            Projection::Orthographic { height: (2.0 * distance * libm::tan(f64::from(fov_y) * 0.5)) as f32 }
        }
        Projection::OffCenter { bottom, top, .. } => {
            Projection::Orthographic { height: (distance * f64::from(top - bottom)) as f32 }
        }
        Projection::Orthographic { height } => {
            let Some(axes) = axes(camera) else { return *camera };
            // The eye moves to where the angle of view shows as much.
            let far = f64::from(height) * 0.5 / libm::tan(f64::from(fov_y) * 0.5);
            let eye = camera.eye.as_dvec3() + axes.forward * (distance - far);
            let camera = looking(camera, eye, axes.forward);
            return usable(&camera, Camera { projection: Projection::Perspective { fov_y }, ..camera });
        }
    };
    usable(camera, Camera { projection, ..*camera })
}

/// The ray through a place in the picture: its origin, and its direction of length 1 along the view.
pub fn ray(camera: &Camera, size: [u32; 2], [x, y]: [f64; 2]) -> Option<(DVec3, DVec3)> {
    let axes = axes(camera)?;
    let eye = camera.eye.as_dvec3();
    let [width, height] = size.map(f64::from);
    // From the middle, in heights of the picture; up is positive.
    let (right, up) = ((x - width * 0.5) / height, 0.5 - y / height);
    Some(match camera.projection {
        Projection::Perspective { fov_y } => {
            let scale = 2.0 * libm::tan(f64::from(fov_y) * 0.5);
            (eye, axes.forward + axes.right * (right * scale) + axes.up * (up * scale))
        }
        Projection::OffCenter { left, right, bottom, top } => {
            let along =
                |from: f32, to: f32, part: f64| f64::from(from) + (f64::from(to) - f64::from(from)) * part;
            let aside = axes.right * along(left, right, x / width) + axes.up * along(top, bottom, y / height);
            (eye, axes.forward + aside)
        }
        Projection::Orthographic { height } => {
            let height = f64::from(height);
            (eye + axes.right * (right * height) + axes.up * (up * height), axes.forward)
        }
    })
}

/// The place of a point in the picture, pixels; none for a point behind the camera.
pub fn projected(camera: &Camera, size: [u32; 2], point: DVec3) -> Option<[f64; 2]> {
    let axes = axes(camera)?;
    let way = point - camera.eye.as_dvec3();
    let [right, up, depth] = [axes.right, axes.up, axes.forward].map(|axis| way.dot(axis));
    let [width, height] = size.map(f64::from);
    let (x, y) = match camera.projection {
        Projection::Orthographic { height } => (right / f64::from(height), up / f64::from(height)),
        _ if depth <= 1e-9 => return None,
        Projection::Perspective { fov_y } => {
            let scale = 2.0 * libm::tan(f64::from(fov_y) * 0.5) * depth;
            (right / scale, up / scale)
        }
        Projection::OffCenter { left, right: end, bottom, top } => {
            let part = |c: f64, from: f32, to: f32| {
                (c / depth - f64::from(from)) / (f64::from(to) - f64::from(from))
            };
            return Some([part(right, left, end) * width, part(up, top, bottom) * height]);
        }
    };
    Some([width * 0.5 + x * height, height * 0.5 - y * height])
}

/// The part of a line that is in the picture; none where nothing is.
pub fn screen_ends(camera: &Camera, size: [u32; 2], [a, b]: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let axes = axes(camera)?;
    let [width, height] = size.map(f64::from);
    let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
    let corners = corners.map(|place| ray(camera, size, place));
    let [Some(upper_left), Some(upper_right), Some(lower_right), Some(lower_left)] = corners else {
        return None;
    };
    // A plane through each side of the picture; what is in front of it is in view.
    let sides = [
        (upper_left, upper_left.1.cross(upper_right.0 + upper_right.1 - upper_left.0)),
        (upper_right, upper_right.1.cross(lower_right.0 + lower_right.1 - upper_right.0)),
        (lower_right, lower_right.1.cross(lower_left.0 + lower_left.1 - lower_right.0)),
        (lower_left, lower_left.1.cross(upper_left.0 + upper_left.1 - lower_left.0)),
    ];
    let middle = ray(camera, size, [width * 0.5, height * 0.5])?;
    let inside = middle.0 + middle.1;
    let planes = sides.map(|((origin, _), normal)| {
        let is_inward = (inside - origin).dot(normal) > 0.0;
        (origin, if is_inward { normal } else { -normal })
    });
    // Nothing behind the eye is projected, and parallel rays have no eye.
    let depth = match camera.projection {
        Projection::Orthographic { .. } => f64::NEG_INFINITY,
        _ => 1e-6,
    };
    let mut part = [0.0, 1.0];
    let mut cut = |from: f64, to: f64| {
        if from < 0.0 && to < 0.0 {
            part = [1.0, 0.0];
        } else if from < 0.0 {
            part[0] = f64::max(part[0], from / (from - to));
        } else if to < 0.0 {
            part[1] = f64::min(part[1], from / (from - to));
        }
    };
    let eye = camera.eye.as_dvec3();
    for (origin, normal) in planes {
        cut((a - origin).dot(normal), (b - origin).dot(normal));
    }
    if depth.is_finite() {
        cut((a - eye).dot(axes.forward) - depth, (b - eye).dot(axes.forward) - depth);
    }
    (part[0] < part[1]).then(|| part.map(|share| a.lerp(b, share)))
}

/// Where a ray to a point begins that the camera may see, and the way from there to the point; none for a point behind
/// the camera.
pub fn way_to(camera: &Camera, point: DVec3) -> Option<(DVec3, DVec3)> {
    let (axes, eye) = (axes(camera)?, camera.eye.as_dvec3());
    let depth = (point - eye).dot(axes.forward);
    let origin = match camera.projection {
        Projection::Orthographic { .. } => point - axes.forward * depth,
        _ => eye,
    };
    (depth > 0.0).then(|| (origin, point - origin))
}

/// The camera on its way from `before` to `after` where it does not pass a surface: `free` is the distance to the next
/// one from a point along a direction of length 1, and `margin` that which is kept along the way. The pivot stays where it is in the
/// picture.
pub fn kept_inside(
    before: &Camera,
    after: &Camera,
    pivot: DVec3,
    margin: f64,
    free: impl FnOnce(DVec3, DVec3) -> Option<f64>,
) -> Camera {
    let (from, to) = (before.eye.as_dvec3(), after.eye.as_dvec3());
    let Some(direction) = unit(to - from) else { return *after };
    let length = from.distance(to);
    let Some(distance) = free(from, direction).filter(|distance| *distance < length + margin) else {
        return *after;
    };
    let eye = from + direction * (distance - margin).clamp(0.0, length);
    let Some(axes) = axes(after) else { return *before };
    let (Some(seen), Some(now)) = (unit(pivot - to), unit(pivot - eye)) else { return *before };
    let forward = match unit(seen.cross(now)) {
        Some(axis) => rotated(axes.forward, axis, libm::acos(seen.dot(now).clamp(-1.0, 1.0))),
        None => axes.forward,
    };
    looking(after, eye, forward)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moves::tests::FRONT;
    use glam::Vec3;

    const FLAT: Camera = Camera { projection: Projection::Orthographic { height: 2.0 }, ..FRONT };
    const SIZE: [u32; 2] = [640, 360];

    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).abs() < 1e-2 && (a[1] - b[1]).abs() < 1e-2
    }

    #[test]
    fn a_pivot_stays_where_it_is_in_the_picture() {
        let pivot = DVec3::new(0.7, -0.4, 0.3);
        for motion in [orbited, rolled] {
            let mut camera = FRONT;
            let place = projected(&camera, SIZE, pivot).unwrap();
            for step in 0..50 {
                camera = motion(&camera, pivot, 0.07, if step < 25 { 0.02 } else { -0.03 });
                let now = projected(&camera, SIZE, pivot).unwrap();
                assert!(near(place, now), "{step}: {place:?} {now:?}");
                let distance = camera.eye.as_dvec3().distance(pivot);
                assert!((distance - FRONT.eye.as_dvec3().distance(pivot)).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_turntable_keeps_the_horizon_and_a_trackball_does_not_stop() {
        let level = orbited(&orbited(&FRONT, DVec3::ZERO, 0.0, -9.0), DVec3::ZERO, 1.0, 0.0);
        assert_eq!(level.up, Vec3::Y);
        assert!(level.eye.y > 3.99 && level.eye.y < 4.0, "{}", level.eye);
        let over = rolled(&FRONT, DVec3::ZERO, 0.0, -std::f64::consts::PI);
        assert!(over.eye.distance(Vec3::new(0.0, 0.0, -4.0)) < 1e-5 && over.up.distance(-Vec3::Y) < 1e-5);
    }

    #[test]
    fn a_dolly_goes_to_the_point_under_the_cursor_and_keeps_it_there() {
        let target = DVec3::new(0.5, 0.2, -1.0);
        for camera in [FRONT, FLAT] {
            let place = projected(&camera, SIZE, target).unwrap();
            let nearer = dollied(&camera, target, 2.0, 0.0);
            assert!(near(place, projected(&nearer, SIZE, target).unwrap()));
            let back = dollied(&nearer, target, -2.0, 0.0);
            assert!(back.eye.distance(camera.eye) < 1e-5);
        }
        let Projection::Orthographic { height } = dollied(&FLAT, target, 1.0, 0.0).projection else {
            panic!("it has parallel rays")
        };
        assert!((f64::from(height) - 2.0 / 1.15).abs() < 1e-6);
    }

    #[test]
    fn a_dolly_passes_its_point_and_goes_on() {
        let mut camera = FRONT;
        for _ in 0..200 {
            camera = dollied(&camera, DVec3::ZERO, 1.0, 0.1);
        }
        assert!(camera.eye.z < -1.0, "{}", camera.eye);
    }

    #[test]
    fn a_dolly_slows_down_and_does_not_pass_a_surface() {
        // A wall at z = 1, three units before the camera.
        let wall = |from: DVec3, along: DVec3| (along.z < 0.0).then(|| (1.0 - from.z) / along.z);
        let step = |camera: &Camera, notches: f64| {
            let next = dollied(camera, DVec3::ZERO, notches, 0.1);
            slowed(camera, &next, notches, 0.01, wall)
        };
        let (mut camera, mut last) = (FRONT, f32::MAX);
        for number in 0..100 {
            let (next, is_stopped) = step(&camera, 1.0);
            let by = camera.eye.z - next.eye.z;
            assert!(by <= last && next.eye.z >= 1.01 - 1e-6, "{number}: {}", next.eye);
            assert!(!is_stopped || next.eye.z < 1.03, "{number}: {}", next.eye);
            (camera, last) = (next, by);
        }
        assert!(step(&camera, 1.0).1 && camera.eye.z < 1.011);
        // A turn of many notches neither; and back there is no wall.
        assert!(step(&FRONT, 30.0).0.eye.z >= 1.01 - 1e-6);
        assert!(step(&camera, -1.0).0.eye.z > 1.1);
        let flat = dollied(&FLAT, DVec3::ONE, 1.0, 0.0);
        assert_eq!(slowed(&FLAT, &flat, 1.0, 0.01, |_, _| Some(0.0)), (flat, false));
    }

    #[test]
    fn a_framed_ball_touches_the_edge_of_the_picture() {
        for camera in [FRONT, FLAT] {
            let center = DVec3::new(3.0, 1.0, -7.0);
            let seen = framed(&camera, (center, 0.5), 16.0 / 9.0);
            assert!(near(projected(&seen, SIZE, center).unwrap(), [320.0, 180.0]));
            let top = match camera.projection {
                Projection::Orthographic { .. } => center + DVec3::Y * 0.5,
                // Where the line of sight touches the ball.
                _ => center + (DVec3::Y * libm::cos(0.5) + DVec3::Z * libm::sin(0.5)) * 0.5,
            };
            let [_, y] = projected(&seen, SIZE, top).unwrap();
            assert!(y.abs() < 0.1, "{y}");
        }
    }

    #[test]
    fn parallel_rays_show_what_is_at_the_pivot_at_the_same_size() {
        let point = DVec3::new(0.3, 0.4, 0.0);
        let flat = parallel(&FRONT, 4.0, 1.0);
        assert!(near(projected(&flat, SIZE, point).unwrap(), projected(&FRONT, SIZE, point).unwrap()));
        let back = parallel(&flat, 4.0, 1.0);
        assert!(back.eye.distance(FRONT.eye) < 1e-5 && back.projection == FRONT.projection);
    }

    #[test]
    fn rays_go_through_the_places_of_points() {
        let off = Projection::OffCenter { left: -0.3, right: 0.9, bottom: -0.2, top: 0.6 };
        for camera in [FRONT, FLAT, Camera { projection: off, ..FRONT }] {
            for place in [[0.0, 0.0], [100.0, 300.0], [639.0, 1.0]] {
                let (origin, direction) = ray(&camera, SIZE, place).unwrap();
                assert!(near(projected(&camera, SIZE, origin + direction * 3.0).unwrap(), place));
            }
        }
        assert_eq!(projected(&FRONT, SIZE, DVec3::Z * 9.0), None);
    }

    #[test]
    fn lines_end_at_the_sides_of_the_picture() {
        for camera in [FRONT, FLAT] {
            // From the middle to far beyond the right and the left side, and from before the camera to behind it.
            for (ends, sides) in [
                ([DVec3::ZERO, DVec3::X * 50.0], [320.0, 640.0]),
                ([DVec3::X * 50.0, DVec3::X * -50.0], [640.0, 0.0]),
            ] {
                let ends = screen_ends(&camera, SIZE, ends).unwrap();
                for (end, x) in ends.into_iter().zip(sides) {
                    assert!(near(projected(&camera, SIZE, end).unwrap(), [x, 180.0]), "{end}");
                }
            }
            let aside = [DVec3::new(-9.0, 9.0, 0.0), DVec3::new(9.0, 9.0, 0.0)];
            assert_eq!(screen_ends(&camera, SIZE, aside), None);
        }
        let through =
            screen_ends(&FRONT, SIZE, [DVec3::new(0.1, 0.0, 0.0), DVec3::new(0.1, 0.0, 9.0)]).unwrap();
        assert!(through[1].z > 3.0 && through[1].z < 4.0, "{}", through[1]);
    }

    #[test]
    fn ways_go_through_the_places_of_points() {
        let point = DVec3::new(0.3, -0.2, 1.0);
        for camera in [FRONT, FLAT] {
            let (origin, way) = way_to(&camera, point).unwrap();
            let place = projected(&camera, SIZE, point).unwrap();
            let (start, direction) = ray(&camera, SIZE, place).unwrap();
            assert!(origin.distance(start) < 1e-6 && way.normalize().distance(direction.normalize()) < 1e-6);
            assert!((origin + way).distance(point) < 1e-12 && way_to(&camera, DVec3::Z * 9.0).is_none());
        }
    }

    #[test]
    fn walls_keep_an_orbit_inside() {
        // A wall at x = 1.
        let wall = |from: DVec3, along: DVec3| (along.x > 1e-9).then(|| (1.0 - from.x) / along.x);
        let mut camera = FRONT;
        for _ in 0..300 {
            let next = orbited(&camera, DVec3::ZERO, 0.02, 0.0);
            camera = kept_inside(&camera, &next, DVec3::ZERO, 0.05, wall);
            assert!(camera.eye.x < 0.99, "{}", camera.eye);
            assert!(near(projected(&camera, SIZE, DVec3::ZERO).unwrap(), [320.0, 180.0]));
        }
        let free = orbited(&FRONT, DVec3::ZERO, 0.02, 0.0);
        assert_eq!(kept_inside(&FRONT, &free, DVec3::ZERO, 0.05, |_, _| None), free);
    }

    #[test]
    fn degenerate_cameras_do_not_change() {
        let blind = Camera { look_at: FRONT.eye, ..FRONT };
        assert_eq!(orbited(&blind, DVec3::ZERO, 1.0, 1.0), blind);
        assert_eq!(rolled(&blind, DVec3::ZERO, 1.0, 1.0), blind);
        assert_eq!(dollied(&blind, DVec3::ZERO, 1.0, 1.0), blind);
        assert_eq!(dollied(&FRONT, DVec3::ZERO, -1e9, 1.0), FRONT);
        assert_eq!((ray(&blind, SIZE, [0.0; 2]), projected(&blind, SIZE, DVec3::ONE)), (None, None));
    }

    #[test]
    fn modes_follow_one_another() {
        assert_eq!(Mode::Turntable.next().next().next(), Mode::Turntable);
        assert!(Mode::ALL.iter().all(|(name, mode)| mode.name() == *name));
    }
}
