//! Whether a file has changed since it was last looked at.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How often the file is looked at.
pub const EVERY: Duration = Duration::from_millis(300);

/// What is known of a file at a time: its length, and when it was written.
type State = Option<(u64, SystemTime)>;

/// A file that is watched.
#[derive(Debug)]
pub struct Watch {
    path: PathBuf,
    /// As it was when [`Watch::has_changed`] last said so, or in the beginning.
    known: State,
    /// As it was when it was last looked at.
    last: State,
    next: Instant,
}

impl Watch {
    pub fn new(path: &Path) -> Self {
        let known = state(path);
        Self { path: path.to_owned(), known, last: known, next: Instant::now() + EVERY }
    }

    /// Whether the file is another one, and at rest: whoever writes it is done, as far as one can
    /// tell. Looks at it only now and then.
    pub fn has_changed(&mut self, now: Instant) -> bool {
        if now < self.next {
            return false;
        }
        self.next = now + EVERY;
        self.look(state(&self.path))
    }

    fn look(&mut self, now: State) -> bool {
        let is_new = now.is_some() && now == self.last && now != self.known;
        self.last = now;
        if is_new {
            self.known = now;
        }
        is_new
    }
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
        let state = |length| Some((length, SystemTime::UNIX_EPOCH));
        let mut watch = Watch { path: PathBuf::new(), known: state(1), last: state(1), next: Instant::now() };
        assert!(!watch.look(state(1)));
        // Being written, gone for a moment, written.
        assert!(!watch.look(state(2)) && !watch.look(None) && !watch.look(state(3)));
        assert!(watch.look(state(3)));
        assert!(!watch.look(state(3)));
    }
}
