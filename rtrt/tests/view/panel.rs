//! What lies over the picture: keys, timing, messages, and the panel, every entry of which has an option.

use crate::display::{
    Display, SCREEN, Window, changed, command, folder, lines, pixels, rendered, stderr, view,
};
use std::fs;

/// A click, and what follows of it.
fn click(x: u32, y: u32) -> String {
    format!("move {x} {y}\nframe 0.1\nbutton left down\nframe 0.1\nbutton left up\nframes 3 0.1\n")
}

/// A number typed where there is another one.
fn number(x: u32, y: u32, number: &str) -> String {
    click(x, y) + &format!("text {number}\nframe 0.1\npress Enter\nframe 0.1\nrelease Enter\nframe 0.1\n")
}

const OPEN: &str = "size 640 480 1\nframe 0.1\npress P\nframe 0.1\nrelease P\nframes 5 0.1\n";
const SHOT: &str = "press F12\nframe 0.1\nrelease F12\n";

#[test]
fn what_is_changed_in_the_panel_is_an_option_of_the_command() {
    let folder = folder("panel");
    let Some(display) = Display::start(&folder) else { return };
    // Places are those of the panel in a window of 640 x 480. Enter and Escape end what is written and what has
    // popped up, and leave the camera and the window alone.
    let zoom = "modifiers ctrl\nwheel 3\nmodifiers\nframe 0.1\n";
    let samples = click(445, 59);
    let shadows = click(429, 83) + &click(406, 132);
    let depth = number(519, 105, "3");
    let ambient = click(455, 206)
        + "point R \nframe 0.1\nbutton left down\nframe 0.1\nbutton left up\nframes 3 0.1\n"
        + "text 200\nframe 0.1\npress Enter\nframe 0.1\nrelease Enter\nframe 0.1\n"
        + "press Escape\nframe 0.1\nrelease Escape\nframes 3 0.1\n";
    let light = number(473, 275, "4") + &number(463, 298, "7") + &number(463, 367, "0.5");
    let shown = click(429, 174) + &click(409, 224);
    let changes = [zoom, OPEN, &samples, &shadows, &depth, &light, SHOT, &ambient, SHOT, &shown, SHOT];
    let line = "demo:matchbox --light point:1,2,3:0.25 --size 640x480 --samples 4 --backend cpu";
    let printed = lines(&view(&display, &folder, line, &changes.concat()));
    let [changed, colored, seen] = &printed[..] else { panic!("{printed:?}") };
    for option in [
        " --samples 1 ",
        " --shadows hard ",
        " --transparency-depth 3 ",
        " --light point:4,2,3:0.5:color=7,7,7 ",
    ] {
        assert!(printed.iter().all(|line| line.contains(option)), "{option}: {printed:?}");
    }
    let ambient = |line: &str| {
        line.split_once(" --ambient ").map(|(_, rest)| rest.split(' ').next().unwrap().to_owned())
    };
    assert!(ambient(colored).is_some() && ambient(colored) != ambient(changed), "{printed:?}");
    assert!(printed.iter().all(|line| !line.contains(" --fov-y 48.7")), "{printed:?}");
    assert!(seen.contains(" --debug ") && !colored.contains(" --debug "), "{printed:?}");
    for (number, printed) in printed.iter().enumerate() {
        assert!(pixels(&folder, &format!("rtrt-000{number}.png")) == rendered(&folder, printed), "{printed}");
    }
}

