//! Exposure and tone maps.

use crate::folder::{Folder, code, json, stderr, stdout};
use std::fs;

const LINE: &str = "render scene.obj --size 40x24 --backend cpu";

fn pixels(folder: &Folder, options: &str) -> Vec<[u8; 4]> {
    stdout(&folder.run(&format!("{LINE} -o out.png {options}")));
    let picture = image::open(folder.0.join("out.png")).unwrap().into_rgba8();
    picture.pixels().map(|pixel| pixel.0).collect()
}

fn mean(pixels: &[[u8; 4]]) -> f64 {
    pixels.iter().flat_map(|pixel| &pixel[..3]).map(|&c| f64::from(c)).sum::<f64>()
        / pixels.len() as f64
        / 3.0
}

#[test]
fn a_meter_finds_the_same_stops_whatever_renders() {
    let folder = Folder::new("metered");
    let stops = |options: &str| {
        let output = folder.run(&format!("{LINE} --json --light sun:1,3,1:color=50,50,50 {options}"));
        json(&output)["exposure"].as_f64().unwrap()
    };
    let auto = stops("--exposure auto");
    assert!((-8.0..-2.0).contains(&auto), "{auto}");
    for options in ["--lanes 1 --threads 1", "--lanes 8", "--tone-map agx", "--samples 16"] {
        assert_eq!(stops(&format!("--exposure auto {options}")), auto, "{options}");
    }
    assert_eq!((stops(""), stops("--exposure -3.5")), (0.0, -3.5));
    let light = "--light sun:1,3,1:color=50,50,50";
    let metered = pixels(&folder, &format!("{light} --exposure auto"));
    assert_eq!(metered, pixels(&folder, &format!("{light} --exposure {auto}")));
    // Ten times as much light is metered away.
    let brighter = pixels(&folder, "--light sun:1,3,1:color=500,500,500 --exposure auto");
    assert!((mean(&brighter) - mean(&metered)).abs() < 6.0);
}

#[test]
fn an_animation_is_metered_once() {
    let folder = Folder::new("metered_once");
    let line = format!("{LINE} --frames 3 -o {{n}}.png --exposure auto");
    let said = stderr(&folder.run(&line));
    assert_eq!(said.matches("exposure: ").count(), 1, "{said}");
}

#[test]
fn tone_maps_differ_where_light_is_strong_and_files_of_light_do_not() {
    let folder = Folder::new("tone_maps");
    let light = "--light sun:1,3,1:color=9,7,5";
    let maps =
        ["neutral", "agx", "aces", "none"].map(|name| pixels(&folder, &format!("{light} --tone-map {name}")));
    for (a, b) in (0..4).flat_map(|a| (0..a).map(move |b| (a, b))) {
        assert_ne!(maps[a], maps[b]);
    }
    assert_eq!(maps[0], pixels(&folder, light));
    let wide = |options: &str| {
        stdout(&folder.run(&format!("{LINE} {light} --bits 16 -o out.png {options}")));
        image::open(folder.0.join("out.png")).unwrap().into_rgba16()
    };
    for (name, eight) in ["neutral", "agx", "aces", "none"].iter().zip(&maps) {
        for (a, b) in wide(&format!("--tone-map {name}")).pixels().zip(eight) {
            assert!(
                a.0.iter().zip(b).all(|(a, b)| (i32::from(*a) - 257 * i32::from(*b)).abs() <= 130),
                "{name}"
            );
        }
    }
    let exr = |options: &str| {
        stdout(&folder.run(&format!("{LINE} {light} -o out.exr {options}")));
        fs::read(folder.0.join("out.exr")).unwrap()
    };
    assert_eq!(exr(""), exr("--exposure 3 --tone-map none"));
}

#[test]
fn a_picture_that_is_mostly_white_or_black_says_so_once() {
    let folder = Folder::new("clipped");
    let said = |options: &str| stderr(&folder.run(&format!("{LINE} -o out.png {options}")));
    for (options, what) in [
        ("--light sun:1,3,1:color=9000,9000,9000", "% of the picture is white"),
        ("--light sun:1,3,1:color=0,0,0 --ambient 0,0,0", "% of the picture is black"),
    ] {
        let line = said(options);
        let lines: Vec<&str> = line.lines().filter(|line| line.contains("of the picture is")).collect();
        assert!(
            lines.len() == 1 && lines[0].contains(what) && lines[0].contains("--exposure auto"),
            "{line}"
        );
    }
    assert!(!said("").contains("of the picture is"));
    assert!(!said("--light sun:1,3,1:color=9000,9000,9000 --exposure auto").contains("of the picture is"));
    // A black picture that is metered: another exposure is no help.
    let dark = "--light sun:1,3,1:color=0,0,0 --ambient 0,0,0 --exposure auto";
    assert!(!said(dark).contains("of the picture is"));
    assert_eq!(said("--light sun:1,3,1:color=9000,9000,9000 --quiet"), "");
}

#[test]
fn numbers_that_expose_nothing_are_wrong_usage() {
    let folder = Folder::new("exposure_refused");
    for wrong in ["--exposure nan", "--exposure 65", "--exposure bright", "--tone-map film", "--exposure"] {
        assert_eq!(code(&folder.run(&format!("{LINE} -o out.png {wrong}"))), 2, "{wrong}");
    }
}
