//! What is recorded, and happens again.

use crate::display::{Display, SCREEN, Window, folder, lines, pixels, present, rendered, stderr, view};
use std::fs;
use std::process::Command;

#[test]
fn a_person_at_the_keyboard_is_recorded() {
    let folder = folder("person");
    let Some(display) = Display::start(&folder) else { return };
    let mut xdotool = Command::new("timeout");
    xdotool.args(["180", "xdotool"]).env("DISPLAY", &display.name);
    let Some(version) =
        present("xdotool", Command::new("xdotool").arg("version").env("DISPLAY", &display.name).output())
    else {
        return;
    };
    assert!(version.status.success());
    let line = "demo:matchbox --size 160x90 --backend cpu --samples 1";
    let mut window = Window::open(&display, &folder, &format!("view {line} -o a.png --record recorded.txt"));
    let keys = "search --sync --onlyvisible --name rtrt windowfocus --sync keydown d sleep 0.3 keyup d \
        mousemove 50 50 mousedown 1 mousemove 70 60 mouseup 1 click 4 key ctrl+2 key F12";
    let done = xdotool.args(keys.split_whitespace()).output().unwrap();
    assert!(done.status.success(), "{}", stderr(&done));
    window.until("a screenshot is written", || folder.join("a.png").exists());
    let mut xdotool = Command::new("xdotool");
    assert!(xdotool.args(["key", "Escape"]).env("DISPLAY", &display.name).status().unwrap().success());
    let code = window.viewer.wait().unwrap().code();
    assert_eq!(code, Some(0));
    let printed = fs::read_to_string(folder.join("stdout")).unwrap();
    assert!(pixels(&folder, "a.png") == rendered(&folder, printed.trim_end()), "{printed}");
    assert!(printed.trim_end().ends_with(" --debug normal"), "{printed}");
    let recorded = fs::read_to_string(folder.join("recorded.txt")).unwrap();
    let again = view(
        &display,
        &folder,
        &format!("{line} -o b.png"),
        recorded.strip_prefix("rtrt input 1\n").unwrap(),
    );
    assert_eq!(lines(&again), [printed.trim_end().replace("a.png", "b.png")]);
    let still = format!("rtrt render {line} -o x.png --debug normal").replace(" --backend cpu", "");
    let still = rendered(&folder, &still);
    assert!(pixels(&folder, "a.png") != still, "nothing has moved");
}

#[test]
fn what_is_recorded_can_be_replayed() {
    let folder = folder("record");
    let Some(display) = Display::start(&folder) else { return };
    let recording = "press D\nframes 3 0.1\nrelease D\nmove 1.25 7\nframe 0.123\npress F12\nframe 0\n";
    let line = "demo:matchbox --size 64x36 --backend cpu -o";
    let first = view(&display, &folder, &format!("{line} a.png --record recorded.txt"), recording);
    let recorded = fs::read_to_string(folder.join("recorded.txt")).unwrap();
    let recorded = recorded.strip_prefix("rtrt input 1\n").unwrap();
    let again = view(&display, &folder, &format!("{line} b.png"), recorded);
    assert_eq!(lines(&first)[0].replace("a.png", "b.png"), lines(&again)[0]);
    assert!(pixels(&folder, "a.png") == pixels(&folder, "b.png"));
}

#[test]
fn text_is_copied_from_one_window_and_pasted_into_another() {
    let folder = folder("clipboard");
    let Some(display) = Display::start(&folder) else { return };
    let xdotool = |words: &str| {
        let mut xdotool = Command::new("timeout");
        xdotool.args(["120", "xdotool"]).args(words.split(' ')).env("DISPLAY", &display.name).status()
    };
    if present("xdotool", xdotool("version")).is_none_or(|done| !done.success()) {
        return;
    }
    for name in ["one.obj", "two.obj"] {
        fs::write(folder.join(name), "v -2 -2 0\nv 2 -2 0\nv 0 2 0\nf 1 2 3\n").unwrap();
    }
    let line = "--size 480x300 --samples 1 --backend cpu --record";
    let mut first = Window::open(&display, &folder, &format!("view one.obj {line} one.txt"));
    let mut second = Window::open(&display, &folder, &format!("view two.obj {line} two.txt"));
    let done = |words: &str| xdotool(words).unwrap().success();
    // The list of objects, and the field in it, which is darker than the pictures.
    let fields = |is_so: fn(u8) -> bool| {
        let pixels = display.pixels(SCREEN);
        [58, 358].iter().all(|&y| is_so(pixels.get_pixel(140, y)[0]))
    };
    assert!(done("search --sync --onlyvisible --name two.obj windowmove --sync 0 300"));
    first.until("both show a picture", || fields(|red| red > 60));
    assert!(done("search --name two.obj windowfocus --sync key l"));
    assert!(done("search --name one.obj windowfocus --sync key l"));
    let recorded = |name: &str| fs::read_to_string(folder.join(name)).unwrap_or_default();
    first.until("both show the list", || fields(|red| red < 30));
    assert!(done("mousemove 140 58 click 1 sleep 0.3 type file"));
    first.until("it is typed", || recorded("one.txt").contains("text e"));
    assert!(done("key ctrl+a key ctrl+c sleep 0.3 key Right key s sleep 0.3 key ctrl+a key ctrl+x"));
    first.until("it is cut", || recorded("one.txt").contains("press X"));
    assert!(done("search --name two.obj windowfocus --sync mousemove 140 358 click 1"));
    second.until("it is pasted", || {
        done("sleep 0.3 key ctrl+a key ctrl+v") && recorded("two.txt").contains("\npaste files\n")
    });
    // A key without a field is a key.
    assert!(done("key Escape sleep 0.5"));
    let pasted = || recorded("two.txt").matches("paste").count();
    let before = pasted();
    assert!(done("key ctrl+v sleep 0.3 key Escape"));
    assert_eq!(second.viewer.wait().unwrap().code(), Some(0));
    assert_eq!(pasted(), before);
}

#[test]
fn what_is_pasted_is_a_path() {
    let folder = folder("pasted");
    let Some(display) = Display::start(&folder) else { return };
    let hdr = fs::File::create(folder.join("a sky.hdr")).unwrap();
    let light: Vec<_> = (0..128).map(|i| image::Rgb([i as f32 * 0.01, 0.5, 0.1])).collect();
    image::codecs::hdr::HdrEncoder::new(hdr).encode(&light, 16, 8).unwrap();
    let recording = "press P\nframe 0.1\nrelease P\nframes 4 0.1\n\
        point path, then Enter\nframe 0.1\nbutton left down\nframe 0.1\nbutton left up\nframe 0.1\n\
        paste a sky.hdr\nframe 0.1\npress Enter\nframe 0.1\nrelease Enter\nframe 0.1\n\
        press F12\nframe 0.1\n";
    let line = "demo:matchbox --size 500x760 --samples 1 --backend cpu";
    let printed = lines(&view(&display, &folder, line, recording));
    assert!(printed[0].contains("--environment 'a sky.hdr'"), "{printed:?}");
}
