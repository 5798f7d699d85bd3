//! What is seen and what is written: the pictures that `rtrt render` makes.

use crate::display::{Display, Window, folder, lines, pixels, rendered, stderr, view};
use image::RgbaImage;
use std::fs;
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

#[test]
fn a_screenshot_is_the_picture_that_the_printed_command_renders() {
    let folder = folder("screenshots");
    let Some(display) = Display::start(&folder) else { return };
    let recording = "size 200 120 1\nframe 0.1\n\
        press W\nframes 5 0.1\nrelease W\n\
        move 100 60\nbutton left down\nmove 130 50\nbutton left up\nwheel 2\npress E\nframe 0.1\nrelease E\n\
        press F12\nframe 0.1\nrelease F12\n\
        press B\nframe 0.1\nrelease B\n\
        press F12\nframe 0.1\nrelease F12\n\
        modifiers ctrl\npress 2\nframe 0.1\nrelease 2\nmodifiers\n\
        press F12\nframe 0.1\nrelease F12\n\
        press D\nframe 0.1\n";
    let output = view(&display, &folder, "demo:matchbox --size 320x180 --backend cpu", recording);
    let printed = lines(&output);
    assert_eq!(printed.len(), 3, "{printed:?}");
    let said = stderr(&output);
    for kind in ["cpu", "gpu"] {
        assert_eq!(said.matches(&format!("backend: {kind}, ")).count(), 1, "{said}");
    }
    let shots = [0, 1, 2].map(|number| pixels(&folder, &format!("rtrt-000{number}.png")));
    assert_eq!(shots[0].dimensions(), (200, 120));
    assert!(shots[0] == shots[1], "the GPU's picture is another one");
    assert!(shots[1] != shots[2], "the normals are the picture");
    for (shot, printed) in shots.iter().zip(&printed) {
        assert!(*shot == rendered(&folder, printed), "{printed}");
    }
    // The test can fail: the camera has moved, and where it is matters.
    let unmoved = "rtrt render demo:matchbox -o x.png --size 200x120";
    assert!(shots[0] != rendered(&folder, unmoved));
    let (before, after) = printed[0].split_once("--eye ").unwrap();
    let (eye, after) = after.split_once(' ').unwrap();
    let (x, rest) = eye.split_once(',').unwrap();
    let x: f32 = x.parse().unwrap();
    assert!(shots[0] != rendered(&folder, &format!("{before}--eye {},{rest} {after}", x + 0.01)));
}

#[test]
fn the_window_shows_the_picture_pixel_for_pixel() {
    // Messages are gone after some seconds; then the window stays open until the test is done.
    let recording =
        "rtrt input 1\nsize 403 217 1\nframe 0.1\npress F12\nframe 0.1\nframes 10 5\nframes 1000000 0.02\n";
    for (window, backend, is_here) in
        [("cpu", "cpu", false), ("cpu", "gpu", false), ("gpu", "cpu", false), ("gpu", "gpu", true)]
    {
        let folder = folder(&format!("window_{window}_{backend}"));
        let Some(display) = Display::start(&folder) else { return };
        fs::write(folder.join("input.txt"), recording).unwrap();
        let line = "view demo:glass --size 403x217 --samples 1 --verbose --replay input.txt -o shot.png";
        let line = format!("{line} --window {window} --backend {backend}");
        let mut window = Window::open(&display, &folder, &line);
        window.until("the screenshot is shown", || {
            let shot = folder.join("shot.png");
            shot.exists() && display.pixels([403, 217]) == pixels(&folder, "shot.png")
        });
        let said = fs::read_to_string(folder.join("stderr")).unwrap();
        assert_eq!(said.contains("pictures stay on the window's device"), is_here, "{said}");
    }
}

