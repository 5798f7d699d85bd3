//! What the command does, one file a subcommand.

mod bench;
mod compare;
mod console;
mod doctor;
mod error;
mod exr;
mod job;
mod names;
mod options;
mod output;
mod parse;
mod render;
mod report;
mod usage;
mod verify;
mod version;
#[cfg(feature = "viewer")]
mod view;

use clap::CommandFactory;
use clap_complete::Shell;
pub use error::Error;
use options::{Bench, Render, Verify};
use std::io;
pub use usage::refused;

/// Real-time ray tracing with the same bits on every machine.
///
/// Exit codes: 0 ok, 1 render failed, 2 usage, 3 input unreadable or invalid, 4 backend or
/// adapter not available, 5 backends or pictures differ, 130 interrupted.
#[derive(Debug, clap::Parser)]
#[command(name = "rtrt", version, long_version = version::long(), max_term_width = 100, after_help = EXAMPLES)]
pub enum Command {
    /// Render a scene to a PNG or EXR file
    #[command(after_help = RENDER_EXAMPLES)]
    Render(Render),
    /// Render a scene on every backend and compare all buffers bit for bit
    ///
    /// The reference is the CPU with 1 lane and 1 thread. Compared with it are: the CPU
    /// with 1, 8 and 16 lanes on 1, 2 and all threads; each GPU adapter through SPIR-V
    /// passthrough and through naga. --backend, --adapter, --lanes and --threads leave out
    /// what does not match. With RTRT_REQUIRE_GPU=1 in the environment, no adapter, or one that
    /// cannot be compared by either route, is a failure (exit code 4).
    Verify(Verify),
    /// Measure how fast a scene renders
    Bench(Bench),
    /// Look at a scene in a window
    ///
    /// F12 writes what is seen at full resolution, and prints the `rtrt render` command that gives the
    /// same file. A window needs a display and a graphics driver; no other command does.
    #[cfg(feature = "viewer")]
    #[command(after_long_help = view::keys())]
    View(options::View),
    /// List adapters and instruction sets, and what --backend auto would choose
    Doctor,
    /// Print a script that completes commands in a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page
    Man,
}

const EXAMPLES: &str = "\
Examples:
  rtrt render demo:matchbox -o matchbox.png
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

/// Does what was asked for.
pub fn run(command: &Command) -> Result<(), Error> {
    match command {
        Command::Render(options) => render::run(options),
        Command::Verify(options) => verify::run(options),
        Command::Bench(options) => bench::run(options),
        #[cfg(feature = "viewer")]
        Command::View(options) => view::run(options),
        Command::Doctor => doctor::run(),
        Command::Completions { shell } => {
            let mut script = vec![];
            clap_complete::generate(*shell, &mut Command::command(), "rtrt", &mut script);
            output::print_bytes(&script)
        }
        Command::Man => Ok(manual(&mut io::stdout())?),
    }
}

/// Writes the manual page of the command, and then those of its subcommands.
fn manual(to: &mut impl io::Write) -> io::Result<()> {
    let mut command = Command::command();
    command.build();
    clap_mangen::Man::new(command.clone()).render(to)?;
    let mut parts = command.get_subcommands().filter(|part| part.get_name() != "help");
    parts.try_for_each(|part| clap_mangen::Man::new(part.clone()).render(to))
}
