//! Figures of the whole loop: from an event to the picture that answers it.

use serde::Serialize;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// So many of the last times are kept.
const KEPT: usize = 4096;
/// The time over which pictures are counted for the overlay.
const WINDOW: Duration = Duration::from_secs(1);

/// A picture that has been presented.
#[derive(Debug, Clone, Copy)]
pub struct Presented {
    /// Whether it is coarse because things move.
    pub is_moving: bool,
    /// Whether it has all pixels.
    pub is_sharp: bool,
}

/// Times of events and presentations.
#[derive(Debug, Default)]
pub struct Figures {
    /// The time of the oldest event that no step has taken, and of the oldest that no picture has answered.
    queued: Option<Instant>,
    taken: Option<Instant>,
    /// Whether a picture that answers it has begun.
    is_begun: bool,
    /// The last change of the picture's inputs, until a picture with all pixels follows.
    changed: Option<Instant>,
    /// The presentations of the last second.
    recent: VecDeque<Instant>,
    /// The last presentation, if things moved.
    moving: Option<Instant>,
    pictures: u64,
    begins_ms: VecDeque<f64>,
    answers_ms: VecDeque<f64>,
    intervals_ms: VecDeque<f64>,
    sharp_ms: VecDeque<f64>,
}

/// The figures of a replay.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The pictures that were presented.
    pictures: u64,
    /// Pictures a second while things moved.
    frames_per_second: Option<f64>,
    /// Milliseconds from an event to the beginning of the picture that answers it.
    event_to_begin_ms: Option<Spread>,
    /// Milliseconds from an event to the presentation of the picture that answers it.
    event_to_picture_ms: Option<Spread>,
    /// Milliseconds from the last change before a rest to a picture with all pixels; none if the window was closed before
    /// there was one.
    sharp_after_ms: Option<Spread>,
}

/// The last figures, for the overlay. Times are in milliseconds, as in [`Report`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Last {
    pub begin_ms: Option<f64>,
    pub answer_ms: Option<f64>,
    pub sharp_ms: Option<f64>,
    /// The pictures of the last second.
    pub pictures: usize,
}

/// How a set of times is spread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    pub median: f64,
    /// 95 of 100 are not longer.
    pub p95: f64,
    pub most: f64,
}

impl Spread {
    fn of(times: &VecDeque<f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = times.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: usize| sorted.get((sorted.len() * share / 100).min(sorted.len().checked_sub(1)?));
        Some(Self { median: *at(50)?, p95: *at(95)?, most: *sorted.last()? })
    }
}

impl Figures {
    /// Notes an event.
    pub fn event(&mut self, at: Instant) {
        self.queued.get_or_insert(at);
    }

    /// Notes that a step takes all events so far.
    pub fn step(&mut self) {
        let queued = self.queued.take();
        self.taken = self.taken.or(queued);
    }

    /// Notes a change of the picture's inputs.
    pub fn changed(&mut self, at: Instant) {
        self.changed = Some(at);
    }

    /// Notes that nothing is to be rendered for the events that were taken.
    pub fn unanswered(&mut self) {
        (self.taken, self.is_begun) = (None, false);
    }

    /// Notes that a picture begins.
    pub fn begins(&mut self, at: Instant) {
        if let Some(event) = self.taken.filter(|_| !self.is_begun) {
            keep(&mut self.begins_ms, at.saturating_duration_since(event).as_secs_f64() * 1e3);
            self.is_begun = true;
        }
    }

    /// Notes the presentation of a new picture.
    pub fn presented(&mut self, at: Instant, picture: Presented) {
        let ms_since = |before: Instant| at.saturating_duration_since(before).as_secs_f64() * 1e3;
        self.pictures += 1;
        self.is_begun = false;
        if let Some(event) = self.taken.take() {
            keep(&mut self.answers_ms, ms_since(event));
        }
        if let Some(changed) = self.changed.filter(|_| picture.is_sharp) {
            keep(&mut self.sharp_ms, ms_since(changed));
            self.changed = None;
        }
        if let Some(before) = self.moving.filter(|_| picture.is_moving) {
            keep(&mut self.intervals_ms, ms_since(before));
        }
        self.moving = picture.is_moving.then_some(at);
        self.recent.push_back(at);
        while self.recent.front().is_some_and(|first| at.saturating_duration_since(*first) > WINDOW) {
            self.recent.pop_front();
        }
    }

    /// Whether a picture with all pixels is still to follow a change.
    pub fn is_waited_for(&self) -> bool {
        self.changed.is_some()
    }

    /// The last figures.
    pub fn last(&self) -> Last {
        let last = |times: &VecDeque<f64>| times.back().copied();
        Last {
            begin_ms: last(&self.begins_ms),
            answer_ms: last(&self.answers_ms),
            sharp_ms: last(&self.sharp_ms),
            pictures: self.recent.len(),
        }
    }

    /// The figures so far.
    pub fn report(&self) -> Report {
        let moving_ms: f64 = self.intervals_ms.iter().sum();
        Report {
            pictures: self.pictures,
            frames_per_second: (moving_ms > 0.0).then(|| 1e3 * self.intervals_ms.len() as f64 / moving_ms),
            event_to_begin_ms: Spread::of(&self.begins_ms),
            event_to_picture_ms: Spread::of(&self.answers_ms),
            sharp_after_ms: Spread::of(&self.sharp_ms),
        }
    }
}

fn keep(times: &mut VecDeque<f64>, ms: f64) {
    if times.len() == KEPT {
        times.pop_front();
    }
    times.push_back(ms);
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOVING: Presented = Presented { is_moving: true, is_sharp: false };
    const SHARP: Presented = Presented { is_moving: false, is_sharp: true };

    #[test]
    fn times_count_from_the_oldest_event_and_from_the_last_change() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut figures = Figures::default();
        for number in 0..5 {
            // Two events, a step, and a third event that belongs to the next step.
            figures.event(at(100 * number));
            figures.event(at(100 * number + 10));
            figures.step();
            figures.changed(at(100 * number + 20));
            figures.begins(at(100 * number + 30));
            // Ended by input, and begun again.
            figures.begins(at(100 * number + 40));
            figures.presented(at(100 * number + 50), MOVING);
        }
        assert!(figures.is_waited_for());
        figures.presented(at(700), SHARP);
        assert!(!figures.is_waited_for());
        figures.event(at(800));
        figures.step();
        figures.unanswered();
        figures.presented(at(900), SHARP);
        let Report { pictures, frames_per_second, event_to_begin_ms, event_to_picture_ms, sharp_after_ms } =
            figures.report();
        let same = |ms| Some(Spread { median: ms, p95: ms, most: ms });
        assert_eq!((pictures, frames_per_second), (7, Some(10.0)));
        assert_eq!(event_to_begin_ms, same(30.0));
        assert_eq!((event_to_picture_ms, sharp_after_ms), (same(50.0), same(280.0)));
        let [begin_ms, answer_ms, sharp_ms] = [30.0, 50.0, 280.0].map(Some);
        assert_eq!(figures.last(), Last { begin_ms, answer_ms, sharp_ms, pictures: 7 });
    }

    #[test]
    fn nothing_is_reported_of_nothing() {
        let report = serde_json::to_value(Figures::default().report()).unwrap();
        let numbers: Vec<_> = report.as_object().unwrap().values().filter(|value| !value.is_null()).collect();
        assert_eq!(numbers, [&serde_json::json!(0)]);
    }
}
