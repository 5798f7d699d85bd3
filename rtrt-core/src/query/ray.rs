//! What is asked: a ray, and what it looks through.

use crate::kernel::ray::Ray as WorldRay;
use crate::lane::V3;
use crate::scene::{COORDINATE_LIMIT, InstanceIndex};
use core::fmt;

/// The sides of triangles that a ray meets. The front is where corners are counterclockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sides {
    /// Front and back.
    #[default]
    Both,
    /// The front.
    Fronts,
    /// The back.
    Backs,
    /// What a camera sees: the front, and the back of what is
    /// [`double_sided`](crate::scene::Material::double_sided).
    Drawn,
}

/// The points `origin + t · direction` with `from ≤ t ≤ to` and `t > 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// The start, within ±2³⁰.
    pub origin: [f32; 3],
    /// Any length but 0; `t` counts in it.
    pub direction: [f32; 3],
    /// The least `t`; 0 at first.
    pub from: f32,
    /// The largest `t`; infinite at first.
    pub to: f32,
    /// The instances that count: those whose [mask](crate::scene::Scene::set_ray_mask) has a bit in common; all
    /// at first.
    pub mask: u32,
    /// The sides that count; both at first.
    pub sides: Sides,
    /// An instance that does not count; none at first.
    pub skip: Option<InstanceIndex>,
    /// Whether the ray passes the holes that a [mask](crate::scene::Material::mask) cuts; not at first.
    pub through_holes: bool,
}

impl Ray {
    /// The ray from `origin` along `direction`, without end.
    pub fn new(origin: impl Into<[f32; 3]>, direction: impl Into<[f32; 3]>) -> Self {
        Self {
            origin: origin.into(),
            direction: direction.into(),
            from: 0.0,
            to: f32::INFINITY,
            mask: u32::MAX,
            sides: Sides::Both,
            skip: None,
            through_holes: false,
        }
    }

    /// The ray from one point to another: `t` is 0 at `from` and 1 at `to`. A surface at `to` is met, or not,
    /// by rounding: [skip](Ray::skip) its instance, or end the ray before it ([`Ray::until`]).
    pub fn between(from: impl Into<[f32; 3]>, to: impl Into<[f32; 3]>) -> Self {
        let (from, to) = (from.into(), to.into());
        Self { to: 1.0, ..Self::new(from, [0, 1, 2].map(|axis| to[axis] - from[axis])) }
    }

    /// The ray with another start of its range.
    #[must_use]
    pub fn starting(self, from: f32) -> Self {
        Self { from, ..self }
    }
    /// The ray with another end of its range.
    #[must_use]
    pub fn until(self, to: f32) -> Self {
        Self { to, ..self }
    }
    /// The ray with a mask.
    #[must_use]
    pub fn mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }
    /// The ray that meets these sides.
    #[must_use]
    pub fn sides(self, sides: Sides) -> Self {
        Self { sides, ..self }
    }
    /// The ray that passes through an instance.
    #[must_use]
    pub fn skip(self, instance: InstanceIndex) -> Self {
        Self { skip: Some(instance), ..self }
    }
    /// The ray that passes the holes of masks.
    #[must_use]
    pub fn through_holes(self) -> Self {
        Self { through_holes: true, ..self }
    }

    /// The ray as kernels take it.
    ///
    /// A direction with a component of at least 2⁻³² and none above 2³² stays as it is. Any other is
    /// multiplied by a power of two, which keeps its bits, so that its largest component is within 1 ..= 2.
    pub(crate) fn scaled(&self) -> Result<ScaledRay, QueryError> {
        let Self { origin, direction, from, to, .. } = *self;
        check_point(origin)?;
        let largest = direction.iter().fold(0.0_f32, |most, c| most.max(c.abs()));
        if !(largest > 0.0 && direction.iter().all(|c| c.is_finite())) {
            return Err(QueryError::Direction { direction });
        }
        if from.is_nan() || to.is_nan() {
            return Err(QueryError::Range { from, to });
        }
        let start = V3::splat((), origin);
        if (1.0 / LONG..=LONG).contains(&largest) {
            let ray = WorldRay::new(start, V3::splat((), direction));
            return Ok(ScaledRay { ray, span: Span::new(from, to) });
        }
        // The reciprocal of the largest component's power of two.
        let exponent = f64::from(largest).to_bits() >> 52;
        let factor = f64::from_bits((2 * 1023 - exponent) << 52);
        let direction = direction.map(|c| (f64::from(c) * factor) as f32);
        // Beyond the numbers there is nothing to meet.
        let limit = |t: f32| (f64::from(t) / factor).min(f64::from(f32::MAX)) as f32;
        Ok(ScaledRay {
            ray: WorldRay::new(start, V3::splat((), direction)),
            span: Span { unit: factor, ..Span::new(limit(from), limit(to)) },
        })
    }
}

/// The longest direction that is left as it is: 2³².
pub(super) const LONG: f32 = 4_294_967_296.0;

/// A ray whose direction has a moderate length.
#[derive(Clone, Copy)]
pub(crate) struct ScaledRay {
    pub ray: WorldRay<f32>,
    pub span: Span,
}

