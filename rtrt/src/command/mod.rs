//! The command, one file for each subcommand.

mod arguments;
mod bench;
mod clipped;
mod compare;
mod console;
mod defaults;
mod doctor;
mod error;
mod exr;
#[cfg_attr(not(feature = "gpu"), path = "no_gpus.rs")]
mod gpus;
mod job;
mod line;
mod memory;
mod names;
mod npy;
mod options;
mod output;
mod parse;
mod render;
mod repaint;
mod report;
mod run_report;
mod sinks;
mod stream;
mod surroundings;
mod usage;
mod verify;
mod version;
mod video;
#[cfg(feature = "viewer")]
mod view;
mod views;

use clap::{CommandFactory, Parser};
pub use error::Error;
pub use line::Command;
use std::ffi::OsString;
use std::io;
use usage::refused;

/// The command in these arguments.
pub fn parsed(arguments: impl IntoIterator<Item = OsString>) -> Result<Command, Error> {
    Command::try_parse_from(arguments::expanded(arguments)?).map_err(refused)
}

/// Runs the subcommand.
pub fn run(command: &Command) -> Result<(), Error> {
    match command {
        Command::Render(options) => render::run(options),
        Command::Verify(options) => verify::run(options),
        Command::Bench(options) => bench::run(options),
        #[cfg(feature = "viewer")]
        Command::View(options) => view::run(options),
        #[cfg(not(feature = "viewer"))]
        Command::View { .. } => Err(Error::NoWindow),
        Command::Doctor(options) => doctor::run(options),
        Command::Completions { shell } => {
            let mut script = vec![];
            clap_complete::generate(*shell, &mut Command::command(), "rtrt", &mut script);
            read_in_part(output::print_bytes(&script))
        }
        Command::Man => read_in_part(manual(&mut io::stdout()).map_err(Error::from)),
    }
}

/// Who reads a text may stop before its end, as `head` does.
fn read_in_part(printed: Result<(), Error>) -> Result<(), Error> {
    match printed {
        Err(Error::Print(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        printed => printed,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_may_stop_and_a_full_disk_is_an_error() {
        let ended = |kind: io::ErrorKind| read_in_part(Err(Error::from(io::Error::from(kind))));
        assert!(ended(io::ErrorKind::BrokenPipe).is_ok());
        assert!(matches!(ended(io::ErrorKind::StorageFull), Err(Error::Print(_))));
    }
}
