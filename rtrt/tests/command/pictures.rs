//! What is written: PNG files of 8 and 16 bits, to files and to standard output.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;

#[test]
fn renders_a_file_and_the_demo_to_png() {
    let folder = Folder::new("renders");
    for scene in ["scene.obj", "demo:matchbox", "demo:glass"] {
        let output =
            folder.run(&format!("render {scene} -o out.png --size 64x36 --backend cpu --eye -1,2,3"));
        assert_eq!(stdout(&output), "");
        assert_eq!(stderr(&output).lines().filter(|line| line.starts_with("backend: cpu, ")).count(), 1);
        let picture = image::open(folder.0.join("out.png")).unwrap().into_rgba8();
        assert_eq!(picture.dimensions(), (64, 36));
        let first = *picture.get_pixel(0, 0);
        assert!(picture.pixels().any(|&pixel| pixel != first), "{scene} is blank");
        assert_eq!(folder.files(), ["out.png"]);
    }
}

#[test]
fn a_png_of_16_bits_rounds_to_that_of_8() {
    let folder = Folder::new("bits");
    let line = "render scene.obj --size 37x21 --backend cpu";
    stdout(&folder.run(&format!("{line} -o 8.png")));
    stdout(&folder.run(&format!("{line} -o 16.png --bits 16")));
    let [narrow, wide] = ["8.png", "16.png"].map(|name| image::open(folder.0.join(name)).unwrap());
    assert_eq!(wide.color(), image::ColorType::Rgba16);
    for (narrow, wide) in narrow.into_rgba8().iter().zip(wide.into_rgba16().iter()) {
        assert!((f64::from(*narrow) - f64::from(*wide) / 257.0).abs() <= 0.51);
    }
    // The same picture goes to standard output, and nothing else does.
    let output = folder.run(&format!("{line} -o -"));
    assert_eq!(code(&output), 0);
    assert_eq!(output.stdout, fs::read(folder.0.join("8.png")).unwrap());
}

#[test]
fn the_picture_in_the_readme_is_what_its_command_writes() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/matchbox.png");
    let folder = Folder::new("readme");
    let mut command = folder.command("render demo:matchbox --backend cpu --compare");
    stdout(&command.arg(path).output().unwrap());
}
