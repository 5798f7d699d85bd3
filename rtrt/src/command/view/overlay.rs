//! The overlay: keys, timing, messages.

use super::controls::KEYS;
use super::pace::Detail;
use super::viewer::{Timing, Viewer};
use egui::{Align2, Area, Color32, Context, Frame, Grid, Id, Rect, Sense, Ui, vec2};
use rtrt_core::schedule::Stage;

/// The margin at the sides of the window.
pub const MARGIN: f32 = 8.0;

/// Shows the overlay. `waits` is a message in place of the viewer's.
pub fn show(context: &Context, viewer: &Viewer, waits: Option<&str>) {
    if viewer.settings.timing {
        boxed(context, "timing", Align2::LEFT_TOP, |ui| timing(ui, viewer));
    }
    if viewer.settings.help {
        boxed(context, "help", Align2::CENTER_CENTER, help);
    }
    if let Some(text) = waits.or(viewer.message()) {
        boxed(context, "message", Align2::CENTER_BOTTOM, |ui| ui.label(text));
    }
    if let Some(legend) = viewer.legend() {
        boxed(context, "legend", Align2::RIGHT_BOTTOM, |ui| ui.label(legend));
    }
}

/// A dark box at a side of the window, through which the mouse reaches the picture.
fn boxed<R>(context: &Context, name: &'static str, side: Align2, content: impl FnOnce(&mut Ui) -> R) {
    let inward = -vec2(side.x().to_sign(), side.y().to_sign()) * MARGIN;
    let id = Id::unique(name);
    if context.memory(|memory| memory.area_rect(id)).is_none() {
        // The position follows from the size, and the next frame may be far away.
        context.request_discard("a new box");
    }
    let area = Area::new(id).anchor(side, inward).interactable(false).fade_in(false);
    area.show(context, |ui| {
        let dark = Frame::popup(ui.style()).fill(Color32::from_black_alpha(200)).shadow(egui::Shadow::NONE);
        dark.show(ui, |ui| {
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
            content(ui)
        });
    });
}

fn help(ui: &mut Ui) {
    Grid::new("keys").num_columns(2).show(ui, |ui| {
        for (keys, what) in KEYS {
            ui.strong(keys);
            ui.label(what);
            ui.end_row();
        }
    });
}

fn timing(ui: &mut Ui, viewer: &Viewer) {
    ui.label(viewer.machine().to_string());
    let Some(Timing { detail, frame_ms, stages_ms }) = viewer.timing else { return };
    let Detail { size: [width, height], samples } = detail;
    ui.label(format!("{width}x{height}, {samples} samples"));
    ui.label(format!("{frame_ms:.1} ms, {:.1} frames a second", 1e3 / frame_ms));
    ui.label(format!("{:.2} million camera rays a second", detail.rays() / frame_ms * 1e-3));
    if let Some((now, end)) = viewer.time() {
        ui.label(format!("{now:.2} of {end:.2} s"));
    }
    let whole = stages_ms.iter().sum::<f64>().max(1e-9);
    Grid::new("stages").num_columns(3).show(ui, |ui| {
        for (stage, ms) in Stage::ALL.iter().zip(stages_ms) {
            ui.label(stage.name());
            bar(ui, (ms / whole) as f32);
            ui.label(format!("{ms:.2} ms"));
            ui.end_row();
        }
    });
}

/// A bar that shows a share of 0 ..= 1.
fn bar(ui: &mut Ui, share: f32) {
    let (place, _) = ui.allocate_exact_size(vec2(120.0, 10.0), Sense::hover());
    let filled = Rect::from_min_size(place.min, vec2(place.width() * share, place.height()));
    ui.painter().rect_filled(place, 2.0, Color32::from_white_alpha(20));
    ui.painter().rect_filled(filled, 2.0, Color32::from_rgb(90, 170, 250));
}
