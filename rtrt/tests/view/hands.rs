//! Fingers, modes, selection, time, files: what the camera, the scene and the printed command are after them.

use crate::display::{Display, SCREEN, Window, changed, command, folder, lines, pixels, rendered, view};
use std::fs;
use std::path::Path;

/// A key that is pressed and released.
fn key(key: &str) -> String {
    format!("press {key}\nframe 0.05\nrelease {key}\n")
}

const SHOT: &str = "press F12\nframe 0.05\nrelease F12\n";
const SCENE: &str = "demo:glass --size 320x180 --samples 1 --shadows off --backend cpu";

/// The commands that are printed after each of these inputs, each from the beginning, which are rendered and compared.
fn after(test: &str, scene: &str, inputs: &[String]) -> Option<Vec<String>> {
    let folder = folder(test);
    let display = Display::start(&folder)?;
    let recording: String = inputs.iter().map(|input| format!("{}{input}{SHOT}", key("Enter"))).collect();
    let printed = lines(&view(&display, &folder, scene, &recording));
    assert_eq!(printed.len(), inputs.len(), "{printed:?}");
    for (number, printed) in printed.iter().enumerate() {
        assert!(pixels(&folder, &format!("rtrt-{number:04}.png")) == rendered(&folder, printed), "{printed}");
    }
    Some(printed)
}

fn option<'a>(printed: &'a str, name: &str) -> Option<&'a str> {
    Some(printed.split_once(&format!(" {name} "))?.1.split(' ').next().unwrap())
}

fn click(x: u32, y: u32) -> String {
    format!("move {x} {y}\nbutton left down\nframe 0.05\nbutton left up\nframe 0.05\n")
}

#[test]
fn fingers_and_modes_move_the_camera() {
    let drag = "move 100 60\nbutton left down\nframe 0\nmove 120 150\nframe 0\nbutton left up\nframe 1\n";
    let inputs = [
        String::new(),
        "move 160 90\npinch 1.5\n".into(),
        "pan 20 5\n".into(),
        key("F"),
        key("O"),
        key("5") + &key("5"),
        key("T") + drag,
        key("T") + drag,
        key("T") + &click(160, 90) + &click(160, 90) + drag,
    ];
    let Some(printed) = after("hands", SCENE, &inputs) else { return };
    let [start, pinch, pan, framed, parallel, back, trackball, fly, pivot] = &printed[..] else {
        panic!("too few")
    };
    let eye = |printed: &str| option(printed, "--eye").unwrap().to_owned();
    let all = [pinch, pan, framed, trackball, pivot];
    assert!(all.iter().all(|printed| eye(printed) != eye(start)), "{printed:?}");
    assert!(option(parallel, "--parallel").is_some() && option(back, "--parallel").is_none());
    assert!(
        option(trackball, "--up") != option(start, "--up") && option(pivot, "--up") == option(start, "--up")
    );
    assert!(eye(fly) == eye(start) && option(fly, "--look-at") != option(start, "--look-at"));
}

#[test]
fn what_is_selected_can_be_hidden_and_shown_again() {
    let inputs = [
        String::new(),
        click(160, 120) + &key("Delete"),
        key("Backspace"),
        click(160, 120) + &key("F") + &key("Delete"),
    ];
    let Some(printed) = after("selected", SCENE, &inputs) else { return };
    assert!(
        option(&printed[0], "--hide").is_none() && option(&printed[2], "--hide").is_none(),
        "{printed:?}"
    );
    assert!(
        option(&printed[1], "--hide").is_some() && option(&printed[3], "--hide").is_some(),
        "{printed:?}"
    );
    assert_eq!(printed[0].replace("0000", ""), printed[2].replace("0002", ""));
}

#[test]
fn steps_of_an_animation_and_files_of_the_folder() {
    let folder = folder("folder");
    let Some(display) = Display::start(&folder) else { return };
    for name in ["a.obj", "b.obj", "c.obj"] {
        fs::write(folder.join(name), "v -2 0 -2\nv 2 0 -2\nv 0 0 2\nf 3 2 1\n").unwrap();
    }
    image::RgbImage::from_fn(16, 8, |x, y| image::Rgb([x as u8 * 9, 99, y as u8 * 20]))
        .save(folder.join("sky.png"))
        .unwrap();
    let hdr = fs::File::create(folder.join("sky.hdr")).unwrap();
    let light: Vec<_> = (0..128).map(|i| image::Rgb([i as f32 * 0.01, 0.5, 0.1])).collect();
    image::codecs::hdr::HdrEncoder::new(hdr).encode(&light, 16, 8).unwrap();
    exr::prelude::write_rgb_file(folder.join("sky.exr"), 16, 8, |x, y| (0.1 * x as f32, 0.2, 0.1 * y as f32))
        .unwrap();
    let recording = [
        &key("ArrowRight"),
        SHOT,
        &key("ArrowLeft"),
        &key("ArrowLeft"),
        SHOT,
        "drop sky.hdr\nframe 0.1\n",
        SHOT,
        "drop sky.exr\nframe 0.1\n",
        SHOT,
    ];
    let output = view(&display, &folder, "a.obj --size 64x36 --backend cpu", &recording.concat());
    let printed = lines(&output);
    let scene = |number: usize| printed[number].split(' ').nth(2).unwrap();
    assert!(
        scene(0).ends_with("b.obj") && scene(1).ends_with("c.obj") && scene(2).ends_with("c.obj"),
        "{printed:?}"
    );
    assert_eq!(option(&printed[2], "--environment"), Some("sky.hdr"));
    assert_eq!(option(&printed[3], "--environment"), Some("sky.exr"));
    for (number, printed) in printed.iter().enumerate() {
        assert!(pixels(&folder, &format!("rtrt-{number:04}.png")) == rendered(&folder, printed), "{printed}");
    }
    let Some(printed) = after(
        "steps",
        "demo:moving --size 64x36 --backend cpu",
        &[key("Period") + &key("Period"), key("Comma")],
    ) else {
        return;
    };
    let time = |printed: &str| option(printed, "--time").unwrap().parse::<f64>().unwrap();
    assert!((time(&printed[0]) - 2.0 / 24.0).abs() < 1e-9, "{printed:?}");
}

