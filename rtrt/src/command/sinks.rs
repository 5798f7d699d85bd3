//! Where pictures go: files, standard output, films.

use super::parse::{Stream, ends_in, is_standard};
use super::video::Video;
use super::{Error, output};
use std::path::Path;

/// Pictures on their way. A film grows while its pictures follow one another.
pub struct Sinks {
    stream: Stream,
    fps: f64,
    film: Option<Video>,
}

impl Sinks {
    /// Nothing is written yet.
    pub fn new(stream: Stream, fps: f64) -> Self {
        Self { stream, fps, film: None }
    }

    /// Whether the path takes bytes of red, green, blue and alpha, row by row, and not a file's bytes.
    pub fn takes_pixels(&self, path: &Path) -> bool {
        ends_in(path, "mp4") || (is_standard(path) && self.stream == Stream::Rgba)
    }

    /// Writes a picture: its pixels, or a file's bytes.
    pub fn write(&mut self, path: &Path, bytes: &[u8], size: [u32; 2]) -> Result<(), Error> {
        if !ends_in(path, "mp4") {
            return output::write(path, bytes);
        }
        if self.film.as_ref().is_some_and(|film| !film.is_at(path)) {
            self.finish()?;
        }
        let film = match self.film.take() {
            Some(film) => film,
            None => Video::new(path, size, self.fps)?,
        };
        self.film.insert(film).add(bytes, size)
    }

    /// Ends the film that is being written.
    pub fn finish(&mut self) -> Result<(), Error> {
        self.film.take().map_or(Ok(()), Video::finish)
    }
}
