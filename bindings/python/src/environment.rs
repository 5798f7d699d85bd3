//! Light from all around.

use crate::arrays::refused;
use crate::file::import_error;
use crate::given::panorama;
use crate::scene::Scene;
use pyo3::exceptions::{PyFileNotFoundError, PyValueError};
use pyo3::prelude::*;
use rtrt::import;
use rtrt_core::scene::Backdrop;
use std::path::PathBuf;

/// The most degrees that an environment is turned by: 1024 radians.
const MOST_TURN: f32 = 58_670.0;

/// How an environment lights a scene.
pub struct Options {
    /// Degrees.
    pub rotation: f32,
    pub intensity: f32,
    pub blur: f32,
    pub sun: bool,
}

/// Surrounds the scene with light.
pub fn set(py: Python<'_>, scene: &Scene, source: &Bound<'_, PyAny>, options: &Options) -> PyResult<()> {
    let Options { rotation, intensity, blur, sun } = *options;
    for (name, value, high) in [
        ("rotation", rotation.abs(), MOST_TURN),
        ("intensity", intensity, 4_294_967_296.0),
        ("blur", blur, 1.0),
    ] {
        if !(0.0..=high).contains(&value) {
            return Err(PyValueError::new_err(format!("{name} is {value}, which is not within 0 .. {high}")));
        }
    }
    let path: Option<PathBuf> = source.extract().ok();
    if let Some(path) = path.as_ref().filter(|path| path.as_os_str() != "studio" && !path.exists()) {
        return Err(PyFileNotFoundError::new_err(format!("there is no environment {}", path.display())));
    }
    let panorama = if path.is_some() { None } else { Some(panorama(source)?) };
    let scene = &mut scene.change()?.scene;
    py.detach(|| {
        let surroundings = match (path, panorama) {
            (Some(path), _) if path.as_os_str() == "studio" => {
                import::surround_with_studio(scene).map_err(refused)?
            }
            (Some(path), _) => import::surround(scene, &path, sun).map_err(|error| import_error(&error))?,
            (None, Some(mut panorama)) => {
                let light = sun.then(|| panorama.take_sun()).flatten();
                scene.set_environment(&panorama).map_err(refused)?;
                import::Surroundings { files: vec![], sun: light }
            }
            (None, None) => return Ok(()),
        };
        (scene.environment_rotation, scene.environment_intensity) = (rotation.to_radians(), intensity);
        scene.environment_blur = blur;
        if let Some(light) = surroundings.placed_sun(scene).filter(|_| sun) {
            scene.add_light(light);
        }
        scene.backdrop = Backdrop::Environment;
        Ok(())
    })
}
