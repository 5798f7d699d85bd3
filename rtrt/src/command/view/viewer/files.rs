//! The scene's file: loading, the files beside it, environments.

use super::{Viewer, pick};
use crate::command::Error;
use crate::command::job::RenderJob;
use crate::command::options::CameraOptions;
use crate::command::parse::{Environment, Exposure};
use crate::command::render::SAMPLES;
use crate::command::view::reproduce::quoted;
use std::path::{Path, PathBuf};

/// Endings of files that are environments.
const ENVIRONMENTS: [&str; 2] = ["hdr", "exr"];

/// What is to be opened.
#[derive(Debug, PartialEq, Eq)]
pub enum Opening {
    /// The scene, which may have changed.
    Again,
    Scene(PathBuf),
    Environment(PathBuf),
}

impl Viewer {
    /// Opens a file: a scene, or an environment.
    pub fn open(&mut self, path: PathBuf) {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        let is_environment = ending.is_some_and(|ending| ENVIRONMENTS.contains(&&*ending));
        self.ask(if is_environment { Opening::Environment(path) } else { Opening::Scene(path) });
    }

    /// Loads the scene again.
    pub fn open_again(&mut self) {
        self.ask(Opening::Again);
    }

    /// Says that the scene's file is gone. The scene stays.
    pub fn miss(&mut self) {
        let text = format!("{} is gone", self.options.scene.display());
        self.console.say(&text);
        self.say(text);
    }

    /// Whether files wait to be opened.
    pub fn has_to_open(&self) -> bool {
        !self.openings.is_empty()
    }

    /// Has a file opened: at once by a replay, else by whoever calls [`Self::open_files`]. The last scene counts.
    fn ask(&mut self, opening: Opening) {
        let name = match &opening {
            Opening::Again => &self.options.scene,
            Opening::Scene(path) | Opening::Environment(path) => path,
        };
        self.say(format!("opening {}", name.display()));
        let is_environment = |opening: &Opening| matches!(opening, Opening::Environment(_));
        let kind = is_environment(&opening);
        self.openings.retain(|other| is_environment(other) != kind);
        self.openings.push(opening);
        if self.is_exact {
            self.open_files();
        }
    }

    /// Opens the files that wait.
    pub fn open_files(&mut self) {
        for opening in std::mem::take(&mut self.openings) {
            match opening {
                Opening::Again => self.load(None),
                Opening::Scene(path) => self.load(Some(path)),
                Opening::Environment(path) => {
                    let surrounded = self.surround(path);
                    self.note(surrounded);
                }
            }
        }
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
        let waits = self.openings.iter().find_map(|opening| match opening {
            Opening::Scene(path) => Some(path),
            _ => None,
        });
        match beside(waits.unwrap_or(&self.options.scene), places) {
            Some(path) => self.open(path),
            None => self.say("no other scene in the folder".into()),
        }
    }

    /// Loads the scene again, or another one. On a failure the scene does not change.
    fn load(&mut self, scene: Option<PathBuf>) {
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
                if !self.is_exact {
                    pick::grow(&mut self.tree, &self.job.scene, &self.console);
                    self.tree_of = Some(self.job.scene.id());
                }
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

/// The scene so many places behind a file, which may be gone, among those of its folder in the order of their names; the
/// first follows the last. None if there is no other.
fn beside(path: &Path, places: i32) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_scene = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        ending.is_some_and(|ending| ["glb", "gltf", "obj", "ply", "stl"].contains(&&*ending))
    };
    let mut files: Vec<_> =
        std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).filter(is_scene).collect();
    files.sort();
    if !files.iter().any(|file| file.file_name() == path.file_name()) {
        files.push(folder.join(path.file_name()?));
        files.sort();
    }
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
        // One that is gone has neighbors.
        assert_eq!(at("bb.obj", 1), Some(folder.join("c.STL")));
        assert_eq!(at("bb.obj", -1), Some(folder.join("b.glb")));
        assert_eq!((at("a.obj", 3), beside(&folder.join("none/a.obj"), 1)), (None, None));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
