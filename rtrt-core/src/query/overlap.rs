//! What a box or a ball overlaps.

use super::block::Block;
use super::ray::{QueryError, check_distance, check_point};
use super::seek::{Placed, Seeker, corners, rounding};
use super::shape::{box_meets_ellipsoid, box_meets_triangle, nearest_on_ellipsoid, nearest_on_triangle};
use super::source::Source;
use super::world::{Hit, World};
use crate::scene::{Bounds, InstanceIndex};
use glam::DVec3;

/// A box along the axes, or a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    low: [f32; 3],
    high: [f32; 3],
    /// Of a ball.
    radius: Option<f32>,
}

impl Volume {
    /// The box between two corners, whichever is the lower along each axis.
    pub fn between(one: impl Into<[f32; 3]>, other: impl Into<[f32; 3]>) -> Self {
        let (one, other) = (one.into(), other.into());
        let low = [0, 1, 2].map(|axis| one[axis].min(other[axis]));
        let high = [0, 1, 2].map(|axis| one[axis].max(other[axis]));
        // The lesser of NaN and a number is the number: NaN must be seen.
        let is_whole = one.iter().chain(&other).all(|c| !c.is_nan());
        if is_whole { Self { low, high, radius: None } } else { Self { low: one, high: other, radius: None } }
    }

    /// The ball around a point.
    pub fn ball(center: impl Into<[f32; 3]>, radius: f32) -> Self {
        let center = center.into();
        Self { low: center, high: center, radius: Some(radius) }
    }

    fn check(&self) -> Result<(), QueryError> {
        check_point(self.low)?;
        check_point(self.high)?;
        match self.radius {
            Some(distance) => check_distance(distance),
            None => Ok(()),
        }
    }
}

/// Something that a [`Volume`] overlaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Overlap {
    /// The instance.
    pub instance: InstanceIndex,
    /// The triangle, numbered as that of a [`Hit`]; of a sphere, 0.
    pub triangle: u32,
}

impl Overlap {
    /// No overlap: what slices can be filled with before [`World::overlaps`].
    pub const NONE: Self = Self { instance: Hit::NONE.instance, triangle: u32::MAX };
}

impl<S: Source> World<'_, S> {
    /// Fills `overlaps` with the triangles and spheres that a volume has a point of, and returns how many they are: those with
    /// the least numbers, in order. If it fills all of them, there may be more. Surfaces count, not what they enclose.
    ///
    /// # Errors
    /// The volume is out of range: see [`QueryError`].
    pub fn overlaps(&self, volume: &Volume, overlaps: &mut [Overlap]) -> Result<usize, QueryError> {
        let mut count = 0;
        self.overlapped(volume, |new| {
            let place = overlaps[..count].partition_point(|old| key(old) < key(&new));
            if place < overlaps.len() {
                count = overlaps.len().min(count + 1);
                overlaps[place..count].rotate_right(1);
                overlaps[place] = new;
            }
            true
        })?;
        Ok(count)
    }

    /// Fills `instances` with those that a volume has a point of, as [`World::overlaps`].
    ///
    /// # Errors
    /// As for [`World::overlaps`].
    pub fn overlapped_instances(
        &self,
        volume: &Volume,
        instances: &mut [InstanceIndex],
    ) -> Result<usize, QueryError> {
        let mut count = 0;
        self.overlapped(volume, |Overlap { instance, .. }| {
            let place = instances[..count].partition_point(|old| old.number < instance.number);
            // It may have been found in another leaf of it.
            let is_new = instances[..count].get(place) != Some(&instance);
            if is_new && place < instances.len() {
                count = instances.len().min(count + 1);
                instances[place..count].rotate_right(1);
                instances[place] = instance;
            }
            // One triangle of it is enough.
            false
        })?;
        Ok(count)
    }

    /// Calls `found` for each triangle or sphere that a volume has a point of, in no particular order; where it returns
    /// false, other triangles of the instance may be left out.
    fn overlapped(&self, volume: &Volume, found: impl FnMut(Overlap) -> bool) -> Result<(), QueryError> {
        volume.check()?;
        let (low, high) = corners(&Bounds { low: volume.low, high: volume.high });
        let magnitude = self.magnitude_from(volume.low).max(self.magnitude_from(volume.high));
        let radius = volume.radius.map(f64::from);
        self.seek(magnitude, &mut Overlapped { low, high, radius, rounding: rounding(magnitude), found });
        Ok(())
    }
}

/// The order of overlaps.
fn key(overlap: &Overlap) -> (u32, u32) {
    (overlap.instance.number, overlap.triangle)
}

/// Calls `found` with what overlaps this box or ball.
struct Overlapped<F> {
    low: DVec3,
    high: DVec3,
    /// Of a ball.
    radius: Option<f64>,
    rounding: f64,
    found: F,
}

