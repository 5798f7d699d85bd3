//! Commands that are ended, and disks that are full.
#![cfg(unix)]

use crate::folder::{Folder, code, stderr};
use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

#[test]
fn an_interrupted_run_leaves_whole_files() {
    for signal in ["-INT", "-TERM"] {
        interrupted(signal);
    }
}

fn interrupted(signal: &str) {
    let folder = Folder::new("interrupted");
    fs::create_dir(folder.0.join("out")).unwrap();
    let line = "render scene.obj --size 640x360 --backend cpu --frames 100000 -o out/{frame}.png";
    let mut running = folder.command(line).stderr(Stdio::null()).spawn().unwrap();
    let files = || -> Vec<_> {
        fs::read_dir(folder.0.join("out")).unwrap().map(|entry| entry.unwrap().path()).collect()
    };
    let start = Instant::now();
    while files().len() < 3 {
        assert!(start.elapsed() < Duration::from_secs(60), "no frame is written");
        sleep(Duration::from_millis(5));
    }
    let pid = running.id().to_string();
    assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
    assert_eq!(running.wait().unwrap().code(), Some(130));
    for file in files() {
        assert_eq!(file.extension().unwrap(), "png", "{} is left", file.display());
        assert_eq!(image::open(&file).unwrap().width(), 640);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_said() {
    let folder = Folder::new("full");
    let full = || Stdio::from(fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    for line in ["render scene.obj -o -", "render scene.obj --hash", "verify scene.obj", "man"] {
        let size = if line == "man" { "" } else { "--size 8x8 --backend cpu" };
        let output = folder.command(&format!("{line} {size}")).stdout(full()).output().unwrap();
        assert_eq!(code(&output), 1, "{line}: {}", stderr(&output));
        let said = stderr(&output);
        assert!(said.contains("error: cannot write to standard output: No space left on device"), "{said}");
    }
}

/// A disk of 64 KiB, which takes a right that tests may not have.
#[test]
#[cfg(target_os = "linux")]
fn a_picture_that_does_not_fit_on_its_disk_leaves_nothing() {
    let folder = Folder::new("small_disk");
    let disk = folder.0.join("disk");
    fs::create_dir(&disk).unwrap();
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(&disk).output();
    if !mount.is_ok_and(|mount| mount.status.success()) {
        return println!("skipped: no disk can be mounted here");
    }
    let line = "render demo:matchbox --size 640x360 --samples 1 --backend cpu";
    let outputs = ["-o disk/out.png", "--aov disk/out.exr"].map(|to| folder.run(&format!("{line} {to}")));
    let left = fs::read_dir(&disk).unwrap().count();
    assert!(Command::new("umount").arg(&disk).status().unwrap().success());
    for output in outputs {
        let said = stderr(&output);
        assert!(code(&output) == 1 && said.contains("disk/out.") && said.contains("No space left"), "{said}");
    }
    assert_eq!(left, 0);
}
