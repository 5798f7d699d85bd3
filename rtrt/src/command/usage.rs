//! Errors of the command line, in the form of all other errors.

use super::Error;
use clap::error::ErrorKind;

/// The error of an invalid command line. A request for help is no error: help is printed, and the process ends.
pub fn refused(error: clap::Error) -> Error {
    if !error.use_stderr() || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        error.exit();
    }
    let (what, hint) = message_and_hint(&error.render().to_string());
    Error::Line { what, hint }
}

/// The error and a hint, a line each. The paragraphs of `text` are the error, perhaps tips, the usage, and a
/// reference to help.
fn message_and_hint(text: &str) -> (String, String) {
    let mut parts = text.split("\n\n").map(|part| part.split_whitespace().collect::<Vec<_>>().join(" "));
    let what = parts.next().unwrap_or_default();
    let mut tips = parts.filter_map(|part| part.strip_prefix("tip: ").map(str::to_owned));
    // This tip is for values that look like options, which are rare.
    let tip = tips.find(|tip| !tip.starts_with("to pass "));
    (
        what.trim_start_matches("error: ").to_owned(),
        tip.unwrap_or("--help has all options and examples".into()),
    )
}

#[cfg(test)]
mod tests {
    use super::refused;
    use crate::command::Command;
    use clap::Parser;

    #[test]
    fn every_refusal_is_a_line_and_a_hint() {
        for (line, what, hint) in [
            ("render a.obj -o x.png --size 0", "invalid value '0' for '--size <SIZE>': not WIDTH", "--help"),
            (
                "render a.obj -o x.png --bits 9",
                "invalid value '9' for '--bits <BITS>' [possible values: 8, 16]",
                "--help",
            ),
            ("render --hash", "the following required arguments were not provided: <SCENE>", "--help"),
            (
                "render a.obj --hash --evironment x",
                "unexpected argument '--evironment' found",
                "a similar argument exists: '--environment'",
            ),
            ("verify a.obj --hybrid", "unexpected argument '--hybrid' found", "--help"),
            ("rendr", "unrecognized subcommand 'rendr'", "a similar subcommand exists: 'render'"),
        ] {
            let words = ["rtrt"].into_iter().chain(line.split(' '));
            let error = refused(Command::try_parse_from(words).unwrap_err());
            let said = error.to_string();
            assert!(said.starts_with(what) && !said.contains('\n'), "{said}");
            assert!(error.hint().starts_with(hint), "{}", error.hint());
            assert_eq!(error.exit_code(), 2);
        }
    }
}
