//! Keyframes: the value of a property at a time.

use gltf_json::animation::{Interpolation, Property};

/// The keyframes of a property of a node.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    /// The number of its animation in the file.
    pub animation: usize,
    /// The number of its node in the file.
    pub node: usize,
    /// The property.
    pub property: Property,
    pub interpolation: Interpolation,
    /// The times of the keyframes, seconds, strictly increasing.
    pub times: Vec<f64>,
    /// The numbers of a value.
    pub width: usize,
    /// `width` numbers a keyframe; for splines three times as many: in-tangent, value, out-tangent.
    pub values: Vec<f64>,
}

impl Track {
    /// The time of the last keyframe, seconds.
    pub fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The value at a time. The first keyframe's value holds before it, the last one's after it.
    ///
    /// Rotations are interpolated by slerp along the shorter way, splines are cubic Hermite splines, as
    /// the format defines. Sines come from `libm`, so that hosts agree.
    pub fn at(&self, time: f64) -> Vec<f64> {
        let after = self.times.partition_point(|&key| key <= time);
        let (Some(from), Some(&end)) = (after.checked_sub(1), self.times.get(after)) else {
            return self.value(after.saturating_sub(1)).to_vec();
        };
        let length = end - self.times[from];
        let share = (time - self.times[from]) / length;
        let (a, b) = (self.value(from), self.value(after));
        match self.interpolation {
            Interpolation::Step => a.to_vec(),
            Interpolation::Linear if self.property == Property::Rotation => slerp(a, b, share),
            Interpolation::Linear => mix(a, b, 1.0 - share, share),
            Interpolation::CubicSpline => {
                let (out, into) = (self.part(from, 2), self.part(after, 0));
                let (s, s2, s3) = (share, share * share, share * share * share);
                let value = mix(a, b, 2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3);
                let slope = mix(out, into, (s3 - 2.0 * s2 + s) * length, (s3 - s2) * length);
                mix(&value, &slope, 1.0, 1.0)
            }
        }
    }

    /// The value of a keyframe.
    fn value(&self, key: usize) -> &[f64] {
        if self.interpolation == Interpolation::CubicSpline {
            self.part(key, 1)
        } else {
            &self.values[key * self.width..][..self.width]
        }
    }

    /// One of the three values of a spline's keyframe.
    fn part(&self, key: usize, part: usize) -> &[f64] {
        &self.values[(3 * key + part) * self.width..][..self.width]
    }
}

/// `a · by_a + b · by_b`.
fn mix(a: &[f64], b: &[f64], by_a: f64, by_b: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * by_a + b * by_b).collect()
}

/// The rotation between two (Shoemake, "Animating Rotation with Quaternion Curves", 1985).
fn slerp(a: &[f64], b: &[f64], share: f64) -> Vec<f64> {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let (dot, sign) = if dot < 0.0 { (-dot, -1.0) } else { (dot, 1.0) };
    // The sine of a small angle is too small to divide by.
    if dot > 0.9999 {
        return mix(a, b, 1.0 - share, share * sign);
    }
    let angle = libm::acos(dot);
    let scale = 1.0 / libm::sin(angle);
    let (by_a, by_b) = (libm::sin((1.0 - share) * angle) * scale, libm::sin(share * angle) * scale);
    mix(a, b, by_a, by_b * sign)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(property: Property, interpolation: Interpolation, width: usize, values: &[f64]) -> Track {
        Track {
            animation: 0,
            node: 0,
            property,
            interpolation,
            times: vec![1.0, 3.0],
            width,
            values: values.into(),
        }
    }

    #[test]
    fn values_are_held_stepped_or_mixed() {
        let step = track(Property::Scale, Interpolation::Step, 1, &[4.0, 8.0]);
        let linear = track(Property::Scale, Interpolation::Linear, 1, &[4.0, 8.0]);
        for (time, stepped, mixed) in
            [(-1.0, 4.0, 4.0), (1.0, 4.0, 4.0), (2.0, 4.0, 6.0), (3.0, 8.0, 8.0), (9.0, 8.0, 8.0)]
        {
            assert_eq!((step.at(time), linear.at(time)), (vec![stepped], vec![mixed]), "{time}");
        }
        assert_eq!(linear.end(), 3.0);
    }

    #[test]
    fn splines_follow_their_tangents() {
        // The cubic x³ between 1 and 3: its values and slopes are given, its middle follows.
        let spline =
            track(Property::Translation, Interpolation::CubicSpline, 1, &[0.0, 1.0, 3.0, 27.0, 27.0, 0.0]);
        for time in [1.0, 1.5, 2.0, 2.75, 3.0] {
            assert!((spline.at(time)[0] - time * time * time).abs() < 1e-12, "{time}");
        }
    }

    #[test]
    fn rotations_take_the_shorter_way_at_constant_speed() {
        let turn = |degrees: f64| {
            let half = degrees.to_radians() * 0.5;
            [0.0, libm::sin(half), 0.0, libm::cos(half)]
        };
        let [from, to] = [turn(10.0), turn(100.0).map(|c| -c)];
        let track = track(Property::Rotation, Interpolation::Linear, 4, &[from, to].concat());
        for (time, degrees) in [(1.0, 10.0), (1.5, 32.5), (2.0, 55.0)] {
            let expected = turn(degrees);
            let found = track.at(time);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        }
    }
}
