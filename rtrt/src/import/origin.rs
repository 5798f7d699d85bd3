//! Scenes far from the origin of their coordinates, as geo-referenced files are.
//!
//! At 6,000,000 neighbors among numbers of single precision are half a unit apart. An import therefore subtracts an
//! origin from such a scene, in double precision: from the transforms of glTF's nodes, and from the vertices of other
//! formats. What a file itself has in single precision, the vertices of glTF, stays as coarse as it is; a warning says so.

use glam::DVec3;

/// The distance from the origin of coordinates, in diagonals of the scene, from which on another one is taken: a scene
/// that is nearer loses at most 6 of 24 bits.
const FAR: f64 = 64.0;
/// The same for a part of a scene, in diagonals of its smallest object.
const FINE: f64 = 8192.0;
/// Vertices are coarse where fewer numbers than this lie along the diagonal of a mesh.
const FEWEST_STEPS: f64 = 256.0;

/// Lower and upper corner around points; of no points, the first is not below the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    /// Around nothing.
    pub const NONE: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// Around these points, as far as they are finite.
    pub fn of(positions: &[[f32; 3]]) -> Self {
        let mut bounds = Self::NONE;
        positions.iter().for_each(|p| bounds.add(DVec3::from(p.map(f64::from))));
        bounds
    }

    /// Takes in a point, if it is finite.
    pub fn add(&mut self, point: DVec3) {
        if point.is_finite() {
            (self.low, self.high) = (self.low.min(point), self.high.max(point));
        }
    }

    fn diagonal(&self) -> f64 {
        libm::sqrt((self.high - self.low).length_squared())
    }

    fn middle(&self) -> DVec3 {
        self.low * 0.5 + self.high * 0.5
    }

    /// The distance of a point from the box; 0 inside of it.
    fn distance(&self, point: DVec3) -> f64 {
        libm::sqrt((self.low - point).max(point - self.high).max(DVec3::ZERO).length_squared())
    }

    /// What to subtract from coordinates: 0, or, where the middle is more than 64 diagonals away, that middle, rounded.
    pub fn origin(&self) -> DVec3 {
        rounded(self.middle(), self.diagonal(), FAR)
    }

    /// The largest distance between neighboring numbers of single precision at these coordinates, and how many of them
    /// lie along the diagonal, where they are few.
    pub fn coarseness(&self) -> Option<(f64, f64)> {
        let farthest = self.low.abs().max(self.high.abs()).max_element();
        let step = libm::exp2(libm::floor(libm::log2(farthest)) - 23.0);
        let steps = self.diagonal() / step;
        (farthest.is_finite() && steps > 0.0 && steps < FEWEST_STEPS).then_some((step, steps))
    }
}

/// What to subtract from the coordinates of a scene of these objects, where it is seen from `eye`, if that is known: see
/// [`Bounds::origin`]. A scene that reaches from the origin of coordinates to what is far away has its middle between
/// the two. Its details may be far away all the same: where the smallest object that is seen under a degree or more from
/// the eye, or from the median of all objects, has fewer than some 1,000 numbers of single precision along its diagonal,
/// that place is subtracted, rounded.
pub(super) fn origin(objects: &[Bounds], eye: Option<DVec3>) -> DVec3 {
    let mut all = Bounds::NONE;
    for object in objects {
        all.add(object.low);
        all.add(object.high);
    }
    let origin = all.origin();
    if origin != DVec3::ZERO {
        return origin;
    }
    let Some(place) = eye.filter(|eye| eye.is_finite()).or_else(|| median(objects)) else { return origin };
    let is_seen =
        |object: &&Bounds| object.diagonal() > 0.0 && object.distance(place) <= FAR * object.diagonal();
    let sizes = objects.iter().filter(is_seen).map(Bounds::diagonal);
    rounded(place, sizes.fold(f64::INFINITY, f64::min), FINE)
}

/// The median of the middles of objects, coordinate by coordinate.
fn median(objects: &[Bounds]) -> Option<DVec3> {
    let middles: Vec<DVec3> =
        objects.iter().map(Bounds::middle).filter(|middle| middle.is_finite()).collect();
    let coordinate = |axis: usize| {
        let mut coordinates: Vec<f64> = middles.iter().map(|middle| middle[axis]).collect();
        coordinates.sort_by(f64::total_cmp);
        coordinates.get(coordinates.len() / 2).copied()
    };
    Some(DVec3::new(coordinate(0)?, coordinate(1)?, coordinate(2)?))
}

