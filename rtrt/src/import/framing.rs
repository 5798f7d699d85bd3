//! The camera of scenes without one.

use super::{Animation, ImportError};
use glam::{DVec3, Vec3};
use rtrt_core::scene::{Camera, Projection, Scene};

/// The direction from the center of a scene to its default camera: the front (+z in glTF), slightly above and
/// to the right. Any length.
const FROM: DVec3 = DVec3::new(0.4, 0.3, 1.0);
/// Its vertical field of view, radians: 45°.
const FOV_Y: f64 = core::f64::consts::FRAC_PI_4;
/// The share of the picture that the bounds may fill in either direction.
const FILL: f64 = 0.95;

/// A camera with the whole scene in view, for a picture of this `aspect` (width / height). It looks at the center
/// of the bounds from a fixed direction (front, right, above) with a vertical field of view of 45°. The bounds fill
/// 95 % of the picture's width or height. The same scene gives the same camera on every host.
pub fn framing(scene: &Scene, aspect: f32) -> Camera {
    around(scene.extent(), aspect, FROM)
}

/// [`framing`] from another direction: `from` leads from the center of the scene to the camera, and has any length.
pub fn framing_from(scene: &Scene, aspect: f32, from: Vec3) -> Camera {
    around(scene.extent(), aspect, from.as_dvec3())
}

/// [`framing`] of a whole animation: of the bounds at 33 evenly spaced times. The scene is at the end of the
/// animation afterwards.
///
/// # Errors
/// The animation moves something out of range.
pub fn framing_played(scene: &mut Scene, animation: &Animation, aspect: f32) -> Result<Camera, ImportError> {
    const STEPS: u32 = 32;
    let mut extent: Option<(Vec3, Vec3)> = None;
    for step in 0..=STEPS {
        animation.at(animation.end() * f64::from(step) / f64::from(STEPS))?.apply(scene)?;
        extent = match (extent, scene.extent()) {
            (Some((low, high)), Some((a, b))) => Some((low.min(a), high.max(b))),
            (all, now) => all.or(now),
        };
    }
    Ok(around(extent, aspect, FROM))
}

/// A camera with these bounds in view, which are in this direction of it.
fn around(extent: Option<(Vec3, Vec3)>, aspect: f32, from: DVec3) -> Camera {
    let (low, high) = extent.unwrap_or((Vec3::splat(-1.0), Vec3::splat(1.0)));
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let center = (low + high) * 0.5;
    let back = unit(from);
    let right = unit(DVec3::Y.cross(back));
    let up = back.cross(right);
    let tangent = libm::tan(FOV_Y * 0.5) * FILL;
    let aspect = if aspect.is_finite() && aspect > 0.0 { f64::from(aspect) } else { 1.0 };
    // The distance of the camera that each corner of the bounds needs.
    let distance = (0..8).map(|corner| {
        let pick = |bit: u32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
        let corner = DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z));
        let offset = corner - center;
        let across = (offset.dot(up).abs()).max(offset.dot(right).abs() / aspect);
        offset.dot(back) + across / tangent
    });
    let distance = distance.fold(0.0, f64::max);
    let distance = if distance > 0.0 { distance } else { 1.0 };
    Camera {
        eye: (center + back * distance).as_vec3(),
        look_at: center.as_vec3(),
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: FOV_Y as f32 },
    }
}

/// `v` at length 1; the z axis for a vector without a length.
fn unit(v: DVec3) -> DVec3 {
    let length = libm::sqrt(v.length_squared());
    if length > 0.0 && length.is_finite() { v / length } else { DVec3::Z }
}
