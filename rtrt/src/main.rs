//! The `rtrt` command.
#![forbid(unsafe_code)]

mod command;

use std::io::Write;
use std::process::ExitCode;

/// The exit code of an interrupted program, as shells have it.
const INTERRUPTED: i32 = 130;

fn main() -> ExitCode {
    // Without a handler, an interrupted program may leave a partial file.
    _ = ctrlc::set_handler(|| {
        rtrt::replace::abandon();
        std::process::exit(INTERRUPTED);
    });
    match command::parsed(std::env::args_os()).and_then(|command| command::run(&command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Standard error may be closed.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            let _ = writeln!(std::io::stderr(), "hint: {}", error.hint());
            ExitCode::from(error.exit_code())
        }
    }
}
