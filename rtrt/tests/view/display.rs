//! A display without a screen, the viewer on it, and what both give back.

use image::RgbaImage;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

pub const SCREEN: [u32; 2] = [800, 600];

/// A display of the test's own.
pub struct Display {
    pub server: Child,
    pub name: String,
    /// Its pixels, as an X window dump that the server keeps up to date.
    pub frame_buffer: PathBuf,
}

impl Display {
    /// Starts a server. None if there is none to start.
    pub fn start(folder: &Path) -> Option<Self> {
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
    pub fn pixels(&self, [width, height]: [u32; 2]) -> RgbaImage {
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
pub fn present<T>(program: &str, done: std::io::Result<T>) -> Option<T> {
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
pub fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view").join(test);
    fs::remove_dir_all(&path).ok();
    fs::create_dir_all(&path).unwrap();
    path
}

/// The command in a folder. `line` is split at white space.
pub fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rtrt"));
    command.current_dir(folder).args(line.split_whitespace()).env_remove("WAYLAND_DISPLAY");
    command.env_remove("DISPLAY").env_remove("RTRT_REQUIRE_GPU").stdin(Stdio::null());
    command
}

/// Runs `rtrt view` with what follows it, and this recording.
pub fn view(display: &Display, folder: &Path, line: &str, recording: &str) -> Output {
    fs::write(folder.join("input.txt"), format!("rtrt input 1\n{recording}")).unwrap();
    let line = format!("view {line} --replay input.txt");
    command(folder, &line).env("DISPLAY", &display.name).output().unwrap()
}

/// A viewer that runs until the test is done with it.
pub struct Window<'a> {
    pub viewer: Child,
    pub display: &'a Display,
    pub folder: &'a Path,
}

impl<'a> Window<'a> {
    pub fn open(display: &'a Display, folder: &'a Path, line: &str) -> Self {
        Self::run(command(folder, line), display, folder)
    }

    /// Runs a viewer.
    pub fn run(mut viewer: Command, display: &'a Display, folder: &'a Path) -> Self {
        let output = |name| fs::File::create(folder.join(name)).unwrap();
        let viewer = viewer.env("DISPLAY", &display.name).stdout(output("stdout")).stderr(output("stderr"));
        Self { viewer: viewer.spawn().unwrap(), display, folder }
    }

    /// Waits until something is true, which must not take long.
    pub fn until(&mut self, what: &str, is_so: impl Fn() -> bool) {
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

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The lines that a run printed, which must have ended well.
pub fn lines(output: &Output) -> Vec<String> {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect()
}

pub fn pixels(folder: &Path, name: &str) -> RgbaImage {
    image::open(folder.join(name)).unwrap().into_rgba8()
}

/// Runs a command line that the viewer printed, on the CPU, and gives its picture.
pub fn rendered(folder: &Path, printed: &str) -> RgbaImage {
    let line = printed.strip_prefix("rtrt ").unwrap();
    let mut words: Vec<&str> = line.split(' ').collect();
    let output = words.iter().position(|word| *word == "-o").unwrap() + 1;
    words[output] = "headless.png";
    let done = command(folder, &words.join(" ")).args(["--backend", "cpu"]).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{printed}: {}", stderr(&done));
    pixels(folder, "headless.png")
}

/// How many of the pixels of a part of the window differ; places are shares of its width and height.
pub fn changed(a: &RgbaImage, b: &RgbaImage, [left, top, right, bottom]: [f32; 4]) -> usize {
    let (width, height) = a.dimensions();
    let [left, right] = [left, right].map(|x| (x * width as f32) as u32);
    let [top, bottom] = [top, bottom].map(|y| (y * height as f32) as u32);
    let places = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
    places.filter(|&(x, y)| a.get_pixel(x, y) != b.get_pixel(x, y)).count()
}
