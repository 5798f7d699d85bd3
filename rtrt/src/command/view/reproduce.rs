//! The command line that renders the current picture.

use crate::command::Command;
use crate::command::job::RenderJob;
use crate::command::options::Common;
use crate::command::parse::{EnvironmentSun, LIGHT_COLOR, SHADOWS};
use crate::command::render::SAMPLES;
use crate::command::repaint::Repaint;
use crate::command::surroundings::{Surrounded, default_blur};
use clap::CommandFactory;
use clap::parser::ValueSource;
use glam::{DVec3, Vec3};
use rtrt::debug::DebugView;
use rtrt_core::backend::{LAYERS, Request, Shading, Shadows, ToneMap};
use rtrt_core::scene::{Light, LightKind, Projection, Scene};
use std::ffi::OsString;
use std::fmt::Write;
use std::path::Path;

/// The inputs of a screenshot.
pub struct Shot<'a> {
    pub common: &'a Common,
    /// See [`passed_on`].
    pub passed_on: &'a [String],
    pub request: Request<'a>,
    /// What coordinates of the scene are relative to.
    pub origin: DVec3,
    /// The time of the animation; none at rest.
    pub time: Option<f64>,
    /// Whether a GPU rasterizes the first surfaces.
    pub hybrid: bool,
    pub debug: Option<DebugView>,
    /// The lights, if the panel has changed them.
    pub lights: Option<&'a [Light]>,
    /// Ambient light and background, if the panel has changed them.
    pub colors: Option<(Vec3, Vec3)>,
    /// The environment, if there is one.
    pub environment: Option<EnvironmentShot>,
    /// The animation that was chosen, if the scene is not at rest.
    pub animation: Option<&'a str>,
    /// The numbers of objects that are not drawn.
    pub hidden: Vec<u32>,
    /// The changes of materials.
    pub materials: Vec<Repaint>,
}

/// How an environment is shown.
#[derive(Debug, Clone, Copy)]
pub struct EnvironmentShot {
    /// Whether it is the studio, and nobody asked for it.
    is_default: bool,
    is_studio: bool,
    /// Radians.
    rotation: f32,
    intensity: f32,
    blur: f32,
}

impl EnvironmentShot {
    /// That of the job's scene.
    pub fn new(job: &RenderJob) -> Self {
        let Surrounded { is_default, is_studio, .. } = job.surrounded;
        let Scene { environment_rotation, environment_intensity, environment_blur, .. } = *job.scene;
        Self {
            is_default,
            is_studio,
            rotation: environment_rotation,
            intensity: environment_intensity,
            blur: environment_blur,
        }
    }
}

/// Options of `rtrt view` that are not passed on: they do not affect the picture, or [`command`] gives their
/// current values.
const OWN: [&str; 43] = [
    "animation",
    "hide",
    "materials",
    "output",
    "fps",
    "live",
    "window",
    "watch",
    "record",
    "replay",
    "hybrid",
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
    "exposure",
    "tone_map",
    "environment_rotation",
    "environment_intensity",
    "environment_blur",
    "environment_sun",
    "lights",
    "ambient",
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
    "near",
    "far",
];

/// The options of a command line that affect the picture and that the viewer does not change.
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

