//! Golden pictures: tests that compare what is rendered with stored PNG files, to the bit.
//!
//! ```no_run
//! # let loaded = rtrt::demo::glass(&rtrt_core::scene::Sequential).unwrap();
//! // Compares with tests/golden/glass.png of this package.
//! rtrt::golden::assert_picture!(&loaded.scene, &loaded.camera, "glass", size([64, 36]), samples(4));
//! ```
//!
//! | `RTRT_BLESS` | what a test does |
//! |---|---|
//! | not set | it fails where the stored picture differs or is missing |
//! | `new` | it stores pictures that are missing |
//! | `1` | it stores every picture that differs or is missing |
//!
//! A test that fails leaves `NAME.expected.png`, `NAME.actual.png` and `NAME.difference.png` in `tests/golden/failed`,
//! and prints a command that opens the last of them. They go when the test passes.
//!
//! The CPU renders, with all lanes and threads that there are: bits do not depend on them, nor on the machine. Another
//! backend can be compared by [`check`] with its own picture. A guide, and why a software Vulkan device is no reference:
//! docs/golden.md in the repository.

use crate::difference::{Difference, difference, picture as shown};
use crate::replace::replace;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use rtrt_core::backend::{Backend, Picture, RenderError};
use rtrt_cpu::Cpu;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

pub use crate::assert_picture;
pub use rtrt_core::backend::Request;
pub use rtrt_core::scene::{Camera, Scene};

/// The pixels of a picture that has no size of its own: columns and rows.
pub const SIZE: [u32; 2] = [256, 144];
/// The environment variable that stores pictures.
pub const BLESS: &str = "RTRT_BLESS";

/// Asserts that a scene looks from a camera as the stored picture of this name does, to the bit.
///
/// After the name may follow setters of [`Request`]: `size([64, 64])`, `samples(4)`, `exposure(1.0)`. A
/// picture has [`SIZE`](crate::golden::SIZE) pixels unless one of them says otherwise. It is stored in `tests/golden` of the package that is tested,
/// as `NAME.png`; a name may have folders in it.
///
/// # Panics
/// The picture differs, is missing, or cannot be rendered; see [`golden`](crate::golden).
#[macro_export]
macro_rules! assert_picture {
    ($scene:expr, $camera:expr, $name:expr $(, $setter:ident($($value:expr),*))* $(,)?) => {{
        let camera: &$crate::golden::Camera = $camera;
        let request = $crate::golden::Request::new(camera, $crate::golden::SIZE)$(.$setter($($value),*))*;
        $crate::golden::assert(env!("CARGO_MANIFEST_DIR").as_ref(), $scene, &request, $name);
    }};
}

/// Why a test fails.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Mismatch {
    /// The name is no name of a file.
    #[error("{name:?} is no name for a picture: it is empty, or leads out of the folder")]
    Name {
        /// The name.
        name: String,
    },
    /// The scene cannot be rendered.
    #[error("picture {name:?} cannot be rendered: {source}")]
    Render {
        /// The name.
        name: String,
        /// The reason.
        source: RenderError,
    },
    /// The CPU backend cannot be opened.
    #[error(transparent)]
    Cpu(#[from] rtrt_cpu::Error),
    /// There is no stored picture.
    #[error(
        "picture {name:?} is not stored yet\n  actual: {}\n  look:   {}\n  accept: {BLESS}=new cargo test", actual.display(), open(actual)
    )]
    Missing {
        /// The name.
        name: String,
        /// What was rendered.
        actual: PathBuf,
    },
    /// The picture has another size than the stored one.
    #[error(
        "picture {name:?} has {} x {} pixels, and is stored with {} x {}\n  actual: {}\n  look:   {}\n  accept: {BLESS}=1 cargo test", is[0], is[1], expected[0], expected[1], actual.display(), open(actual)
    )]
    Size {
        /// The name.
        name: String,
        /// Columns and rows.
        is: [u32; 2],
        /// Those of the stored picture.
        expected: [u32; 2],
        /// What was rendered.
        actual: PathBuf,
    },
    /// The picture differs from the stored one.
    #[error(
        "picture {name:?} differs: {} of {all} pixels, by at most {} of 255 steps, the first at {},{}: is {:?}, not {:?}\n  expected:   {}\n  actual:     {}\n  difference: {}\n  look:       {}\n  accept:     {BLESS}=1 cargo test",
        difference.pixels, difference.most, difference.first[0], difference.first[1], difference.is, difference.expected,
        files[0].display(), files[1].display(), files[2].display(), open(&files[2])
    )]
    Differs {
        /// The name.
        name: String,
        /// Pixels of the picture.
        all: usize,
        /// How they differ.
        difference: Box<Difference>,
        /// What is stored, what was rendered, and the difference, as pictures.
        files: Box<[PathBuf; 3]>,
    },
    /// A file cannot be read or written.
    #[error("picture {name:?}: {}: {why}", path.display())]
    File {
        /// The name.
        name: String,
        /// The file.
        path: PathBuf,
        /// The reason.
        why: String,
    },
}

