//! The values of command line options.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use core::f32::consts::PI;
use glam::{DVec3, Vec3};
use rtrt::choose::Choice;
use rtrt::debug;
use rtrt_core::backend::{Shading, Shadows, ToneMap};
use rtrt_core::layout::LIGHT_LIMIT;
use rtrt_core::num::srgb_decode;
use rtrt_core::scene::{Light, LightKind, Mip, Occluders, Setup, Structure};
use std::path::{Path, PathBuf};

/// One of a few numbers.
pub fn one_of<const N: usize>(allowed: [&'static str; N]) -> impl TypedValueParser<Value = u32> {
    PossibleValuesParser::new(allowed).try_map(|text| text.parse::<u32>())
}

/// The names of the ways to cast shadows.
pub const SHADOWS: [(&str, Shadows); 5] = [
    ("off", Shadows::Off),
    ("hard", Shadows::Hard),
    ("soft", Shadows::Soft),
    ("area", Shadows::Area { jitter: None }),
    ("jitter", Shadows::Area { jitter: Some(0) }),
];

/// A way to cast shadows.
pub fn shadows() -> impl TypedValueParser<Value = Shadows> {
    PossibleValuesParser::new(SHADOWS.map(|(name, _)| name)).map(|given| {
        SHADOWS.iter().find(|(name, _)| *name == given).map_or(Shadows::default(), |(_, how)| *how)
    })
}

/// The names of ways to shade.
pub const SHADINGS: [(&str, Shading); 2] = [("sample", Shading::Sample), ("pixel", Shading::Pixel)];

/// A way to shade.
pub fn shading() -> impl TypedValueParser<Value = Shading> {
    PossibleValuesParser::new(SHADINGS.map(|(name, _)| name)).map(|given| {
        SHADINGS.iter().find(|(name, _)| *name == given).map_or(Shading::default(), |(_, how)| *how)
    })
}

/// How light becomes colors.
pub fn tone_map() -> impl TypedValueParser<Value = ToneMap> {
    PossibleValuesParser::new(ToneMap::ALL.map(|(name, _)| name)).map(|given| {
        ToneMap::ALL.iter().find(|(name, _)| *name == given).map_or(ToneMap::default(), |(_, map)| *map)
    })
}

/// Stops by which light is raised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exposure {
    /// So many.
    Stops(f32),
    /// What the meter says.
    Auto,
}

/// `auto`, or a number of stops.
pub fn exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    let stops = text.parse().ok().filter(|stops: &f32| stops.abs() <= Setup::MAX_STOPS);
    stops.map(Exposure::Stops).ok_or(format!("not auto, or a number within ±{}", Setup::MAX_STOPS))
}

/// An environment.
#[derive(Debug, Clone, PartialEq)]
pub enum Environment {
    /// None.
    Nothing,
    /// The built-in one.
    Studio,
    /// That of a file or folder.
    At(PathBuf),
}

/// `none`, `studio`, or a path.
pub fn environment(path: PathBuf) -> Environment {
    match path.to_str() {
        Some("none") => Environment::Nothing,
        Some("studio") => Environment::Studio,
        _ => Environment::At(path),
    }
}

/// What becomes of an environment's sun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnvironmentSun {
    /// It becomes a light that casts shadows.
    Light,
    /// It stays in the environment.
    Keep,
    /// It is taken out of the environment, and gone.
    Drop,
}

/// What becomes of an environment's sun.
pub fn environment_sun() -> impl TypedValueParser<Value = EnvironmentSun> {
    PossibleValuesParser::new(["light", "keep", "drop"]).map(|name| match &name[..] {
        "keep" => EnvironmentSun::Keep,
        "drop" => EnvironmentSun::Drop,
        _ => EnvironmentSun::Light,
    })
}

/// From how far away surfaces hide ambient light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AmbientOcclusion {
    /// Not at all.
    Off,
    /// From a sixteenth of the scene's diagonal.
    Auto,
    /// From this distance, world units.
    Reach(f32),
}

/// `off`, `auto` or a distance.
pub fn ambient_occlusion(text: &str) -> Result<AmbientOcclusion, &'static str> {
    match text {
        "off" => Ok(AmbientOcclusion::Off),
        "auto" => Ok(AmbientOcclusion::Auto),
        _ => {
            let reach = height(text).ok().filter(|reach| (1e-18..=1e18).contains(reach));
            reach.map(AmbientOcclusion::Reach).ok_or("neither off, auto nor a distance of 1e-18 to 1e18")
        }
    }
}

