//! Detection of changed files.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// The interval of checks.
pub const EVERY: Duration = Duration::from_millis(300);

/// The length of a file, and its time of modification; none for a missing file.
type State = Option<(u64, SystemTime)>;

/// What has happened to the watched files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// A file is another one, or is gone; the scene's file is there.
    Changed,
    /// The scene's file is gone.
    Gone,
}

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
    /// The checks that have not found the scene's file since it was there.
    missed: u32,
    next: Instant,
}

impl Watch {
    pub fn new(scene: &Path, paths: &[PathBuf]) -> Self {
        let known = states(paths);
        let (scene, paths, last) = (scene.to_owned(), paths.to_owned(), known.clone());
        Self { scene, paths, known, last, missed: 0, next: Instant::now() + EVERY }
    }

    /// Watches these files from now on.
    pub fn follow(&mut self, scene: &Path, paths: &[PathBuf]) {
        if self.scene != scene || self.paths != paths {
            *self = Self::new(scene, paths);
        }
    }

    /// A change after which no file changed until the next check, so that writers are probably done; each once.
    /// Checks the files once per interval.
    pub fn change(&mut self, now: Instant) -> Option<Change> {
        if now < self.next {
            return None;
        }
        self.next = now + EVERY;
        let exists = self.scene.exists();
        if self.misses(exists) {
            return Some(Change::Gone);
        }
        (exists && self.look(states(&self.paths))).then_some(Change::Changed)
    }

    /// Whether the scene's file is missed for the second time: writers may replace it.
    fn misses(&mut self, exists: bool) -> bool {
        self.missed = if exists { 0 } else { self.missed.saturating_add(1) };
        self.missed == 2
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

    #[test]
    fn a_scene_that_is_gone_is_reported_once_each_time() {
        let mut watch = Watch::new(Path::new(""), &[]);
        let checks = [true, false, true, false, false, false, true, false, false];
        let reports = checks.map(|exists| watch.misses(exists));
        assert_eq!(reports, [false, false, false, false, true, false, false, false, true]);
    }
}
