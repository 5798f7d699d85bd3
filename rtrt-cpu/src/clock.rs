//! How long each stage takes.

use crate::instant::Instant;
use crate::parallel;
use core::time::Duration;
use rtrt_core::schedule::Stage;

/// Time spent in each stage.
#[derive(Clone, Copy, Default)]
pub struct Clock([Duration; Stage::COUNT]);

impl Clock {
    /// Adds the time since `start`.
    pub fn add(&mut self, stage: Stage, start: Instant) {
        self.0[stage as usize] += start.elapsed();
    }
    /// Adds the time since `start`, and restarts it.
    pub fn lap(&mut self, stage: Stage, start: &mut Instant) {
        let now = Instant::now();
        self.0[stage as usize] += now - *start;
        *start = now;
    }
    /// The same, of all threads.
    pub fn lap_of_all(&mut self, stage: Stage, start: &mut Instant) {
        let now = Instant::now();
        self.0[stage as usize] += (now - *start) * parallel::threads();
        *start = now;
    }
    /// The sum of both.
    pub fn plus(self, other: Self) -> Self {
        Self(core::array::from_fn(|stage| self.0[stage] + other.0[stage]))
    }
    /// Adds `passed`, divided like `busy`.
    pub fn spread(&mut self, passed: Duration, busy: &Self) {
        let total: Duration = busy.0.iter().sum();
        let share = passed.as_secs_f64() / total.as_secs_f64().max(1e-9);
        for (stage, busy) in self.0.iter_mut().zip(busy.0) {
            *stage += busy.mul_f64(share);
        }
    }
    /// In milliseconds.
    pub fn milliseconds(&self) -> [f64; Stage::COUNT] {
        self.0.map(|stage| stage.as_secs_f64() * 1e3)
    }
}
