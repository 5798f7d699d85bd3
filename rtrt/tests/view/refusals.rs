//! What does not work: a line, a hint, an exit code.

use crate::display::{Display, command, folder, stderr, view};
use std::fs;

#[test]
fn a_replay_ends_with_an_error_where_something_does_not_work() {
    let folder = folder("errors");
    let Some(display) = Display::start(&folder) else { return };
    let end = |recording: &str, options: &str| {
        let output = view(&display, &folder, &format!("demo:matchbox --size 32x18 {options}"), recording);
        let said = stderr(&output);
        let error = said.lines().rfind(|line| line.starts_with("error: ")).unwrap_or_default().to_owned();
        (output.status.code(), error)
    };
    let (code, error) = end("drop nothing.glb\nframe 0.1\n", "");
    assert!(code == Some(3) && error.contains("nothing.glb"), "{code:?} {error}");
    // Nobody has to press F12 for that.
    let (code, error) = end("frame 0.1\n", "-o nowhere/x.png");
    assert!(code == Some(1) && error.contains("nowhere"), "{code:?} {error}");
    let (code, error) = end("modifiers ctrl\npress 1\nsize 16384 8192 1\nframe 0.1\n", "");
    assert!(code == Some(2) && error.contains("frame too large"), "{code:?} {error}");
    let (code, error) = end("press Wumm\nframe 0.1\n", "");
    assert!(code == Some(3) && error.contains("input.txt: line 2: no such key"), "{code:?} {error}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_missing_library_is_an_error_and_no_panic() {
    let folder = folder("library");
    let Some(display) = Display::start(&folder) else { return };
    fs::write(folder.join("input.txt"), "rtrt input 1\nframe 0.1\n").unwrap();
    for names in [["libXi.so.6", "libXi.so"], ["libxkbcommon-x11.so.0", "libxkbcommon-x11.so"]] {
        // An empty file in place of the library.
        names.iter().for_each(|name| fs::write(folder.join(name), "").unwrap());
        let mut command = command(&folder, "view demo:matchbox --size 32x18 --replay input.txt");
        let output = command.env("DISPLAY", &display.name).env("LD_LIBRARY_PATH", &folder).output().unwrap();
        let said = stderr(&output);
        assert!(output.status.code() == Some(4) && said.lines().count() == 2, "{names:?}: {said}");
        assert!(said.starts_with("error: cannot open a window: demo:matchbox: "), "{names:?}: {said}");
        names.iter().for_each(|name| fs::remove_file(folder.join(name)).unwrap());
    }
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_display_there_is_an_error_and_no_window() {
    let folder = folder("no_display");
    for display in [None, Some(":54321")] {
        let mut command = command(&folder, "view demo:matchbox");
        command.envs(display.map(|name| ("DISPLAY", name)));
        let output = command.output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(4), "{said}");
        let lines: Vec<_> = said.lines().collect();
        assert!(
            lines.len() == 2 && lines[0].starts_with("error: cannot open a window: demo:matchbox: "),
            "{said}"
        );
        assert!(lines[1].starts_with("hint: ") && !said.contains(".rs:"), "{said}");
    }
}

#[test]
fn a_window_that_software_is_told_to_draw_is_refused_where_warnings_are_errors() {
    let folder = folder("strict");
    let Some(display) = Display::start(&folder) else { return };
    let end = |options: &str| {
        let line = format!("demo:matchbox --size 32x18 --backend cpu {options}");
        let output = view(&display, &folder, &line, "frame 0.1\n");
        (output.status.code(), stderr(&output))
    };
    // Without being told, the CPU draws the window.
    assert_eq!(end("--strict").0, Some(0));
    let (code, said) = end("--window gpu");
    assert_eq!(code, Some(0), "{said}");
    if said.contains("warning: the window is drawn by a software adapter: ") {
        let (code, said) = end("--window gpu --strict --quiet");
        assert_eq!(code, Some(4), "{said}");
        assert!(said.contains("error: the window is drawn by a software adapter: "), "{said}");
        assert!(said.contains(" (--strict)\nhint: "), "{said}");
    }
}