/// Degrees, to radians, all the way around and more.
pub fn turn(text: &str) -> Result<f32, &'static str> {
    let degrees = text.parse().ok().filter(|degrees: &f64| degrees.abs() <= 36_000.0);
    degrees.map(|degrees| degrees.to_radians() as f32).ok_or("not a number of degrees within ±36000")
}

/// What light is multiplied by.
pub fn intensity(text: &str) -> Result<f32, &'static str> {
    radius(text).ok().filter(|factor| *factor <= 65_536.0).ok_or("not a number within 0 and 65536")
}

/// A part of all.
pub fn part(text: &str) -> Result<f32, &'static str> {
    text.parse().ok().filter(|part: &f32| (0.0..=1.0).contains(part)).ok_or("not a number within 0 and 1")
}

/// A backend's name.
pub fn choice() -> impl TypedValueParser<Value = Choice> {
    PossibleValuesParser::new(["auto", "cpu", "gpu"]).map(|name| match &name[..] {
        "cpu" => Choice::Cpu,
        "gpu" => Choice::Gpu,
        _ => Choice::Auto,
    })
}

/// `all`, or a distance.
pub fn occluders(text: &str) -> Result<Occluders, &'static str> {
    match text {
        "all" => Ok(Occluders::All),
        _ => rate(text)
            .map(|distance| Occluders::Near(distance as f32))
            .map_err(|_| "neither all nor a number above 0"),
    }
}

/// The choice of mip levels.
pub fn mip() -> impl TypedValueParser<Value = Mip> {
    PossibleValuesParser::new(["distance", "angle"]).map(|name| match &name[..] {
        "angle" => Mip::Angle,
        _ => Mip::Distance,
    })
}

/// `blocks`, `objects`, `none`, or the most triangles of a part of an object.
pub fn structure(text: &str) -> Result<Structure, String> {
    match text {
        "blocks" => Ok(Structure::Blocks),
        "objects" => Ok(Structure::Objects),
        "none" => Ok(Structure::None),
        _ => {
            let triangles = text.parse().ok().filter(|&triangles| triangles > 0);
            triangles
                .map(Structure::Parts)
                .ok_or("not blocks, objects, none, or a number of triangles above 0".into())
        }
    }
}

/// `1280x720`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=Setup::MAX_SIDE).contains(side));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or(format!("not WIDTHxHEIGHT with sides of 1 to {}", Setup::MAX_SIDE))
}

/// `-12,4,0`.
pub fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f32>> =
        text.split(',').map(|number| number.trim().parse().ok().filter(|n: &f32| n.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("not three finite numbers with commas between them".into()),
    }
}

/// A point, in coordinates that single precision need not hold exactly: `6000000.1,4,0`.
pub fn point_of_file(text: &str) -> Result<DVec3, String> {
    vector(text)?;
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err("not three finite numbers with commas between them".into()),
    }
}

/// The background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Background {
    /// Linear RGB.
    Color([f32; 3]),
    /// Nothing.
    Transparent,
    /// The environment.
    Environment,
}

/// `0.1,0.2,0.5`, `navy`, `#336`, `transparent` or `env`.
pub fn background(text: &str) -> Result<Background, String> {
    match text {
        "transparent" => Ok(Background::Transparent),
        "env" => Ok(Background::Environment),
        color => {
            let linear = vector(color).ok().filter(|color| color.min_element() >= 0.0).map(|c| c.to_array());
            let color = linear.or_else(|| css(color)).map(Background::Color);
            color.ok_or("not three numbers of 0 or more, an opaque color of CSS, transparent or env".into())
        }
    }
}

/// The linear light of an opaque color of CSS, which is sRGB.
fn css(text: &str) -> Option<[f32; 3]> {
    let color = csscolorparser::parse(text).ok().filter(|color| color.a >= 1.0)?;
    Some([color.r, color.g, color.b].map(|channel| srgb_decode(channel.clamp(0.0, 1.0))))
}

/// Degrees, to radians.
pub fn angle(text: &str) -> Result<f32, String> {
    let radians = text.parse().map(|degrees: f64| degrees.to_radians() as f32);
    radians
        .ok()
        .filter(|&radians| radians > 0.0 && radians < core::f32::consts::PI)
        .ok_or("not a number within 0 and 180".into())
}

/// World units, above 0.
pub fn height(text: &str) -> Result<f32, &'static str> {
    let height = text.parse().ok().filter(|height: &f32| *height > 0.0 && height.is_finite());
    height.ok_or("not a finite number above 0")
}

