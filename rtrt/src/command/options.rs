//! The command line.

use clap::Args;
use clap::builder::{PathBufValueParser, PossibleValuesParser, TypedValueParser};
use glam::Vec3;
use rtrt::choose::{self, Choice};
use rtrt::debug;
use rtrt_core::backend::{LAYERS, RenderError, Shadows};
use rtrt_core::scene::{Light, Mip, Occluders, Setup, Structure};
use std::path::{Path, PathBuf};

/// Options of `rtrt render`.
#[derive(Debug, Args)]
pub struct Render {
    /// Where to write the picture: a PNG file; an EXR file, which gets the linear color; or - to
    /// write a PNG to standard output. In names of files, {scene} becomes the scene's name, {n} the
    /// frame's number, and {frame} the same with at least four digits
    #[arg(short, long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(picture), required_unless_present_any = ["aov", "compare", "hash", "json"])]
    pub output: Option<PathBuf>,
    /// Bits of a channel of the PNG
    #[arg(long, default_value = "8", value_parser = one_of(["8", "16"]))]
    pub bits: u32,
    /// Where to write the deferred buffers: an EXR file with the layers color (linear), depth,
    /// normal, albedo, object, triangle (as stored, and as in the source), barycentrics, uv and
    /// shadow (the share of lights that reach a surface). Color, albedo and shadow are averages of
    /// sub-rays, the others are those of each pixel's first one
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(exr))]
    pub aov: Option<PathBuf>,
    /// Show this instead of the picture. blocks is black where a block's list is empty, blue where
    /// a ray misses all bounding spheres, white where it misses all meshes; heat is how many entries
    /// a block's list has; tests is how many boxes and triangles a ray is asked for
    #[arg(long, value_name = "VIEW", value_parser = view())]
    pub debug: Option<debug::View>,
    /// What is behind everything: a linear color; transparent, which is an alpha of 0 where a ray
    /// hits nothing; or env, the environment, which is usual where there is one. With an
    /// environment, or transparent, what is seen through a surface stays as it was
    #[arg(long, value_name = "R,G,B|transparent|env", value_parser = background, allow_hyphen_values = true)]
    pub background: Option<Background>,
    /// Compare the picture with this PNG file, pixel by pixel; a difference is exit code 5
    #[arg(long, value_name = "FILE")]
    pub compare: Option<PathBuf>,
    /// Let each channel be off by so many of 256 steps when pictures are compared
    #[arg(long, value_name = "STEPS", default_value_t = 0, requires = "compare")]
    pub tolerance: u8,
    /// Render so many frames, from --time on, or from the start, numbered from 0 on: the names of files need {n} or
    /// {frame} in them. --hash and --json print for each frame
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub frames: u32,
    /// Frames a second
    #[arg(long, value_name = "F", default_value = "24", value_parser = rate)]
    pub fps: f64,
    /// Print the SHA-256 of the pixels (red, green, blue, alpha, row by row) and of each
    /// deferred buffer
    #[arg(long)]
    pub hash: bool,
    #[command(flatten)]
    pub common: Common,
}

/// Options of `rtrt verify`.
#[derive(Debug, Args)]
pub struct Verify {
    /// Print the SHA-256 of the reference's pixels and of each of its deferred buffers
    #[arg(long)]
    pub hash: bool,
    #[command(flatten)]
    pub common: Common,
}

/// Options of `rtrt bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// Frames to measure, after two that are not counted
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// What keeps rays from being asked for every object: lists of blocks, or nothing, to see what
    /// these are worth. That the picture is the same is checked
    #[arg(long, default_value = "blocks", value_parser = structure())]
    pub structure: Structure,
    #[command(flatten)]
    pub common: Common,
}

/// Options of `rtrt view`.
#[cfg(feature = "viewer")]
#[derive(Debug, Args)]
pub struct View {
    /// Where F12 writes the picture, a PNG file; {frame} becomes the first number that no file has
    #[arg(short, long, value_name = "FILE", default_value = "rtrt-{frame}.png", value_parser = PathBufValueParser::new().try_map(png))]
    pub output: PathBuf,
    /// While something moves, trace fewer rays if fewer frames a second than this could be shown
    #[arg(long, value_name = "N", default_value = "25", value_parser = rate)]
    pub fps: f64,
    /// Load the scene again when its file changes
    #[arg(long)]
    pub watch: bool,
    /// Write keys and mouse, frame by frame, to this file
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Take keys and mouse from this file, and close at its end. Frames happen at the times that
    /// the file says, all of them at full resolution
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    #[command(flatten)]
    pub common: Common,
}

