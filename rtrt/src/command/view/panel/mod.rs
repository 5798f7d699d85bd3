//! The panel: what can be changed.

mod camera;
mod environment;
mod fields;
mod lights;
mod objects;
mod picture;
mod selection;
mod time;
mod tone;

use super::overlay::MARGIN;
use super::viewer::{Settings, Viewer};
use egui::{Align2, CollapsingHeader, Context, ScrollArea, Ui, Window, vec2};
pub use objects::{Rows, show as show_objects};

/// The width of a panel, units.
const WIDTH: f32 = 260.0;

/// Whether the panel and the list of objects were open.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Opened {
    panel: bool,
    objects: bool,
}

impl Opened {
    /// Closes the one that was open before the other where there is no room for both.
    pub fn give_room(&mut self, context: &Context, settings: &mut Settings) {
        let is_narrow = context.content_rect().width() < 2.0 * WIDTH + 6.0 * MARGIN;
        if is_narrow && settings.panel && settings.objects {
            (settings.panel, settings.objects) = (self.objects, !self.objects);
        }
        *self = Self { panel: settings.panel, objects: settings.objects };
    }
}

/// Shows the panel, and applies changes.
pub fn show(context: &Context, viewer: &mut Viewer) {
    let mut is_open = viewer.settings.panel;
    let corner = context.content_rect().right_top() + vec2(-MARGIN, MARGIN);
    let window = Window::new("rtrt").open(&mut is_open).default_width(WIDTH);
    let window = window.pivot(Align2::RIGHT_TOP).default_pos(corner);
    let window = window.default_height(height(context)).max_height(height(context));
    window.show(context, |ui| {
        ScrollArea::vertical().show(ui, |ui| {
            let is_gpu = viewer.is_gpu();
            picture::picture(ui, &mut viewer.settings, is_gpu);
            ui.separator();
            lights::lights(ui, viewer);
            ui.separator();
            picture::exposure(ui, viewer);
            ui.separator();
            environment::show(ui, viewer);
            ui.separator();
            section(ui, "camera", false, |ui| camera::show(ui, viewer));
            section(ui, "time", viewer.job.end().is_some(), |ui| time::show(ui, viewer));
            section(ui, "files", false, |ui| files(ui, viewer));
        });
    });
    viewer.settings.panel = is_open;
}

/// Shows what is selected, and applies changes of its material.
pub fn show_selection(context: &Context, viewer: &mut Viewer) {
    if !viewer.shows_selection() {
        return;
    }
    let mut is_open = true;
    let corner = context.content_rect().left_bottom() + vec2(MARGIN, -MARGIN);
    let window = Window::new("selected").open(&mut is_open).default_width(WIDTH);
    // The list of objects is above.
    let most = if viewer.settings.objects { half(context) } else { height(context) };
    let window = window.pivot(Align2::LEFT_BOTTOM).default_pos(corner).max_height(most);
    window.show(context, |ui| {
        ScrollArea::vertical().show(ui, |ui| selection::show(ui, viewer));
    });
    if !is_open {
        viewer.selection = None;
    }
}

/// What a panel may have of the window's height, without its title.
fn height(context: &Context) -> f32 {
    (context.content_rect().height() - 4.0 * MARGIN - 40.0).max(60.0)
}

/// What each of two panels above each other may have of the window's height, without its title.
fn half(context: &Context) -> f32 {
    (context.content_rect().height() * 0.5 - 2.0 * MARGIN - 40.0).max(60.0)
}

/// A part of the panel. Whether it is open at first may depend on the scene.
fn section(ui: &mut Ui, name: &str, is_open: bool, content: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(name).id_salt((name, is_open)).default_open(is_open).show(ui, content);
}

/// The files that were opened last, and those beside this one.
fn files(ui: &mut Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        for (name, places) in [("previous", -1), ("next", 1)] {
            if ui.button(name).clicked() {
                viewer.open_beside(places);
            }
        }
    });
    let mut chosen = None;
    for path in viewer.recent() {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        if ui.link(name).on_hover_text(path.display().to_string()).clicked() {
            chosen = Some(path.clone());
        }
    }
    if let Some(path) = chosen {
        viewer.open(path);
    }
}
