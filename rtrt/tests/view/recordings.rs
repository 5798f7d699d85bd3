//! What is recorded, and happens again.

use crate::display::{Display, Window, folder, lines, pixels, present, rendered, stderr, view};
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