/// What all commands that render take.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// A .glb, .gltf or .obj file, demo:matchbox, demo:glass, demo:spheres or demo:levels
    pub scene: PathBuf,
    /// Width and height in pixels, each at most 16384
    #[arg(long, value_name = "SIZE", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// Sub-rays a pixel; render and view take 4, verify and bench 1
    #[arg(long, value_parser = one_of(["1", "4", "16"]))]
    pub samples: Option<u32>,
    /// How lights with a radius cast shadows: hard, as if all came from their middle; soft,
    /// blurred as far as their penumbra reaches; area, where each sub-ray of a pixel asks for
    /// another point of the light; jitter, the same with other points in each pixel. Or off
    #[arg(long, value_name = "HOW", default_value = "soft", value_parser = shadows())]
    shadows: Shadows,
    /// Render without shadows, as --shadows off does
    #[arg(long)]
    no_shadows: bool,
    /// Give every point and spot light this radius, world units
    #[arg(long, value_name = "R", value_parser = radius)]
    pub light_radius: Option<f32>,
    /// Look at most so many surfaces that cover one another only in part, the last of which is
    /// then drawn as opaque; 1 draws everything as opaque
    #[arg(long, value_name = "N", default_value_t = LAYERS, value_parser = clap::value_parser!(u32).range(1..=i64::from(Setup::MAX_LAYERS)))]
    pub transparency_depth: u32,
    /// Let suns have shadows of all objects, of those whose shadows may be seen (the picture is the
    /// same), or of those within this distance of the camera
    #[arg(long, value_name = "all|seen|DISTANCE", default_value = "all", value_parser = occluders)]
    pub sun_shadows: Occluders,
    /// Show point and spot lights that have a radius as spheres
    #[arg(long)]
    pub show_lights: bool,
    /// Choose the levels of textures by the distance of a surface, or also by the angle at which it
    /// is seen
    #[arg(long, default_value = "distance", value_parser = mip())]
    pub mip: Mip,
    /// Add a white light; the scene's own lights are then off. point:x,y,z shines from there
    /// without limit; spot:x,y,z:dx,dy,dz:degrees shines from there in the direction dx,dy,dz,
    /// brightest in the middle and up to that angle off it (within 0 and 90); sun:x,y,z stands
    /// infinitely far away in that direction. A radius may follow, as in point:x,y,z:0.5, that of
    /// a sun in degrees: shadows are then soft
    #[arg(long = "light", value_name = "KIND:X,Y,Z", value_parser = light)]
    pub lights: Vec<Light>,
    /// Surround the scene with this panorama, a Radiance .hdr file: it is the background, is
    /// mirrored, and lights in place of the ambient light. A scene without lights gets none
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// Play the file's first animation until this time, seconds after its start. If not given, the
    /// file is shown at rest. A file without a camera is framed so that the whole animation is in
    /// view
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<f64>,
    /// Keep the trees of large meshes in this folder, and take them from there the next time. Files
    /// that are damaged or of another mesh are built anew
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Print the results as one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub talk: Talk,
    #[command(flatten)]
    pub camera: CameraOptions,
    #[command(flatten)]
    pub backend: BackendOptions,
}

impl Common {
    /// How lights cast shadows.
    pub fn shadows(&self) -> Shadows {
        if self.no_shadows { Shadows::Off } else { self.shadows }
    }
}

/// How much is said on standard error.
#[derive(Debug, Clone, Copy, Args)]
pub struct Talk {
    /// Say nothing but results and errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Say more
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Make every warning an error
    #[arg(long)]
    pub strict: bool,
}

/// What is behind everything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Background {
    /// Linear RGB.
    Color([f32; 3]),
    /// Nothing.
    Transparent,
    /// The environment.
    Environment,
}

/// Where the scene is seen from. What is not given is the scene's.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraOptions {
    /// Take this camera of the scene's, counted from 0
    #[arg(long, value_name = "N")]
    pub camera: Option<usize>,
    /// Where the camera is; without --look-at it looks at the middle of the scene
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub eye: Option<Vec3>,
    /// A point in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub look_at: Option<Vec3>,
    /// What is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub up: Option<Vec3>,
    /// Angle between the top and the bottom of the picture, degrees within 0 and 180
    #[arg(long, value_name = "DEGREES", value_parser = angle, allow_hyphen_values = true)]
    pub fov_y: Option<f32>,
    /// Look along parallel rays, and show so much from top to bottom, world units
    #[arg(long, value_name = "HEIGHT", value_parser = height, conflicts_with = "fov_y")]
    pub parallel: Option<f32>,
}