#[test]
fn hybrid_frames_are_switched_in_the_panel() {
    let folder = folder("hybrid");
    let Some(display) = Display::start(&folder) else { return };
    let is_hybrid = |line: &String| line.contains(" --hybrid --backend gpu");
    let shots = |line: &str, recording: &str| {
        let printed = lines(&view(
            &display,
            &folder,
            &format!("demo:matchbox --size 640x480 --samples 1 {line}"),
            recording,
        ));
        printed.iter().map(is_hybrid).collect::<Vec<_>>()
    };
    let recording =
        [OPEN, SHOT, &click(386, 128), SHOT, "press B\nframe 0.1\nrelease B\n", SHOT, &click(386, 128), SHOT]
            .concat();
    // The CPU draws nothing, and there is nothing to switch.
    assert_eq!(shots("--backend gpu", &recording), [false, true, false, false]);
    let [traced, drawn, cpu, _] =
        [0, 1, 2, 3].map(|number| pixels(&folder, &format!("rtrt-000{number}.png")));
    let different = drawn.pixels().zip(traced.pixels()).filter(|(a, b)| a != b).count();
    assert!(different < 1000 && traced == cpu, "{different}");
    assert_eq!(
        shots("--backend gpu --hybrid -o h-{n}.png", &[SHOT, OPEN, &click(386, 128), SHOT].concat()),
        [true, false]
    );
    assert!(pixels(&folder, "h-1.png") == traced);
    // The printed command draws the same.
    let mut again = command(&folder, "render demo:matchbox -o again.png --size 640x480 --samples 1");
    let output = again.args(["--hybrid", "--backend", "gpu"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(pixels(&folder, "again.png") == drawn);
}

#[test]
fn keys_timing_messages_and_the_panel_are_seen() {
    let (left, middle, right, low) =
        ([0.0, 0.0, 0.3, 0.4], [0.4, 0.3, 0.6, 0.7], [0.7, 0.0, 1.0, 0.4], [0.4, 0.9, 0.6, 1.0]);
    for (name, keys, place, elsewhere) in [
        ("timing", "press Z", left, low),
        ("help", "press H", middle, [0.0, 0.9, 0.15, 1.0]),
        ("panel_seen", "press P", right, left),
        ("message", "press Space", low, middle),
    ] {
        let folder = folder(name);
        let Some(display) = Display::start(&folder) else { return };
        let recording = format!(
            "rtrt input 1\nsize 800 600 1\nframe 0.1\n{keys}\nframe 0.1\nframes 5 0.1\nframes 1000000 0\n"
        );
        fs::write(folder.join("input.txt"), recording).unwrap();
        let line = "demo:matchbox --size 800x600 --samples 1 --shadows off --backend cpu";
        command(&folder, &format!("render {line} -o plain.png")).status().unwrap();
        let plain = pixels(&folder, "plain.png");
        let mut window = Window::open(&display, &folder, &format!("view {line} --replay input.txt"));
        window.until(name, || {
            let seen = display.pixels(SCREEN);
            changed(&plain, &seen, place) > 500 && changed(&plain, &seen, elsewhere) == 0
        });
    }
}

#[test]
fn keys_switch_what_lies_over_the_picture_and_never_what_is_written() {
    let folder = folder("overlay");
    let Some(display) = Display::start(&folder) else { return };
    let recording = "press F12\nframe 0.1\nrelease F12\n\
        press H\nframe 0.1\npress Z\nframe 0.1\npress P\nframes 3 0.1\n\
        press F12\nframe 0.1\nrelease F12\nmove 200 20\nframe 0.1\nbutton left down\nframe 0.1\n\
        move 160 50\nframe 0.1\nbutton left up\nwheel -3\nframe 0.1\npress F12\nframe 0.1\n";
    let line = "demo:matchbox --size 320x180 --samples 1 --backend cpu --json";
    let output = view(&display, &folder, line, recording);
    let printed = lines(&output);
    let report: serde_json::Value = serde_json::from_str(&printed[0]).unwrap();
    assert_eq!((report["backend"].as_str(), report["output"].as_str()), (Some("cpu"), Some("rtrt-0000.png")));
    let shots = [0, 1, 2].map(|number| pixels(&folder, &format!("rtrt-000{number}.png")));
    assert!(shots[0] == shots[1], "{printed:?}");
    assert!(shots[1] == shots[2], "a drag on the panel moved the camera: {printed:?}");
}