/// World units, 0 or more, or infinitely many.
pub fn depth(text: &str) -> Result<f32, &'static str> {
    text.parse().ok().filter(|depth: &f32| *depth >= 0.0).ok_or("not a number of 0 or more")
}

/// Seconds, 0 or more.
pub fn seconds(text: &str) -> Result<f64, &'static str> {
    text.parse().ok().filter(|time: &f64| time.is_finite() && *time >= 0.0).ok_or("not a number of 0 or more")
}

/// Frames a second, above 0.
pub fn rate(text: &str) -> Result<f64, &'static str> {
    seconds(text).ok().filter(|rate| *rate >= 1e-6).ok_or("not a number above 0")
}

/// A radius, 0 or more.
pub fn radius(text: &str) -> Result<f32, &'static str> {
    text.parse().ok().filter(|r: &f32| r.is_finite() && *r >= 0.0).ok_or("not a number of 0 or more")
}

/// A linear color.
pub fn tone(text: &str) -> Result<Vec3, &'static str> {
    let color = vector(text).ok().filter(|color| (0.0..=LIGHT_LIMIT).contains(&color.min_element()));
    let color = color.filter(|color| color.max_element() <= LIGHT_LIMIT);
    color.ok_or("not three numbers of 0 to 2^48 with commas between them")
}

/// The color of a light without one: candela, or lux for a sun. A white surface that faces it at a distance of
/// 1 is white.
pub const LIGHT_COLOR: Vec3 = Vec3::splat(PI);

/// A light, and its position in the file's coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenLight {
    light: Light,
    position: DVec3,
}

impl GivenLight {
    /// Where it is, in the file's coordinates.
    #[cfg(feature = "viewer")]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// The light in a scene whose coordinates are relative to this origin.
    pub fn relative_to(&self, origin: DVec3) -> Light {
        let mut light = self.light;
        light.position = (self.position - origin).as_vec3();
        light
    }
}

/// [`light`], with the digits of its position.
pub fn given_light(text: &str) -> Result<GivenLight, String> {
    let light = light(text)?;
    let place = text.split(':').filter(|part| !part.contains('=')).nth(1);
    let position = match light.kind {
        LightKind::Sun => light.position.as_dvec3(),
        _ => place.map_or(Ok(light.position.as_dvec3()), point_of_file)?,
    };
    Ok(GivenLight { light, position })
}

/// `point:0,14,0`, `spot:0,14,0:0,-1,0:30` or `sun:1,2,2`, perhaps with a radius and properties such as
/// `color=1,0.5,0`.
pub fn light(text: &str) -> Result<Light, String> {
    const FORMS: &str = "not point:X,Y,Z, spot:X,Y,Z:X,Y,Z:DEGREES or sun:X,Y,Z, with or without :RADIUS";
    let (more, parts): (Vec<_>, Vec<_>) = text.split(':').partition(|part| part.contains('='));
    let light = match parts[..] {
        ["point", place] => point(place, "0"),
        ["point", place, radius] => point(place, radius),
        ["spot", place, direction, outer] => spot(place, direction, outer, "0"),
        ["spot", place, direction, outer, radius] => spot(place, direction, outer, radius),
        ["sun", place] => sun(place, "0"),
        ["sun", place, radius] => sun(place, radius),
        _ => Err(FORMS.into()),
    };
    let mut seen = Vec::new();
    more.into_iter().try_fold(light?, |light, what| {
        let (key, value) = what.split_once('=').unwrap_or_default();
        if seen.contains(&key) {
            return Err(format!("the light has two values of {key}"));
        }
        seen.push(key);
        with(light, key, value)
    })
}

/// The light with a property.
fn with(mut light: Light, key: &str, value: &str) -> Result<Light, String> {
    let is_sun = light.kind == LightKind::Sun;
    match key {
        "color" => light.color = tone(value)?,
        "reach" if !is_sun => light.reach = Some(height(value)?),
        "fade" if !is_sun => {
            light.inverse_square = match value {
                "square" => true,
                "linear" => false,
                _ => return Err("a light's fade is square or linear".into()),
            }
        }
        "inner" if light.kind == LightKind::Spot => {
            let angle = value.parse().map(|degrees: f64| degrees.to_radians() as f32);
            let angle = angle.ok().filter(|angle| (0.0..=light.outer).contains(angle));
            light.inner = angle.ok_or("the inner angle is not within 0 and the outer one")?;
        }
        _ => {
            let (kind, known) = match light.kind {
                LightKind::Sun => ("sun", "color"),
                LightKind::Point => ("point light", "color, reach and fade"),
                LightKind::Spot => ("spot light", "color, reach, fade and inner"),
            };
            return Err(format!("a {kind} has no {key}; it may have {known}"));
        }
    }
    Ok(light)
}

