//! Animations: from keyframes to numbers at a time.

use super::Import;
use super::accessor::Column;
use crate::import::ImportError;
use gltf_json::accessor::Type;
use gltf_json::animation::{Channel, Interpolation, Property, Sampler};
use gltf_json::validation::Checked;
use rtrt_core::scene::Join;

/// How one property of a node changes with time.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    /// The animation that it is of, in the file.
    pub animation: usize,
    /// The node, in the file.
    pub node: usize,
    /// Which of its properties.
    pub property: Property,
    interpolation: Interpolation,
    /// Seconds, rising.
    times: Vec<f64>,
    /// Numbers of one value.
    width: usize,
    /// `width` numbers a keyframe; three times as many for splines (tangent on the way in, value,
    /// tangent on the way out).
    values: Vec<f64>,
}

impl Track {
    /// When the last keyframe is.
    pub fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The value at a time. Before the first keyframe it is that of the first, after the last
    /// that of the last.
    ///
    /// Rotations turn at constant speed along the shorter way (slerp); splines are Hermite's, as
    /// the format has them. Sines come from `libm`, so that hosts agree.
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

/// A rotation between two (Shoemake, "Animating Rotation with Quaternion Curves", 1985).
fn slerp(a: &[f64], b: &[f64], share: f64) -> Vec<f64> {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let (dot, sign) = if dot < 0.0 { (-dot, -1.0) } else { (dot, 1.0) };
    // Too near to each other to divide by the sine of the angle between them.
    if dot > 0.9999 {
        return mix(a, b, 1.0 - share, share * sign);
    }
    let angle = libm::acos(dot);
    let scale = 1.0 / libm::sin(angle);
    let (by_a, by_b) = (libm::sin((1.0 - share) * angle) * scale, libm::sin(share * angle) * scale);
    mix(a, b, by_a, by_b * sign)
}

impl<J: Join> Import<'_, '_, J> {
    /// The tracks of all animations of the file. Those that mean nothing are left out with a
    /// warning.
    pub fn tracks(&mut self) -> Vec<Track> {
        let mut tracks = Vec::new();
        for (index, animation) in self.root.animations.iter().enumerate() {
            for (number, channel) in animation.channels.iter().enumerate() {
                let track = self.track(index, channel, animation.samplers.get(channel.sampler.value()));
                match track.unwrap_or_else(|error| Err(error.to_string())) {
                    Ok(track) => tracks.push(track),
                    Err(why) => {
                        let what = format!("channel {number} of animation {index}");
                        self.builder.warn(format!("{what} is left out: {why}"));
                    }
                }
            }
        }
        tracks
    }

    fn track(
        &self,
        animation: usize,
        channel: &Channel,
        sampler: Option<&Sampler>,
    ) -> Result<Result<Track, String>, ImportError> {
        let refused = |why: &str| Ok(Err(why.to_owned()));
        let Some(sampler) = sampler else { return refused("it has no sampler") };
        let (Checked::Valid(property), Checked::Valid(interpolation)) =
            (channel.target.path, sampler.interpolation)
        else {
            return refused("it has an unknown target or interpolation");
        };
        let column = |index, kind| Column::new(&self.builder.path, self.root, self.buffers, index, &[kind]);
        let input = column(sampler.input, Type::Scalar)?;
        let kind = match property {
            Property::Translation | Property::Scale => Type::Vec3,
            Property::Rotation => Type::Vec4,
            Property::MorphTargetWeights => Type::Scalar,
        };
        let output = column(sampler.output, kind)?;
        let times: Vec<f64> = (0..input.count).map(|i| f64::from(input.at(i)[0])).collect();
        let values =
            (0..output.count).flat_map(|i| output.at(i).map(f64::from).into_iter().take(output.width));
        let values: Vec<f64> = values.collect();
        let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if times.is_empty() || !values.len().is_multiple_of(parts * times.len()) {
            return refused("its keyframes and values differ in number");
        }
        let width = values.len() / (parts * times.len());
        if width == 0 || (property != Property::MorphTargetWeights && width != kind.multiplicity()) {
            return refused("its keyframes and values differ in number");
        }
        if !times.is_sorted_by(|a, b| a < b) || !times.iter().chain(&values).all(|n| n.is_finite()) {
            return refused("its times do not rise, or a number is not finite");
        }
        let node = channel.target.node.value();
        Ok(Ok(Track { animation, node, property, interpolation, times, width, values }))
    }
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