/// A triangle that moves to the right in two seconds.
fn moving_triangle(folder: &Path) {
    let positions = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    let (times, places) = ([0.0, 2.0], [0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
    let numbers = positions.iter().chain(&times).chain(&places);
    let bytes: Vec<u8> = numbers.flat_map(|number: &f32| number.to_le_bytes()).collect();
    fs::write(folder.join("moving.bin"), bytes).unwrap();
    let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [{"samplers": [{"input": 1, "output": 2}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
             "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [2]},
            {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
            {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
        "buffers": [{"uri": "moving.bin", "byteLength": 68}]}"#;
    fs::write(folder.join("moving.gltf"), gltf).unwrap();
}

#[test]
fn an_animation_plays_and_a_file_can_be_dropped() {
    let folder = folder("animation");
    let Some(display) = Display::start(&folder) else { return };
    moving_triangle(&folder);
    // At rest, after a second, in the beginning, of another scene.
    let recording = "press F12\nframe 0.1\nrelease F12\n\
        press Space\nframe 0\nrelease Space\nframes 10 0.1\npress Space\nframe 0.1\nrelease Space\n\
        press F12\nframe 1\nrelease F12\n\
        press Enter\nframe 1\nrelease Enter\npress F12\nframe 0.1\nrelease F12\n\
        drop moving.gltf\npress 3\nframe 0.1\npress PageUp\nframes 20 0.1\npress F12\nframe 0.1\n";
    fs::write(folder.join("a b.obj"), "v -2 0 -2\nv 2 0 -2\nv 0 0 2\nf 3 2 1\n").unwrap();
    let recording = recording.replace("drop moving.gltf", "drop a b.obj");
    let output = view(&display, &folder, "moving.gltf --size 160x90 --backend cpu", &recording);
    let printed = lines(&output);
    let times = [0, 1, 2].map(|shot| printed[shot].split_once("--time ").map(|(_, rest)| rest));
    let times = times.map(|rest| rest.map(|rest| rest.split(' ').next().unwrap().parse::<f64>().unwrap()));
    let [None, Some(played), Some(0.0)] = times else { panic!("{printed:?}") };
    assert!((played - 1.0).abs() < 1e-5, "{printed:?}");
    let shots = [0, 1, 2, 3].map(|number| pixels(&folder, &format!("rtrt-000{number}.png")));
    assert!(shots[0] != shots[1] && shots[0] == shots[2] && shots[2] != shots[3]);
    for (shot, printed) in shots.iter().zip(&printed[..3]) {
        assert!(*shot == rendered(&folder, printed), "{printed}");
    }
    let plain = printed[3].replace("'a b.obj'", "c.obj");
    assert!(plain.starts_with("rtrt render c.obj "), "{}", printed[3]);
    fs::rename(folder.join("a b.obj"), folder.join("c.obj")).unwrap();
    assert!(shots[3] == rendered(&folder, &plain));
}

#[test]
fn a_scene_that_is_written_again_is_shown_again() {
    let folder = folder("watch");
    let Some(display) = Display::start(&folder) else { return };
    let write = |x: f32| {
        let scene = format!("mtllib scene.mtl\nusemtl a\nv {x} 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n");
        fs::write(folder.join("scene.obj"), scene).unwrap();
    };
    let paint = |color: &str| {
        fs::write(folder.join("scene.mtl"), format!("newmtl a\nKd 0 0 0\nKe {color}\n")).unwrap()
    };
    let surround = |tone: [u8; 3]| {
        RgbaImage::from_fn(8, 4, |x, _| image::Rgba([tone[0], tone[1], tone[2] + x as u8, 255]))
            .save(folder.join("sky.png"))
            .unwrap();
    };
    write(-2.0);
    paint("0.9 0.9 0.9");
    surround([30, 60, 90]);
    let line = "view scene.obj --environment sky.png --size 160x90 --backend cpu --watch";
    let mut window = Window::open(&display, &folder, line);
    let shown = || display.pixels([160, 90]);
    let colors = |picture: RgbaImage| picture.pixels().collect::<std::collections::HashSet<_>>().len();
    window.until("there is a picture", || colors(shown()) > 3);
    sleep(Duration::from_millis(500));
    let before = shown();
    write(1.0);
    window.until("the picture is another one", || shown() != before && colors(shown()) > 3);
    // What the scene was read from is watched too. A message goes over the lower part of the picture.
    let pixel = |x, y| shown().get_pixel(x, y).0;
    paint("0.9 0 0");
    window.until("the triangle is red", || {
        let [red, green, ..] = pixel(58, 22);
        red > 200 && green < 50
    });
    surround([0, 200, 0]);
    window.until("the sky is green", || {
        let [red, green, ..] = pixel(150, 20);
        green > 150 && red < 50
    });
    fs::write(folder.join("scene.obj"), "nonsense\nf 1 2 3\n").unwrap();
    let said = || fs::read_to_string(folder.join("stderr")).unwrap();
    window.until("the scene is refused", || said().contains("\nerror: ") && said().contains("scene.obj"));
    fs::remove_file(folder.join("scene.obj")).unwrap();
    window.until("the scene is missed", || said().contains("\nscene.obj is gone"));
    assert!(window.viewer.try_wait().unwrap().is_none(), "the viewer has ended");
}
