//! The `rtrt` command.
#![forbid(unsafe_code)]

mod command;

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

/// What shells return for a program that was interrupted.
const INTERRUPTED: i32 = 130;

fn main() -> ExitCode {
    // Without a handler the program ends all the same, and may leave a file that is half written.
    _ = ctrlc::set_handler(|| {
        rtrt::replace::abandon();
        std::process::exit(INTERRUPTED);
    });
    let command = command::Command::try_parse().map_err(command::refused);
    match command.and_then(|command| command::run(&command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // With standard error closed there is nobody left to tell.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            let _ = writeln!(std::io::stderr(), "hint: {}", error.hint());
            ExitCode::from(error.exit_code())
        }
    }
}
