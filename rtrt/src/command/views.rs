//! The views of a scene that a run renders.

use super::Error;
use super::job::RenderJob;
use super::options::RenderOptions;
use super::poses::{Pose, plain};
use glam::{DVec3, Vec3};
use rtrt::import::framing_from;
use rtrt_core::scene::{Camera, Scene};
use std::collections::BTreeSet;

/// A view of a scene.
#[derive(Debug, Clone)]
pub struct View {
    /// What `{camera}` becomes.
    pub name: String,
    pub from: Viewpoint,
    /// Pixels; those of `--size` if there are none.
    pub size: Option<[u32; 2]>,
    /// The time of the animation, seconds; that of the options if there is none.
    pub time: Option<f64>,
}

/// Where a view is taken from.
#[derive(Debug, Clone, Copy)]
pub enum Viewpoint {
    /// The camera of the options.
    Options,
    /// A camera of the file, by its number.
    File(usize),
    /// This camera.
    Camera(Camera),
}

/// The views that the options ask for; `poses` are those of `--cameras`.
pub fn views(options: &RenderOptions, poses: &[Pose], job: &RenderJob) -> Result<Vec<View>, Error> {
    let usual = View { name: "camera".into(), from: Viewpoint::Options, size: None, time: None };
    if !poses.is_empty() {
        let view = |pose: &Pose| View {
            name: pose.name.clone(),
            from: Viewpoint::Camera(pose.camera(job.origin)),
            size: Some(pose.size),
            time: pose.time,
        };
        return Ok(poses.iter().map(view).collect());
    }
    if let Some(count) = options.orbit {
        let cameras = orbit(&job.scene, &job.camera, count, job.is_framed().then(|| job.aspect()));
        let view = |(number, camera)| View {
            name: format!("orbit-{number:04}"),
            from: Viewpoint::Camera(camera),
            ..usual.clone()
        };
        return Ok(cameras.into_iter().enumerate().map(view).collect());
    }
    if is_all(options) {
        let names = unique(job.camera_names());
        let view = |(number, name)| View { name, from: Viewpoint::File(number), ..usual.clone() };
        return Ok(names.into_iter().enumerate().map(view).collect());
    }
    let name = job.camera_name().map(plain).filter(|name| !name.is_empty());
    Ok(vec![View { name: name.unwrap_or(usual.name), ..usual }])
}

/// Whether the options ask for every camera of the file.
pub fn is_all(options: &RenderOptions) -> bool {
    options.common.camera.camera.as_deref() == Some("all")
}

/// Whether the options ask for several views, or may.
pub fn are_many(options: &RenderOptions, poses: &[Pose]) -> bool {
    poses.len() > 1 || options.orbit.is_some_and(|count| count > 1) || is_all(options)
}

/// So many cameras around the point that a camera looks at, evenly, counterclockwise if seen from where the camera's
/// up leads. With an `aspect`, all of them are so far away that the whole scene is in view.
fn orbit(scene: &Scene, camera: &Camera, count: u32, aspect: Option<f32>) -> Vec<Camera> {
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

/// The names, each of them once, and none of them empty.
fn unique(names: Vec<String>) -> Vec<String> {
    let mut known = BTreeSet::new();
    let name = |(number, name): (usize, String)| {
        let name = if name.is_empty() { number.to_string() } else { plain(&name) };
        let name = if known.contains(&name) { format!("{name}-{number}") } else { name };
        known.insert(name.clone());
        name
    };
    names.into_iter().enumerate().map(name).collect()
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

    #[test]
    fn names_differ() {
        let names = ["a", "", "a", "b/c"].map(String::from).to_vec();
        assert_eq!(unique(names), ["a", "1", "a-2", "b_c"]);
    }
}
