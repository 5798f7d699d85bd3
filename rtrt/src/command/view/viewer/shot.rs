//! Screenshots.

use super::draw::pixels;
use super::{Viewer, Wanted};
use crate::command::Error;
use crate::command::names::{filled, is_numbered};
use crate::command::output::{self, png};
use crate::command::render::encode;
use crate::command::report::Machine;
use crate::command::view::engine::Engine;
use crate::command::view::reproduce::{self, EnvironmentShot, Shot};
use image::ExtendedColorType::Rgba8;
use rtrt_core::backend::Picture;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// The output of `--json` for a screenshot.
#[derive(serde::Serialize)]
struct ScreenshotReport<'a> {
    #[serde(flatten)]
    machine: Machine,
    size: [u32; 2],
    /// The command that renders the same picture.
    command: String,
    output: &'a Path,
}

/// What is printed of a screenshot, and how.
struct Printed {
    machine: Machine,
    size: [u32; 2],
    command: String,
    is_json: bool,
}

impl Printed {
    /// Writes the pixels as a file, and prints what there is to print.
    fn write(self, path: &Path, pixels: &[u8]) -> Result<(), Error> {
        let Self { machine, size, command, is_json } = self;
        let bytes = png(pixels, size, Rgba8).map_err(encode(path))?;
        output::write(path, &bytes)?;
        if is_json {
            output::print_json(&ScreenshotReport { machine, size, command, output: path })
        } else {
            output::print(command)
        }
    }
}

impl Viewer {
    /// Writes the picture at full detail, and prints the command that renders it. A replay waits for it. Else a thread
    /// writes it and, where that is no slower, renders it too, with the same bits.
    pub(super) fn screenshot(&mut self) -> Result<(), Error> {
        let path = self.free_name();
        output::check(&path)?;
        let wanted = self.wanted(self.full());
        wanted.check()?;
        let mut printed = Printed {
            machine: self.machine().clone(),
            size: wanted.detail.size,
            command: self.command(&path, wanted),
            is_json: self.options.json,
        };
        if self.is_exact {
            self.draw(wanted, &AtomicBool::new(false))?;
            printed.write(&path, &self.pixels())?;
            self.say(format!("written: {}", path.display()));
            return Ok(());
        }
        self.say(format!("rendering {}", path.display()));
        if wanted.hybrid || self.engines.drawing().is_fast() {
            self.draw(wanted, &AtomicBool::new(false))?;
            let pixels = self.pixels().into_owned();
            self.shots.begin(path.clone(), move || printed.write(&path, &pixels));
            return Ok(());
        }
        let (mut job, options) = (self.job.still(), self.options.backend.clone());
        wanted.apply(&mut job);
        self.shots.begin(path.clone(), move || {
            let mut cpu = Engine::cpu(&options)?;
            printed.machine = cpu.machine().clone();
            let mut picture = Picture::default();
            job.render(cpu.backend(), &job.request(wanted.debug.is_some()), &mut picture)?;
            let shown = wanted.debug.map(|view| job.show(view, &picture)).transpose()?;
            // What changes the scene from here on need not copy it.
            drop(job);
            printed.write(&path, &pixels(shown.as_ref(), &picture))
        });
        Ok(())
    }

    /// The command that renders a picture as it would be now.
    fn command(&self, path: &Path, wanted: Wanted) -> String {
        let mut job = self.job.still();
        wanted.apply(&mut job);
        let shot = Shot {
            common: &self.options,
            passed_on: &self.passed_on,
            request: job.request(wanted.debug.is_some()),
            origin: self.job.origin,
            time: self.time,
            hybrid: wanted.hybrid,
            debug: wanted.debug,
            lights: self.has_own_lights.then(|| self.job.scene.lights()),
            colors: self.has_own_colors.then_some((self.job.scene.ambient, self.job.scene.background)),
            animation: self.time.and(self.options.animation.as_deref()),
            hidden: self.job.hidden.keys().copied().collect(),
            materials: self.repaints(),
            environment: self.job.surrounded.has_environment.then(|| EnvironmentShot::new(&self.job)),
        };
        reproduce::command(&shot, path)
    }

    /// Says which screenshots are done.
    pub(super) fn take_shots(&mut self) {
        for (path, written) in self.shots.done() {
            match written {
                Ok(()) => self.say(format!("written: {}", path.display())),
                Err(error) => self.note(Err(error)),
            }
        }
    }

    /// The first unused name for a picture, if the name has a number.
    fn free_name(&self) -> PathBuf {
        if !is_numbered(&self.output) {
            return filled(&self.output, &self.options.scene, "camera", 0);
        }
        let mut names = (0..10_000).map(|number| filled(&self.output, &self.options.scene, "camera", number));
        names.find(|name| !name.exists() && !self.shots.has(name)).unwrap_or_else(|| self.output.clone())
    }
}
