//! The overlay: keys, timing, messages.

use super::controls::KEYS;
use super::figures::Last;
use super::pace::Detail;
use super::viewer::{Timing, Viewer};
use crate::command::report::counted;
use egui::{Align2, Area, Color32, Context, FontId, Frame, Grid, Id, Order, Rect, Sense, Ui, vec2};
use rtrt_core::schedule::Stage;
use std::path::Path;

/// The margin at the sides of the window.
pub const MARGIN: f32 = 8.0;

/// The height of a bar.
const BAR: f32 = 10.0;
/// The gap between columns of keys, the distance of their lines, and the height of a line, sizes of the text.
const GAP: f32 = 1.0;
const LINE: f32 = 1.6;
const TALL: f32 = 1.3;

/// Shows the overlay.
pub fn show(context: &Context, viewer: &Viewer, last: &Last) {
    if viewer.settings.timing {
        // The list of objects is on the left.
        let side = if viewer.settings.objects { Align2::CENTER_TOP } else { Align2::LEFT_TOP };
        // Over the panels, which take most of a small window.
        boxed(context, Order::Foreground, "timing", side, |ui| timing(ui, viewer, last));
    }
    if viewer.settings.help {
        boxed(context, Order::Foreground, "help", Align2::CENTER_CENTER, help);
    }
    if let Some(text) = viewer.message() {
        boxed(context, Order::Foreground, "message", Align2::CENTER_BOTTOM, |ui| line(ui, &text));
    }
    if let Some(legend) = viewer.legend() {
        boxed(context, Order::Background, "legend", Align2::RIGHT_BOTTOM, |ui| line(ui, &legend));
    }
}

/// Shows that a scene is being loaded.
pub fn waits(context: &Context, scene: &Path) {
    boxed(context, Order::Foreground, "message", Align2::CENTER_BOTTOM, |ui| {
        line(ui, &format!("loading {}", scene.display()));
    });
}

/// A text in a line, or in more where the window is not wide enough.
fn line(ui: &mut Ui, text: &str) {
    let room = ui.ctx().content_rect().width() - 6.0 * MARGIN;
    let font = egui::TextStyle::Body.resolve(ui.style());
    let width = ui.painter().layout_no_wrap(text.into(), font, Color32::WHITE).rect.width();
    if width > room {
        ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Wrap);
        ui.set_width(room);
    }
    ui.label(text);
}

/// A dark box at a side of the window, through which the mouse reaches the picture.
fn boxed<R>(
    context: &Context,
    order: Order,
    name: &'static str,
    side: Align2,
    content: impl FnOnce(&mut Ui) -> R,
) {
    let inward = -vec2(side.x().to_sign(), side.y().to_sign()) * MARGIN;
    let id = Id::unique(name);
    if context.memory(|memory| memory.area_rect(id)).is_none() {
        // The position follows from the size, and the next frame may be far away.
        context.request_discard("a new box");
    }
    let area = Area::new(id).order(order).anchor(side, inward).interactable(false).fade_in(false);
    area.show(context, |ui| {
        let dark = Frame::popup(ui.style()).fill(Color32::from_black_alpha(200)).shadow(egui::Shadow::NONE);
        dark.show(ui, |ui| {
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
            content(ui)
        });
    });
}

