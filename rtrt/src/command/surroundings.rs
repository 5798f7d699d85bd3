//! What surrounds the scene: an environment, and the light that goes with it.

use super::Error;
use super::options::{Common, SurroundingsOptions};
use super::parse::{Environment, EnvironmentSun};
use rtrt::import::{ImportError, Surroundings, surround, surround_with_studio};
use rtrt_core::scene::Scene;

/// How blurred an environment is behind everything if nothing is said.
pub fn default_blur(is_studio: bool) -> f32 {
    if is_studio { 1.0 } else { 0.0 }
}

/// What was done.
#[derive(Debug, Default)]
#[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "the viewer prints options that do the same"))]
pub struct Surrounded {
    /// The environment's files, and its sun.
    pub surroundings: Surroundings,
    /// Whether there is an environment.
    pub has_environment: bool,
    /// Whether it is the studio.
    pub is_studio: bool,
    /// Whether that is so although nobody asked for it.
    pub is_default: bool,
    /// Which of the scene's lights is the sun.
    pub sun: Option<usize>,
}

/// Surrounds the scene as the options say. A scene without lights for which they say nothing, neither of
/// lights nor of ambient light, is in the studio.
pub fn surrounded(scene: &mut Scene, common: &Common) -> Result<Surrounded, Error> {
    let SurroundingsOptions { environment, rotation, intensity, blur, sun, .. } = &common.surroundings;
    let is_lit = !scene.lights().is_empty();
    let is_default = environment.is_none() && !is_lit && common.ambient.is_none();
    let is_studio = is_default || *environment == Some(Environment::Studio);
    scene.environment_rotation = *rotation;
    scene.environment_intensity = *intensity;
    scene.environment_blur = blur.unwrap_or(default_blur(is_studio));
    let surroundings = match environment {
        Some(Environment::At(path)) => surround(scene, path, *sun != EnvironmentSun::Keep)?,
        _ if is_studio => {
            let path = &common.scene;
            surround_with_studio(scene).map_err(|source| ImportError::Scene { path: path.clone(), source })?
        }
        _ => {
            scene.remove_environment();
            return Ok(Surrounded::default());
        }
    };
    // The studio's key light is for scenes that have none.
    let has_sun = *sun == EnvironmentSun::Light && !(is_studio && is_lit);
    let light = surroundings.placed_sun(scene).filter(|_| has_sun);
    let sun = light.map(|light| {
        scene.add_light(light);
        scene.lights().len() - 1
    });
    Ok(Surrounded { surroundings, has_environment: true, is_studio, is_default, sun })
}