/// The position of a point or spot light.
fn place(text: &str) -> Result<Vec3, String> {
    let place = vector(text)?;
    let is_near = place.abs().max_element() <= Light::FARTHEST;
    if is_near { Ok(place) } else { Err("a light's position must be within ±2^40".into()) }
}

/// Position and radius of a point light.
pub fn point(position: &str, size: &str) -> Result<Light, String> {
    let (position, radius) = (place(position)?, radius(size)?);
    Ok(Light::point(position).color(LIGHT_COLOR).inverse_square(true).radius(radius))
}

/// The direction towards the sun, and its radius in degrees.
pub fn sun(place: &str, size: &str) -> Result<Light, String> {
    let (place, radius) = (vector(place)?, seconds(size)?.to_radians() as f32);
    if place.abs().max_element() < 1e-18 {
        return Err("the sun has no direction".into());
    }
    if radius >= core::f32::consts::FRAC_PI_4 {
        return Err("the sun's radius is not below 45".into());
    }
    Ok(Light::sun(-place).color(LIGHT_COLOR).radius(radius))
}

/// Position, direction, outer angle and radius of a spot light. It fades from its axis on, the default
/// of glTF.
pub fn spot(position: &str, direction: &str, outer: &str, size: &str) -> Result<Light, String> {
    let (position, direction) = (place(position)?, vector(direction)?);
    let refused = "the spot light's angle is not a number above 0 and up to 90";
    let (outer, radius) = (angle(outer).map_err(|_| refused)?, radius(size)?);
    if direction.abs().max_element() < 1e-18 {
        return Err("the spot light has no direction".into());
    }
    if outer > core::f32::consts::FRAC_PI_2 {
        return Err(refused.into());
    }
    let light = Light::spot(position, direction, outer).color(LIGHT_COLOR);
    Ok(light.inverse_square(true).radius(radius))
}

/// The path of a picture, an array or a film, or `-`.
pub fn picture(path: PathBuf) -> Result<PathBuf, &'static str> {
    let is_known = is_standard(&path) || ["png", "exr", "npy", "mp4"].iter().any(|e| ends_in(&path, e));
    if is_known { Ok(path) } else { Err("the name must end in .png, .exr, .npy or .mp4, or be -") }
}

/// The path of a JSON file.
pub fn json(path: PathBuf) -> Result<PathBuf, &'static str> {
    if ends_in(&path, "json") { Ok(path) } else { Err("the name must end in .json") }
}

/// The encoding of pictures on standard output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// PNG files, one behind the other.
    Png,
    /// Bytes of red, green, blue and alpha, row by row.
    Rgba,
}

/// The encoding of pictures on standard output.
pub fn encoding() -> impl TypedValueParser<Value = Stream> {
    PossibleValuesParser::new(["png", "rgba"]).map(|name| match &name[..] {
        "rgba" => Stream::Rgba,
        _ => Stream::Png,
    })
}

/// The path of a PNG file.
#[cfg(feature = "viewer")]
pub fn png(path: PathBuf) -> Result<PathBuf, &'static str> {
    if ends_in(&path, "png") { Ok(path) } else { Err("the name must end in .png") }
}

/// The path of a file of layers.
pub fn layers(path: PathBuf) -> Result<PathBuf, &'static str> {
    let is_known = ends_in(&path, "exr") || ends_in(&path, "npz");
    if is_known { Ok(path) } else { Err("the name must end in .exr or .npz") }
}

/// Whether a path means standard output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Whether a path has this ending, in lower or upper case.
pub fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|has| has.eq_ignore_ascii_case(ending))
}

