//! The command line.

#[cfg(feature = "viewer")]
use super::parse::png;
use super::parse::{
    Background, angle, background, choice, exr, height, light, mip, occluders, one_of, picture, radius, rate,
    seconds, shadows, size, structure, tone, vector, view,
};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::Vec3;
use rtrt::choose::{self, Choice};
use rtrt::debug;
use rtrt_core::backend::{LAYERS, Shadows};
use rtrt_core::scene::{Light, Mip, Occluders, Setup, Structure};
use std::path::PathBuf;

/// Options of `rtrt render`.
#[derive(Debug, Args)]
pub struct RenderOptions {
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
    pub debug: Option<debug::DebugView>,
    /// What is behind everything, and is seen through what is not opaque: a linear color;
    /// transparent, which is an alpha of 0 where a ray hits nothing, and one in between where
    /// surfaces are seen through; or env, the environment, which is usual where there is one.
    /// Surfaces mirror the environment all the same
    #[arg(long, value_name = "R,G,B|transparent|env", value_parser = background, allow_hyphen_values = true)]
    pub background: Option<Background>,
    /// Compare the picture with this PNG file, pixel by pixel; a difference is exit code 5
    #[arg(long, value_name = "FILE")]
    pub compare: Option<PathBuf>,
    /// Let each channel be off by so many of 256 steps when pictures are compared
    #[arg(
        long,
        value_name = "STEPS",
        default_value_t = 0,
        requires = "compare",
        allow_negative_numbers = true
    )]
    pub tolerance: u8,
    /// Render so many frames, from --time on, or from the start, numbered from 0 on: the names of files need {n} or
    /// {frame} in them. --hash and --json print for each frame
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    pub frames: u32,
    /// Frames a second
    #[arg(long, value_name = "F", default_value = "24", value_parser = rate, allow_negative_numbers = true)]
    pub fps: f64,
    /// Print the SHA-256 of the pixels (red, green, blue, alpha, row by row) and of each
    /// deferred buffer
    #[arg(long)]
    pub hash: bool,
    /// Let the GPU draw what the camera sees, and trace shadows, light and what is seen through something. The
    /// picture is not the same to the bit: some pixels at edges are others
    #[arg(long)]
    pub hybrid: bool,
    #[command(flatten)]
    pub common: Common,
}

/// Options of `rtrt verify`.
#[derive(Debug, Args)]
pub struct VerifyOptions {
    /// Print the SHA-256 of the reference's pixels and of each of its deferred buffers
    #[arg(long)]
    pub hash: bool,
    #[command(flatten)]
    pub common: Common,
}

/// Options of `rtrt bench`.
#[derive(Debug, Args)]
pub struct BenchOptions {
    /// Frames to measure, after two that are not counted
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000), allow_negative_numbers = true)]
    pub frames: u32,
    /// Let the GPU draw what the camera sees, and trace shadows, light and what is seen through something. The
    /// picture is not the same to the bit: some pixels at edges are others
    #[arg(long)]
    pub hybrid: bool,
    #[command(flatten)]
    pub common: Common,
}

/// Options of `rtrt view`.
#[cfg(feature = "viewer")]
#[derive(Debug, Args)]
pub struct ViewOptions {
    /// Where F12 writes the picture, a PNG file; {frame} becomes the first number that no file has
    #[arg(short, long, value_name = "FILE", default_value = "rtrt-{frame}.png", value_parser = PathBufValueParser::new().try_map(png))]
    pub output: PathBuf,
    /// While something moves, trace fewer rays if fewer frames a second than this could be shown
    #[arg(long, value_name = "N", default_value = "25", value_parser = rate, allow_negative_numbers = true)]
    pub fps: f64,
    /// Load the scene again when a file changes that it was read from: its own, textures, buffers,
    /// material libraries, the environment
    #[arg(long)]
    pub watch: bool,
    /// Write keys and mouse, frame by frame, to this file
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Take keys and mouse from this file, and close at its end. Frames happen at the times that
    /// the file says, all of them at full resolution
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    /// Let a GPU draw what the camera sees, and trace shadows, light and what is seen through something; the
    /// panel switches it. The picture is not the same to the bit: some pixels at edges are others
    #[arg(long)]
    pub hybrid: bool,
    #[command(flatten)]
    pub common: Common,
}

