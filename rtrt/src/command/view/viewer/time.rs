//! The animation of the scene, and the cameras of the file.

use super::Viewer;
use crate::command::Error;

impl Viewer {
    /// The time of the animation, and its end.
    pub fn time(&self) -> Option<(f64, f64)> {
        self.time.zip(self.job.end())
    }

    /// Whether the animation plays.
    pub fn is_playing(&self) -> bool {
        self.is_playing
    }

    /// Plays the animation, or stops it.
    pub fn toggle_play(&mut self) {
        match self.job.end() {
            Some(_) => self.is_playing = !self.is_playing,
            None => self.say("nothing in the scene is animated".into()),
        }
    }

    /// Stops the animation so many seconds from here.
    pub(super) fn step(&mut self, seconds: f64) -> Result<(), Error> {
        let Some(end) = self.job.end() else {
            self.say("nothing in the scene is animated".into());
            return Ok(());
        };
        self.is_playing = false;
        self.play((self.time.unwrap_or(0.0) + seconds).clamp(0.0, end))
    }

    /// Shows the scene at a time of its animation. A failure is noted.
    pub fn scrub(&mut self, time: f64) {
        let played = self.play(time);
        self.note(played);
    }

    /// Whether the animation moves the camera: until a person does.
    fn follows_camera(&self) -> bool {
        self.is_at_start && self.job.has_cameras()
    }

    /// Shows the scene at a time of its animation.
    pub(super) fn play(&mut self, time: f64) -> Result<(), Error> {
        let camera = self.job.camera;
        self.time = Some(time);
        let played = self.job.play(time);
        if !self.follows_camera() {
            self.job.camera = camera;
        }
        self.touch();
        if played.is_err() {
            self.is_playing = false;
        }
        played
    }

    /// Chooses an animation by its number, or all at once, and starts at its beginning.
    pub fn choose_animation(&mut self, number: Option<usize>) {
        let camera = self.job.camera;
        let chosen = self.job.choose_animation(number);
        if !self.follows_camera() {
            self.job.camera = camera;
        }
        self.note(chosen);
        self.options.animation = Some(number.map_or("all".into(), |number| number.to_string()));
        self.scrub(0.0);
    }

    /// Looks from a camera of the file.
    pub fn choose_camera(&mut self, number: usize) {
        self.job.choose_camera(number);
        (self.start, self.is_at_start, self.controls.pivot) = (self.job.camera, true, None);
        self.touch();
    }
}
