//! `rtrt view` in a real window: under Xvfb, a display without a screen. Input comes from recordings.

use image::RgbaImage;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const SCREEN: [u32; 2] = [800, 600];

/// A display of the test's own.
struct Display {
    server: Child,
    name: String,
    /// Its pixels, as an X window dump that the server keeps up to date.
    frame_buffer: PathBuf,
}

impl Display {
    /// Starts a server. None if there is none to start.
    fn start(folder: &Path) -> Option<Self> {
        let [width, height] = SCREEN;
        let server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-nolisten",
                "tcp",
                "-noreset",
                "-screen",
                "0",
                &format!("{width}x{height}x24"),
            ])
            .arg("-fbdir")
            .arg(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut server = present("Xvfb", server)?;
        let mut number = String::new();
        let output = server.stdout.take().expect("it is piped");
        BufReader::new(output).read_line(&mut number).unwrap();
        let name = format!(":{}", number.trim());
        Some(Self { server, name, frame_buffer: folder.join("Xvfb_screen0") })
    }

    /// What is to be seen in the upper left corner.
    fn pixels(&self, [width, height]: [u32; 2]) -> RgbaImage {
        let dump = fs::read(&self.frame_buffer).unwrap();
        let word = |place: usize| u32::from_be_bytes(dump[4 * place..][..4].try_into().unwrap());
        // The header's own size, and the number of colors, which follow it with 12 bytes each.
        let first = (word(0) + 12 * word(19)) as usize;
        let (bits, row) = (word(11), word(12));
        assert_eq!(bits, 32, "bits a pixel");
        RgbaImage::from_fn(width, height, |x, y| {
            let [b, g, r, _] = dump[first + (y * row + 4 * x) as usize..][..4] else { unreachable!() };
            [r, g, b, 255].into()
        })
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.server.kill().ok();
        self.server.wait().ok();
    }
}

/// What a program that tests need has done. None, and said loudly, where it is missing; a failure where
/// RTRT_REQUIRE_GPU says that this machine has all that tests need.
fn present<T>(program: &str, done: std::io::Result<T>) -> Option<T> {
    match done {
        Ok(done) => Some(done),
        Err(error) => {
            assert!(std::env::var_os("RTRT_REQUIRE_GPU").is_none(), "{program} is required: {error}");
            println!("skipped: {program}: {error}");
            None
        }
    }
}

/// A folder of the test's own.
fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view").join(test);
    fs::remove_dir_all(&path).ok();
    fs::create_dir_all(&path).unwrap();
    path
}

/// The command in a folder. `line` is split at white space.
fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rtrt"));
    command.current_dir(folder).args(line.split_whitespace()).env_remove("WAYLAND_DISPLAY");
    command.env_remove("DISPLAY").env_remove("RTRT_REQUIRE_GPU").stdin(Stdio::null());
    command
}

/// Runs `rtrt view` with what follows it, and this recording.
fn view(display: &Display, folder: &Path, line: &str, recording: &str) -> Output {
    fs::write(folder.join("input.txt"), format!("rtrt input 1\n{recording}")).unwrap();
    let line = format!("view {line} --replay input.txt");
    command(folder, &line).env("DISPLAY", &display.name).output().unwrap()
}

/// A viewer that runs until the test is done with it.
struct Window<'a> {
    viewer: Child,
    display: &'a Display,
    folder: &'a Path,
}

impl<'a> Window<'a> {
    fn open(display: &'a Display, folder: &'a Path, line: &str) -> Self {
        let mut viewer = command(folder, line);
        let output = |name| fs::File::create(folder.join(name)).unwrap();
        let viewer = viewer.env("DISPLAY", &display.name).stdout(output("stdout")).stderr(output("stderr"));
        Self { viewer: viewer.spawn().unwrap(), display, folder }
    }

    /// Waits until something is true, which must not take long.
    fn until(&mut self, what: &str, is_so: impl Fn() -> bool) {
        let end = Instant::now() + Duration::from_secs(180);
        while !is_so() {
            sleep(Duration::from_millis(50));
            let ended = self.viewer.try_wait().unwrap();
            if ended.is_some() || Instant::now() > end {
                self.display.pixels(SCREEN).save(self.folder.join("screen.png")).unwrap();
                let said = fs::read_to_string(self.folder.join("stderr")).unwrap();
                panic!("not so: {what}; {ended:?}; see screen.png in {}: {said}", self.folder.display());
            }
        }
    }
}