/// A view's name.
pub fn view() -> impl TypedValueParser<Value = debug::DebugView> {
    PossibleValuesParser::new(debug::DebugView::ALL.map(|(name, _)| name)).try_map(|name| {
        debug::DebugView::ALL
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, view)| *view)
            .ok_or("unknown view")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_within_the_limits_are_taken() {
        assert_eq!(size("317x179"), Ok([317, 179]));
        for bad in ["", "0x0", "1280", "12x", "99999x99999", "-1x5", "4x4x4", "1e2x5"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn numbers_are_finite() {
        assert_eq!(vector("-12,4, 0.5"), Ok(Vec3::new(-12.0, 4.0, 0.5)));
        for bad in ["", "1,2", "1,2,3,4", "nan,0,0", "0,inf,0", "1e39,0,0", "a,b,c"] {
            assert!(vector(bad).is_err(), "{bad}");
        }
        for bad in ["0", "-5", "180", "179.99999999", "nan", "inf", "1e-60", "x"] {
            assert!(angle(bad).is_err(), "{bad}");
        }
        assert_eq!(angle("90"), Ok(core::f32::consts::FRAC_PI_2));
    }

    #[test]
    fn colors_of_css_are_the_pixels() {
        let shown = |text: &str| match background(text) {
            Ok(Background::Color(color)) => {
                color.map(|c| (rtrt_core::num::srgb_encode(c) * 255.0 + 0.5) as u8)
            }
            other => panic!("{text}: {other:?}"),
        };
        for step in 0..=255 {
            assert_eq!(shown(&format!("rgb({step} {step} 0)")), [step, step, 0]);
        }
        // The names are those of CSS Color Module Level 4.
        assert_eq!(shown("navy"), [0, 0, 128]);
        assert_eq!(shown("RebeccaPurple"), [0x66, 0x33, 0x99]);
        assert_eq!([shown("#369"), shown("#336699")], [[0x33, 0x66, 0x99]; 2]);
        assert_eq!(background("0.5,0,1"), Ok(Background::Color([0.5, 0.0, 1.0])));
        assert_eq!(background("transparent"), Ok(Background::Transparent));
        for bad in ["", "bleu", "#12", "#33669980", "rgb(1 2 3 / 50%)", "-1,0,0"] {
            assert!(background(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_sun_shines_from_where_it_stands() {
        assert_eq!(light("sun:1,2,2").map(|light| light.direction), Ok(Vec3::new(-1.0, -2.0, -2.0)));
        assert!(light("spot:0,1,0:0,-1,0:90").is_ok());
        for bad in ["spot:0,1,0", "spot:0,1,0:0,0,0:30", "spot:0,1,0:0,-1,0:91", "spot:0,1,0:0,-1,0:30:1:1"] {
            assert!(light(bad).is_err(), "{bad}");
        }
        assert_eq!(light("point:1,2,3:0.5").map(|light| light.radius), Ok(0.5));
        assert_eq!(light("sun:1,2,3:0.27").map(|light| light.radius), Ok(0.27_f64.to_radians() as f32));
        for bad in [
            "sun:0,0,0",
            "sun:0,-0,1e-38",
            "moon:1,2,3",
            "1,2,3",
            "point:1,2",
            "point:",
            "point:1,2,3:-1",
            "sun:1,2,2:45",
        ] {
            assert!(light(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lights_have_colors_and_ends() {
        let lamp = Light::point([1.0, 2.0, 3.0]).color([1.0, 0.5, 0.0]).reach(9.0).radius(0.5);
        assert_eq!(light("point:1,2,3:0.5:color=1,0.5,0:reach=9"), Ok(lamp.inverse_square(true)));
        assert_eq!(light("point:1,2,3:0.5:color=1,0.5,0:reach=9:fade=square"), Ok(lamp.inverse_square(true)));
        assert_eq!(light("point:1,2,3:0.5:color=1,0.5,0:reach=9:fade=linear"), Ok(lamp));
        let [inner, outer] = [20.0_f64, 30.0].map(|degrees| degrees.to_radians() as f32);
        let spot = Light::spot([0.0, 1.0, 0.0], [0.0, -1.0, 0.0], outer).inner(inner);
        let spot = spot.color(LIGHT_COLOR).inverse_square(true);
        assert_eq!(light("spot:0,1,0:0,-1,0:30:inner=20"), Ok(spot));
        assert!(light("sun:1,2,3:color=0,0,1").is_ok());
        assert_eq!(light("sun:1,2,3:reach=2").unwrap_err(), "a sun has no reach; it may have color");
        for bad in [
            "point:1,2,3:color=1,2",
            "point:1,2,3:color=-1,0,0",
            "point:1,2,3:color=nan,0,0",
            "point:1,2,3:color=1e30,0,0",
            "point:1,2,3:reach=0",
            "point:1,2,3:fade=cubic",
            "point:1,2,3:inner=3",
            "point:1,2,3:reach=1:reach=2",
            "sun:1,2,3:reach=4",
            "spot:0,1,0:0,-1,0:30:inner=31",
            "point:1,2,3:shape=round",
            "color=1,1,1",
            "point:1e30,0,0",
            "spot:0,-1e13,0:0,-1,0:30",
        ] {
            assert!(light(bad).is_err(), "{bad}");
        }
    }
}
