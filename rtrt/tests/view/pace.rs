//! How soon a picture follows what a person does.

use crate::display::{
    Display, SCREEN, Window, changed, command, folder, lines, pixels, present, stderr, view,
};
use image::RgbaImage;
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A person's key, by xdotool; none if that is missing.
fn keys<'a>(display: &'a Display) -> Option<impl Fn(&str, &str) -> bool + 'a> {
    present("xdotool", Command::new("xdotool").arg("version").output())?;
    Some(|action: &str, key: &str| {
        let search = "search --sync --onlyvisible --name rtrt windowfocus --sync";
        let mut xdotool = Command::new("timeout");
        xdotool.args(["120", "xdotool"]).args(search.split(' ')).args([action, key]);
        xdotool.env("DISPLAY", &display.name).status().is_ok_and(|status| status.success())
    })
}

/// The mean difference of pixels beside each other: less in a picture of fewer pixels that was scaled up.
fn sharpness(picture: &RgbaImage) -> f64 {
    let (width, height) = picture.dimensions();
    let level = |x, y| picture.get_pixel(x, y).0[..3].iter().map(|c| f64::from(*c)).sum::<f64>();
    let pairs = (0..height).flat_map(|y| (1..width).map(move |x| (x, y)));
    pairs.map(|(x, y)| (level(x, y) - level(x - 1, y)).abs()).sum::<f64>() / f64::from(width * height)
}

#[test]
fn fewer_rays_are_traced_while_something_moves() {
    let folder = folder("coarse");
    let Some(display) = Display::start(&folder) else { return };
    let Some(key) = keys(&display) else { return };
    let line = "view demo:matchbox --size 800x600 --samples 4 --backend cpu --fps 1000 -o still.png";
    let mut window = Window::open(&display, &folder, line);
    let seen = || sharpness(&display.pixels(SCREEN));
    window.until("there is a picture", || seen() > 0.5);
    sleep(Duration::from_secs(3));
    let fine = seen();
    assert!(key("keydown", "d"));
    window.until("the picture is coarse", || seen() < 0.8 * fine);
    key("keyup", "d");
    sleep(Duration::from_secs(8));
    assert!(key("key", "F12"));
    window.until("a screenshot is written", || folder.join("still.png").exists());
    let still = pixels(&folder, "still.png");
    let shown = || changed(&still, &display.pixels(SCREEN), [0.0, 0.0, 1.0, 0.9]) == 0;
    window.until("it is what is seen", shown);
}

#[test]
fn a_replay_at_its_own_speed_measures_the_loop() {
    let folder = folder("live");
    let Some(display) = Display::start(&folder) else { return };
    // An orbit of a second by 60 moves, and two seconds of rest.
    let moves: String =
        (1..60).map(|step| format!("move {} 200\nframe 0.016666667\n", 200 + 2 * step)).collect();
    let recording = format!(
        "frame 1\nmove 200 200\nbutton left down\nframe 0.1\n{moves}button left up\nframe 0\nframe 2\n"
    );
    let line = "demo:matchbox --size 320x180 --backend cpu --live --json";
    let mut reports = Vec::new();
    for _ in 0..4 {
        let printed = lines(&view(&display, &folder, line, &recording));
        let report: serde_json::Value = serde_json::from_str(printed.last().unwrap()).unwrap();
        let number = |path: &str| {
            report.pointer(&format!("/loop/{path}")).and_then(serde_json::Value::as_f64).unwrap()
        };
        // What docs/viewer.md promises, with some air: a picture may be waited for that a busy machine draws.
        let is_soon = number("pictures") > 20.0
            && number("frames_per_second") > 20.0
            && number("event_to_begin_ms/median") < 50.0
            && number("event_to_picture_ms/median") < 100.0
            && number("sharp_after_ms/median") < 500.0;
        reports.push(report);
        if is_soon {
            return;
        }
    }
    // Other tests run at the same time.
    panic!("never soon: {reports:#?}");
}

#[test]
fn the_cpu_draws_while_a_gpu_compiles_and_escape_closes() {
    let folder = folder("compiling");
    let Some(display) = Display::start(&folder) else { return };
    let Some(key) = keys(&display) else { return };
    let mut viewer = command(&folder, "view demo:matchbox --size 800x600 --samples 1 --backend gpu");
    // Shaders that are compiled already would be ready.
    viewer.env("MESA_SHADER_CACHE_DISABLE", "true");
    let mut window = Window::run(viewer, &display, &folder);
    window.until("the picture is seen", || sharpness(&display.pixels(SCREEN)) > 0.5);
    let start = Instant::now();
    // The window is gone before the key could be released.
    assert!(key("keydown", "Escape"));
    let code = window.viewer.wait().unwrap().code();
    // It takes a twentieth of a second, and a shader some seconds.
    assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
    let is_black = || display.pixels(SCREEN).pixels().all(|pixel| pixel.0[..3] == [0; 3]);
    assert!(is_black(), "the window is still there");
    let said = std::fs::read_to_string(folder.join("stderr")).unwrap();
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn a_replay_that_is_not_live_reports_as_well() {
    let folder = folder("reports");
    let Some(display) = Display::start(&folder) else { return };
    let output =
        view(&display, &folder, "demo:matchbox --size 64x36 --backend cpu --json", "press W\nframes 3 0.1\n");
    let printed = lines(&output);
    let report: serde_json::Value = serde_json::from_str(&printed[0]).unwrap();
    assert_eq!((printed.len(), report["loop"]["pictures"].as_u64()), (1, Some(3)), "{}", stderr(&output));
}