/// What renders.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Backend")]
pub struct BackendOptions {
    /// What renders; auto takes the first that works of: discrete, integrated, virtual GPU,
    /// CPU, software Vulkan
    #[arg(long, default_value = "auto", value_parser = choice())]
    pub backend: Choice,
    /// The GPU adapter whose name contains this, or that has this number in `rtrt doctor`; auto
    /// then takes no other. WGPU_BACKEND (vulkan, metal, dx12) and WGPU_POWER_PREF (low, high) in the
    /// environment choose among adapters as well
    #[arg(long, value_name = "NAME", env = "WGPU_ADAPTER_NAME", hide_env_values = true)]
    pub adapter: Option<String>,
    /// Threads for loading, and for rendering on the CPU; as many as run at once if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Numbers side by side in one instruction on the CPU; the fastest if not given
    #[arg(long, value_parser = one_of(["1", "8", "16"]))]
    pub lanes: Option<u32>,
}

impl BackendOptions {
    /// What to choose from.
    pub fn choose(&self, tell: Option<fn(&RenderError)>) -> choose::Options {
        choose::Options {
            choice: self.backend,
            adapter: self.adapter.clone(),
            lanes: self.lanes,
            threads: self.threads(),
            tell,
        }
    }

    /// Threads, if given.
    pub fn threads(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }
}

/// One of a few numbers.
fn one_of<const N: usize>(allowed: [&'static str; N]) -> impl TypedValueParser<Value = u32> {
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
fn shadows() -> impl TypedValueParser<Value = Shadows> {
    PossibleValuesParser::new(SHADOWS.map(|(name, _)| name)).map(|given| {
        SHADOWS.iter().find(|(name, _)| *name == given).map_or(Shadows::default(), |(_, how)| *how)
    })
}

/// A backend's name.
fn choice() -> impl TypedValueParser<Value = Choice> {
    PossibleValuesParser::new(["auto", "cpu", "gpu"]).map(|name| match &name[..] {
        "cpu" => Choice::Cpu,
        "gpu" => Choice::Gpu,
        _ => Choice::Auto,
    })
}

/// `all`, `seen`, or a distance.
fn occluders(text: &str) -> Result<Occluders, &'static str> {
    match text {
        "all" => Ok(Occluders::All),
        "seen" => Ok(Occluders::Seen),
        _ => rate(text)
            .map(|distance| Occluders::Near(distance as f32))
            .map_err(|_| "not all, seen or a number above 0"),
    }
}

/// How levels of textures are chosen.
fn mip() -> impl TypedValueParser<Value = Mip> {
    PossibleValuesParser::new(["distance", "angle"]).map(|name| match &name[..] {
        "angle" => Mip::Angle,
        _ => Mip::Distance,
    })
}

/// What keeps rays from being asked for every object.
fn structure() -> impl TypedValueParser<Value = Structure> {
    PossibleValuesParser::new(["blocks", "none"]).map(|name| match &name[..] {
        "none" => Structure::None,
        _ => Structure::Blocks,
    })
}

/// `1280x720`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=Setup::MAX_SIDE).contains(side));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or(format!("not WIDTHxHEIGHT with sides of 1 to {}", Setup::MAX_SIDE))
}

/// `-12,4,0`.
fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f32>> =
        text.split(',').map(|number| number.trim().parse().ok().filter(|n: &f32| n.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("not three finite numbers with commas between them".into()),
    }
}

/// `0.1,0.2,0.5`, `transparent` or `env`.
fn background(text: &str) -> Result<Background, String> {
    match text {
        "transparent" => Ok(Background::Transparent),
        "env" => Ok(Background::Environment),
        color => vector(color)
            .ok()
            .filter(|color| color.min_element() >= 0.0)
            .map(|color| Background::Color(color.to_array()))
            .ok_or("not three numbers of 0 or more, transparent or env".into()),
    }
}

/// Degrees, to radians.
fn angle(text: &str) -> Result<f32, String> {
    let radians = text.parse().map(|degrees: f64| degrees.to_radians() as f32);
    radians
        .ok()
        .filter(|&radians| radians > 0.0 && radians < core::f32::consts::PI)
        .ok_or("not a number within 0 and 180".into())
}

/// World units, above 0.
fn height(text: &str) -> Result<f32, &'static str> {
    let height = text.parse().ok().filter(|height: &f32| *height > 0.0 && height.is_finite());
    height.ok_or("not a finite number above 0")
}

/// Seconds, 0 or more.
fn seconds(text: &str) -> Result<f64, &'static str> {
    text.parse().ok().filter(|time: &f64| time.is_finite() && *time >= 0.0).ok_or("not a number of 0 or more")
}

/// Frames a second, above 0.
fn rate(text: &str) -> Result<f64, &'static str> {
    seconds(text).ok().filter(|rate| *rate >= 1e-6).ok_or("not a number above 0")
}

