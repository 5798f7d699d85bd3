//! Films: frames through a pipe to ffmpeg.

use super::Error;
use rtrt::replace::Part;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// A film that is being written. Nothing is at its path before it is complete.
pub struct Video {
    path: PathBuf,
    size: [u32; 2],
    encoder: Child,
    /// None once the film is at its path.
    part: Option<Part>,
}

impl Video {
    /// Starts ffmpeg for a film of pictures of this size.
    pub fn new(path: &Path, size: [u32; 2], fps: f64) -> Result<Self, Error> {
        let refused = |why: String| Error::Video { path: path.to_owned(), why };
        let part = Part::new(path);
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgba"]);
        command.args(["-video_size", &format!("{}x{}", size[0], size[1]), "-framerate", &fps.to_string()]);
        // Colors are at half the resolution, so sides are even. Without names of colors players guess by the size.
        let filter = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv";
        command.args([
            "-i",
            "-",
            "-vf",
            filter,
            "-pix_fmt",
            "yuv420p",
            "-color_range",
            "tv",
            "-colorspace",
            "bt709",
        ]);
        command.args(["-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-f", "mp4"]);
        command.arg(part.path()).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let encoder = command.spawn().map_err(|error| refused(format!("ffmpeg does not start: {error}")))?;
        Ok(Self { path: path.to_owned(), size, encoder, part: Some(part) })
    }

    /// Whether it is the film at this path.
    pub fn is_at(&self, path: &Path) -> bool {
        self.path == path
    }

    /// Adds a picture: red, green, blue, alpha, row by row.
    pub fn add(&mut self, pixels: &[u8], size: [u32; 2]) -> Result<(), Error> {
        if size != self.size {
            let [has, is] = [self.size, size].map(|[width, height]| format!("{width} x {height}"));
            return Err(self.refused(format!("its pictures have {has} pixels, and this one {is}")));
        }
        let written = self.encoder.stdin.as_mut().map_or(Ok(()), |to| to.write_all(pixels));
        written.map_err(|error| {
            let said = self.said();
            self.refused(if said.is_empty() { error.to_string() } else { said })
        })
    }

    /// Waits for ffmpeg, and puts the film at its path.
    pub fn finish(mut self) -> Result<(), Error> {
        drop(self.encoder.stdin.take());
        let said = self.said();
        match self.encoder.wait() {
            Ok(status) if status.success() => {}
            Ok(status) => return Err(self.refused(format!("ffmpeg ended with {status}: {said}"))),
            Err(error) => return Err(self.refused(error.to_string())),
        }
        let path = self.path.clone();
        self.part
            .take()
            .map_or(Ok(()), |part| part.keep(&path))
            .map_err(|source| Error::Write { path, source })
    }

    /// What ffmpeg says before it ends, in a line.
    fn said(&mut self) -> String {
        drop(self.encoder.stdin.take());
        let mut said = String::new();
        if let Some(from) = &mut self.encoder.stderr {
            // What cannot be read says nothing.
            from.read_to_string(&mut said).ok();
        }
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    fn refused(&self, why: String) -> Error {
        Error::Video { path: self.path.clone(), why }
    }
}

impl Drop for Video {
    fn drop(&mut self) {
        // It may have ended. Otherwise it would make a file where the part was.
        self.encoder.kill().ok();
        self.encoder.wait().ok();
    }
}
