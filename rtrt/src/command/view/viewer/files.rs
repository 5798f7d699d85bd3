//! The scene's file: loading, the files beside it, environments.

use super::Viewer;
use super::loader::{Found, Fresh, Loader, Loading, Opening};
use crate::command::Error;
use crate::command::parse::{Environment, Exposure};
use crate::command::view::reproduce::quoted;
use rtrt::replace::folder;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Endings of files that are environments.
const ENVIRONMENTS: [&str; 2] = ["hdr", "exr"];

/// Endings of files that are scenes.
const SCENES: [&str; 5] = ["glb", "gltf", "obj", "ply", "stl"];

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

    /// Surrounds the scene with another environment: at once in a replay, else when [`Self::open_environment_now`] is
    /// called. The last one counts.
    pub fn open_environment(&mut self, environment: Environment) {
        self.say(format!("opening {}", named(&environment)));
        self.surrounding = Some(environment);
        if self.is_exact {
            self.open_environment_now();
        }
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

    /// Whether an environment waits to be opened. It waits for a scene that is being loaded.
    pub fn has_to_open(&self) -> bool {
        self.surrounding.is_some() && self.loading.is_none()
    }

    /// Opens the environment that waits.
    pub fn open_environment_now(&mut self) {
        if let Some(environment) = self.surrounding.take() {
            let surrounded = self.surround(environment);
            self.note(surrounded);
        }
    }

    /// Whether a scene is being loaded.
    pub fn is_loading(&self) -> bool {
        self.loading.is_some()
    }

    /// Has a scene opened: at once in a replay, else by a thread, after the one that is being loaded. The last one counts.
    fn ask(&mut self, opening: Opening) {
        if self.loading.is_some() {
            self.opening = Some(opening);
            return;
        }
        let name = match &opening {
            Opening::Again => self.options.scene.display().to_string(),
            Opening::Scene(path) => path.display().to_string(),
            Opening::Beside(path, places) => {
                match beside(path.as_ref().unwrap_or(&self.options.scene), *places) {
                    Some(path) => path.display().to_string(),
                    None => return self.say("the folder has no other scene".into()),
                }
            }
        };
        self.say(format!("opening {name}"));
        let (options, console) = (self.options.clone(), Arc::clone(&self.console));
        let loader = Loader { options, console, grows: !self.is_exact };
        if self.is_exact {
            return self.take(loader.open(opening));
        }
        let waker = Arc::clone(&self.waker);
        let thread = std::thread::spawn(move || {
            let found = loader.open(opening);
            waker();
            found
        });
        self.loading = Some(Loading { name, thread });
    }

    /// Shows a scene that has been loaded, and has the next one loaded.
    pub(super) fn take_loaded(&mut self) {
        let Some(Loading { thread, .. }) = self.loading.take_if(|loading| loading.thread.is_finished())
        else {
            return;
        };
        let found = thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        self.take(found);
        if let Some(opening) = self.opening.take() {
            self.ask(opening);
        }
    }

    /// Shows what an opening has found. The files that were passed are named.
    fn take(&mut self, found: Result<Found, Error>) {
        let Found { fresh, passed } = match found {
            Ok(found) => found,
            Err(error) => return self.note(Err(error)),
        };
        let passed = passed.join(", ");
        match fresh {
            Some(fresh) => {
                self.show(*fresh);
                let shown = self.scene().display();
                let text = if passed.is_empty() {
                    format!("loaded {shown}")
                } else {
                    format!("loaded {shown}; passed {passed}")
                };
                self.say(text);
            }
            None if passed.is_empty() => {}
            None => self.say(format!("the folder has no other scene that can be loaded; passed {passed}")),
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
        let opening = match self.opening.take() {
            Some(Opening::Scene(path)) => Opening::Beside(Some(path), places),
            Some(Opening::Beside(path, before)) => Opening::Beside(path, before + places),
            Some(Opening::Again) | None => Opening::Beside(None, places),
        };
        self.ask(opening);
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

    /// Shows another scene, or the same again.
    fn show(&mut self, Fresh { job, options, tree, is_other }: Fresh) {
        let camera = self.job.camera;
        self.start = job.camera;
        if options.exposure == Exposure::Auto {
            self.settings.exposure = job.exposure;
        }
        self.tree_of = (!self.is_exact).then(|| job.scene.id());
        (self.job, self.options, self.tree) = (job, options, tree);
        (self.time, self.is_playing) = (self.options.start(), false);
        (self.has_own_lights, self.has_own_colors) = (false, false);
        (self.selection, self.controls.pivot) = (None, None);
        self.unpainted.clear();
        self.is_at_start |= is_other;
        if !self.is_at_start {
            self.job.camera = camera;
        }
        self.touch();
        self.remember();
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

/// Whether two paths name the same file of one folder.
pub(super) fn is_same(a: &Path, b: &Path) -> bool {
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
pub(super) fn beside(path: &Path, places: i32) -> Option<PathBuf> {
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
