//! Messages on standard error while a command runs.

use super::options::Talk;
use super::{Error, output};
use indicatif::{ProgressBar, ProgressStyle};
use rtrt::choose::Tell;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::Write;
use std::time::Duration;

/// Messages, and a progress bar where standard error is a terminal.
pub struct Console {
    bar: ProgressBar,
    talk: Talk,
}

impl Console {
    /// A console for a command of that many steps.
    pub fn new(talk: Talk, steps: u64) -> Self {
        let bar = if talk.quiet { ProgressBar::hidden() } else { ProgressBar::new(steps) };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {bar:24} {msg}") {
            bar.set_style(style);
        }
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Self { bar, talk }
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

    /// Prints a line of results.
    pub fn print(&self, line: impl Display) -> Result<(), Error> {
        self.bar.suspend(|| output::print(line))
    }

    /// Writes hashes as results, a line each: of the pixels, then of the deferred buffers. `of` says of which picture, where
    /// there are several.
    pub fn print_hashes(
        &self,
        pixels: &str,
        buffers: Option<BTreeMap<&'static str, String>>,
        of: Option<&str>,
    ) -> Result<(), Error> {
        let of = of.map_or_else(String::new, |of| format!("  {of}"));
        self.print(format_args!("{pixels}  pixels{of}"))?;
        let mut buffers = buffers.into_iter().flatten();
        buffers.try_for_each(|(name, hash)| self.print(format_args!("{hash}  {name}{of}")))
    }

    /// Prints a warning. With `--strict` it is an error with this exit code.
    pub fn warn(&self, code: u8, warning: impl Display) -> Result<(), Error> {
        if self.talk.strict {
            return Err(Error::Strict { warning: warning.to_string(), code });
        }
        self.say(format_args!("warning: {warning}"));
        Ok(())
    }

    /// The callback for a GPU that fails: it prints a warning and accepts the CPU. With `--strict` it refuses.
    pub fn on_gpu_failure(&self) -> Option<Tell> {
        if self.talk.strict {
            return Some(|_| false);
        }
        (!self.talk.quiet).then_some(|error| {
            _ = writeln!(std::io::stderr(), "warning: {error}; the CPU renders from here on");
            true
        })
    }

    /// Prints a line with `--verbose`.
    pub fn detail(&self, line: impl Display) {
        if self.talk.verbose {
            self.say(line);
        }
    }

    /// Prints a line that is not a result.
    pub fn say(&self, line: impl Display) {
        if self.talk.quiet {
            return;
        }
        // Standard error may be closed.
        self.bar.suspend(|| writeln!(std::io::stderr(), "{line}").ok());
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
