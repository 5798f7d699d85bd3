//! The command line.

#[cfg(feature = "viewer")]
use super::parse::png;
use super::parse::{
    AmbientOcclusion, Background, Environment, EnvironmentSun, Exposure, GivenLight, Stream,
    ambient_occlusion, angle, background, choice, depth, encoding, environment, environment_sun, exposure,
    given_light, height, intensity, json, layers, mip, occluders, one_of, part, picture, point_of_file,
    radius, rate, seconds, shading, shadows, size, structure, tone, tone_map, turn, vector, view,
};
use super::repaint::Repaint;
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::{DVec3, Vec3};
use rtrt::choose::{self, Choice};
use rtrt::debug;
use rtrt_core::backend::{LAYERS, Shading, Shadows, ToneMap};
use rtrt_core::scene::{Mip, Occluders, Setup, Structure};
use std::path::PathBuf;

/// Options of `rtrt render`.
#[derive(Debug, Args)]
pub struct RenderOptions {
    // clap takes {n} for a line break, unless a style is inside of it.
    #[arg(short, long, value_name = "FILE", help = "Write the picture to this file: PNG; EXR or NPY (an array of NumPy), in linear color; MP4, a film of all pictures, by ffmpeg; or -, standard output. In names of files, {scene} becomes the scene's name, {camera} the camera's, {frame} the number of the frame with at least four digits, and {\u{1b}[0mn} the number alone; where each view has one frame, it is the number of the view", value_parser = PathBufValueParser::new().try_map(picture))]
    pub output: Option<PathBuf>,
    /// Bits per channel of the PNG
    #[arg(long, default_value = "8", value_parser = one_of(["8", "16"]), allow_negative_numbers = true)]
    pub bits: u32,
    /// Write the deferred buffers to this EXR or NPZ file, with the layers color (linear), depth, normal,
    /// albedo, object, material, triangle (as stored, and as in the source), barycentrics, uv, position,
    /// shadow (the share of lights that reach a surface), and, with --frames, motion (pixels since the
    /// frame before). Color, albedo and shadow are averages over sub-rays; the others come from each
    /// pixel's first sub-ray
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(layers))]
    pub aov: Option<PathBuf>,
    /// Render this view in place of the picture. blocks is black for an empty list of a block, blue for a
    /// ray that misses all bounding spheres, and white for one that misses all meshes; heat is the
    /// length of the block's list; tests is the number of boxes and triangles that a ray is tested with
    #[arg(long, value_name = "VIEW", value_parser = view())]
    pub debug: Option<debug::DebugView>,
    /// The background, also behind transparent surfaces: a linear color (0.1,0.2,0.5); a color of CSS
    /// (navy, '#336', 'rgb(10 20 30)'), which the picture shows as it is; transparent, which
    /// gives pixels without a surface an alpha of 0 and transparent surfaces one in between; or env, the
    /// environment, which is the default if there is one. It does not change reflections
    #[arg(long, value_name = "R,G,B|COLOR|transparent|env", value_parser = background, allow_hyphen_values = true)]
    pub background: Option<Background>,
    /// Compare the picture with this PNG file, pixel by pixel; exit code 5 means a difference
    #[arg(long, value_name = "FILE")]
    pub compare: Option<PathBuf>,
    /// Allow a difference of so many of 256 steps in each channel when pictures are compared
    #[arg(
        long,
        value_name = "STEPS",
        default_value_t = 0,
        requires = "compare",
        allow_negative_numbers = true
    )]
    pub tolerance: u8,
    /// Render so many frames, numbered from 0, from --time or from the start of the animation. Names of
    /// files then need {frame}. --hash and --json print for each frame
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    pub frames: u32,
    /// The pictures on standard output (-o -): PNG files one behind the other, or the bytes red, green,
    /// blue and alpha, row by row
    #[arg(long, value_name = "ENCODING", default_value = "png", value_parser = encoding())]
    pub stream: Stream,
    /// Render a view from each camera of this file: JSON with poses and lenses, or transforms.json of NeRF
    #[arg(long, value_name = "FILE", conflicts_with_all = ["camera", "eye", "look_at", "up", "fov_y", "parallel", "orbit"])]
    pub cameras: Option<PathBuf>,
    /// Render so many views around the point that the camera looks at, evenly, counterclockwise from above
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    pub orbit: Option<u32>,
    /// Write what was rendered to this JSON file: poses, lenses, names of files, hashes, times, memory;
    /// names of objects; and their visible pixels and boxes in each picture. --cameras reads it
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(json))]
    pub report: Option<PathBuf>,
    /// Frames per second
    #[arg(long, value_name = "F", default_value = "24", value_parser = rate, allow_negative_numbers = true)]
    pub fps: f64,
    /// Print the SHA-256 of the pixels (red, green, blue, alpha, row by row) and of each
    /// deferred buffer; of several pictures with scene, view and frame behind them
    #[arg(long)]
    pub hash: bool,
    /// Rasterize the first surfaces on the GPU, and trace shadows, light and transparency. Some pixels at
    /// edges differ from the exact picture
    #[arg(long)]
    pub hybrid: bool,
    #[command(flatten)]
    pub common: Common,
    /// Further scenes, for which everything else is the same; names of files then need {scene}
    #[arg(value_name = "SCENE")]
    pub more: Vec<PathBuf>,
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
    /// Measure so many frames, after two frames of warm-up
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000), allow_negative_numbers = true)]
    pub frames: u32,
    /// Rasterize the first surfaces on the GPU, and trace shadows, light and transparency. Some pixels at
    /// edges differ from the exact picture
    #[arg(long)]
    pub hybrid: bool,
    #[command(flatten)]
    pub common: Common,
}

