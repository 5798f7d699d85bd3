//! A scene without a subcommand.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;

#[test]
fn a_scene_with_an_output_is_rendered() {
    let folder = Folder::new("shorthand");
    let line = "scene.obj --size 8x8 --backend cpu";
    stdout(&folder.run(&format!("{line} -o short.png")));
    stdout(&folder.run(&format!("render {line} -o long.png")));
    let [short, long] = ["short.png", "long.png"].map(|name| fs::read(folder.0.join(name)).unwrap());
    assert_eq!(short, long);
    assert_eq!(stdout(&folder.run("demo:glass --hash --size 8x8 --backend cpu")).lines().count(), 11);
    let said = stderr(&folder.run("rendr scene.obj -o out.png"));
    assert!(said.contains("unrecognized subcommand 'rendr'"), "{said}");
    let output = folder.run("missing.obj -o out.png");
    assert!(code(&output) == 3 && stderr(&output).contains("missing.obj"), "{}", stderr(&output));
}

/// A display that is not there is the viewer's error.
#[test]
#[cfg(all(target_os = "linux", feature = "viewer"))]
fn a_scene_alone_is_shown_in_a_window() {
    let folder = Folder::new("shorthand_view");
    let mut command = folder.command("scene.obj --size 8x8");
    let output = command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").output().unwrap();
    assert_eq!(code(&output), 4);
    assert!(stderr(&output).contains("cannot open a window: scene.obj"), "{}", stderr(&output));
}
