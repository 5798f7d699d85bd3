//! Screenshots.

use super::Viewer;
use crate::command::Error;
use crate::command::names::{filled, is_numbered};
use crate::command::output::{self, png};
use crate::command::render::encode;
use crate::command::report::Machine;
use crate::command::view::reproduce::{self, EnvironmentShot, Shot};
use image::ExtendedColorType::Rgba8;
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

impl Viewer {
    /// Writes the picture at full detail, and prints the command that renders it.
    pub(super) fn screenshot(&mut self) -> Result<(), Error> {
        let path = self.free_name();
        output::check(&path)?;
        let full = self.full();
        self.draw(self.wanted(full), &AtomicBool::new(false))?;
        let bytes = png(&self.pixels(), full.size, Rgba8).map_err(encode(&path))?;
        output::write(&path, &bytes)?;
        let shot = Shot {
            common: &self.options,
            passed_on: &self.passed_on,
            request: self.job.request(self.settings.debug.is_some()),
            origin: self.job.origin,
            time: self.time,
            hybrid: self.is_hybrid(),
            debug: self.settings.debug,
            lights: self.has_own_lights.then(|| self.job.scene.lights()),
            colors: self.has_own_colors.then_some((self.job.scene.ambient, self.job.scene.background)),
            animation: self.time.and(self.options.animation.as_deref()),
            hidden: self.job.hidden.keys().copied().collect(),
            materials: self.repaints(),
            environment: self.job.surrounded.has_environment.then(|| EnvironmentShot::new(&self.job)),
        };
        let command = reproduce::command(&shot, &path);
        if self.options.json {
            let machine = self.machine().clone();
            self.console.print(output::json(&ScreenshotReport {
                machine,
                size: full.size,
                command,
                output: &path,
            })?)?;
        } else {
            self.console.print(command)?;
        }
        self.say(format!("written: {}", path.display()));
        Ok(())
    }

    /// The first unused name for a picture, if the name has a number.
    fn free_name(&self) -> PathBuf {
        if !is_numbered(&self.output) {
            return filled(&self.output, &self.options.scene, "camera", 0);
        }
        let mut names = (0..10_000).map(|number| filled(&self.output, &self.options.scene, "camera", number));
        names.find(|name| !name.exists()).unwrap_or_else(|| self.output.clone())
    }
}
