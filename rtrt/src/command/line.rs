//! The subcommands, with their help.

#[cfg(feature = "viewer")]
use super::options::ViewOptions;
use super::options::{BenchOptions, DoctorOptions, RenderOptions, VerifyOptions};
use super::version;
#[cfg(feature = "viewer")]
use super::view::keys;
use clap_complete::Shell;

/// Real-time ray tracing with the same bits on every machine.
///
/// `rtrt SCENE` shows a scene in a window, and `rtrt SCENE -o FILE` renders it. The environment variable
/// RTRT_CONFIG names a file with defaults: an option a line, as on the command line.
///
/// Exit codes: 0 ok, 1 render failed, 2 usage, 3 input unreadable or invalid, 4 backend or
/// adapter not available, 5 backends or pictures differ, 130 interrupted.
#[derive(Debug, clap::Parser)]
#[command(name = "rtrt", version, long_version = version::long(), max_term_width = 100, after_help = EXAMPLES)]
pub enum Command {
    /// Render a scene to a PNG or EXR file
    #[command(after_help = RENDER_EXAMPLES)]
    Render(RenderOptions),
    /// Render a scene on every backend and compare all buffers bit for bit
    ///
    /// The reference is the CPU with 1 lane and 1 thread. The others are the CPU with 1, 8 and
    /// 16 lanes on 1, 2 and all threads, and each GPU adapter through SPIR-V passthrough and
    /// through naga. --backend, --adapter, --lanes and --threads restrict them. With
    /// RTRT_REQUIRE_GPU=1 in the environment, a missing adapter, or one that neither route can
    /// use, is a failure (exit code 4).
    Verify(VerifyOptions),
    /// Measure how fast a scene renders
    Bench(BenchOptions),
    /// Show a scene in a window
    ///
    /// F12 writes the picture at full resolution, and prints the `rtrt render` command for the same
    /// file. Only this command needs a display and a graphics driver.
    #[cfg(feature = "viewer")]
    #[command(after_long_help = keys())]
    View(ViewOptions),
    /// Show a scene in a window, in a program that was built with the feature `viewer`; this one was not
    #[cfg(not(feature = "viewer"))]
    View {
        /// A scene, and options
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<std::ffi::OsString>,
    },
    /// List adapters, instruction sets, and the choice of --backend auto
    Doctor(DoctorOptions),
    /// Print a script that completes commands in a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page
    Man,
}

impl Command {
    /// Whether it opens a window.
    #[cfg(feature = "viewer")]
    pub fn has_window(&self) -> bool {
        matches!(self, Self::View(_))
    }

    /// Whether it opens a window.
    #[cfg(not(feature = "viewer"))]
    pub fn has_window(&self) -> bool {
        false
    }
}

const EXAMPLES: &str = "\
Examples:
  rtrt render demo:matchbox -o matchbox.png
  rtrt scene.glb
  rtrt render scene.glb -o picture.png --size 1920x1080 --samples 16
  rtrt verify scene.glb
  rtrt doctor";

const RENDER_EXAMPLES: &str = "\
Examples:
  rtrt render scene.glb -o picture.png --eye 0,2,5 --look-at 0,1,0
  rtrt render scene.glb -o {scene}-{frame}.png --frames 48 --fps 24
  rtrt render scene.glb -o cutout.png --background transparent
  rtrt render scene.glb --aov buffers.exr --hash
  rtrt render scene.glb --compare yesterday.png --quiet";
