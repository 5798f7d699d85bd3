//! Defaults of options from a file.

use crate::folder::{Folder, code, json, stderr};
use std::fs;
use std::process::Output;

fn run(folder: &Folder, line: &str, file: &str) -> Output {
    folder.command(line).env("RTRT_CONFIG", file).output().unwrap()
}

#[test]
fn a_file_has_defaults_and_the_line_decides() {
    let folder = Folder::new("defaults");
    fs::write(folder.0.join("rtrt.conf"), "# small\n--size 24x12\n--samples=1\n--backend cpu\n--fps 3\n")
        .unwrap();
    let size = |line: &str, file: &str| json(&run(&folder, line, file))["size"].clone();
    assert_eq!(size("render scene.obj --json", "rtrt.conf"), serde_json::json!([24, 12]));
    assert_eq!(size("render scene.obj --json --size 8x8", "rtrt.conf"), serde_json::json!([8, 8]));
    // verify has no --fps.
    assert_eq!(size("verify scene.obj --json", "rtrt.conf"), serde_json::json!([24, 12]));
    assert_eq!(size("scene.obj --json", "rtrt.conf"), serde_json::json!([24, 12]));
    assert_eq!(size("render scene.obj --json --backend cpu", ""), serde_json::json!([1280, 720]));
}

#[test]
fn a_wrong_file_is_refused_by_its_name() {
    let folder = Folder::new("defaults_wrong");
    fs::write(folder.0.join("wrong.conf"), "--size 8x8\n--szie 3\n").unwrap();
    for (file, why) in [("wrong.conf", "line 2: no command has the option --szie"), ("missing.conf", "")] {
        let output = run(&folder, "render scene.obj --hash", file);
        let said = stderr(&output);
        assert_eq!(code(&output), 2, "{said}");
        assert!(said.starts_with(&format!("error: defaults refused: {file}: {why}")), "{said}");
    }
}
