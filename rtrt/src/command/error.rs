//! Why a command failed, and its exit code.

use super::parse::ends_in;
use rtrt::choose::ChooseError;
use rtrt::import::ImportError;
use rtrt::poses::PosesError;
use rtrt_core::backend::RenderError;
use rtrt_core::scene::SetupError;
use std::io;
use std::path::{Path, PathBuf};

/// Why a command failed. Shown in one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no built-in scene with this name.
    #[error("unknown scene: demo:{name}: no such scene is built in")]
    Demo {
        /// The name behind `demo:`.
        name: String,
    },
    /// A picture of the scene would be blank.
    #[error("nothing to draw: {}: {}", scene.display(), blank(warnings))]
    Blank {
        /// The scene.
        scene: PathBuf,
        /// The warnings of the import.
        warnings: Vec<String>,
    },
    /// The scene has no such camera.
    #[error("unknown camera: {}: there is no camera {asked:?}; {}", scene.display(), listed("camera", names))]
    Camera {
        /// The scene.
        scene: PathBuf,
        /// The number or name of the wanted camera.
        asked: String,
        /// The names of the scene's cameras.
        names: Vec<String>,
    },
    /// The scene has no object or material with a number.
    #[error("unknown {what}: {}: there is no {what} {asked}; {what}s of the scene: {}", scene.display(), ranges(known))]
    Number {
        /// The scene.
        scene: PathBuf,
        /// `object` or `material`.
        what: &'static str,
        /// The number.
        asked: u32,
        /// Those that there are, in order.
        known: Vec<u32>,
    },
    /// The scene has no such animation.
    #[error("unknown animation: {}: there is no animation {asked:?}; {}", scene.display(), listed("animation", names))]
    Animation {
        /// The scene.
        scene: PathBuf,
        /// The wanted animation.
        asked: String,
        /// The names of the scene's animations.
        names: Vec<String>,
    },
    /// The command line is invalid.
    #[error("{what}")]
    Line {
        /// The error.
        what: String,
        /// A way out.
        hint: String,
    },
    /// The file of `--cameras` is invalid.
    #[error(transparent)]
    Poses(#[from] PosesError),
    /// The film could not be made.
    #[error("cannot make the film: {}: {why}", path.display())]
    Video {
        /// The file.
        path: PathBuf,
        /// The reason.
        why: String,
    },
    /// Two pictures would have the same name.
    #[error("two pictures have one name: {}", path.display())]
    SameName {
        /// The name.
        path: PathBuf,
    },
    /// The file with defaults is invalid.
    #[error("defaults refused: {}: {why}", path.display())]
    Defaults {
        /// The file.
        path: PathBuf,
        /// The reason.
        why: String,
    },
    /// The options contradict each other.
    #[error("wrong usage: {0}")]
    Usage(&'static str),
    /// The frame has too many rays.
    #[error("frame too large: {rays} rays, but at most {limit} {may}")]
    TooLarge {
        /// The rays of the frame.
        rays: u64,
        /// The use that has the limit.
        may: &'static str,
        /// The limit.
        limit: u64,
    },
    /// The scene could not be loaded.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The backend is not available.
    #[error(transparent)]
    Choose(#[from] ChooseError),
    /// `RTRT_REQUIRE_GPU` is set, and a GPU could not be compared.
    #[error("a GPU is required by RTRT_REQUIRE_GPU: {skipped}")]
    GpuRequired {
        /// The skipped variant, and the reason.
        skipped: String,
    },
    /// No wanted variant is available.
    #[error("nothing was compared: all variants were skipped")]
    NothingCompared,
    /// The frame could not be rendered.
    #[error("cannot render: {}: {source}", scene.display())]
    Render {
        /// The scene.
        scene: PathBuf,
        /// The reason.
        source: RenderError,
    },
    /// The picture could not be encoded.
    #[error("cannot encode the picture: {}: {source}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The picture could not be written.
    #[error("cannot write the picture: {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The program has no window.
    #[cfg(not(feature = "viewer"))]
    #[error("no window: this program was built without the feature `viewer`")]
    NoWindow,
    /// No window could be opened.
    #[cfg(feature = "viewer")]
    #[error("cannot open a window: {}: {why}", scene.display())]
    Window {
        /// The scene.
        scene: PathBuf,
        /// The failed step, and the reason.
        why: String,
    },
    /// The recording cannot be replayed.
    #[cfg(feature = "viewer")]
    #[error("cannot replay: {}: {why}", path.display())]
    Replay {
        /// The recording.
        path: PathBuf,
        /// The error of the system, or the line and its error.
        why: String,
    },
    /// The recording cannot be written.
    #[cfg(feature = "viewer")]
    #[error("cannot record: {}: {source}", path.display())]
    Record {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// Results could not be written.
    #[error("cannot write to standard output: {0}")]
    Print(#[from] io::Error),
    /// A picture made without lists of blocks differs from one made with them.
    #[error("the picture depends on the structure: {}", scene.display())]
    Structure {
        /// The scene.
        scene: PathBuf,
    },
    /// The reference picture cannot be read.
    #[error("cannot read the picture: {}: {why}", path.display())]
    Reference {
        /// The file.
        path: PathBuf,
        /// The reason.
        why: String,
    },
    /// The picture and its reference have different sizes.
    #[error("pictures differ: {}: it has {} x {} pixels, the frame {} x {}", path.display(), has[0], has[1], frame[0], frame[1])]
    Size {
        /// The file.
        path: PathBuf,
        /// Its size.
        has: [u32; 2],
        /// The frame's.
        frame: [u32; 2],
    },
    /// The picture differs from its reference.
    #[error("pictures differ: {}: {pixels} pixels, the first at {},{}: is {is:?}, not {expected:?}", path.display(), at[0], at[1])]
    Differs {
        /// The file.
        path: PathBuf,
        /// The number of differing pixels.
        pixels: usize,
        /// Column and row of the first.
        at: [u32; 2],
        /// Its color.
        is: [u8; 4],
        /// The color in the file.
        expected: [u8; 4],
    },
    /// A warning that `--strict` turns into an error.
    #[error("{warning} (--strict)")]
    Strict {
        /// The warning.
        warning: String,
        /// The exit code.
        code: u8,
    },
    /// Results differ from the reference.
    #[error("backends disagree: {}: {differ} of {variants} differ from the reference", scene.display())]
    Disagree {
        /// The scene.
        scene: PathBuf,
        /// The number of differing variants.
        differ: usize,
        /// The number of variants.
        variants: usize,
    },
}

impl Error {
    /// The exit code of the process.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Encode { .. } | Self::Write { .. } | Self::Video { .. } | Self::Print(_) => 1,
            Self::Demo { .. }
            | Self::Camera { .. }
            | Self::Number { .. }
            | Self::Animation { .. }
            | Self::TooLarge { .. }
            | Self::Line { .. }
            | Self::Defaults { .. }
            | Self::SameName { .. }
            | Self::Usage(_) => 2,
            Self::Import(_) | Self::Blank { .. } | Self::Reference { .. } | Self::Poses(_) => 3,
            Self::Strict { code, .. } => *code,
            #[cfg(feature = "viewer")]
            Self::Record { .. } => 1,
            #[cfg(feature = "viewer")]
            Self::Replay { .. } => 3,
            #[cfg(feature = "viewer")]
            Self::Window { .. } => 4,
            #[cfg(not(feature = "viewer"))]
            Self::NoWindow => 4,
            Self::Choose(_) | Self::GpuRequired { .. } | Self::NothingCompared => 4,
            Self::Disagree { .. } | Self::Structure { .. } | Self::Size { .. } | Self::Differs { .. } => 5,
            Self::Render { source: RenderError::Setup(error), .. } => match error {
                // The command's own lights are checked when they are parsed.
                SetupError::Light { .. } | SetupError::Lights { .. } => 3,
                _ => 2,
            },
            Self::Render { .. } => 1,
        }
    }

    /// A way out, in one line.
    pub fn hint(&self) -> &str {
        match self {
            Self::Line { hint, .. } => hint,
            Self::Demo { .. } => DEMOS,
            Self::Blank { .. } => "export the scene with its meshes; demo:matchbox needs no file",
            Self::Camera { .. } => {
                "--camera takes a name, or a number from 0; --eye and --look-at need no camera"
            }
            Self::Number { .. } => "`rtrt render --report FILE` has the numbers of objects and materials",
            Self::Animation { .. } => "--animation takes a number, a name, or all",
            Self::Poses(_) => "README.md, \"Many views\", has the keys of that file",
            Self::Video { .. } => "a film needs ffmpeg; -o - writes frames for another program",
            Self::SameName { .. } => "names of files may contain {scene}, {camera}, {frame} and {n}",
            Self::Defaults { .. } => {
                "the file that RTRT_CONFIG names has an option a line, such as --size 640x360"
            }
            Self::Usage(_) => "--help has all options and examples",
            Self::TooLarge { .. } => "try a smaller --size or fewer --samples",
            Self::Choose(_) | Self::GpuRequired { .. } | Self::NothingCompared => {
                "`rtrt doctor` lists what this machine offers"
            }
            Self::Differs { .. } => "--tolerance N allows for N of 256 steps a channel",
            Self::Size { .. } => "--size gives the frame the picture's size",
            Self::Reference { .. } => "--compare takes a PNG file, such as `rtrt render` writes",
            Self::Strict { .. } => "without --strict this is a warning",
            Self::Import(error) => of_import(error),
            Self::Write { source, .. } => of_writing(source),
            #[cfg(feature = "viewer")]
            Self::Record { source, .. } => of_writing(source),
            #[cfg(feature = "viewer")]
            Self::Replay { .. } => "--replay takes what --record has written",
            Self::Render { source: RenderError::Setup(SetupError::Camera { .. }), .. } => {
                "see --eye, --look-at, --up and --fov-y"
            }
            Self::Render { source: RenderError::Setup(SetupError::Clip { .. }), .. } => {
                "see --near and --far"
            }
            Self::Render { source: RenderError::Backend { .. }, .. } => "--backend cpu needs no GPU",
            Self::Disagree { .. } | Self::Structure { .. } => {
                "this is a mistake in rtrt; `rtrt --version` and `rtrt doctor` say what it happened with"
            }
            #[cfg(feature = "viewer")]
            Self::Window { .. } => {
                "a window needs a display (on Linux X11, or XWayland, with DISPLAY set); \
                 `rtrt render` needs none"
            }
            #[cfg(not(feature = "viewer"))]
            Self::NoWindow => {
                "`rtrt render SCENE -o FILE` needs none; `cargo run --release -- SCENE` builds the window too"
            }
            Self::Render { .. } => "try a smaller --size, fewer --samples, or other --light",
            Self::Encode { .. } => "try another format: .png or .exr",
            Self::Print(_) => "what standard output goes to has ended, or is full",
        }
    }
}

/// The scenes that are built in.
const DEMOS: &str = "try demo:matchbox, demo:glass, demo:spheres, demo:levels or demo:moving";

/// What to try instead of a scene or an environment that cannot be loaded.
fn of_import(error: &ImportError) -> &'static str {
    match error {
        ImportError::Unreadable { path, .. } if is_url(path) => {
            "fetch it first: rtrt reads files, and no URLs"
        }
        ImportError::Unreadable { source, .. } if source.kind() == io::ErrorKind::NotFound => {
            "names begin at the folder that the command runs in; demo:matchbox needs no file"
        }
        ImportError::Unreadable { .. } | ImportError::Format { .. } => {
            "scenes are .glb, .gltf, .obj, .stl and .ply files; demo:matchbox needs no file"
        }
        ImportError::Environment { .. } => {
            "an environment is a .hdr, .exr, PNG or JPEG file, or a folder with px, nx, py, ny, pz and nz"
        }
        ImportError::Extension { .. } => "export the scene without that extension",
        ImportError::Limit { .. } => "what is read is limited so that memory lasts; export less of the scene",
        ImportError::Buffer { .. } => {
            "buffers lie beside the scene's file, under the names that it gives them"
        }
        ImportError::Invalid { path, .. } if ends_in(path, "stl") || ends_in(path, "ply") => {
            "the file may have been cut off: copy or export it again"
        }
        ImportError::Invalid { path, .. } if !ends_in(path, "obj") => {
            "what else is wrong with a glTF file, a glTF validator says"
        }
        _ => "export the scene again, with numbers that are finite and within 2^30",
    }
}

/// Whether a path is a URL.
fn is_url(path: &Path) -> bool {
    path.to_str().is_some_and(|path| path.contains("://"))
}

/// What to try where a file cannot be written.
fn of_writing(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "make the folder first, or give another name",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "make room, or write it elsewhere",
        _ => "write it elsewhere",
    }
}