/// A radius, 0 or more.
fn radius(text: &str) -> Result<f32, &'static str> {
    text.parse().ok().filter(|r: &f32| r.is_finite() && *r >= 0.0).ok_or("not a number of 0 or more")
}

/// `point:0,14,0`, `spot:0,14,0:0,-1,0:30` or `sun:1,2,2`, and perhaps a radius.
fn light(text: &str) -> Result<Light, String> {
    const FORMS: &str = "not point:X,Y,Z, spot:X,Y,Z:X,Y,Z:DEGREES or sun:X,Y,Z, with or without :RADIUS";
    let parts: Vec<&str> = text.split(':').collect();
    match parts[..] {
        ["point", place] => point(place, "0"),
        ["point", place, radius] => point(place, radius),
        ["spot", place, direction, outer] => spot(place, direction, outer, "0"),
        ["spot", place, direction, outer, radius] => spot(place, direction, outer, radius),
        ["sun", place] => sun(place, "0"),
        ["sun", place, radius] => sun(place, radius),
        _ => Err(FORMS.into()),
    }
}

/// Position and radius of a point light.
fn point(position: &str, size: &str) -> Result<Light, String> {
    let (position, radius) = (vector(position)?, radius(size)?);
    Ok(Light::Point { position, color: Vec3::ONE, reach: None, inverse_square: false, radius })
}

/// Where the sun stands, and its radius in degrees.
fn sun(place: &str, size: &str) -> Result<Light, String> {
    let (place, radius) = (vector(place)?, radius(size)?.to_radians());
    if place.abs().max_element() < 1e-18 {
        return Err("the sun has no direction".into());
    }
    if radius >= core::f32::consts::FRAC_PI_4 {
        return Err("the sun's radius is not below 45".into());
    }
    Ok(Light::Sun { direction: -place, color: Vec3::ONE, radius })
}

/// Position, direction, outer angle and radius of a spot light. It fades from the middle on, as
/// glTF's does if nothing else is said.
fn spot(position: &str, direction: &str, outer: &str, size: &str) -> Result<Light, String> {
    let (position, direction) = (vector(position)?, vector(direction)?);
    let (outer, radius) = (angle(outer)?, radius(size)?);
    if direction.abs().max_element() < 1e-18 {
        return Err("the spot light has no direction".into());
    }
    if outer > core::f32::consts::FRAC_PI_2 {
        return Err("the spot light's angle is above 90".into());
    }
    Ok(Light::Spot {
        position,
        direction,
        inner: 0.0,
        outer,
        color: Vec3::ONE,
        reach: None,
        inverse_square: false,
        radius,
    })
}

/// The path of a PNG or EXR file, or `-`.
fn picture(path: PathBuf) -> Result<PathBuf, &'static str> {
    let is_known = is_standard(&path) || ends_in(&path, "png") || ends_in(&path, "exr");
    if is_known { Ok(path) } else { Err("the name must end in .png or .exr, or be -") }
}

/// The path of a PNG file.
#[cfg(feature = "viewer")]
fn png(path: PathBuf) -> Result<PathBuf, &'static str> {
    if ends_in(&path, "png") { Ok(path) } else { Err("the name must end in .png") }
}

/// The path of an EXR file.
fn exr(path: PathBuf) -> Result<PathBuf, &'static str> {
    if ends_in(&path, "exr") { Ok(path) } else { Err("the name must end in .exr") }
}

/// Whether a path stands for standard output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Whether a path has this ending, in lower or upper case.
pub fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|has| has.eq_ignore_ascii_case(ending))
}

/// A view's name.
fn view() -> impl TypedValueParser<Value = debug::View> {
    PossibleValuesParser::new(debug::View::ALL.map(|(name, _)| name)).try_map(|name| {
        debug::View::ALL.iter().find(|(known, _)| *known == name).map(|(_, view)| *view).ok_or("unknown view")
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
    fn the_sun_shines_from_where_it_stands() {
        let Ok(Light::Sun { direction, .. }) = light("sun:1,2,2") else { panic!("no sun") };
        assert_eq!(direction, Vec3::new(-1.0, -2.0, -2.0));
        assert!(light("spot:0,1,0:0,-1,0:90").is_ok());
        for bad in ["spot:0,1,0", "spot:0,1,0:0,0,0:30", "spot:0,1,0:0,-1,0:91", "spot:0,1,0:0,-1,0:30:1:1"] {
            assert!(light(bad).is_err(), "{bad}");
        }
        assert_eq!(light("point:1,2,3:0.5").map(|light| light.radius()), Ok(0.5));
        assert_eq!(light("sun:1,2,3:0.27").map(|light| light.radius()), Ok(0.27_f32.to_radians()));
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
}
