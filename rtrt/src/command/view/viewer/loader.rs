//! Scenes that a thread loads while the viewer goes on.

use super::files::{beside, is_same};
use super::pick;
use crate::command::Error;
use crate::command::console::Console;
use crate::command::job::RenderJob;
use crate::command::options::{CameraOptions, Common};
use crate::command::parse::Exposure;
use crate::command::render::SAMPLES;
use crate::command::view::engine::Engine;
use rtrt_core::query::Tree;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

/// A scene that is to be opened.
#[derive(Debug, PartialEq)]
pub enum Opening {
    /// The scene, which may have changed.
    Again,
    Scene(PathBuf),
    /// The scene so many places behind a file in its folder; behind the one that is shown if none is named. Those that
    /// cannot be loaded are passed.
    Beside(Option<PathBuf>, i32),
}

/// What a scene is loaded with.
pub struct Loader {
    /// The options of the scene that is shown.
    pub options: Common,
    pub console: Arc<Console>,
    /// Whether trees for rays are made too.
    pub grows: bool,
}

/// A loaded scene.
pub struct Fresh {
    pub job: RenderJob,
    pub options: Common,
    pub tree: Tree,
    /// Whether it is another one than before.
    pub is_other: bool,
}

/// What came of an opening: a scene, if there was one, and the names of the files that were passed.
pub struct Found {
    pub fresh: Option<Box<Fresh>>,
    pub passed: Vec<String>,
}

/// A scene that is being loaded.
pub struct Loading {
    /// Where it is, in words.
    pub name: String,
    pub thread: JoinHandle<Result<Found, Error>>,
}

impl Loader {
    /// Opens a scene.
    pub fn open(&self, opening: Opening) -> Result<Found, Error> {
        let fresh = match opening {
            Opening::Again => self.load(None)?,
            Opening::Scene(path) => self.load(Some(path))?,
            Opening::Beside(path, places) => {
                return self.load_beside(path.as_ref().unwrap_or(&self.options.scene), places);
            }
        };
        Ok(Found { fresh: Some(Box::new(fresh)), passed: Vec::new() })
    }

    /// Loads the scene so many places behind a file, or the first one behind it in the same direction that can be
    /// loaded.
    fn load_beside(&self, path: &Path, places: i32) -> Result<Found, Error> {
        let (mut path, mut places, mut passed) = (path.to_owned(), places, Vec::new());
        while let Some(next) = beside(&path, places).filter(|next| !is_same(next, &self.options.scene)) {
            let error = match self.load(Some(next.clone())) {
                Ok(fresh) => return Ok(Found { fresh: Some(Box::new(fresh)), passed }),
                Err(error) => error,
            };
            if passed.contains(&file_name(&next)) {
                break;
            }
            self.console.warn(3, format_args!("{} is passed: {error}", next.display()))?;
            passed.push(file_name(&next));
            (path, places) = (next, places.signum());
        }
        Ok(Found { fresh: None, passed })
    }

    /// Loads the scene again, or another one.
    fn load(&self, scene: Option<PathBuf>) -> Result<Fresh, Error> {
        let is_other = scene.is_some();
        let mut options = self.options.clone();
        if let Some(scene) = scene {
            options.scene = scene;
            // These options belong to the previous scene.
            options.camera = CameraOptions::default();
            (options.time, options.animation) = (None, None);
            (options.hide, options.materials) = (Vec::new(), Vec::new());
        }
        let job = RenderJob::load(&options, SAMPLES, false, options.start(), &self.console);
        let job = job.and_then(|job| self.exposed(job, &options));
        self.console.finish();
        let mut fresh = Fresh { job: job?, options, tree: Tree::default(), is_other };
        if self.grows {
            pick::grow(&mut fresh.tree, &fresh.job.scene, &self.console);
        }
        Ok(fresh)
    }

    /// The job with the exposure of its options. The CPU meters, with the bits of every backend.
    fn exposed(&self, mut job: RenderJob, options: &Common) -> Result<RenderJob, Error> {
        if options.exposure == Exposure::Auto {
            job.expose(Engine::cpu(&options.backend)?.backend(), &self.console)?;
        }
        Ok(job)
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
