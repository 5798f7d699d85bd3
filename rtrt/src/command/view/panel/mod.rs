//! The panel: what can be changed.

mod camera;
mod fields;
mod lights;
mod objects;
mod picture;
mod selection;
mod time;

use super::overlay::MARGIN;
use super::viewer::Viewer;
use egui::{Align2, CollapsingHeader, Context, ScrollArea, Ui, Window, vec2};
pub use objects::{Rows, show as show_objects};

/// Shows the panel, and applies changes.
pub fn show(context: &Context, viewer: &mut Viewer) {
    let mut is_open = viewer.settings.panel;
    let corner = context.content_rect().right_top() + vec2(-MARGIN, MARGIN);
    let window = Window::new("rtrt").open(&mut is_open).default_width(260.0);
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
            if viewer.job.surrounded.has_environment {
                picture::environment(ui, viewer);
            }
            ui.separator();
            section(ui, "camera", |ui| camera::show(ui, viewer));
            section(ui, "time", |ui| time::show(ui, viewer));
            section(ui, "files", |ui| files(ui, viewer));
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
    let window = Window::new("selected").open(&mut is_open).default_width(260.0);
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

fn section(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(name).show(ui, content);
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
