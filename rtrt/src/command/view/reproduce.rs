//! The command line that renders what is seen.

use crate::command::Command;
use crate::command::options::Common;
use crate::command::parse::SHADOWS;
use crate::command::render::SAMPLES;
use clap::CommandFactory;
use clap::parser::ValueSource;
use glam::Vec3;
use rtrt::debug::View;
use rtrt_core::backend::{LAYERS, Request, Shadows};
use rtrt_core::scene::{Light, Projection};
use std::ffi::OsString;
use std::fmt::Write;
use std::path::Path;

/// What a screenshot shows.
pub struct Shot<'a> {
    pub common: &'a Common,
    /// See [`passed_on`].
    pub passed_on: &'a [String],
    pub request: Request<'a>,
    /// When, of the animation, if it was played.
    pub time: Option<f64>,
    pub debug: Option<View>,
    /// The lights, if they are no longer those that the scene and the options give.
    pub lights: Option<&'a [Light]>,
}

/// Options of `rtrt view` that are not passed on: those that say nothing about the picture, and those
/// that [`command`] gives anew, because they may have changed.
const OWN: [&str; 28] = [
    "output",
    "fps",
    "watch",
    "record",
    "replay",
    "json",
    "cache",
    "backend",
    "adapter",
    "threads",
    "lanes",
    "size",
    "samples",
    "no_shadows",
    "shadows",
    "light_radius",
    "transparency_depth",
    "lights",
    "quiet",
    "verbose",
    "strict",
    "time",
    "camera",
    "eye",
    "look_at",
    "up",
    "fov_y",
    "parallel",
];

/// The options of a command line that change the picture, and that nothing in a viewer changes.
pub fn passed_on(line: impl IntoIterator<Item = OsString>) -> Vec<String> {
    let command = Command::command();
    let parsed = command.clone().try_get_matches_from(line);
    let (Some(view), Some(given)) = (
        command.find_subcommand("view"),
        parsed.as_ref().ok().and_then(|parsed| parsed.subcommand_matches("view")),
    ) else {
        return Vec::new();
    };
    let mut options = Vec::new();
    for argument in view.get_arguments() {
        let (name, Some(long)) = (argument.get_id().as_str(), argument.get_long()) else { continue };
        if OWN.contains(&name) || given.value_source(name) != Some(ValueSource::CommandLine) {
            continue;
        }
        if !argument.get_action().takes_values() {
            options.push(format!("--{long}"));
            continue;
        }
        let values = given.get_raw(name).into_iter().flatten();
        options.extend(values.map(|value| format!("--{long} {}", quoted(Path::new(value)))));
    }
    options
}

/// The command that writes the same file. None if no option gives one of the lights.
pub fn command(shot: &Shot<'_>, output: &Path) -> Option<String> {
    let Shot { common, request, .. } = shot;
    let [width, height] = request.size;
    let mut line =
        format!("rtrt render {} -o {} --size {width}x{height}", quoted(&common.scene), quoted(output));
    let mut option = |text: std::fmt::Arguments<'_>| {
        // Writing to a string does not fail.
        line.write_fmt(format_args!(" {text}")).ok();
    };
    if request.samples != SAMPLES {
        option(format_args!("--samples {}", request.samples));
    }
    if request.shadows != Shadows::default() {
        let (name, _) = SHADOWS.iter().find(|(_, how)| *how == request.shadows)?;
        option(format_args!("--shadows {name}"));
    }
    if request.layers != LAYERS {
        option(format_args!("--transparency-depth {}", request.layers));
    }
    for text in shot.passed_on {
        option(format_args!("{text}"));
    }
    if let (None, Some(radius)) = (shot.lights, common.light_radius) {
        option(format_args!("--light-radius {radius}"));
    }
    for light in shot.lights.unwrap_or(&common.lights) {
        option(format_args!("--light {}", light_option(light)?));
    }
    if let Some(time) = shot.time {
        option(format_args!("--time {time}"));
    }
    let camera = request.camera;
    option(format_args!("--eye {}", vector(camera.eye)));
    option(format_args!("--look-at {}", vector(camera.look_at)));
    option(format_args!("--up {}", vector(camera.up)));
    match camera.projection {
        Projection::Perspective { fov_y } => {
            option(format_args!("--fov-y {}", f64::from(fov_y).to_degrees()));
        }
        Projection::Orthographic { height } => option(format_args!("--parallel {height}")),
    }
    if let Some((name, _)) = View::ALL.iter().find(|(_, view)| Some(*view) == shot.debug) {
        option(format_args!("--debug {name}"));
    }
    Some(line)
}

