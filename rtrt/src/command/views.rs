//! The views of a scene that a run renders.

use super::Error;
use super::job::RenderJob;
use super::options::RenderOptions;
use rtrt::orbit::orbit;
use rtrt::poses::{Pose, plain};
use rtrt_core::scene::Camera;
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
    /// This camera, with the depths of its near and its far plane.
    Camera(Camera, [f32; 2]),
}

/// The views that the options ask for; `poses` are those of `--cameras`.
pub fn views(options: &RenderOptions, poses: &[Pose], job: &RenderJob) -> Result<Vec<View>, Error> {
    let usual = View { name: "camera".into(), from: Viewpoint::Options, size: None, time: None };
    if !poses.is_empty() {
        let view = |pose: &Pose| View {
            name: pose.name.clone(),
            from: Viewpoint::Camera(pose.camera(job.origin), pose.clip),
            size: Some(pose.size),
            time: pose.time,
        };
        return Ok(poses.iter().map(view).collect());
    }
    if let Some(count) = options.orbit {
        let cameras = orbit(&job.scene, &job.camera, count, job.is_framed().then(|| job.aspect()));
        let view = |(number, camera)| View {
            name: format!("orbit-{number:04}"),
            from: Viewpoint::Camera(camera, job.clip),
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

/// Names that are taken.
#[derive(Default)]
pub struct Names(BTreeSet<String>);

impl Names {
    /// Takes a name: with this number behind it, once or more, if it is taken.
    pub fn take(&mut self, name: &str, number: usize) -> String {
        let mut name = name.to_owned();
        while !self.0.insert(name.clone()) {
            name = format!("{name}-{number}");
        }
        name
    }
}

/// The names, each of them once, and none of them empty.
fn unique(names: Vec<String>) -> Vec<String> {
    let mut taken = Names::default();
    let name = |(number, name): (usize, String)| {
        let name = if name.is_empty() { number.to_string() } else { plain(&name) };
        taken.take(&name, number)
    };
    names.into_iter().enumerate().map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_differ() {
        let names = ["a", "", "a", "b/c", "a-5", "a"].map(String::from).to_vec();
        assert_eq!(unique(names), ["a", "1", "a-2", "b_c", "a-5", "a-5-5"]);
    }
}