/// What all commands that render take.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// A .glb, .gltf or .obj file, demo:matchbox, demo:glass, demo:spheres, demo:levels or demo:moving
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
    #[arg(long, conflicts_with = "shadows")]
    no_shadows: bool,
    /// Give every point and spot light this radius, world units
    #[arg(long, value_name = "R", value_parser = radius, allow_negative_numbers = true)]
    pub light_radius: Option<f32>,
    /// Look at most so many surfaces that cover one another only in part, the last of which is
    /// then drawn as opaque; 1 draws everything as opaque
    #[arg(long, value_name = "N", default_value_t = LAYERS, value_parser = clap::value_parser!(u32).range(1..=i64::from(Setup::MAX_LAYERS)), allow_negative_numbers = true)]
    pub transparency_depth: u32,
    /// What keeps rays from being asked for every object: lists of objects for each block of each
    /// view; lists of parts with at most so many triangles, for the camera's blocks; whichever of
    /// these suits the scene (blocks); or nothing. The picture is the same
    #[arg(long, value_name = "blocks|objects|TRIANGLES|none", default_value = "blocks", value_parser = structure)]
    pub structure: Structure,
    /// Let suns have shadows of all objects, of those whose shadows may be seen (the picture is the
    /// same), or of those within this distance of the camera
    #[arg(long, value_name = "all|seen|DISTANCE", default_value = "all", value_parser = occluders, allow_negative_numbers = true)]
    pub sun_shadows: Occluders,
    /// Show point and spot lights that have a radius as spheres
    #[arg(long)]
    pub show_lights: bool,
    /// Choose the levels of textures by the distance of a surface, or also by the angle at which it
    /// is seen
    #[arg(long, default_value = "distance", value_parser = mip())]
    pub mip: Mip,
    /// Add a light; the scene's own lights are then off. point:x,y,z shines from there
    /// without limit; spot:x,y,z:dx,dy,dz:degrees shines from there in the direction dx,dy,dz,
    /// brightest in the middle and up to that angle off it (within 0 and 90); sun:x,y,z stands
    /// infinitely far away in that direction. A radius may follow, as in point:x,y,z:0.5, that of
    /// a sun in degrees: shadows are then soft. After that may follow color=r,g,b (linear, 1,1,1 if
    /// not given), reach=r (beyond it, the light is 0), fade=square (with the square of the distance),
    /// and inner=degrees (up to that angle a spot light does not fade), as in
    /// point:0,3,0:0.5:color=1,0.6,0.2:fade=square
    #[arg(long = "light", value_name = "KIND:X,Y,Z", value_parser = light)]
    pub lights: Vec<Light>,
    /// Light from everywhere, linear; an environment takes its place
    #[arg(long, value_name = "R,G,B", value_parser = tone, allow_hyphen_values = true)]
    pub ambient: Option<Vec3>,
    /// Surround the scene with this environment: it is the background, is mirrored, and lights in
    /// place of the ambient light. A scene without lights gets none. A picture (Radiance .hdr, PNG
    /// or JPEG) is, by its shape, a panorama (2:1) or a cube: px, nx, py, ny, pz, nz in a row (6:1) or a
    /// column (1:6), or unfolded to a cross (4:3, 3:4) that has nothing beside it. A folder is a cube, of
    /// pictures named px, nx, py, ny, pz and nz. pz is in front, which is -z
    #[arg(long, value_name = "FILE|DIR")]
    pub environment: Option<PathBuf>,
    /// Play this animation of the file: its number, counted from 0, its name, or all at once. The first
    /// if not given. Without --time it is shown at its start
    #[arg(long, value_name = "N|NAME|all")]
    pub animation: Option<String>,
    /// Play the file's animation until this time, seconds after its start. If not given, the
    /// file is shown at rest. A file without a camera is framed so that the whole animation is in
    /// view
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
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
    /// When, of the animation; none for the scene at rest.
    pub fn start(&self) -> Option<f64> {
        self.time.or(self.animation.as_ref().map(|_| 0.0))
    }
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

/// Where the scene is seen from. What is not given is the scene's.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraOptions {
    /// Take this camera of the scene's, counted from 0
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
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
    #[arg(long, value_name = "HEIGHT", value_parser = height, conflicts_with = "fov_y", allow_negative_numbers = true)]
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
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Numbers side by side in one instruction on the CPU; the fastest if not given
    #[arg(long, value_parser = one_of(["1", "8", "16"]))]
    pub lanes: Option<u32>,
}

impl BackendOptions {
    /// What to choose from.
    pub fn choose(&self, tell: Option<choose::Tell>) -> choose::Options {
        choose::Options {
            choice: self.backend,
            adapter: self.adapter.clone(),
            lanes: self.lanes,
            threads: self.threads(),
            hybrid: false,
            tell,
        }
    }

    /// Threads, if given.
    pub fn threads(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }
}