/// The keys, as large as fits into the window, but no larger than other text.
fn help(ui: &mut Ui) {
    let most = egui::TextStyle::Body.resolve(ui.style()).size;
    let width = |text: &str| {
        let font = FontId::proportional(most);
        ui.painter().layout_no_wrap(text.into(), font, Color32::WHITE).rect.width()
    };
    let widths = KEYS.map(|(keys, what)| [width(keys), width(what)]);
    // Widths and heights grow with the text.
    let room = ui.ctx().content_rect().size() - vec2(6.0, 6.0) * MARGIN;
    let size = |columns: usize| {
        let lines = KEYS.len().div_ceil(columns);
        let widest = |part: &[[f32; 2]]| {
            (0..2).map(|side| part.iter().map(|both| both[side]).fold(0.0, f32::max)).sum::<f32>()
        };
        let across: f32 = widths.chunks(lines).map(|part| widest(part) + 2.0 * GAP * most).sum();
        let down = lines as f32 * most * LINE;
        (most * (room.x / across).min(room.y / down).min(1.0)).max(2.0)
    };
    let columns = (1..=4).rev().max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(1);
    let size = size(columns);
    ui.style_mut().override_font_id = Some(FontId::proportional(size));
    ui.spacing_mut().item_spacing.x = GAP * size;
    ui.horizontal_top(|ui| {
        for (number, keys) in KEYS.chunks(KEYS.len().div_ceil(columns)).enumerate() {
            let grid = Grid::new(("keys", number)).num_columns(2).min_row_height(0.0);
            grid.spacing(vec2(GAP, LINE - TALL) * size).show(ui, |ui| {
                for (keys, what) in keys {
                    ui.strong(*keys);
                    ui.label(*what);
                    ui.end_row();
                }
            });
        }
    });
}

fn timing(ui: &mut Ui, viewer: &Viewer, last: &Last) {
    ui.style_mut().override_text_style = Some(egui::TextStyle::Small);
    ui.label(viewer.machine().to_string());
    let Some(Timing { detail, frame_ms, stages_ms }) = viewer.timing else { return };
    let Detail { size: [width, height], samples } = detail;
    ui.label(format!("{width}x{height}, {}", counted(samples, "sample")));
    ui.label(format!("{frame_ms:.1} ms to render"));
    ui.label(format!("{:.2} million camera rays a second", detail.rays() / frame_ms * 1e-3));
    if let Some((now, end)) = viewer.time() {
        ui.label(format!("{now:.2} of {end:.2} s"));
    }
    ui.separator();
    ui.label(format!("window: {}", viewer.drawn_by));
    let Last { begin_ms, answer_ms, sharp_ms, pictures } = *last;
    ui.label(format!("pictures in the last second: {pictures}"));
    if let Some(ms) = begin_ms {
        ui.label(format!("{ms:.0} ms from an event to the beginning of its picture"));
    }
    if let Some(ms) = answer_ms {
        ui.label(format!("{ms:.0} ms from an event to its picture"));
    }
    if let Some(ms) = sharp_ms {
        ui.label(format!("{ms:.0} ms from the last change to all pixels"));
    }
    ui.separator();
    let whole = stages_ms.iter().sum::<f64>().max(1e-9);
    // In a small window, those that take longest.
    let line = ui.text_style_height(&egui::TextStyle::Small).max(BAR) + ui.spacing().item_spacing.y;
    let room = ui.ctx().content_rect().bottom() - MARGIN - ui.cursor().top();
    let mut longest = stages_ms;
    longest.sort_by(|a, b| b.total_cmp(a));
    let least = longest.get((room / line) as usize).copied().unwrap_or(-1.0);
    Grid::new("stages").num_columns(3).min_row_height(0.0).show(ui, |ui| {
        for (stage, ms) in Stage::ALL.iter().zip(stages_ms).filter(|(_, ms)| *ms > least) {
            ui.label(stage.name());
            bar(ui, (ms / whole) as f32);
            ui.label(format!("{ms:.2} ms"));
            ui.end_row();
        }
    });
}

/// A bar that shows a share of 0 ..= 1.
fn bar(ui: &mut Ui, share: f32) {
    let (place, _) = ui.allocate_exact_size(vec2(120.0, BAR), Sense::hover());
    let filled = Rect::from_min_size(place.min, vec2(place.width() * share, place.height()));
    ui.painter().rect_filled(place, 2.0, Color32::from_white_alpha(20));
    ui.painter().rect_filled(filled, 2.0, Color32::from_rgb(90, 170, 250));
}
