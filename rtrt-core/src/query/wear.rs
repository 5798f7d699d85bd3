//! How much worse a tree has become by refitting its boxes.

use crate::scene::Bounds;

/// A tree with so many times the cost that it had when it was built is built again.
const WORN: f64 = 2.0;

/// The surfaces of a tree's boxes, now and when it was built.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wear {
    /// The surfaces of all boxes, summed.
    pub area: f64,
    /// The quotient of that by the surface of the whole, when built.
    built_cost: f64,
}

impl Wear {
    /// Replaces a box.
    pub fn replace(&mut self, old: &Bounds, new: &Bounds) {
        self.area += f64::from(new.area()) - f64::from(old.area());
    }

    /// The tree has just been built; `whole` is around all of it.
    pub fn set_built(&mut self, whole: &Bounds) {
        self.built_cost = self.cost(whole);
    }

    /// Whether it is to be built again.
    pub fn is_worn(&self, whole: &Bounds) -> bool {
        self.cost(whole) > WORN * self.built_cost
    }

    /// How often a ray that hits the whole may be expected to hit a box.
    fn cost(&self, whole: &Bounds) -> f64 {
        let whole = f64::from(whole.area());
        if whole > 0.0 { self.area / whole } else { 0.0 }
    }
}
