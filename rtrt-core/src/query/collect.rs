//! What becomes of the hits that a search meets.

use super::search::{Collect, Found};
use super::source::Parts;
use super::world::Hit;
use crate::layout::NONE;

/// Keeps the closest.
pub(super) struct Closest {
    best: Found,
}

impl Closest {
    pub fn new(limit: f32) -> Self {
        Self { best: Found { t: limit, instance: NONE, triangle: NONE, u: 0.0, v: 0.0 } }
    }
    pub fn found(&self) -> Option<Found> {
        (self.best.instance != NONE).then_some(self.best)
    }
}

impl Collect for Closest {
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.best.t
    }
    #[inline(always)]
    fn take(&mut self, found: Found) {
        if found.is_before(&self.best) {
            self.best = found;
        }
    }
}

/// Ends at the first.
pub(super) struct Any {
    limit: f32,
    pub is_hit: bool,
}

impl Any {
    pub fn new(limit: f32) -> Self {
        Self { limit, is_hit: false }
    }
}

impl Collect for Any {
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }
    #[inline(always)]
    fn take(&mut self, _: Found) {
        (self.limit, self.is_hit) = (-1.0, true);
    }
}

/// Passes on what the caller accepts.
pub(super) struct Filtered<C, F> {
    pub inner: C,
    pub accept: F,
}

impl<C: Collect, F: FnMut(&Found) -> bool> Collect for Filtered<C, F> {
    fn limit(&self) -> f32 {
        self.inner.limit()
    }
    fn take(&mut self, found: Found) {
        if (self.accept)(&found) {
            self.inner.take(found);
        }
    }
}

/// Keeps the nearest, in order.
pub(super) struct Sorted<'a, S> {
    hits: &'a mut [Hit],
    pub count: usize,
    limit: f32,
    source: &'a S,
}

impl<'a, S> Sorted<'a, S> {
    pub fn new(hits: &'a mut [Hit], limit: f32, source: &'a S) -> Self {
        let limit = if hits.is_empty() { -1.0 } else { limit };
        Self { hits, count: 0, limit, source }
    }
}

/// A hit, as it was found.
fn found(hit: &Hit) -> Found {
    let &Hit { t, instance, triangle, u, v } = hit;
    Found { t, instance: instance.number(), triangle, u, v }
}

impl<S: Parts> Collect for Sorted<'_, S> {
    fn limit(&self) -> f32 {
        self.limit
    }
    fn take(&mut self, new: Found) {
        let place = self.hits[..self.count].partition_point(|hit| found(hit).is_before(&new));
        if place == self.hits.len() {
            return;
        }
        self.count = self.hits.len().min(self.count + 1);
        self.hits[place..self.count].rotate_right(1);
        let Found { t, instance, triangle, u, v } = new;
        self.hits[place] = Hit { t, instance: self.source.numbered(instance), triangle, u, v };
        if self.count == self.hits.len() {
            self.limit = self.hits[self.count - 1].t;
        }
    }
}
