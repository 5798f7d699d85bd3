//! The detail of pictures for a frame rate while things move.

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
    fn coarser(&self, divisor: u32) -> Self {
        Self { size: self.size.map(|side| side.div_ceil(divisor)), samples: 1 }
    }
}

/// Steps from fine to coarse behind the full detail.
const DIVISORS: [u32; 6] = [1, 2, 3, 4, 6, 8];
/// The share of the budget that the frame of a finer step may take: times vary.
const HEADROOM: f64 = 0.75;
/// The weight of a new measurement in the mean.
const WEIGHT: f64 = 0.5;

/// The measured cost of frames.
#[derive(Debug, Clone, Default)]
pub struct Pace {
    ms_per_ray: Option<f64>,
    /// The last step; 0 is full detail.
    step: usize,
}

impl Pace {
    /// Records a frame.
    pub fn measured(&mut self, rays: f64, ms: f64) {
        let now = ms / rays.max(1.0);
        let mean = self.ms_per_ray.map_or(now, |before| before + (now - before) * WEIGHT);
        self.ms_per_ray = Some(mean);
    }

    /// The finest detail with frames within `budget_ms`, else the coarsest one. Without a measurement it is
    /// full detail.
    pub fn detail(&mut self, full: Detail, budget_ms: f64) -> Detail {
        let Some(ms_per_ray) = self.ms_per_ray else { return full };
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
        assert_eq!(Pace::default().detail(FULL, 1.0), FULL);
        assert_eq!(pace(30.0).detail(FULL, 30.0), FULL);
        assert_eq!(pace(100.0).detail(FULL, 30.0), Detail { size: [1001, 500], samples: 1 });
        assert_eq!(pace(400.0).detail(FULL, 30.0), Detail { size: [501, 250], samples: 1 });
        assert_eq!(pace(1e9).detail(FULL, 30.0), Detail { size: [126, 63], samples: 1 });
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
}
