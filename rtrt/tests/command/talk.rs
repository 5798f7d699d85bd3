//! How much is said, and in which colors.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;

const LINE: &str = "--size 8x8 --backend cpu";

/// A scene whose texture is missing.
fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    fs::write(folder.0.join("a.mtl"), "newmtl a\nmap_Kd nowhere.png\n").unwrap();
    let obj = "mtllib a.mtl\nusemtl a\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 4 0\nvt 0 4\nf 1/1 2/2 3/3\n";
    fs::write(folder.0.join("textured.obj"), obj).unwrap();
    folder
}

#[test]
fn quiet_says_nothing_and_verbose_says_more() {
    let folder = folder("talk");
    let said = |options: &str| {
        let output = folder.run(&format!("render textured.obj {LINE} -o out.png {options}"));
        assert_eq!(stdout(&output), "");
        stderr(&output)
    };
    assert_eq!(said("--quiet"), "");
    let (usual, more) = (said(""), said("-v"));
    assert!(usual.contains("backend: cpu") && !usual.contains("visibility"), "{usual}");
    assert!(more.contains("1 triangle stored") && more.contains("visibility"), "{more}");
    assert_eq!(code(&folder.run(&format!("render scene.obj {LINE} -o out.png -q -v"))), 2);
    // Errors are said all the same.
    assert!(stderr(&folder.run("render missing.obj --quiet -o out.png")).starts_with("error: "));
}

/// Libraries print what they like on standard error, such as Mesa without a window system.
#[test]
fn no_library_says_anything() {
    let folder = folder("libraries");
    let said = |line: &str| {
        let mut command = folder.command(line);
        command.env_remove("XDG_RUNTIME_DIR").env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
        stderr(&command.output().unwrap())
    };
    assert_eq!(said("doctor"), "");
    assert_eq!(said("render scene.obj --size 8x8 -q -o out.png"), "");
    let usual = said("render scene.obj --size 8x8 -o out.png");
    assert!(usual.starts_with("backend: ") && usual.lines().count() == 1, "{usual}");
}

#[test]
fn a_missing_texture_is_named_and_seen() {
    let folder = folder("missing");
    let output = folder.run(&format!("render textured.obj {LINE} -o out.png"));
    assert!(stderr(&output).contains("warning: texture \"nowhere.png\""), "{}", stderr(&output));
    let picture = image::open(folder.0.join("out.png")).unwrap().into_rgba8();
    let is_magenta = |p: &image::Rgba<u8>| p[0] > 90 && p[2] > 90 && p[1] < 60;
    assert!(picture.pixels().any(is_magenta));
}

#[test]
fn strict_makes_a_warning_an_error() {
    let folder = folder("strict");
    for command in ["render -o out.png", "verify", "bench"] {
        let output = folder.run(&format!("{command} textured.obj {LINE} --strict"));
        assert_eq!(code(&output), 3, "{}", stderr(&output));
        let said = stderr(&output);
        assert!(said.starts_with("error: texture \"nowhere.png\"") && said.contains("hint: "), "{said}");
    }
    assert!(!folder.0.join("out.png").exists());
    stdout(&folder.run(&format!("render scene.obj {LINE} --strict -o out.png")));
}

#[test]
fn no_color_means_no_color() {
    let folder = folder("color_free");
    let said = |name: &str, value: &str| {
        let mut command = folder.command("render --help");
        command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").env(name, value);
        stdout(&command.output().unwrap())
    };
    assert!(said("CLICOLOR_FORCE", "1").contains('\u{1b}'));
    assert!(!said("NO_COLOR", "1").contains('\u{1b}'));
}