/// Numbers that are read as the same ones.
fn vector(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}

/// What `--light` takes for a light; none if it has no form for it.
fn light_option(light: &Light) -> Option<String> {
    match *light {
        Light::Point { position, color, reach: None, inverse_square: false, radius }
            if color == Vec3::ONE =>
        {
            Some(format!("point:{}:{radius}", vector(position)))
        }
        Light::Spot {
            position,
            direction,
            inner: 0.0,
            outer,
            color,
            reach: None,
            inverse_square: false,
            radius,
        } if color == Vec3::ONE => {
            let degrees = f64::from(outer).to_degrees();
            Some(format!("spot:{}:{}:{degrees}:{radius}", vector(position), vector(direction)))
        }
        Light::Sun { direction, color, radius } if color == Vec3::ONE => {
            Some(format!("sun:{}:{}", vector(-direction), f64::from(radius).to_degrees()))
        }
        _ => None,
    }
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    let text = path.to_string_lossy();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-:+,=@".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.into();
    }
    format!("'{}'", text.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::options::{CameraOptions, Render};
    use clap::Parser;
    use rtrt_core::scene::Camera;

    fn options(line: &str) -> Render {
        match Command::parse_from(line.split_whitespace()) {
            Command::Render(options) => options,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_is_printed_is_read_as_the_same() {
        let common = options(
            "rtrt render a.obj -o x.png --light point:0.1,-2e-7,3e9 --light spot:1,2,3:0,-1,0.3:33.3:0.7 \
             --light sun:1,2,2:3.3",
        )
        .common;
        let numbers = [0.1, 1.0 / 3.0, 1e-20, 1.234_567_9e20, 0.7, 1e-3, 3.1];
        for (place, &number) in numbers.iter().enumerate() {
            let eye = Vec3::new(number, -number, 7.0);
            let projection = if place % 2 == 0 {
                Projection::Orthographic { height: number }
            } else {
                Projection::Perspective { fov_y: number.min(3.1) }
            };
            let camera = Camera { eye, look_at: -eye, up: eye + 1.0, projection };
            let request = Request {
                camera: &camera,
                size: [123, 45],
                samples: 16,
                shadows: Shadows::Off,
                layers: 3,
                deferred: true,
            };
            let debug = Some(View::Heat);
            let shot =
                Shot { common: &common, passed_on: &[], request, time: Some(0.1 + 0.2), debug, lights: None };
            let read = options(&command(&shot, Path::new("out.png")).unwrap());
            let CameraOptions { eye, look_at, up, .. } = read.common.camera;
            assert_eq!((eye, look_at, up), (Some(camera.eye), Some(camera.look_at), Some(camera.up)));
            match projection {
                Projection::Perspective { fov_y } => assert_eq!(read.common.camera.fov_y, Some(fov_y)),
                Projection::Orthographic { height } => {
                    assert_eq!(read.common.camera.parallel, Some(height));
                }
            }
            assert_eq!((read.common.size, read.common.samples), ([123, 45], Some(16)));
            assert_eq!((read.common.shadows(), read.common.transparency_depth), (Shadows::Off, 3));
            assert_eq!((read.debug, read.common.time), (debug, Some(0.1 + 0.2)));
            assert_eq!(read.common.lights, common.lights);
        }
    }

    #[test]
    fn what_a_viewer_does_not_change_is_passed_on() {
        let line = "rtrt view a.obj --fps 9 --environment sky.hdr --watch --threads 2 --eye 1,2,3 --size 9x9";
        assert_eq!(passed_on(line.split(' ').map(OsString::from)), ["--environment sky.hdr"]);
        let view = Command::command().find_subcommand("view").unwrap().clone();
        let is_known = |name: &&str| view.get_arguments().any(|argument| *argument.get_id() == **name);
        assert_eq!(OWN.iter().find(|name| !is_known(name)), None);
    }

    #[test]
    fn a_light_without_an_option_is_admitted() {
        let light = Light::Sun { direction: Vec3::X, color: Vec3::X, radius: 0.0 };
        assert_eq!(light_option(&light), None);
    }

    #[test]
    fn odd_names_are_quoted() {
        assert_eq!(quoted(Path::new("demo:matchbox")), "demo:matchbox");
        assert_eq!(quoted(Path::new("a b/it's.glb")), "'a b/it'\\''s.glb'");
        assert_eq!(quoted(Path::new("")), "''");
    }
}
