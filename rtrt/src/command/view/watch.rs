//! Detection of changed files.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// The interval of checks.
pub const EVERY: Duration = Duration::from_millis(300);

/// The length of a file, and its time of modification; none for a missing file.
type State = Option<(u64, SystemTime)>;

/// A set of watched files.
#[derive(Debug)]
pub struct Watch {
    /// The scene's file.
    scene: PathBuf,
    paths: Vec<PathBuf>,
    /// The states at the last reported change, or at the start.
    known: Vec<State>,
    /// The states at the last check.
    last: Vec<State>,
    next: Instant,
}

impl Watch {
    pub fn new(scene: &Path, paths: &[PathBuf]) -> Self {
        let known = states(paths);
        let (scene, paths, last) = (scene.to_owned(), paths.to_owned(), known.clone());
        Self { scene, paths, known, last, next: Instant::now() + EVERY }
    }

    /// Watches these files from now on.
    pub fn follow(&mut self, scene: &Path, paths: &[PathBuf]) {
        if self.scene != scene || self.paths != paths {
            *self = Self::new(scene, paths);
        }
    }

    /// Whether a file has changed and no file changed since the last check, so that writers are probably done.
    /// Checks the files once per interval, and only while the scene's file exists.
    pub fn has_changed(&mut self, now: Instant) -> bool {
        if now < self.next {
            return false;
        }
        self.next = now + EVERY;
        self.scene.exists() && self.look(states(&self.paths))
    }

    fn look(&mut self, now: Vec<State>) -> bool {
        let is_new = now == self.last && now != self.known;
        if is_new {
            self.known.clone_from(&now);
        }
        self.last = now;
        is_new
    }
}

fn states(paths: &[PathBuf]) -> Vec<State> {
    paths.iter().map(|path| state(path)).collect()
}

fn state(path: &Path) -> State {
    let metadata = fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_reported_once_after_it_is_over() {
        let state = |length| vec![Some((7, SystemTime::UNIX_EPOCH)), Some((length, SystemTime::UNIX_EPOCH))];
        let gone = || vec![Some((7, SystemTime::UNIX_EPOCH)), None];
        let mut watch = Watch::new(Path::new(""), &[]);
        (watch.known, watch.last) = (state(1), state(1));
        assert!(!watch.look(state(1)));
        // A write in progress, a moment without the file, the end of the write.
        assert!(!watch.look(state(2)) && !watch.look(gone()) && !watch.look(state(3)));
        assert!(watch.look(state(3)));
        assert!(!watch.look(state(3)));
        // A removed texture is a change.
        assert!(!watch.look(gone()) && watch.look(gone()) && !watch.look(gone()));
    }
}
