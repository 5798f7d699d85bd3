//! The scene's file: loading, the files beside it, environments.

use super::{Viewer, pick};
use crate::command::Error;
use crate::command::job::RenderJob;
use crate::command::options::CameraOptions;
use crate::command::parse::{Environment, Exposure};
use crate::command::render::SAMPLES;
use crate::command::view::reproduce::quoted;
use rtrt::replace::folder;
use std::path::{Path, PathBuf};

/// Endings of files that are environments.
const ENVIRONMENTS: [&str; 2] = ["hdr", "exr"];

/// Endings of files that are scenes.
const SCENES: [&str; 5] = ["glb", "gltf", "obj", "ply", "stl"];

/// What is to be opened.
#[derive(Debug, PartialEq)]
pub enum Opening {
    /// The scene, which may have changed.
    Again,
    Scene(PathBuf),
    /// The scene so many places behind a file in its folder. Those that cannot be loaded are passed.
    Beside(PathBuf, i32),
    Environment(Environment),
}

impl Opening {
    fn is_environment(&self) -> bool {
        matches!(self, Self::Environment(_))
    }
}

impl Viewer {
    /// Opens a file: a scene, or an environment.
    pub fn open(&mut self, path: PathBuf) {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        let is_environment = ending.is_some_and(|ending| ENVIRONMENTS.contains(&&*ending));
        if is_environment {
            self.open_environment(Environment::At(path));
        } else {
            self.ask(Opening::Scene(path));
        }
    }

    /// Surrounds the scene with another environment.
    pub fn open_environment(&mut self, environment: Environment) {
        self.ask(Opening::Environment(environment));
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
            Opening::Again => self.options.scene.display().to_string(),
            Opening::Scene(path) => path.display().to_string(),
            Opening::Beside(path, places) => match beside(path, *places) {
                Some(path) => path.display().to_string(),
                None => return self.say("the folder has no other scene".into()),
            },
            Opening::Environment(environment) => named(environment),
        };
        self.say(format!("opening {name}"));
        let kind = opening.is_environment();
        self.openings.retain(|other| other.is_environment() != kind);
        self.openings.push(opening);
        if self.is_exact {
            self.open_files();
        }
    }

    /// Opens the files that wait.
    pub fn open_files(&mut self) {
        for opening in std::mem::take(&mut self.openings) {
            let opened = match opening {
                Opening::Again => self.load(None),
                Opening::Scene(path) => self.load(Some(path)),
                Opening::Beside(path, places) => self.load_beside(&path, places),
                Opening::Environment(environment) => self.surround(environment),
            };
            self.note(opened);
        }
    }

    /// Surrounds the scene with another environment, which is turned and as bright as the one before.
    fn surround(&mut self, environment: Environment) -> Result<(), Error> {
        self.job.surround_with(environment.clone())?;
        let name = named(&environment);
        self.passed_on.retain(|option| !option.starts_with("--environment "));
        self.passed_on.push(format!("--environment {}", quoted(Path::new(&name))));
        self.options.surroundings.environment = Some(environment);
        self.touch();
        self.say(format!("environment: {name}"));
        Ok(())
    }

    /// Opens the file so many places behind this one in its folder.
    pub fn open_beside(&mut self, places: i32) {
        let waits = self.openings.iter().find(|opening| !opening.is_environment());
        let opening = match waits {
            Some(Opening::Scene(path)) => Opening::Beside(path.clone(), places),
            Some(Opening::Beside(path, before)) => Opening::Beside(path.clone(), before + places),
            _ => Opening::Beside(self.options.scene.clone(), places),
        };
        self.ask(opening);
    }

    /// Loads the scene so many places behind a file, or the first one behind it in the same direction that can be
    /// loaded. The others are named.
    fn load_beside(&mut self, path: &Path, places: i32) -> Result<(), Error> {
        let (mut path, mut places, mut passed) = (path.to_owned(), places, Vec::new());
        while let Some(next) = beside(&path, places).filter(|next| !is_same(next, &self.options.scene)) {
            let Err(error) = self.load(Some(next.clone())) else {
                if !passed.is_empty() {
                    self.say(format!("loaded {}; passed {}", next.display(), passed.join(", ")));
                }
                return Ok(());
            };
            if passed.contains(&file_name(&next)) {
                break;
            }
            self.console.warn(3, format_args!("{} is passed: {error}", next.display()))?;
            passed.push(file_name(&next));
            (path, places) = (next, places.signum());
        }
        if !passed.is_empty() {
            self.say(format!(
                "the folder has no other scene that can be loaded; passed {}",
                passed.join(", ")
            ));
        }
        Ok(())
    }

    /// The environments that can be chosen: files beside the scene, and the one in use.
    pub fn environments(&self) -> Vec<PathBuf> {
        let mut files = files_in(folder(&self.options.scene), &ENVIRONMENTS);
        if let Some(Environment::At(path)) = &self.options.surroundings.environment
            && !files.iter().any(|file| is_same(file, path))
        {
            files.push(path.clone());
        }
        files
    }

    /// The environment in use.
    pub fn environment(&self) -> Environment {
        match &self.options.surroundings.environment {
            Some(environment) => environment.clone(),
            None if self.job.surrounded.is_studio => Environment::Studio,
            None => Environment::Nothing,
        }
    }

    /// Loads the scene again, or another one. On a failure the scene does not change.
    fn load(&mut self, scene: Option<PathBuf>) -> Result<(), Error> {
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
        let job = job?;
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
        Ok(())
    }
}

/// An environment, as an option names it.
pub fn named(environment: &Environment) -> String {
    match environment {
        Environment::Nothing => "none".into(),
        Environment::Studio => "studio".into(),
        Environment::At(path) => match path.to_str() {
            // A file of the name of another environment.
            Some(name @ ("none" | "studio")) => format!("./{name}"),
            _ => path.display().to_string(),
        },
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Whether two paths name the same file of one folder.
fn is_same(a: &Path, b: &Path) -> bool {
    a.file_name() == b.file_name() && folder(a) == folder(b)
}

/// The files of a folder with one of these endings, in the order of their names.
fn files_in(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let is_one = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        ending.is_some_and(|ending| endings.contains(&&*ending))
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries.map(|entry| entry.path()).filter(is_one).collect();
    files.sort();
    files
}

/// The scene so many places behind a file, which may be gone, among those of its folder in the order of their names; the
/// first follows the last. None if there is no other.
fn beside(path: &Path, places: i32) -> Option<PathBuf> {
    let folder = folder(path);
    if !folder.is_dir() {
        return None;
    }
    let mut files = files_in(folder, &SCENES);
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
