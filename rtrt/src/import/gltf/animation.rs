//! Animations: from keyframes to numbers at a time.

use super::accessor::Column;
use super::meshes::Import;
use crate::import::ImportError;
use crate::import::track::Track;
use gltf_json::accessor::Type;
use gltf_json::animation::{Channel, Interpolation, Property, Sampler};
use gltf_json::validation::Checked;
use rtrt_core::scene::Join;

impl<J: Join> Import<'_, '_, J> {
    /// The tracks of all animations of the file. A channel with an error is left out with a warning.
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
