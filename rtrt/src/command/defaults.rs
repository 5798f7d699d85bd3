//! A file with defaults of options.
//!
//! Only the variable `RTRT_CONFIG` names it. A file in a place that is always looked at could change the pictures
//! of a command that is run again elsewhere, and nobody would see why.

use super::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// The environment variable with the name of the file.
const VARIABLE: &str = "RTRT_CONFIG";

/// A default of an option.
#[derive(Debug, PartialEq)]
pub struct Setting {
    /// The long name of the option, without dashes.
    pub name: String,
    /// Its value, if it takes one.
    pub value: Option<String>,
}

/// The file, if there is one.
pub fn path() -> Option<PathBuf> {
    std::env::var_os(VARIABLE).filter(|name| !name.is_empty()).map(PathBuf::from)
}

/// The defaults in a file. Each must be an option of one of the subcommands.
pub fn read(path: &Path, command: &clap::Command) -> Result<Vec<Setting>, Error> {
    let refused = |why: String| Error::Defaults { path: path.to_owned(), why };
    let text = fs::read_to_string(path).map_err(|error| refused(error.to_string()))?;
    parse(&text, command).map_err(refused)
}

/// The defaults in a text: an option a line, as on the command line, its value behind a space or `=`. Empty lines and
/// lines that begin with `#` mean nothing.
fn parse(text: &str, command: &clap::Command) -> Result<Vec<Setting>, String> {
    let mut defaults = Vec::new();
    let lines = text.lines().map(str::trim).enumerate();
    for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        let place = |what: String| format!("line {}: {what}", number + 1);
        let (name, value) = match line.split_once(|c: char| c == '=' || c.is_whitespace()) {
            Some((name, value)) => (name, Some(value.trim())),
            None => (line, None),
        };
        let long = name.strip_prefix("--").ok_or_else(|| place(format!("{name:?} is no option")))?;
        let known = command.get_subcommands().flat_map(clap::Command::get_arguments);
        let Some(argument) = known.into_iter().find(|argument| argument.get_long() == Some(long)) else {
            return Err(place(format!("no command has the option {name}")));
        };
        match (argument.get_action().takes_values(), value) {
            (true, None) => return Err(place(format!("{name} has no value"))),
            (false, Some(value)) => return Err(place(format!("{name} takes no value, and has {value:?}"))),
            _ => defaults.push(Setting { name: long.into(), value: value.map(Into::into) }),
        }
    }
    Ok(defaults)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Command;
    use clap::CommandFactory;

    #[test]
    fn a_line_is_an_option() {
        let command = Command::command();
        let text = "# mine\n\n--size 64x48\n  --environment=my sky.hdr\n--quiet\n";
        let read: Vec<_> = parse(text, &command).unwrap().into_iter().map(|d| (d.name, d.value)).collect();
        let value = |text: &str| Some(text.to_owned());
        let expected = [("size", value("64x48")), ("environment", value("my sky.hdr")), ("quiet", None)];
        assert_eq!(read, expected.map(|(name, value)| (name.to_owned(), value)));
        for (text, why) in [
            ("size 3", "line 1: \"size\" is no option"),
            ("\n--szie 3", "line 2: no command has the option --szie"),
            ("--size", "line 1: --size has no value"),
            ("--quiet yes", "line 1: --quiet takes no value, and has \"yes\""),
        ] {
            assert_eq!(parse(text, &command).unwrap_err(), why);
        }
    }
}
