//! A program without std links the crate and runs.

use std::path::Path;
use std::process::Command;

#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "the program's entry point is written for Linux")]
fn a_program_without_std_links_and_runs() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no_std");
    let built = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--locked", "--manifest-path"])
        .arg(here.join("no_std/Cargo.toml"))
        .arg("--target-dir")
        .arg(&target)
        .status()
        .expect("cargo runs");
    assert!(built.success(), "rtrt-core needs std");
    let ran = Command::new(target.join("debug/rtrt-core-no-std")).status().expect("the program starts");
    assert!(ran.success(), "the ray missed the triangle");
}
