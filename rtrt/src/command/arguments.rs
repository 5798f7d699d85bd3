//! The arguments before they are parsed: a scene alone is a command, and a file has defaults.

use super::defaults::{self, Setting};
use super::{Command, Error};
use clap::CommandFactory;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// Options that ask for a picture or its numbers: with one of them, a scene alone is rendered.
const RESULTS: [&str; 6] = ["--output", "--aov", "--compare", "--hash", "--json", "--report"];

/// The arguments with the subcommand that `rtrt SCENE` stands for, and with the defaults of the file that
/// `RTRT_CONFIG` names.
pub fn expanded(given: impl IntoIterator<Item = OsString>) -> Result<Vec<OsString>, Error> {
    let mut arguments: Vec<OsString> = given.into_iter().collect();
    let command = Command::command();
    let is_subcommand = |name: &OsStr| name.to_str().is_some_and(|n| command.find_subcommand(n).is_some());
    if let Some(first) = arguments.get(1)
        && !is_subcommand(first)
        && is_scene(first)
    {
        arguments.insert(1, if wants_results(&arguments) { "render" } else { "view" }.into());
    }
    let path = defaults::path();
    let subcommand = arguments.get(1).and_then(|name| command.find_subcommand(name));
    if let (Some(path), Some(subcommand)) = (path, subcommand) {
        let defaults = defaults::read(&path, &command)?;
        let more = with_defaults(subcommand, &arguments[2..], defaults);
        arguments.splice(2..2, more);
    }
    Ok(arguments)
}

/// Whether a first argument is a scene, and not a misspelled subcommand.
fn is_scene(argument: &OsStr) -> bool {
    let text = argument.to_string_lossy();
    let is_option = text.len() > 1 && text.starts_with('-');
    !is_option
        && (text == "-"
            || text.starts_with("demo:")
            || text.contains(['.', '/', '\\'])
            || Path::new(argument).exists())
}

/// Whether the arguments ask for results.
fn wants_results(arguments: &[OsString]) -> bool {
    let asks = |argument: &OsString| {
        let text = argument.to_string_lossy();
        let name = text.split_once('=').map_or(&*text, |(name, _)| name);
        RESULTS.contains(&name) || (text.starts_with("-o") && !text.starts_with("--"))
    };
    arguments.iter().any(asks)
}

/// The defaults as arguments of a subcommand: those that it has, and that neither the command line nor the
/// environment decides.
fn with_defaults(command: &clap::Command, line: &[OsString], defaults: Vec<Setting>) -> Vec<OsString> {
    let is_given = |argument: &clap::Arg| {
        let long = argument.get_long().map(|long| format!("--{long}"));
        let short = argument.get_short().map(|short| format!("-{short}"));
        line.iter().map(|given| given.to_string_lossy()).any(|given| {
            let name = given.split_once('=').map_or(&*given, |(name, _)| name);
            long.as_deref() == Some(name)
                || short.as_deref().is_some_and(|short| given.starts_with(short) && !given.starts_with("--"))
        })
    };
    let mut arguments = Vec::new();
    for Setting { name, value } in defaults {
        let Some(argument) = command.get_arguments().find(|a| a.get_long() == Some(&name)) else { continue };
        let is_rival = |other: &&clap::Arg| {
            let blames = |one: &clap::Arg, other: &clap::Arg| {
                command.get_arg_conflicts_with(one).iter().any(|rival| rival.get_id() == other.get_id())
            };
            other.get_id() == argument.get_id() || blames(argument, other) || blames(other, argument)
        };
        let is_set = argument.get_env().is_some_and(|variable| std::env::var_os(variable).is_some());
        if !is_set && !command.get_arguments().filter(is_rival).any(is_given) {
            arguments.push(OsString::from(match value {
                Some(value) => format!("--{name}={value}"),
                None => format!("--{name}"),
            }));
        }
    }
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<OsString> {
        line.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn a_scene_alone_is_a_command() {
        for (line, command) in [
            ("rtrt a.glb", "view"),
            ("rtrt demo:glass --size 8x8", "view"),
            ("rtrt a.glb -o x.png", "render"),
            ("rtrt a.glb --output=x.png", "render"),
            ("rtrt - --hash", "render"),
            ("rtrt verify", "verify"),
            ("rtrt rendr", "rendr"),
            ("rtrt --help", "--help"),
        ] {
            assert_eq!(expanded(words(line)).unwrap()[1], *command, "{line}");
        }
    }

    #[test]
    fn the_line_decides_before_the_file() {
        let command = Command::command();
        let render = command.find_subcommand("render").unwrap();
        let default =
            |name: &str, value: Option<&str>| Setting { name: name.into(), value: value.map(Into::into) };
        let kept = |line: &str| {
            let defaults = vec![
                default("size", Some("64x64")),
                default("quiet", None),
                default("fov-y", Some("40")),
                default("watch", None),
            ];
            with_defaults(render, &words(line), defaults)
        };
        assert_eq!(kept("a.glb"), ["--size=64x64", "--quiet", "--fov-y=40"]);
        assert_eq!(kept("a.glb --size=8x8 -v"), ["--fov-y=40"]);
        assert_eq!(kept("a.glb --parallel 3 -q"), ["--size=64x64"]);
    }
}
