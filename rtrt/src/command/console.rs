//! What a person sees while a command runs, on standard error.

use super::{Error, output};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Display;
use std::io::Write;
use std::time::Duration;

/// Messages, and a progress bar where standard error is a terminal.
pub struct Console {
    bar: ProgressBar,
}

impl Console {
    /// A console for a command of that many steps.
    pub fn new(steps: u64) -> Self {
        let bar = ProgressBar::new(steps);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {bar:24} {msg}") {
            bar.set_style(style);
        }
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Self { bar }
    }

    /// The next step begins.
    pub fn step(&self, what: impl Display) {
        self.bar.set_message(what.to_string());
        self.bar.inc(1);
    }

    /// The last step is done.
    #[cfg(feature = "viewer")]
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// A line of results.
    pub fn print(&self, line: impl Display) -> Result<(), Error> {
        self.bar.suspend(|| output::print(line))
    }

    /// A line that is not a result.
    pub fn say(&self, line: impl Display) {
        // With standard error closed there is nobody to tell.
        self.bar.suspend(|| writeln!(std::io::stderr(), "{line}").ok());
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
