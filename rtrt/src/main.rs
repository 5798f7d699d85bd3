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
    let (ran, has_window) = match command::parsed(std::env::args_os()) {
        Ok(command) => (command::run(&command), command.has_window()),
        Err(error) => (Err(error), false),
    };
    let code = match ran {
        Ok(()) => 0,
        Err(error) => {
            // Standard error may be closed.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            let _ = writeln!(std::io::stderr(), "hint: {}", error.hint());
            error.exit_code()
        }
    };
    if has_window {
        // Who has closed a window waits for nothing.
        rtrt::replace::leave(code);
    }
    ExitCode::from(code)
}