/// Options of `rtrt doctor`.
#[derive(Debug, Args)]
pub struct DoctorOptions {
    /// Print the list as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// The name of a screenshot if nothing is said. Nobody may want one, so nothing is checked in advance.
#[cfg(feature = "viewer")]
pub const OUTPUT: &str = "rtrt-{frame}.png";

/// Options of `rtrt view`.
#[cfg(feature = "viewer")]
#[derive(Debug, Clone, Args)]
pub struct ViewOptions {
    /// The PNG file that F12 writes; {frame} becomes the first unused number
    #[arg(short, long, value_name = "FILE", default_value = OUTPUT, value_parser = PathBufValueParser::new().try_map(png))]
    pub output: PathBuf,
    /// While something moves, trace fewer rays to reach this frame rate
    #[arg(long, value_name = "N", default_value = "25", value_parser = rate, allow_negative_numbers = true)]
    pub fps: f64,
    /// Load the scene again after a change of one of its files: scene, textures, buffers, material
    /// libraries, environment
    #[arg(long)]
    pub watch: bool,
    /// Write keys and mouse, frame by frame, to this file
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Take keys and mouse from this file, and close at its end. The file has the times of the frames,
    /// which are all at full resolution
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    /// Replay at the recorded speed, with the detail that this machine has time for, as for a person. With --json
    /// the figures of the loop are printed in the end
    #[arg(long, requires = "replay")]
    pub live: bool,
    /// What draws the window: a GPU, or the CPU; auto takes the CPU where the GPU is software or none is there
    #[arg(long, value_name = "auto|gpu|cpu", default_value = "auto", value_parser = choice(), allow_negative_numbers = true)]
    pub window: Choice,
    /// Rasterize the first surfaces on a GPU, and trace shadows, light and transparency; the panel has a
    /// switch for it. Some pixels at edges differ from the exact picture
    #[arg(long)]
    pub hybrid: bool,
    #[command(flatten)]
    pub common: Common,
}

/// Options of all commands that render.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// A .glb, .gltf, .obj, .stl or .ply file; - for standard input; demo:matchbox, demo:glass, demo:spheres, demo:levels or
    /// demo:moving
    pub scene: PathBuf,
    /// Width and height in pixels, each at most 16384
    #[arg(long, value_name = "SIZE", default_value = "1280x720", value_parser = size, allow_hyphen_values = true)]
    pub size: [u32; 2],
    /// Sub-rays per pixel; the default is 4 for render and view, and 1 for verify and bench
    #[arg(long, value_parser = one_of(["1", "4", "16"]), allow_negative_numbers = true)]
    pub samples: Option<u32>,
    /// Colors of a pixel with several sub-rays: one a sub-ray (sample), or one for each triangle that they meet
    /// (pixel): edges stay smooth, but textures and edges of shadows are as with one sub-ray. Not possible with soft
    /// shadows, ambient occlusion and transparency
    #[arg(long, value_name = "HOW", default_value = "sample", value_parser = shading())]
    pub shading: Shading,
    /// Shadows of lights with a radius: off; hard, from the center of the light; soft, blurred by the
    /// width of the penumbra; area, with another point of the light for each sub-ray; jitter, the same
    /// with other points in each pixel
    #[arg(long, value_name = "HOW", default_value = "soft", value_parser = shadows())]
    shadows: Shadows,
    /// Render without shadows, as --shadows off does
    #[arg(long, conflicts_with = "shadows")]
    no_shadows: bool,
    /// The radius of every point and spot light, world units
    #[arg(long, value_name = "R", value_parser = radius, allow_negative_numbers = true)]
    pub light_radius: Option<f32>,
    /// The most transparent surfaces along a ray; the last one is drawn as opaque. 1 draws everything as
    /// opaque; with --ground it is 2 at least
    #[arg(long, value_name = "N", default_value_t = LAYERS, value_parser = clap::value_parser!(u32).range(1..=i64::from(Setup::MAX_LAYERS)), allow_negative_numbers = true)]
    pub transparency_depth: u32,
    /// The lists of the camera's blocks: of objects; of parts of objects with at most so many triangles;
    /// the better of both for the scene (blocks); or no lists at all (none). The picture is the same
    #[arg(long, value_name = "blocks|objects|TRIANGLES|none", default_value = "blocks", value_parser = structure, allow_negative_numbers = true)]
    pub structure: Structure,
    /// The objects that cast shadows of suns: all, or those within this distance of the camera
    #[arg(long, value_name = "all|DISTANCE", default_value = "all", value_parser = occluders, allow_negative_numbers = true)]
    pub sun_shadows: Occluders,
    /// Show point and spot lights that have a radius as spheres
    #[arg(long)]
    pub show_lights: bool,
    /// Choose mip levels by the distance of a surface, or also by its angle to the view
    #[arg(long, default_value = "distance", value_parser = mip())]
    pub mip: Mip,
    /// Add a light, in place of the scene's lights. point:x,y,z is a point light at this position;
    /// spot:x,y,z:dx,dy,dz:degrees is a spot light with this direction and half angle (within 0 and 90);
    /// sun:x,y,z is infinitely far away in this direction. A radius may follow, as in point:x,y,z:0.5
    /// (degrees for a sun), which makes shadows soft. Then may follow color=r,g,b (linear; candela, or lux
    /// for a sun; without it white is white at a distance of 1), reach=r (no light beyond), fade=linear (to
    /// 0 at the reach, or not at all, in place of the square of the distance) and inner=degrees (full
    /// brightness within this angle of a spot light), as in point:0,3,0:0.5:color=30,18,6:reach=20
    #[arg(long = "light", value_name = "KIND:X,Y,Z", value_parser = given_light)]
    pub lights: Vec<GivenLight>,
    /// Ambient light, linear; an environment replaces it
    #[arg(long, value_name = "R,G,B", value_parser = tone, allow_hyphen_values = true)]
    pub ambient: Option<Vec3>,
    /// Raise light by so many stops before it is tone mapped; each stop doubles it. auto meters a small
    /// picture (the first one of an animation) and brings its mean to middle gray
    #[arg(long, value_name = "STOPS|auto", default_value = "0", value_parser = exposure, allow_hyphen_values = true)]
    pub exposure: Exposure,
    /// The tone map: neutral (Khronos PBR Neutral) keeps base colors; agx (Blender's) and aces (the fit of
    /// Stephen Hill) look like film; none clips light beyond white. An EXR file contains the light itself,
    /// without exposure and tone map
    #[arg(long, value_name = "NAME", default_value = "neutral", value_parser = tone_map())]
    pub tone_map: ToneMap,
    /// Play this animation of the file: its number, counted from 0, its name, or all at once. The default
    /// is the first one. Without --time the scene is at its start
    #[arg(long, value_name = "N|NAME|all", allow_negative_numbers = true)]
    pub animation: Option<String>,
    /// Show the animation at this time, seconds after its start. Without it the scene is at rest. The
    /// default camera of a file without cameras has the whole animation in view
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// The diameter of points and the thickness of lines, world units. The default is 1/250 of the diagonal of the file's
    /// content
    #[arg(long, value_name = "SIZE", value_parser = height, allow_negative_numbers = true)]
    pub point_size: Option<f32>,
    /// Do not draw these objects, by their numbers in --report
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    pub hide: Vec<u32>,
    /// Change a material, by its number in --report: color=r,g,b and emission=r,g,b (linear), metallic, roughness, alpha and
    /// transmission (within 0 and 1), with colons between them, as in 3:color=0.8,0.1,0.1:roughness=0.4
    #[arg(long = "material", value_name = "N:KEY=VALUE")]
    pub materials: Vec<Repaint>,
    /// Cache the BVHs of large meshes in this folder. A damaged file is built again
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Print the results as one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub talk: Talk,
    #[command(flatten)]
    pub surroundings: SurroundingsOptions,
    #[command(flatten)]
    pub camera: CameraOptions,
    #[command(flatten)]
    pub backend: BackendOptions,
}