impl Drop for Window<'_> {
    fn drop(&mut self) {
        self.viewer.kill().ok();
        self.viewer.wait().ok();
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The lines that a run printed, which must have ended well.
fn lines(output: &Output) -> Vec<String> {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect()
}

fn pixels(folder: &Path, name: &str) -> RgbaImage {
    image::open(folder.join(name)).unwrap().into_rgba8()
}

/// Runs a command line that the viewer printed, on the CPU, and gives its picture.
fn rendered(folder: &Path, printed: &str) -> RgbaImage {
    let line = printed.strip_prefix("rtrt ").unwrap();
    let mut words: Vec<&str> = line.split(' ').collect();
    let output = words.iter().position(|word| *word == "-o").unwrap() + 1;
    words[output] = "headless.png";
    let done = command(folder, &words.join(" ")).args(["--backend", "cpu"]).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{printed}: {}", stderr(&done));
    pixels(folder, "headless.png")
}

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
    for (backend, is_here) in [("cpu", false), ("gpu", true)] {
        let folder = folder(&format!("window_{backend}"));
        let Some(display) = Display::start(&folder) else { return };
        fs::write(folder.join("input.txt"), recording).unwrap();
        let line = "view demo:glass --size 403x217 --samples 1 --verbose --replay input.txt -o shot.png";
        let mut window = Window::open(&display, &folder, &format!("{line} --backend {backend}"));
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
    // At rest, after a second, in the beginning, of another scene. The sun of a scene without lights
    // follows the camera.
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
    assert!(window.viewer.try_wait().unwrap().is_none(), "the viewer has ended");
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

#[test]
fn a_replay_ends_with_an_error_where_something_does_not_work() {
    let folder = folder("errors");
    let Some(display) = Display::start(&folder) else { return };
    let end = |recording: &str, options: &str| {
        let output = view(&display, &folder, &format!("demo:matchbox --size 32x18 {options}"), recording);
        let said = stderr(&output);
        let error = said.lines().rfind(|line| line.starts_with("error: ")).unwrap_or_default().to_owned();
        (output.status.code(), error)
    };
    let (code, error) = end("drop nothing.glb\nframe 0.1\n", "");
    assert!(code == Some(3) && error.contains("nothing.glb"), "{code:?} {error}");
    let (code, error) = end("press F12\nframe 0.1\n", "-o nowhere/x.png");
    assert!(code == Some(1) && error.contains("nowhere"), "{code:?} {error}");
    let (code, error) = end("modifiers ctrl\npress 1\nsize 16384 8192 1\nframe 0.1\n", "");
    assert!(code == Some(2) && error.contains("frame too large"), "{code:?} {error}");
    let (code, error) = end("press Wumm\nframe 0.1\n", "");
    assert!(code == Some(3) && error.contains("input.txt: line 2: no such key"), "{code:?} {error}");
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
#[cfg(target_os = "linux")]
fn a_missing_library_is_an_error_and_no_panic() {
    let folder = folder("library");
    let Some(display) = Display::start(&folder) else { return };
    fs::write(folder.join("input.txt"), "rtrt input 1\nframe 0.1\n").unwrap();
    for names in [["libXi.so.6", "libXi.so"], ["libxkbcommon-x11.so.0", "libxkbcommon-x11.so"]] {
        // An empty file in place of the library.
        names.iter().for_each(|name| fs::write(folder.join(name), "").unwrap());
        let mut command = command(&folder, "view demo:matchbox --size 32x18 --replay input.txt");
        let output = command.env("DISPLAY", &display.name).env("LD_LIBRARY_PATH", &folder).output().unwrap();
        let said = stderr(&output);
        assert!(output.status.code() == Some(4) && said.lines().count() == 2, "{names:?}: {said}");
        assert!(said.starts_with("error: cannot open a window: demo:matchbox: "), "{names:?}: {said}");
        names.iter().for_each(|name| fs::remove_file(folder.join(name)).unwrap());
    }
}

#[test]
fn without_a_display_there_is_an_error_and_no_window() {
    let folder = folder("no_display");
    for display in [None, Some(":54321")] {
        let mut command = command(&folder, "view demo:matchbox");
        command.envs(display.map(|name| ("DISPLAY", name)));
        let output = command.output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(4), "{said}");
        let lines: Vec<_> = said.lines().collect();
        assert!(
            lines.len() == 2 && lines[0].starts_with("error: cannot open a window: demo:matchbox: "),
            "{said}"
        );
        assert!(lines[1].starts_with("hint: ") && !said.contains(".rs:"), "{said}");
    }
}