/// The command that opens a picture.
fn open(path: &Path) -> String {
    let path = path.display().to_string();
    if cfg!(windows) {
        // What is quoted first is the title of a window.
        return format!("start \"\" \"{path}\"");
    }
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    format!("{program} '{}'", path.replace('\'', r"'\''"))
}

/// Renders on the CPU, and compares with the stored picture of this name in `tests/golden` of `package`; see
/// [`assert_picture`].
///
/// # Panics
/// As [`assert_picture`] does.
#[track_caller]
pub fn assert(package: &Path, scene: &Scene, request: &Request<'_>, name: &str) {
    if let Err(mismatch) = rendered(package, scene, request, name) {
        panic!("{mismatch}");
    }
}

fn rendered(package: &Path, scene: &Scene, request: &Request<'_>, name: &str) -> Result<(), Mismatch> {
    let mut picture = Picture::default();
    let mut cpu = Cpu::new(rtrt_cpu::Options::default())?;
    let rendered = cpu.render(scene, request, &mut picture);
    rendered.map_err(|source| Mismatch::Render { name: name.into(), source })?;
    check(&package.join("tests/golden"), &picture, name, std::env::var(BLESS).unwrap_or_default().as_str())
}

/// Compares a picture with `NAME.png` in a folder. `bless` is what `RTRT_BLESS` may be: `1` stores it, `new` stores it
/// if there is none, anything else stores nothing.
///
/// # Errors
/// The picture differs, or a file cannot be read or written.
pub fn check(folder: &Path, picture: &Picture, name: &str, bless: &str) -> Result<(), Mismatch> {
    let parts = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
    if name.is_empty() || name.ends_with(['/', '\\']) || !parts {
        return Err(Mismatch::Name { name: name.into() });
    }
    let files = Files { folder, name };
    let size = [picture.width, picture.height];
    let bytes = picture.bytes();
    let is = bytes.as_chunks::<4>().0;
    let stored = files.read()?;
    let (has, expected) = stored.as_ref().map_or(([0; 2], &[][..]), |stored| (stored.size, &stored.pixels));
    if has == size && is == expected {
        files.clear();
        return Ok(());
    }
    if bless == "1" || (bless == "new" && stored.is_none()) {
        files.write(&files.golden(), is, size)?;
        files.clear();
        return Ok(());
    }
    let [before, actual, differs] = ["expected", "actual", "difference"].map(|what| files.failed(what));
    files.write(&actual, is, size)?;
    if stored.is_none() {
        return Err(Mismatch::Missing { name: name.into(), actual });
    }
    files.write(&before, expected, has)?;
    if has != size {
        return Err(Mismatch::Size { name: name.into(), is: size, expected: has, actual });
    }
    files.write(&differs, &shown(is, expected), size)?;
    let Some(difference) = difference(is, expected, size[0], 0) else { return Ok(()) };
    let (difference, files) = (Box::new(difference), Box::new([before, actual, differs]));
    Err(Mismatch::Differs { name: name.into(), all: is.len(), difference, files })
}

/// A picture in a file.
struct Stored {
    size: [u32; 2],
    pixels: Vec<[u8; 4]>,
}

/// The files of a picture.
struct Files<'a> {
    folder: &'a Path,
    name: &'a str,
}