impl Common {
    /// The time of the animation; none for the scene at rest.
    pub fn start(&self) -> Option<f64> {
        self.time.or(self.animation.as_ref().map(|_| 0.0))
    }
    /// The shadows of lights.
    pub fn shadows(&self) -> Shadows {
        if self.no_shadows { Shadows::Off } else { self.shadows }
    }
}

/// The amount of output on standard error.
#[derive(Debug, Clone, Copy, Args)]
pub struct Talk {
    /// Print only results and errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Print details
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Turn every warning into an error
    #[arg(long)]
    pub strict: bool,
}

/// What surrounds the scene.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Surroundings")]
pub struct SurroundingsOptions {
    /// Surround the scene with this environment. It is the background, surfaces mirror it, and it
    /// replaces the ambient light. studio is a built-in room with softboxes, and a key light for a scene
    /// without lights; it is the default where the scene, --light and --ambient give no light. A picture
    /// (Radiance .hdr, OpenEXR, PNG or JPEG) is, by its shape, a panorama (2:1) or a cube: px, nx, py, ny,
    /// pz, nz in a row (6:1) or a column (1:6), or unfolded to a cross (4:3, 3:4) with nothing beside it.
    /// A folder is a cube of pictures named px, nx, py, ny, pz and nz. pz is in front, which is -z
    #[arg(id = "environment", long = "environment", value_name = "none|studio|FILE|DIR", value_parser = PathBufValueParser::new().map(environment))]
    pub environment: Option<Environment>,
    /// Turn the environment around the vertical axis. At 0, the default, the middle of a panorama is at +x.
    /// The default of the Khronos glTF Sample Renderer is 90
    #[arg(id = "environment_rotation", long = "environment-rotation", value_name = "DEGREES", default_value = "0", value_parser = turn, allow_hyphen_values = true)]
    pub rotation: f32,
    /// Multiply the light of the environment by this factor
    #[arg(id = "environment_intensity", long = "environment-intensity", value_name = "FACTOR", default_value = "1", value_parser = intensity, allow_negative_numbers = true)]
    pub intensity: f32,
    /// Blur the environment in the background alone, from 0 (sharp) to 1. The default is 0, and 1 for the
    /// studio
    #[arg(id = "environment_blur", long = "environment-blur", value_name = "AMOUNT", value_parser = part, allow_negative_numbers = true)]
    pub blur: Option<f32>,
    /// Put a plane under the scene that shows shadows and nothing else
    #[arg(id = "ground", long = "ground")]
    pub ground: bool,
    /// Let surfaces hide the light of the environment, and ambient light, from what is as near as this distance; auto is a
    /// sixteenth of the scene's diagonal
    #[arg(id = "ambient_occlusion", long = "ambient-occlusion", value_name = "off|auto|DISTANCE", default_value = "off", value_parser = ambient_occlusion, allow_negative_numbers = true)]
    pub ambient_occlusion: AmbientOcclusion,
    /// The brightest disc of an environment, if it sheds at least a quarter as much light as everything
    /// else: light makes it a sun that casts shadows, keep leaves it in the environment, drop removes it.
    /// The key light of the studio is a sun as well
    #[arg(id = "environment_sun", long = "environment-sun", value_name = "light|keep|drop", default_value = "light", value_parser = environment_sun())]
    pub sun: EnvironmentSun,
}

