//! Why a window could not be opened, in one line.

use std::fmt::Display;
use std::panic::{self, AssertUnwindSafe};

/// The result of `open`, with a panic as an error: where a library or an extension of the display is missing,
/// the crates for windows panic.
pub(super) fn panics_caught<T>(open: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let opened = panic::catch_unwind(AssertUnwindSafe(open));
    panic::set_hook(hook);
    opened.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or(panic.downcast_ref::<String>().map(String::as_str));
        // Messages are one line.
        Err(text.unwrap_or("it panicked").lines().collect::<Vec<_>>().join(" "))
    })
}

/// The text of an error without the place in a library's source, as in "os error at src/x.rs:12: why".
pub(super) fn reason(error: &impl Display) -> String {
    let text = error.to_string();
    let why = text.strip_prefix("os error at ").and_then(|rest| rest.split_once(".rs:")?.1.split_once(": "));
    why.map_or(text.as_str(), |(_, why)| why).trim_end_matches('.').to_owned()
}
