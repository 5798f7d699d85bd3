//! The overlay: keys, timing, messages.

use super::controls::KEYS;
use super::pace::Detail;
use super::viewer::{Timing, Viewer};
use egui::{Align2, Area, Color32, Context, Frame, Grid, Id, Rect, Sense, Ui, vec2};
use rtrt_core::schedule::Stage;

/// The margin at the sides of the window.
pub const MARGIN: f32 = 8.0;

/// Shows the overlay.
pub fn show(context: &Context, viewer: &Viewer) {
    if viewer.settings.timing {
        // The list of objects is on the left.
        let side = if viewer.settings.objects { Align2::CENTER_TOP } else { Align2::LEFT_TOP };
        boxed(context, "timing", side, |ui| timing(ui, viewer));
    }
    if viewer.settings.help {
        boxed(context, "help", Align2::CENTER_CENTER, help);
    }
    if let Some(text) = viewer.message() {
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

/// The keys, in as many columns as a small window needs.
fn help(ui: &mut Ui) {
    // As large as fits into one column, else small.
    let lines = |ui: &Ui, style| {
        let line = ui.text_style_height(&style) + ui.spacing().item_spacing.y;
        (((ui.ctx().content_rect().height() - 6.0 * MARGIN) / line) as usize).max(1)
    };
    let fits = lines(ui, egui::TextStyle::Body) >= KEYS.len();
    let style = if fits { egui::TextStyle::Body } else { egui::TextStyle::Small };
    let lines = lines(ui, style.clone());
    ui.style_mut().override_text_style = Some(style);
    let columns = KEYS.len().div_ceil(lines).max(1);
    ui.horizontal_top(|ui| {
        for (number, keys) in KEYS.chunks(KEYS.len().div_ceil(columns)).enumerate() {
            Grid::new(("keys", number)).num_columns(2).min_row_height(0.0).show(ui, |ui| {
                for (keys, what) in keys {
                    ui.strong(*keys);
                    ui.label(*what);
                    ui.end_row();
                }
            });
        }
    });
}

fn timing(ui: &mut Ui, viewer: &Viewer) {
    ui.style_mut().override_text_style = Some(egui::TextStyle::Small);
    ui.label(viewer.machine().to_string());
    let Some(Timing { detail, frame_ms, stages_ms }) = viewer.timing else { return };
    let Detail { size: [width, height], samples } = detail;
    ui.label(format!("{width}x{height}, {samples} samples"));
    ui.label(format!("{frame_ms:.1} ms to render"));
    ui.label(format!("{:.2} million camera rays a second", detail.rays() / frame_ms * 1e-3));
    if let Some((now, end)) = viewer.time() {
        ui.label(format!("{now:.2} of {end:.2} s"));
    }
    ui.separator();
    ui.label(format!("window: {}", viewer.drawn_by));
    let (answer_ms, sharp_ms, pictures) = viewer.figures.last();
    ui.label(format!("pictures in the last second: {pictures}"));
    if let Some(ms) = answer_ms {
        ui.label(format!("{ms:.0} ms from an event to its picture"));
    }
    if let Some(ms) = sharp_ms {
        ui.label(format!("{ms:.0} ms from the last change to all pixels"));
    }
    ui.separator();
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
