//! A recording that happens again at its own speed.

use super::input::{Event, Replay, Step};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How long the end of a recording waits for a picture with all pixels.
const PATIENCE: Duration = Duration::from_secs(10);

/// A recording and a clock.
#[derive(Debug)]
pub struct Live {
    /// The steps that have events, with their times. In between nothing wakes the window, as while a person does nothing.
    steps: VecDeque<(Duration, Vec<Event>)>,
    /// The time of the last step.
    length: Duration,
    /// None before the first call.
    start: Option<Instant>,
    /// Until when the end may be waited for.
    end: Option<Instant>,
}

impl Live {
    pub fn new(replay: Replay) -> Self {
        let (mut steps, mut length) = (VecDeque::new(), Duration::ZERO);
        for (number, Step { events, seconds }) in replay.enumerate() {
            // The clock starts with the first one.
            if number > 0 {
                length += Duration::from_secs_f64(f64::from(seconds));
            }
            if !events.is_empty() {
                steps.push_back((length, events));
            }
        }
        Self { steps, length, start: None, end: None }
    }

    /// The events up to now with their times; none after the end of the recording. The first call starts the clock.
    pub fn due(&mut self, now: Instant) -> Option<Vec<(Instant, Event)>> {
        let start = *self.start.get_or_insert(now);
        let mut events = Vec::new();
        while let Some((at, all)) = self.steps.pop_front_if(|(at, _)| start + *at <= now) {
            events.extend(all.into_iter().map(|event| (start + at, event)));
        }
        let is_over = self.steps.is_empty() && start + self.length <= now;
        (!is_over || !events.is_empty()).then_some(events)
    }

    /// Whether an event is due.
    pub fn acts(&self, now: Instant) -> bool {
        let next = self.start.zip(self.steps.front());
        next.is_some_and(|(start, (at, _))| start + *at <= now)
    }

    /// Whether a picture may still be waited for at the end of the recording.
    pub fn waits(&mut self, now: Instant) -> bool {
        *self.end.get_or_insert(now + PATIENCE) > now
    }

    /// The time of the next event, or of the end.
    pub fn wake(&self) -> Option<Instant> {
        let next = self.steps.front().map_or(self.length, |(at, _)| *at);
        self.end.or(self.start.map(|start| start + next))
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
        assert!(live.acts(at(500)) && !live.acts(at(499)));
        assert_eq!(live.due(at(500)), Some(vec![(at(500), Event::Leave)]));
        // Nothing happens at 1000.
        assert!(!live.acts(at(1499)) && live.wake() == Some(at(1500)));
        assert_eq!(live.due(at(1600)), Some(vec![(at(1500), Event::Wheel(1.0))]));
        assert_eq!((live.due(at(2499)), live.wake()), (Some(vec![]), Some(at(2500))));
        assert!(!live.acts(at(2500)) && live.due(at(2500)).is_none());
        assert!(live.waits(at(2500)) && live.waits(at(12_499)) && !live.waits(at(12_500)));
        assert_eq!(live.wake(), Some(at(12_500)));
    }
}
