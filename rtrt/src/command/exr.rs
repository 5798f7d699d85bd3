//! OpenEXR files: a color, or all layers.

use super::run_report::Shot;
use exr::prelude::*;
use rtrt::layers::Layers;
use std::io::Cursor;

/// A file with the linear color only.
pub fn color(layers: &Layers, shot: &Shot) -> exr::error::Result<Vec<u8>> {
    write(layers, shot, vec![("color", colors(layers))])
}

/// A file with all layers, each a part.
pub fn all(layers: &Layers, motion: Option<&[[f32; 2]]>, shot: &Shot) -> exr::error::Result<Vec<u8>> {
    let mut parts = vec![
        ("color", colors(layers)),
        ("depth", channels(["Z"], &each(&layers.depth))),
        ("normal", channels(["X", "Y", "Z"], &layers.normal)),
        ("albedo", channels(["R", "G", "B"], &layers.albedo)),
        ("object", [numbers("id", &layers.object)].into_iter().collect()),
        ("material", [numbers("id", &layers.material)].into_iter().collect()),
        (
            "triangle",
            [numbers("id", &layers.triangle), numbers("source", &layers.source)].into_iter().collect(),
        ),
        ("barycentrics", channels(["U", "V"], &layers.barycentrics)),
        ("uv", channels(["U", "V"], &layers.uv)),
        ("position", channels(["X", "Y", "Z"], &layers.position)),
        ("shadow", channels(["Y"], &each(&layers.shadow))),
    ];
    parts.extend(motion.map(|motion| ("motion", channels(["X", "Y"], motion))));
    write(layers, shot, parts)
}

/// Channels with their names.
type Channels = SmallVec<[AnyChannel<FlatSamples>; 4]>;

fn colors(layers: &Layers) -> Channels {
    channels(["R", "G", "B", "A"], &layers.color)
}

/// A channel for each component.
fn channels<const N: usize>(names: [&str; N], pixels: &[[f32; N]]) -> Channels {
    let channel = |i: usize| {
        let samples = pixels.iter().map(|pixel| pixel[i]).collect();
        AnyChannel::new(names[i], FlatSamples::F32(samples))
    };
    (0..N).map(channel).collect()
}

/// Each number as a pixel of one component.
fn each(numbers: &[f32]) -> Vec<[f32; 1]> {
    numbers.iter().map(|&number| [number]).collect()
}

/// A channel of whole numbers.
fn numbers(name: &str, samples: &[u32]) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::U32(samples.to_vec()))
}

fn write(layers: &Layers, shot: &Shot, parts: Vec<(&str, Channels)>) -> exr::error::Result<Vec<u8>> {
    let size = Vec2(layers.width as usize, layers.height as usize);
    let parts = parts.into_iter().map(|(name, channels)| {
        let attributes = LayerAttributes::named(name);
        Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels))
    });
    let parts: SmallVec<[_; 2]> = parts.collect();
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    // Text of these files is Latin-1: other letters are dropped from the names of cameras.
    let json = serde_json::to_string(shot).unwrap_or_default().replace(|c: char| !c.is_ascii(), "?");
    if let Some(json) = Text::new_or_none(json) {
        attributes.other.insert(Text::from("rtrt"), AttributeValue::Text(json));
    }
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layers(attributes, parts).write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}