/// Why nothing of a file is drawn: what the import left out, if it says so.
fn blank(warnings: &[String]) -> String {
    if warnings.is_empty() { "it has no surfaces, points or lines".into() } else { warnings.join("; ") }
}

/// How many cameras or animations there are, in words, with their numbers and names.
fn listed(what: &str, names: &[String]) -> String {
    let count = match names.len() {
        0 => return format!("the scene has no {what}s"),
        1 => format!("one {what}"),
        count => format!("{count} {what}s"),
    };
    let list = names.iter().enumerate().map(|(number, name)| match &name[..] {
        "" => number.to_string(),
        name => format!("{number} {name:?}"),
    });
    format!("the scene has {count}: {}", list.collect::<Vec<_>>().join(", "))
}

/// Numbers in order, in words: `0 to 3, 7`.
fn ranges(numbers: &[u32]) -> String {
    let runs = numbers.chunk_by(|a, b| a.checked_add(1) == Some(*b)).map(|run| match run {
        [first, .., last] => format!("{first} to {last}"),
        run => run.iter().map(u32::to_string).collect(),
    });
    runs.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_ranges() {
        for (numbers, words) in
            [(&[0, 1, 2, 3, 7][..], "0 to 3, 7"), (&[4], "4"), (&[0, 2, u32::MAX], "0, 2, 4294967295")]
        {
            assert_eq!(ranges(numbers), words);
        }
    }
}