#[test]
fn a_broken_file_of_the_folder_is_passed_and_named() {
    let folder = folder("passed");
    let Some(display) = Display::start(&folder) else { return };
    for name in ["a.obj", "d.obj"] {
        fs::write(folder.join(name), "v -2 0 -2\nv 2 0 -2\nv 0 0 2\nf 3 2 1\n").unwrap();
    }
    fs::write(folder.join("b.glb"), "glTF, but not really").unwrap();
    fs::write(folder.join("c.obj"), "v 0 0 0\n").unwrap();
    let recording = [
        &key("ArrowRight"),
        "frame 0.05\npoint loaded ./d.obj; passed b.glb, c.obj\nframe 0.05\n",
        SHOT,
        &key("ArrowLeft"),
        "frame 0.05\npoint loaded ./a.obj; passed c.obj, b.glb\nframe 0.05\n",
        SHOT,
    ];
    let output =
        view(&display, &folder, "a.obj --size 640x360 --samples 1 --backend cpu", &recording.concat());
    let printed = lines(&output);
    let scenes: Vec<_> = printed.iter().map(|line| line.split(' ').nth(2).unwrap()).collect();
    assert_eq!(scenes, ["./d.obj", "./a.obj"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(said.matches("warning: ./b.glb is passed: ").count(), 2, "{said}");
    fs::remove_file(folder.join("d.obj")).unwrap();
    let none = "frame 0.05\npoint the folder has no other scene that can be loaded; passed b.glb, c.obj\nframe 0.05\n";
    let recording = key("ArrowRight") + none + SHOT;
    let printed =
        lines(&view(&display, &folder, "a.obj --size 640x360 --samples 1 --backend cpu", &recording));
    assert!(printed[0].starts_with("rtrt render a.obj "), "{printed:?}");
}

#[test]
fn the_wheel_stops_at_a_wall_and_flies_through_it() {
    let folder = folder("wall");
    let Some(display) = Display::start(&folder) else { return };
    fs::write(folder.join("wall.obj"), "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n").unwrap();
    let turns = "wheel 1\nframe 0.05\n".repeat(80);
    let recording = [
        "frame 0.05\n",
        &turns,
        "point a surface is in the way: W passes it, or T for the mode fly\nframe 0.05\n",
        SHOT,
        &(key("T") + &key("T")),
        &turns,
        SHOT,
    ];
    let line = "wall.obj --size 320x180 --samples 1 --backend cpu --eye 0,0,12 --look-at 0,0,0";
    let printed = lines(&view(&display, &folder, line, &recording.concat()));
    let z = |number: usize| {
        let eye = option(&printed[number], "--eye").unwrap();
        eye.rsplit(',').next().unwrap().parse::<f64>().unwrap()
    };
    assert!(z(0) > 0.0 && z(0) < 0.1 && z(1) < -1.0, "{printed:?}");
}

#[test]
fn what_lies_over_the_picture_is_seen() {
    // Where something changes by each key, and where nothing does.
    let (low, left, all) = ([0.8, 0.8, 1.0, 1.0], [0.0, 0.0, 0.4, 0.5], [0.0, 0.0, 1.0, 1.0]);
    for (name, keys, place) in [("axes", key("X"), low), ("grid", key("G"), all), ("list", key("L"), left)] {
        let folder = folder(name);
        let Some(display) = Display::start(&folder) else { return };
        see(&display, &folder, &keys, place);
    }
    let (folder, selected) = (folder("clicked"), click(400, 400));
    let Some(display) = Display::start(&folder) else { return };
    see(&display, &folder, &selected, [0.0, 0.5, 0.4, 1.0]);
}

fn see(display: &Display, folder: &Path, keys: &str, place: [f32; 4]) {
    let recording =
        format!("rtrt input 1\nsize 800 600 1\nframe 0.1\n{keys}frames 5 0.1\nframes 1000000 0\n");
    fs::write(folder.join("input.txt"), recording).unwrap();
    let line = "demo:glass --size 800x600 --samples 1 --shadows off --backend cpu";
    command(folder, &format!("render {line} -o plain.png")).status().unwrap();
    let plain = pixels(folder, "plain.png");
    let mut window = Window::open(display, folder, &format!("view {line} --replay input.txt"));
    window.until(keys, || changed(&plain, &display.pixels(SCREEN), place) > 150);
}
