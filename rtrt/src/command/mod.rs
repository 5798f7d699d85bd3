//! What the command does, one file a subcommand.

mod bench;
mod console;
mod doctor;
mod error;
mod exr;
mod job;
mod options;
mod output;
mod render;
mod report;
mod verify;
#[cfg(feature = "viewer")]
mod view;

pub use error::Error;
use options::{Bench, Render, Verify};

/// Real-time ray tracing with the same bits on every machine.
///
/// Exit codes: 0 ok, 1 render failed, 2 usage, 3 input unreadable or invalid, 4 backend or
/// adapter not available, 5 backends disagree.
#[derive(Debug, clap::Parser)]
#[command(name = "rtrt", version, max_term_width = 100)]
pub enum Command {
    /// Render a scene to a PNG or EXR file
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
}

/// Does what was asked for.
pub fn run(command: &Command) -> Result<(), Error> {
    match command {
        Command::Render(options) => render::run(options),
        Command::Verify(options) => verify::run(options),
        Command::Bench(options) => bench::run(options),
        #[cfg(feature = "viewer")]
        Command::View(options) => view::run(options),
        Command::Doctor => doctor::run(),
    }
}
