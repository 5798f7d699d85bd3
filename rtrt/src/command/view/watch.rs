//! Whether files have changed since they were last looked at.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How often the files are looked at.
pub const EVERY: Duration = Duration::from_millis(300);

/// What is known of a file at a time: its length, and when it was written; none if it is not there.
type State = Option<(u64, SystemTime)>;

/// Files that are watched.
#[derive(Debug)]
pub struct Watch {
    /// The scene's own.
    scene: PathBuf,
    paths: Vec<PathBuf>,
    /// As they were when [`Watch::has_changed`] last said so, or in the beginning.
    known: Vec<State>,
    /// As they were when they were last looked at.
    last: Vec<State>,
    next: Instant,
}

impl Watch {
    pub fn new(scene: &Path, paths: &[PathBuf]) -> Self {
        let known = states(paths);
        let (scene, paths, last) = (scene.to_owned(), paths.to_owned(), known.clone());
        Self { scene, paths, known, last, next: Instant::now() + EVERY }
    }

    /// Watches these files, if it does not already.
    pub fn follow(&mut self, scene: &Path, paths: &[PathBuf]) {
        if self.scene != scene || self.paths != paths {
            *self = Self::new(scene, paths);
        }
    }

    /// Whether one of the files is another one, and all are at rest: whoever writes them is done, as
    /// far as one can tell. Looks at them only now and then, and while the scene's own file is there.
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
    fn a_change_is_told_once_and_only_when_it_is_over() {
        let state = |length| vec![Some((7, SystemTime::UNIX_EPOCH)), Some((length, SystemTime::UNIX_EPOCH))];
        let gone = || vec![Some((7, SystemTime::UNIX_EPOCH)), None];
        let mut watch = Watch::new(Path::new(""), &[]);
        (watch.known, watch.last) = (state(1), state(1));
        assert!(!watch.look(state(1)));
        // Being written, gone for a moment, written.
        assert!(!watch.look(state(2)) && !watch.look(gone()) && !watch.look(state(3)));
        assert!(watch.look(state(3)));
        assert!(!watch.look(state(3)));
        // A texture that is gone for good is a change too.
        assert!(!watch.look(gone()) && watch.look(gone()) && !watch.look(gone()));
    }
}
