//! Turntables: cameras around a point.

use crate::import::framing_from;
use glam::{DVec3, Vec3};
use rtrt_core::scene::{Camera, Scene};

/// So many cameras around the point that a camera looks at, evenly, counterclockwise if seen from where the camera's
/// up leads. With an `aspect`, all of them are so far away that the whole scene is in view.
pub fn orbit(scene: &Scene, camera: &Camera, count: u32, aspect: Option<f32>) -> Vec<Camera> {
    let middle = camera.look_at.as_dvec3();
    let offset = camera.eye.as_dvec3() - middle;
    let up = camera.up.as_dvec3();
    let up = up / up.length_squared().sqrt().max(1e-30);
    let turned = |number: u32| {
        // Rodrigues' rotation formula.
        let angle = core::f64::consts::TAU * f64::from(number) / f64::from(count);
        let (sine, cosine) = libm::sincos(angle);
        offset * cosine + up.cross(offset) * sine + up * (up.dot(offset) * (1.0 - cosine))
    };
    let offsets: Vec<DVec3> = (0..count).map(turned).collect();
    let length = |v: DVec3| v.length_squared().sqrt();
    let needed = |aspect: f32| {
        let distance = |offset: &DVec3| {
            let camera = framing_from(scene, aspect, offset.as_vec3());
            length(camera.eye.as_dvec3() - camera.look_at.as_dvec3())
        };
        offsets.iter().map(distance).fold(0.0, f64::max)
    };
    let scale = aspect.map_or(1.0, |aspect| needed(aspect) / length(offset).max(1e-30));
    let place = |offset: &DVec3| -> Vec3 { (middle + *offset * scale).as_vec3() };
    offsets.iter().map(|offset| Camera { eye: place(offset), ..*camera }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rtrt_core::scene::Projection;

    #[test]
    fn an_orbit_goes_around_evenly() {
        let projection = Projection::Perspective { fov_y: 1.0 };
        let camera =
            Camera { eye: Vec3::new(1.0, 3.0, 2.0), look_at: Vec3::X, up: Vec3::Y * 2.0, projection };
        let cameras = orbit(&Scene::new(), &camera, 4, None);
        let expected = [[1.0, 3.0, 2.0], [3.0, 3.0, 0.0], [1.0, 3.0, -2.0], [-1.0, 3.0, 0.0]];
        for (camera, eye) in cameras.iter().zip(expected) {
            assert!((camera.eye - Vec3::from(eye)).abs().max_element() < 1e-6, "{}", camera.eye);
            assert_eq!(camera.look_at, Vec3::X);
        }
        assert_eq!(cameras.len(), 4);
    }
}
