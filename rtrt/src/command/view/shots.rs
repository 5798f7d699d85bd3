//! Screenshots that are made beside the window.

use super::viewer::Waker;
use crate::command::Error;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// The screenshots in progress. Threads make them, one after the other. Clones share them.
#[derive(Clone)]
pub struct Shots {
    shots: Arc<Mutex<Vec<Shot>>>,
    /// Held by the thread whose turn it is.
    turn: Arc<Mutex<()>>,
    /// Wakes the window.
    waker: Waker,
}

/// A screenshot in progress.
struct Shot {
    path: PathBuf,
    thread: JoinHandle<Result<(), Error>>,
    is_done: Arc<AtomicBool>,
}

impl Shot {
    /// What became of it. Waits for that.
    fn written(self) -> (PathBuf, Result<(), Error>) {
        (self.path, self.thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
    }
}

impl Shots {
    /// None yet.
    pub fn new(waker: Waker) -> Self {
        Self { shots: Arc::default(), turn: Arc::default(), waker }
    }

    fn shots(&self) -> MutexGuard<'_, Vec<Shot>> {
        self.shots.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Has a thread make and write a picture.
    pub fn begin(&self, path: PathBuf, make: impl FnOnce() -> Result<(), Error> + Send + 'static) {
        let (turn, waker) = (Arc::clone(&self.turn), Waker::clone(&self.waker));
        let is_done = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&is_done);
        let thread = std::thread::spawn(move || {
            let written = {
                let _turn = turn.lock().unwrap_or_else(PoisonError::into_inner);
                make()
            };
            flag.store(true, Ordering::Relaxed);
            waker();
            written
        });
        self.shots().push(Shot { path, thread, is_done });
    }

    /// The picture that is being made.
    pub fn in_progress(&self) -> Option<PathBuf> {
        self.shots().first().map(|shot| shot.path.clone())
    }

    /// Whether a picture of this name is being made.
    pub fn has(&self, path: &Path) -> bool {
        self.shots().iter().any(|shot| shot.path == path)
    }

    /// The pictures that are done, with what became of them; each once.
    pub fn done(&self) -> Vec<(PathBuf, Result<(), Error>)> {
        let is_done = |shot: &mut Shot| shot.is_done.load(Ordering::Relaxed) || shot.thread.is_finished();
        let done: Vec<Shot> = self.shots().extract_if(.., is_done).collect();
        done.into_iter().map(Shot::written).collect()
    }

    /// Waits for all pictures.
    pub fn all(&self) -> Vec<(PathBuf, Result<(), Error>)> {
        let all = std::mem::take(&mut *self.shots());
        all.into_iter().map(Shot::written).collect()
    }
}