/// The range of a scaled ray, and the unit of its `t`.
#[derive(Clone, Copy)]
pub(crate) struct Span {
    /// The range of the scaled ray's `t`.
    pub from: f32,
    /// Its end.
    pub to: f32,
    /// The caller's `t`, for each unit of this ray's.
    pub unit: f64,
}

impl Span {
    /// That of a ray which stays as it is.
    #[inline(always)]
    pub fn new(from: f32, to: f32) -> Self {
        // The sum is never −0, whose bits are not in order with other numbers'.
        Self { from: from.max(0.0) + 0.0, to: to.min(f32::MAX), unit: 1.0 }
    }

    /// The caller's `t`. One that is too large for a number is the largest.
    #[inline(always)]
    pub fn t(&self, t: f32) -> f32 {
        if self.unit == 1.0 { t } else { (f64::from(t) * self.unit).min(f64::from(f32::MAX)) as f32 }
    }
}

/// Refuses a point that is out of range.
pub(crate) fn check_point(point: [f32; 3]) -> Result<(), QueryError> {
    let is_inside = point.iter().all(|c| c.abs() <= COORDINATE_LIMIT);
    if is_inside { Ok(()) } else { Err(QueryError::Point { point }) }
}

/// Refuses a distance that is below 0 or NaN.
pub(crate) fn check_distance(distance: f32) -> Result<(), QueryError> {
    if distance >= 0.0 { Ok(()) } else { Err(QueryError::Distance { distance }) }
}

/// Why a query was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum QueryError {
    /// A point has a coordinate that is NaN, or beyond [`COORDINATE_LIMIT`].
    Point {
        /// The point.
        point: [f32; 3],
    },
    /// A direction is zero, or has a component that is NaN or infinite.
    Direction {
        /// The direction.
        direction: [f32; 3],
    },
    /// The range of a ray has an end that is NaN. (A range that ends before it starts is empty.)
    Range {
        /// Its start.
        from: f32,
        /// Its end.
        to: f32,
    },
    /// A distance is NaN or negative.
    Distance {
        /// What it is.
        distance: f32,
    },
}

impl fmt::Display for QueryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Point { point } => write!(f, "the point {point:?} is not within ±2^30"),
            Self::Direction { direction } => write!(f, "{direction:?} is not the direction of a ray"),
            Self::Range { from, to } => write!(f, "a ray cannot reach from {from} to {to}"),
            Self::Distance { distance } => write!(f, "{distance} is not a distance"),
        }
    }
}

impl core::error::Error for QueryError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_keep_their_bits_at_any_length() {
        let ray = |length: f32| Ray::new([0.0; 3], [0.3 * length, -0.7 * length, 0.1 * length]);
        let plain = ray(1.0).scaled().unwrap();
        assert_eq!((plain.span.unit, plain.ray.direction.lane(0)), (1.0, [0.3, -0.7, 0.1]));
        for power in [-120, -40, 40, 120] {
            let length = f32::from_bits(((127 + power) as u32) << 23);
            let scaled = ray(length).scaled().unwrap();
            let direction = scaled.ray.direction.lane(0);
            assert_eq!(direction, [0.6, -1.4, 0.2], "{power}");
            // What is 5 of the scaled ray's away is at 10 units, and t counts in lengths.
            assert_eq!(f64::from(scaled.span.t(5.0)) * f64::from(length), 10.0_f64.min(f64::from(f32::MAX)));
        }
        // Denormals too, and the longest.
        for length in [1e-45, 1e-40, f32::MAX] {
            let scaled = Ray::new([0.0; 3], [0.0, length, 0.0]).scaled().unwrap();
            let [_, y, _] = scaled.ray.direction.lane(0);
            assert!((1.0..2.0).contains(&y), "{y}");
        }
    }

    #[test]
    fn what_is_no_ray_is_an_error() {
        let refused = |ray: Ray| ray.scaled().err();
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(matches!(refused(Ray::new([0.0, bad, 0.0], [1.0; 3])), Some(QueryError::Point { .. })));
            let direction = refused(Ray::new([0.0; 3], [1.0, 0.0, bad]));
            assert!(matches!(direction, Some(QueryError::Direction { .. })));
        }
        assert!(matches!(refused(Ray::new([2e9; 3], [1.0; 3])), Some(QueryError::Point { .. })));
        assert!(matches!(refused(Ray::new([0.0; 3], [-0.0; 3])), Some(QueryError::Direction { .. })));
        let ray = Ray::new([0.0; 3], [1.0; 3]);
        assert!(matches!(refused(ray.until(f32::NAN)), Some(QueryError::Range { .. })));
        assert_eq!(refused(ray.until(-1.0)), None);
    }

    #[test]
    fn a_range_from_minus_zero_starts_at_zero() {
        for length in [1.0, 1e20, 1e-20] {
            let ray = Ray::new([0.0; 3], [0.0, length, 0.0]);
            let from = |from| ray.starting(from).scaled().unwrap().span.from.to_bits();
            assert_eq!([from(-0.0), from(0.0), from(-1.0)], [0; 3]);
        }
    }

    #[test]
    fn between_two_points_t_is_from_0_to_1() {
        let ray = Ray::between([1.0, 2.0, 3.0], [3.0, 2.0, 0.0]);
        assert_eq!((ray.direction, ray.from, ray.to), ([2.0, 0.0, -3.0], 0.0, 1.0));
    }
}