impl Files<'_> {
    fn golden(&self) -> PathBuf {
        self.folder.join(format!("{}.png", self.name))
    }

    fn failed(&self, what: &str) -> PathBuf {
        self.folder.join("failed").join(format!("{}.{what}.png", self.name))
    }

    fn refused(&self, path: &Path, why: &impl ToString) -> Mismatch {
        Mismatch::File { name: self.name.into(), path: path.to_owned(), why: why.to_string() }
    }

    /// The stored picture, if there is one.
    fn read(&self) -> Result<Option<Stored>, Mismatch> {
        let path = self.golden();
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(self.refused(&path, &error)),
        };
        let picture = image::load_from_memory(&bytes).map_err(|error| self.refused(&path, &error))?;
        let picture = picture.into_rgba8();
        let pixels = picture.as_raw().as_chunks::<4>().0.to_vec();
        Ok(Some(Stored { size: picture.dimensions().into(), pixels }))
    }

    fn write(&self, path: &Path, pixels: &[[u8; 4]], [width, height]: [u32; 2]) -> Result<(), Mismatch> {
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new(&mut bytes);
        encoder
            .write_image(pixels.as_flattened(), width, height, ExtendedColorType::Rgba8)
            .map_err(|error| self.refused(path, &error))?;
        let folder = path.parent().unwrap_or(self.folder);
        fs::create_dir_all(folder)
            .and_then(|()| replace(path, &bytes))
            .map_err(|error| self.refused(path, &error))
    }

    /// Removes what an earlier failure left.
    fn clear(&self) {
        for what in ["expected", "actual", "difference"] {
            // Usually there is nothing.
            fs::remove_file(self.failed(what)).ok();
        }
        // And the folders that are empty now, from the inside to the outside.
        let (all, first) = (self.folder.join("failed"), self.failed("actual"));
        for folder in first.ancestors().skip(1).take_while(|folder| folder.starts_with(&all)) {
            fs::remove_dir(folder).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty folder of a test's own, and a picture of one color.
    fn folder(test: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("rtrt-golden-{test}-{}", std::process::id()));
        fs::remove_dir_all(&folder).ok();
        folder
    }

    fn plain(size: [u32; 2], color: u32) -> Picture {
        let pixels = vec![color; (size[0] * size[1]) as usize];
        Picture { width: size[0], height: size[1], pixels, ..Picture::default() }
    }

    #[test]
    fn a_picture_is_stored_on_request_and_then_compared() {
        let folder = folder("it's stored");
        let red = plain([4, 3], 0xff00_00ff);
        let error = check(&folder, &red, "sub/red", "").unwrap_err();
        assert!(
            matches!(error, Mismatch::Missing { .. }) && folder.join("failed/sub/red.actual.png").is_file()
        );
        assert!(error.to_string().contains("accept: RTRT_BLESS=new cargo test"), "{error}");
        if cfg!(unix) {
            // A shell would wait for the end of what an apostrophe begins.
            assert!(error.to_string().contains(r"rtrt-golden-it'\''s stored"), "{error}");
        }
        check(&folder, &red, "sub/red", "new").unwrap();
        assert!(!folder.join("failed").exists());
        check(&folder, &red, "sub/red", "").unwrap();
        // A step in one channel of one pixel is a difference, also for who stores only new ones.
        let mut other = red.clone();
        other.pixels[6] -= 1;
        for bless in ["", "new"] {
            let error = check(&folder, &other, "sub/red", bless).unwrap_err();
            let Mismatch::Differs { difference, files, .. } = &error else { panic!("{error}") };
            assert_eq!((difference.pixels, difference.most, difference.first), (1, 1, [2, 1]));
            assert!(files.iter().all(|file| file.is_file()));
            assert!(
                error.to_string().contains("1 of 12 pixels, by at most 1 of 255 steps, the first at 2,1")
            );
        }
        check(&folder, &other, "sub/red", "1").unwrap();
        check(&folder, &other, "sub/red", "").unwrap();
        let error = check(&folder, &plain([3, 4], 0xff00_00ff), "sub/red", "").unwrap_err();
        assert!(matches!(error, Mismatch::Size { expected: [4, 3], .. }), "{error}");
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn names_stay_in_the_folder_and_files_are_pictures() {
        let folder = folder("names");
        for name in ["", "../a", "/a", "a/../b", "a/", "."] {
            let error = check(&folder, &plain([1, 1], 0), name, "1").unwrap_err();
            assert!(matches!(error, Mismatch::Name { .. }), "{name}");
        }
        assert!(!folder.exists());
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("text.png"), "no picture").unwrap();
        let error = check(&folder, &plain([1, 1], 0), "text", "").unwrap_err();
        assert!(matches!(error, Mismatch::File { .. }) && error.to_string().contains("text.png"), "{error}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