impl<F: FnMut(Overlap) -> bool> Seeker for Overlapped<F> {
    fn distance(&self, low: DVec3, high: DVec3) -> f64 {
        (low - self.high).max(self.low - high).max_element().max(0.0)
    }

    fn reach(&self) -> f64 {
        self.radius.unwrap_or(0.0) + self.rounding
    }

    fn accepts(&mut self, _: InstanceIndex) -> bool {
        true
    }

    fn sphere(&mut self, instance: InstanceIndex, placed: &Placed) {
        let is_met = match self.radius {
            Some(radius) => {
                let n = nearest_on_ellipsoid(self.low - placed.moved, &placed.to_world);
                (placed.to_world * n + placed.moved - self.low).length_squared() <= radius * radius
            }
            None => box_meets_ellipsoid(self.low, self.high, &placed.to_ball, placed.ball_moved),
        };
        if is_met {
            (self.found)(Overlap { instance, triangle: 0 });
        }
    }

    fn triangles(&mut self, instance: InstanceIndex, placed: &Placed, blocks: &[Block]) -> bool {
        for (triangle, corners) in blocks.iter().flat_map(Block::triangles) {
            let corners = placed.triangle(corners);
            let is_met = match self.radius {
                Some(radius) => nearest_on_triangle(self.low, corners).squared <= radius * radius,
                None => box_meets_triangle(self.low, self.high, corners),
            };
            if is_met && !(self.found)(Overlap { instance, triangle }) {
                return false;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::fixture::{Random, each, strewn};
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn overlaps_are_those_of_each_triangle() {
        let mut random = Random(2);
        let (scene, mut tree) = strewn(&mut random);
        let all = tree.world(&scene);
        let mut met = 0;
        for round in 0..300 {
            let center = random.vector(6.0);
            let radius = random.signed().abs() * if round % 4 == 0 { 3.0 } else { 0.4 };
            let volume = if round % 2 == 0 {
                Volume::ball(center, radius)
            } else {
                Volume::between(center, center + random.vector(radius))
            };
            let (low, high) = corners(&Bounds { low: volume.low, high: volume.high });
            let (world, mask) = if round % 3 == 0 { (all.masked(2), 2) } else { (all, u32::MAX) };
            let mut expected = vec![];
            each(&scene, |number, triangle, placed, corners| {
                let r = f64::from(radius);
                let is_met = match (corners, volume.radius) {
                    (Some(corners), Some(_)) => nearest_on_triangle(low, corners).squared <= r * r,
                    (Some(corners), None) => box_meets_triangle(low, high, corners),
                    (None, Some(_)) => {
                        let n = nearest_on_ellipsoid(low - placed.moved, &placed.to_world);
                        (placed.to_world * n + placed.moved - low).length_squared() <= r * r
                    }
                    (None, None) => box_meets_ellipsoid(low, high, &placed.to_ball, placed.ball_moved),
                };
                if is_met && scene.tags()[number as usize].mask & mask != 0 {
                    let instance = scene.instance_index(number).unwrap();
                    expected.push(Overlap { instance, triangle });
                }
            });
            for size in [0, 1, 5, 4000] {
                let mut found = vec![Overlap::NONE; size];
                let count = world.overlaps(&volume, &mut found).unwrap();
                assert_eq!(found[..count], expected[..expected.len().min(size)]);
                let mut instances = vec![Overlap::NONE.instance; size];
                let count = world.overlapped_instances(&volume, &mut instances).unwrap();
                let mut numbers: Vec<_> = expected.iter().map(|overlap| overlap.instance).collect();
                numbers.dedup();
                assert_eq!(instances[..count], numbers[..numbers.len().min(size)]);
            }
            met += expected.len();
        }
        assert!(met > 1000, "{met}");
    }

    #[test]
    fn what_is_no_volume_is_an_error() {
        let (scene, mut tree) = strewn(&mut Random(3));
        let world = tree.world(&scene);
        for bad in [f32::NAN, f32::INFINITY, -2e9] {
            let point = [0.0, bad, 0.0];
            for volume in
                [Volume::ball(point, 1.0), Volume::between(point, [0.0; 3]), Volume::between([0.0; 3], point)]
            {
                assert!(
                    matches!(world.overlaps(&volume, &mut []), Err(QueryError::Point { .. })),
                    "{volume:?}"
                );
            }
        }
        for bad in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            let ball = Volume::ball([0.0; 3], bad);
            assert!(matches!(world.overlapped_instances(&ball, &mut []), Err(QueryError::Distance { .. })));
        }
        let ball = Volume::ball([0.0; 3], f32::INFINITY);
        assert_eq!(world.overlapped_instances(&ball, &mut [Overlap::NONE.instance; 99]), Ok(59));
    }
}
