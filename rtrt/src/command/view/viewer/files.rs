//! The scene's file: loading, the files beside it, environments.

use super::Viewer;
use crate::command::Error;
use crate::command::job::RenderJob;
use crate::command::options::CameraOptions;
use crate::command::parse::{Environment, Exposure};
use crate::command::render::SAMPLES;
use crate::command::view::reproduce::quoted;
use std::path::{Path, PathBuf};

/// Endings of files that are environments.
const ENVIRONMENTS: [&str; 2] = ["hdr", "exr"];

impl Viewer {
    /// Opens a file: a scene, or an environment.
    pub fn open(&mut self, path: PathBuf) -> Result<(), Error> {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        if ending.is_some_and(|ending| ENVIRONMENTS.contains(&&*ending)) {
            return self.surround(path);
        }
        self.load(Some(path));
        Ok(())
    }

    /// Surrounds the scene with a panorama.
    fn surround(&mut self, path: PathBuf) -> Result<(), Error> {
        self.job.surround_with(Environment::At(path.clone()))?;
        self.options.surroundings.environment = Some(Environment::At(path.clone()));
        self.passed_on.retain(|option| !option.starts_with("--environment "));
        self.passed_on.push(format!("--environment {}", quoted(&path)));
        self.touch();
        self.say(format!("environment: {}", path.display()));
        Ok(())
    }

    /// Opens the file so many places behind this one in its folder.
    pub fn open_beside(&mut self, places: i32) {
        match beside(&self.options.scene, places) {
            Some(path) => self.load(Some(path)),
            None => self.say("no other scene in the folder".into()),
        }
    }

    /// Loads the scene again, or another one. On a failure the scene does not change.
    pub fn load(&mut self, scene: Option<PathBuf>) {
        let is_other = scene.is_some();
        let mut options = self.options.clone();
        if let Some(scene) = scene {
            options.scene = scene;
            // These options belong to the previous scene.
            options.camera = CameraOptions::default();
            (options.time, options.animation) = (None, None);
            (options.hide, options.materials) = (Vec::new(), Vec::new());
        }
        let backend = self.engines.drawing_mut().backend();
        let job = RenderJob::load(&options, SAMPLES, false, options.start(), &self.console);
        let job = job.and_then(|mut job| job.expose(backend, &self.console).map(|()| job));
        self.console.finish();
        match job {
            Ok(job) => {
                let camera = self.job.camera;
                self.start = job.camera;
                if options.exposure == Exposure::Auto {
                    self.settings.exposure = job.exposure;
                }
                self.job = job;
                self.options = options;
                (self.time, self.is_playing) = (self.options.start(), false);
                (self.has_own_lights, self.has_own_colors) = (false, false);
                (self.selection, self.controls.pivot) = (None, None);
                self.unpainted.clear();
                self.is_at_start |= is_other;
                if !self.is_at_start {
                    self.job.camera = camera;
                }
                self.touch();
                self.say(format!("loaded {}", self.scene().display()));
                self.remember();
            }
            Err(error) => self.note(Err(error)),
        }
    }
}

/// The scene so many places behind a file, among those of its folder in the order of their names; the first follows the
/// last. None if there is no other.
fn beside(path: &Path, places: i32) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_scene = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        ending.is_some_and(|ending| ["glb", "gltf", "obj", "ply", "stl"].contains(&&*ending))
    };
    let mut files: Vec<_> =
        std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).filter(is_scene).collect();
    files.sort();
    let here = files.iter().position(|file| file.file_name() == path.file_name())?;
    let there = (here as i64 + i64::from(places)).rem_euclid(files.len() as i64) as usize;
    (there != here).then(|| files.swap_remove(there))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_follow_one_another_by_name() {
        let folder = std::env::temp_dir().join(format!("rtrt-beside-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for name in ["b.glb", "a.obj", "c.STL", "readme.txt", "d.hdr"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        let at = |name: &str, places| beside(&folder.join(name), places);
        assert_eq!(at("a.obj", 1), Some(folder.join("b.glb")));
        assert_eq!(at("c.STL", 1), Some(folder.join("a.obj")));
        assert_eq!(at("a.obj", -1), Some(folder.join("c.STL")));
        assert_eq!((at("gone.obj", 1), at("a.obj", 3)), (None, None));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