/// The command that renders the same file.
pub fn command(shot: &Shot<'_>, output: &Path) -> String {
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
    if request.shading == Shading::Pixel {
        option(format_args!("--shading pixel"));
    }
    if request.shadows != Shadows::default() {
        let known = SHADOWS.iter().find(|(_, how)| *how == request.shadows);
        option(format_args!("--shadows {}", known.map_or("soft", |(name, _)| name)));
    }
    if request.layers != LAYERS {
        option(format_args!("--transparency-depth {}", request.layers));
    }
    if request.exposure != 0.0 {
        option(format_args!("--exposure {}", request.exposure));
    }
    if request.tone_map != ToneMap::Neutral {
        let known = ToneMap::ALL.iter().find(|(_, map)| *map == request.tone_map);
        option(format_args!("--tone-map {}", known.map_or("none", |(name, _)| name)));
    }
    for text in shot.passed_on {
        option(format_args!("{text}"));
    }
    if let (None, Some(ambient)) = (shot.colors, common.ambient) {
        option(format_args!("--ambient {}", vector(ambient)));
    }
    if let (None, Some(radius)) = (shot.lights, common.light_radius) {
        option(format_args!("--light-radius {radius}"));
    }
    if shot.lights.is_none() {
        for given in &common.lights {
            let position = given.position().to_array().map(|c| c.to_string()).join(",");
            option(format_args!("--light {}", light_option(&given.relative_to(shot.origin), &position)));
        }
    }
    for light in shot.lights.unwrap_or_default() {
        option(format_args!("--light {}", light_option(light, &in_file(light.position, shot.origin))));
    }
    if let Some(environment) = &shot.environment {
        // Lights of their own would put a scene out of the studio.
        if environment.is_default && shot.lights.is_some() {
            option(format_args!("--environment studio"));
        }
        if environment.rotation != 0.0 {
            option(format_args!("--environment-rotation {}", degrees(environment.rotation)));
        }
        if environment.intensity != 1.0 {
            option(format_args!("--environment-intensity {}", environment.intensity));
        }
        if environment.blur != default_blur(environment.is_studio) {
            option(format_args!("--environment-blur {}", environment.blur));
        }
        match (common.surroundings.sun, shot.lights) {
            (EnvironmentSun::Keep, _) => option(format_args!("--environment-sun keep")),
            // It is among the lights.
            (EnvironmentSun::Light, Some(_)) | (EnvironmentSun::Drop, _) => {
                option(format_args!("--environment-sun drop"));
            }
            (EnvironmentSun::Light, None) => {}
        }
    }
    if let Some((ambient, background)) = shot.colors.filter(|_| shot.environment.is_none()) {
        option(format_args!("--ambient {}", vector(ambient)));
        // Debug views have no background.
        if shot.debug.is_none() {
            option(format_args!("--background {}", vector(background)));
        }
    }
    for repaint in &shot.materials {
        option(format_args!("--material {repaint}"));
    }
    if !shot.hidden.is_empty() {
        let numbers: Vec<_> = shot.hidden.iter().map(u32::to_string).collect();
        option(format_args!("--hide {}", numbers.join(",")));
    }
    if let Some(animation) = shot.animation {
        option(format_args!("--animation {}", quoted(Path::new(animation))));
    }
    if let Some(time) = shot.time {
        option(format_args!("--time {time}"));
    }
    let camera = request.camera;
    option(format_args!("--eye {}", in_file(camera.eye, shot.origin)));
    option(format_args!("--look-at {}", in_file(camera.look_at, shot.origin)));
    option(format_args!("--up {}", vector(camera.up)));
    match camera.projection {
        Projection::Perspective { fov_y } => {
            option(format_args!("--fov-y {}", degrees(fov_y)));
        }
        Projection::Orthographic { height } => option(format_args!("--parallel {height}")),
        // No file and no option of the viewer makes one.
        Projection::OffCenter { .. } => {}
    }
    let [near, far] = request.clip;
    if near > 0.0 {
        option(format_args!("--near {near}"));
    }
    if far < f32::INFINITY {
        option(format_args!("--far {far}"));
    }
    if shot.hybrid {
        // The CPU has no hybrid frames.
        option(format_args!("--hybrid --backend gpu"));
        if let Some(adapter) = &common.backend.adapter {
            option(format_args!("--adapter {}", quoted(Path::new(adapter))));
        }
    }
    if let Some((name, _)) = DebugView::ALL.iter().find(|(_, view)| Some(*view) == shot.debug) {
        option(format_args!("--debug {name}"));
    }
    line
}

/// Three numbers, which parse to the same bits.
fn vector(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}

/// A point that the scene has relative to an origin, in the file's coordinates.
fn in_file(point: Vec3, origin: DVec3) -> String {
    if origin == DVec3::ZERO {
        return vector(point);
    }
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let is_same = |number: f64| (number - origin[axis]) as f32 == point[axis];
        shortest(f64::from(point[axis]) + origin[axis], is_same)
    });
    format!("{x},{y},{z}")
}

/// The shortest number of degrees that is the same angle.
fn degrees(radians: f32) -> f64 {
    shortest(f64::from(radians).to_degrees(), |degrees| degrees.to_radians() as f32 == radians)
}

/// The number of the fewest digits near this one that is the same, or this one.
fn shortest(number: f64, is_same: impl Fn(f64) -> bool) -> f64 {
    let rounded = (0..16).filter_map(|digits| format!("{number:.digits$e}").parse().ok());
    rounded.into_iter().find(|number| is_same(*number)).unwrap_or(number)
}

/// The value of `--light` for a light that is there, in the file's coordinates.
fn light_option(light: &Light, position: &str) -> String {
    let Light { kind, direction, color, reach, inverse_square, inner, outer, radius, .. } = *light;
    let mut text = match kind {
        LightKind::Point => format!("point:{position}:{radius}"),
        LightKind::Spot => {
            format!("spot:{position}:{}:{}:{radius}", vector(direction), degrees(outer))
        }
        LightKind::Sun => format!("sun:{}:{}", vector(-direction), degrees(radius)),
    };
    if color != LIGHT_COLOR {
        text += &format!(":color={}", vector(color));
    }
    if kind != LightKind::Sun {
        text += &reach.map_or(String::new(), |reach| format!(":reach={reach}"));
        text += if inverse_square { "" } else { ":fade=linear" };
    }
    if kind == LightKind::Spot && inner > 0.0 {
        text += &format!(":inner={}", degrees(inner));
    }
    text
}