/// The camera. The scene gives what the options do not.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraOptions {
    /// Use this camera of the scene: its name, or its number, counted from 0. all renders a view from each
    /// (render only)
    #[arg(long, value_name = "N|NAME|all", allow_negative_numbers = true)]
    pub camera: Option<String>,
    /// The position of the camera; without --look-at it looks at the center of the scene
    #[arg(long, value_name = "X,Y,Z", value_parser = point_of_file, allow_hyphen_values = true)]
    pub eye: Option<DVec3>,
    /// A point in the center of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point_of_file, allow_hyphen_values = true)]
    pub look_at: Option<DVec3>,
    /// The direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub up: Option<Vec3>,
    /// Vertical field of view, degrees within 0 and 180
    #[arg(long, value_name = "DEGREES", value_parser = angle, allow_hyphen_values = true)]
    pub fov_y: Option<f32>,
    /// Use parallel rays and a picture of this height, world units
    #[arg(long, value_name = "HEIGHT", value_parser = height, conflicts_with = "fov_y", allow_negative_numbers = true)]
    pub parallel: Option<f32>,
    /// Do not draw what is nearer than this along the view, world units. The default is that of the file's camera, unless
    /// --eye or --look-at moves it
    #[arg(long, value_name = "DEPTH", value_parser = depth, allow_negative_numbers = true)]
    pub near: Option<f32>,
    /// Do not draw what is farther than this along the view; inf for no limit. The default is as for --near
    #[arg(long, value_name = "DEPTH|inf", value_parser = depth, allow_negative_numbers = true)]
    pub far: Option<f32>,
}

/// The backend.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Backend")]
pub struct BackendOptions {
    /// The backend; auto takes the first that works of: discrete, integrated, virtual GPU, CPU,
    /// software Vulkan
    #[arg(long, default_value = "auto", value_parser = choice())]
    pub backend: Choice,
    /// The GPU adapter whose name contains this text, or whose number in `rtrt doctor` it is; auto then
    /// takes no other. The environment variables WGPU_BACKEND (vulkan, metal, dx12) and WGPU_POWER_PREF
    /// (low, high) also choose among adapters
    #[arg(
        long,
        value_name = "NAME",
        env = "WGPU_ADAPTER_NAME",
        hide_env_values = true,
        allow_negative_numbers = true
    )]
    pub adapter: Option<String>,
    /// Threads for loading, and for rendering on the CPU; the default is one for each hardware thread
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// SIMD lanes on the CPU; the default is the fastest
    #[arg(long, value_parser = one_of(["1", "8", "16"]), allow_negative_numbers = true)]
    pub lanes: Option<u32>,
}

impl BackendOptions {
    /// The options for [`choose::choose`].
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
