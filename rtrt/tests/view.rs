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
    /// Starts a server. None if there is none to start, which is a failure where RTRT_REQUIRE_GPU says that
    /// this machine has all that tests need.
    fn start(folder: &Path) -> Option<Self> {
        let [width, height] = SCREEN;
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0", &format!("{width}x{height}x24")])
            .arg("-fbdir")
            .arg(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut server = match server {
            Ok(server) => server,
            Err(error) => {
                assert!(std::env::var_os("RTRT_REQUIRE_GPU").is_none(), "Xvfb is required: {error}");
                println!("skipped: no window was opened: Xvfb: {error}");
                return None;
            }
        };
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
    let folder = folder("window");
    let Some(display) = Display::start(&folder) else { return };
    // Messages are gone after some seconds; then the window stays open until the test is done.
    let recording =
        "rtrt input 1\nsize 403 217 1\nframe 0.1\npress F12\nframe 0.1\nframes 10 5\nframes 1000000 0.02\n";
    fs::write(folder.join("input.txt"), recording).unwrap();
    let line = "view demo:glass --size 403x217 --samples 1 --backend cpu --replay input.txt -o shot.png";
    let mut viewer = command(&folder, line);
    let viewer = viewer.env("DISPLAY", &display.name).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut viewer = viewer.spawn().unwrap();
    let end = Instant::now() + Duration::from_secs(60);
    let shows = || {
        let shot = folder.join("shot.png");
        shot.exists() && display.pixels([403, 217]) == pixels(&folder, "shot.png")
    };
    let mut is_shown = false;
    while !is_shown && Instant::now() < end && viewer.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(50));
        is_shown = shows();
    }
    let last = display.pixels(SCREEN);
    viewer.kill().unwrap();
    let output = viewer.wait_with_output().unwrap();
    last.save(folder.join("screen.png")).unwrap();
    assert!(is_shown, "see screen.png in {}: {}", folder.display(), stderr(&output));
}

#[test]
fn keys_switch_what_lies_over_the_picture_and_never_what_is_written() {
    let folder = folder("overlay");
    let Some(display) = Display::start(&folder) else { return };
    let recording = "press F12\nframe 0.1\nrelease F12\n\
        press H\nframe 0.1\npress Z\nframe 0.1\npress P\nframes 3 0.1\n\
        press F12\nframe 0.1\nrelease F12\nmove 40 60\nframe 0.1\nbutton left down\nframe 0.1\n\
        move 90 90\nframe 0.1\nbutton left up\nwheel -3\nframe 0.1\npress F12\nframe 0.1\n";
    let output = view(&display, &folder, "demo:matchbox --size 320x180 --samples 1 --backend cpu", recording);
    let printed = lines(&output);
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