/// A path, quoted for a shell if necessary.
pub fn quoted(path: &Path) -> String {
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
    use crate::command::options::{CameraOptions, RenderOptions};
    use clap::Parser;
    use rtrt_core::scene::Camera;

    fn options(line: &str) -> RenderOptions {
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
            let request =
                Request::new(&camera, [123, 45]).samples(16).shadows(Shadows::Off).layers(3).deferred(true);
            let shading = if place % 3 == 0 { Shading::Pixel } else { Shading::Sample };
            let request = request.shading(shading);
            let request = if place % 2 == 0 { request.clip(0.1, 1e30) } else { request };
            let debug = Some(DebugView::Heat);
            let shot = Shot {
                common: &common,
                passed_on: &[],
                request,
                origin: if place % 3 == 0 { DVec3::new(6e6, -3e6, 0.5) } else { DVec3::ZERO },
                time: Some(0.1 + 0.2),
                hybrid: place % 3 == 0,
                debug,
                lights: None,
                colors: None,
                environment: None,
                animation: Some("run"),
                hidden: vec![3, 1],
                materials: vec!["2:alpha=0.5".parse().unwrap()],
            };
            let read = options(&command(&shot, Path::new("out.png")));
            let planes = if place % 2 == 0 { [Some(0.1), Some(1e30)] } else { [None; 2] };
            let CameraOptions { eye, look_at, up, near, far, .. } = read.common.camera;
            assert_eq!([near, far], planes);
            let back = |point: Option<DVec3>| point.map(|point| (point - shot.origin).as_vec3());
            let apart = |a: Option<Vec3>, b: Vec3| a.map_or(f32::MAX, |a| (a - b).abs().max_element());
            // Double precision at 6,000,000.
            let most = if place % 3 == 0 { 1e-9 * camera.eye.abs().max_element().max(1.0) } else { 0.0 };
            assert!(apart(back(eye), camera.eye) <= most && apart(back(look_at), camera.look_at) <= most);
            assert_eq!(up, Some(camera.up));
            match projection {
                Projection::Perspective { fov_y } => assert_eq!(read.common.camera.fov_y, Some(fov_y)),
                Projection::Orthographic { height } => {
                    assert_eq!(read.common.camera.parallel, Some(height));
                }
                Projection::OffCenter { .. } => unreachable!("none is made above"),
            }
            assert_eq!((read.common.size, read.common.samples), ([123, 45], Some(16)));
            assert_eq!((read.common.shadows(), read.common.transparency_depth), (Shadows::Off, 3));
            assert_eq!((read.hybrid, read.common.shading), (place % 3 == 0, shading));
            assert_eq!((read.debug, read.common.time), (debug, Some(0.1 + 0.2)));
            assert_eq!(read.common.lights, common.lights);
            assert_eq!((read.common.hide, read.common.materials), (vec![3, 1], shot.materials));
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
    fn lights_are_read_as_the_same() {
        let (place, along) = (Vec3::new(0.1, -2e-7, 3e9), Vec3::new(1e-3, -1.0, 1.0 / 3.0));
        let mut number = 0.37_f32;
        for round in 0..200 {
            number = (number * 1.7).fract();
            let color = if round % 3 == 0 { LIGHT_COLOR } else { Vec3::new(number, 1e-9, 1e9 * number) };
            let reach = (round % 2 == 0).then_some(number * 10.0 + 0.1);
            let inverse_square = round % 5 < 2;
            let (outer, radius) = (number.max(0.01) * 1.5, number);
            let inner = if round % 4 == 0 { 0.0 } else { outer * number };
            for light in [
                Light::point(place).color(color).reach(reach).inverse_square(inverse_square).radius(radius),
                Light::spot(place, along, outer)
                    .color(color)
                    .reach(reach)
                    .inverse_square(inverse_square)
                    .inner(inner)
                    .radius(radius),
                Light::sun(along).color(color).radius(number * 0.78),
            ] {
                let text = light_option(&light, &in_file(light.position, DVec3::ZERO));
                assert_eq!(crate::command::parse::light(&text), Ok(light), "{text}");
            }
        }
    }

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        for text in ["45", "30", "0.5", "48.7", "-90", "179.99", "1e-7"] {
            let number: f64 = text.parse().unwrap();
            assert_eq!(degrees(number.to_radians() as f32), number);
        }
        let origin = DVec3::new(6e6, -3e6, 0.5);
        let point = (DVec3::new(6_000_000.1, -2_999_999.7, 0.75) - origin).as_vec3();
        assert_eq!(in_file(point, origin), "6000000.1,-2999999.7,0.75");
        let mut bits = 1_u32;
        for _ in 0..10_000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // From 2^-23 to 4.
            let angle = f32::from_bits(0x3400_0000 + (bits >> 4) % 0x0c80_0000);
            let text = degrees(angle).to_string();
            assert_eq!(text.parse::<f64>().unwrap().to_radians() as f32, angle, "{text}");
            // A float has 9 digits at most.
            assert!(text.trim_start_matches(['0', '.']).len() <= 10, "{text}");
        }
    }

    #[test]
    fn odd_names_are_quoted() {
        assert_eq!(quoted(Path::new("demo:matchbox")), "demo:matchbox");
        assert_eq!(quoted(Path::new("a b/it's.glb")), "'a b/it'\\''s.glb'");
        assert_eq!(quoted(Path::new("")), "''");
    }
}
