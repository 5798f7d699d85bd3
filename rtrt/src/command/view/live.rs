//! A recording that happens again at its own speed.

use super::input::{Event, Replay, Step};
use std::time::{Duration, Instant};

/// How long the end of a recording waits for a picture with all pixels.
const PATIENCE: Duration = Duration::from_secs(10);

/// A recording and a clock.
#[derive(Debug)]
pub struct Live {
    steps: std::iter::Peekable<Replay>,
    /// The time of the next step; none before the first call.
    next: Option<Instant>,
    /// Until when the end may be waited for.
    end: Option<Instant>,
}

impl Live {
    pub fn new(replay: Replay) -> Self {
        Self { steps: replay.peekable(), next: None, end: None }
    }

    /// The events up to now with their times; none after the end of the recording. The first call starts the clock.
    pub fn due(&mut self, now: Instant) -> Option<Vec<(Instant, Event)>> {
        let mut events = Vec::new();
        let mut next = *self.next.get_or_insert(now);
        while next <= now {
            let Some(Step { events: all, .. }) = self.steps.next() else {
                return (!events.is_empty()).then_some(events);
            };
            events.extend(all.into_iter().map(|event| (next, event)));
            let seconds = self.steps.peek().map_or(0.0, |step| f64::from(step.seconds));
            next += Duration::from_secs_f64(seconds);
        }
        self.next = Some(next);
        Some(events)
    }

    /// Whether a picture may still be waited for at the end of the recording.
    pub fn waits(&mut self, now: Instant) -> bool {
        *self.end.get_or_insert(now + PATIENCE) > now
    }

    /// The time of the next step, or of the end.
    pub fn wake(&self) -> Option<Instant> {
        self.end.or(self.next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn events_happen_at_their_times() {
        let text = "rtrt input 1\nleave\nframe 9\nleave\nframes 2 0.5\nwheel 1\nframe 0.5\nframe 1\n";
        let mut live = Live::new(Replay::parse(text, Path::new("")).unwrap());
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        assert_eq!(live.due(at(0)), Some(vec![(at(0), Event::Leave)]));
        assert_eq!(live.wake(), Some(at(500)));
        assert_eq!(live.due(at(499)), Some(vec![]));
        assert_eq!(live.due(at(1600)), Some(vec![(at(500), Event::Leave), (at(1500), Event::Wheel(1.0))]));
        assert_eq!(live.due(at(2499)), Some(vec![]));
        assert_eq!(live.due(at(2500)), None);
        assert!(live.waits(at(2500)) && live.waits(at(12_499)) && !live.waits(at(12_500)));
        assert_eq!(live.wake(), Some(at(12_500)));
    }
}
