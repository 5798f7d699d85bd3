//! The detail of pictures: as fine as a frame rate allows while things move, then finer step by step.

/// The pixels of a frame, and the sub-rays per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Detail {
    pub size: [u32; 2],
    pub samples: u32,
}

impl Detail {
    pub fn rays(&self) -> f64 {
        f64::from(self.size[0]) * f64::from(self.size[1]) * f64::from(self.samples)
    }

    /// The detail with one sub-ray per pixel, and width and height divided.
    fn coarser(&self, divisor: f64) -> Self {
        let side = |side: u32| ((f64::from(side) / divisor).ceil() as u32).max(1);
        Self { size: self.size.map(side), samples: 1 }
    }
}

/// Steps from fine to coarse behind the full detail.
const DIVISORS: [f64; 12] = [1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0];
/// Steps from coarse to fine in front of the full detail, once nothing moves: a quarter of the pixels, all of them.
const REFINEMENTS: [f64; 2] = [2.0, 1.0];
/// The share of the budget that the frame of a finer step may take: times vary.
const HEADROOM: f64 = 0.8;
/// The weight of a new measurement in the mean.
const WEIGHT: f64 = 0.5;
/// Milliseconds: if the full detail takes at most this, a refinement has no steps in between.
const AT_ONCE_MS: f64 = 100.0;

/// The measured cost of frames.
#[derive(Debug, Clone, Default)]
pub struct Pace {
    ms_per_ray: Option<f64>,
    /// The time of a frame in which nothing is rendered: input, scaling, overlay, presentation.
    rest_ms: f64,
    /// The last step; 0 is full detail.
    step: usize,
}

impl Pace {
    /// Records the rendering of a frame.
    pub fn measured(&mut self, rays: f64, ms: f64) {
        let now = ms / rays.max(1.0);
        let mean = self.ms_per_ray.map_or(now, |before| before + (now - before) * WEIGHT);
        self.ms_per_ray = Some(mean);
    }

    /// Records the time of a frame in which nothing was rendered.
    pub fn presented(&mut self, rest_ms: f64) {
        self.rest_ms += (rest_ms - self.rest_ms) * WEIGHT;
    }

    /// The finest detail with frames within `budget_ms` from input to presentation, else the coarsest one. Without a
    /// measurement it is a quarter of the pixels.
    pub fn detail(&mut self, full: Detail, budget_ms: f64) -> Detail {
        let Some(ms_per_ray) = self.ms_per_ray else { return full.coarser(REFINEMENTS[0]) };
        let budget_ms = budget_ms - self.rest_ms;
        let steps = || std::iter::once(full).chain(DIVISORS.iter().map(|&divisor| full.coarser(divisor)));
        let fits = |(step, detail): &(usize, Detail)| {
            let free = if *step < self.step { HEADROOM } else { 1.0 };
            detail.rays() * ms_per_ray <= budget_ms * free
        };
        let coarsest = (DIVISORS.len(), full.coarser(DIVISORS[DIVISORS.len() - 1]));
        let (step, detail) = steps().enumerate().find(fits).unwrap_or(coarsest);
        self.step = step;
        detail
    }

    /// The next finer detail of a picture that is not going to change, from that which is shown.
    pub fn refined(&self, full: Detail, shown: Option<Detail>) -> Detail {
        let is_quick = self.ms_per_ray.is_some_and(|ms| full.rays() * ms <= AT_ONCE_MS);
        let shown = shown.map_or(0.0, |shown| shown.rays());
        let finer = REFINEMENTS.iter().map(|&divisor| full.coarser(divisor));
        // Half as many rays again are worth a picture.
        finer.filter(|_| !is_quick).find(|finer| finer.rays() >= 1.5 * shown).unwrap_or(full)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Detail = Detail { size: [1001, 500], samples: 4 };

    fn pace(ms_of_full: f64) -> Pace {
        let mut pace = Pace::default();
        pace.measured(FULL.rays(), ms_of_full);
        pace
    }

    #[test]
    fn detail_fits_the_budget() {
        assert_eq!(Pace::default().detail(FULL, 1.0), Detail { size: [501, 250], samples: 1 });
        assert_eq!(pace(30.0).detail(FULL, 30.0), FULL);
        assert_eq!(pace(100.0).detail(FULL, 30.0), Detail { size: [1001, 500], samples: 1 });
        assert_eq!(pace(400.0).detail(FULL, 30.0), Detail { size: [501, 250], samples: 1 });
        assert_eq!(pace(1e9).detail(FULL, 30.0), Detail { size: [126, 63], samples: 1 });
    }

    #[test]
    fn what_is_not_rendering_is_taken_off_the_budget() {
        let mut pace = pace(400.0);
        pace.presented(20.0);
        assert_eq!(pace.detail(FULL, 36.0), Detail { size: [501, 250], samples: 1 });
        pace.presented(1e3);
        assert_eq!(pace.detail(FULL, 35.0), Detail { size: [126, 63], samples: 1 });
    }

    #[test]
    fn varying_times_do_not_toggle_the_detail() {
        let mut pace = pace(110.0);
        let coarse = pace.detail(FULL, 100.0);
        assert_eq!(coarse.samples, 1);
        pace.ms_per_ray = Some(95.0 / FULL.rays());
        assert_eq!(pace.detail(FULL, 100.0), coarse);
        pace.ms_per_ray = Some(70.0 / FULL.rays());
        assert_eq!(pace.detail(FULL, 100.0), FULL);
    }

    #[test]
    fn a_still_picture_is_refined_by_steps_unless_the_full_detail_is_quick() {
        let (quarter, whole) = (FULL.coarser(2.0), FULL.coarser(1.0));
        let slow = pace(1000.0);
        assert_eq!(slow.refined(FULL, None), quarter);
        assert_eq!(slow.refined(FULL, Some(FULL.coarser(6.0))), quarter);
        assert_eq!(slow.refined(FULL, Some(FULL.coarser(2.5))), quarter);
        assert_eq!(slow.refined(FULL, Some(FULL.coarser(1.75))), whole);
        assert_eq!(slow.refined(FULL, Some(whole)), FULL);
        assert_eq!(slow.refined(FULL, Some(FULL)), FULL);
        assert_eq!(pace(90.0).refined(FULL, None), FULL);
    }
}