/// The place, rounded to a multiple of a power of two that is at least `size`, if it is more than so many sizes away, and
/// 0 otherwise. Differences from it are exact for whatever coordinates are near it.
fn rounded(place: DVec3, size: f64, far: f64) -> DVec3 {
    let distance = place.abs().max_element();
    if !(distance > far * size && distance.is_finite()) {
        return DVec3::ZERO;
    }
    // A point has no size.
    let size = size.max(distance / (1_u64 << 40) as f64);
    let unit = libm::exp2(libm::ceil(libm::log2(size)));
    let rounded = place.to_array().map(|c| libm::rint(c / unit) * unit);
    if rounded.iter().all(|c| c.is_finite()) { DVec3::from(rounded) } else { DVec3::ZERO }
}

/// Positions relative to an origin.
pub(super) fn relative(positions: &mut [[f32; 3]], origin: DVec3) {
    for position in positions {
        *position = (DVec3::from(position.map(f64::from)) - origin).as_vec3().to_array();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_far_away_gets_an_origin() {
        let at = |x: f64, size: f64| {
            let mut bounds = Bounds::NONE;
            bounds.add(DVec3::new(x, 0.0, 0.0));
            bounds.add(DVec3::new(x + size, size, 0.0));
            bounds
        };
        assert_eq!(at(10.0, 1.0).origin(), DVec3::ZERO);
        assert_eq!(at(-80.0, 1.0).origin(), DVec3::ZERO);
        // Diagonal √2, so multiples of 2.
        assert_eq!(at(100.0, 1.0).origin(), DVec3::new(100.0, 0.0, 0.0));
        assert_eq!(at(6e6, 1000.0).origin(), DVec3::new(6_000_640.0, 0.0, 0.0));
        assert_eq!(at(-6e6, 1.0).origin(), DVec3::new(-6e6, 0.0, 0.0));
        assert_eq!(Bounds::NONE.origin(), DVec3::ZERO);
        let point = at(3e5, 0.0).origin();
        assert!((point.x - 3e5).abs() < 1e-6, "{point}");
        assert!(at(1e308, 1e300).origin().is_finite());
    }

    #[test]
    fn details_far_from_a_scenes_other_end_get_an_origin() {
        let at = |x: f64, size: f64| {
            let mut bounds = Bounds::NONE;
            bounds.add(DVec3::new(x, 0.0, 0.0));
            bounds.add(DVec3::new(x + size, size, 0.0));
            bounds
        };
        let houses = [at(0.0, 10.0), at(6e6, 10.0), at(6e6 + 40.0, 10.0)];
        // Diagonals of 14.1, so multiples of 16.
        assert_eq!(origin(&houses, None), DVec3::new(6e6, 0.0, 0.0));
        assert_eq!(
            origin(&houses, Some(DVec3::new(6e6 + 90.0, 2.0, 5.0))),
            DVec3::new(6_000_096.0, 0.0, 0.0)
        );
        assert_eq!(origin(&houses, Some(DVec3::new(5.0, 2.0, 5.0))), DVec3::ZERO);
        // An eye that is near nothing sees nothing that would be coarse; nor is what is large.
        assert_eq!(origin(&houses, Some(DVec3::new(3e6, 0.0, 0.0))), DVec3::ZERO);
        assert_eq!(origin(&[at(0.0, 10.0), at(6e6, 1e6)], Some(DVec3::new(6e6, 0.0, 0.0))), DVec3::ZERO);
        assert_eq!(origin(&[], None), DVec3::ZERO);
        assert_eq!(origin(&[at(f64::NAN, 1.0), Bounds::NONE], Some(DVec3::NAN)), DVec3::ZERO);
    }

    #[test]
    fn differences_are_exact() {
        let mut positions = [[6_000_000.5, 1.25, -3.0], [6_000_001.0, 2.0, 0.0]];
        let origin = Bounds::of(&positions).origin();
        assert_eq!(origin, DVec3::new(6_000_000.0, 0.0, 0.0));
        relative(&mut positions, origin);
        assert_eq!(positions, [[0.5, 1.25, -3.0], [1.0, 2.0, 0.0]]);
    }

    #[test]
    fn vertices_are_coarse_where_few_numbers_lie_between_them() {
        // Neighbors at 6,000,000 are 0.5 apart.
        let coarse = Bounds::of(&[[6e6, 0.0, 0.0], [6e6 + 10.0, 0.0, 0.0]]).coarseness();
        assert_eq!(coarse, Some((0.5, 20.0)));
        assert_eq!(Bounds::of(&[[6e6, 0.0, 0.0], [6e6 + 1000.0, 0.0, 0.0]]).coarseness(), None);
        assert_eq!(Bounds::of(&[[1.0; 3]]).coarseness(), None);
        assert_eq!(Bounds::of(&[]).coarseness(), None);
    }
}
