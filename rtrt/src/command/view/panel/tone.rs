//! A color of the panel: a button, and a picker that pops up.
//!
//! That of egui was refused: it has a button that copies to a clipboard, which the viewer lacks, and gradients of few
//! texels.

use egui::epaint::{Hsva, HsvaGamma, Mesh};
use egui::{Color32, DragValue, Id, Popup, PopupCloseBehavior, Pos2, Rect, Rgba, Sense, Stroke, Ui};
use egui::{lerp, pos2, remap_clamp, vec2};
use glam::Vec3;

/// The side of the square, and the height of the strip below, units of the user interface.
const SIDE: f32 = 160.0;
const STRIP: f32 = 16.0;
/// Squares of a gradient along a side: between their corners colors are interpolated.
const PARTS: usize = 36;

/// A button for a color. Without a change the color keeps its bits.
pub fn tone(ui: &mut Ui, color: &mut Vec3) {
    let [red, green, blue] = color.to_array();
    let shown = Color32::from(Rgba::from_rgb(red, green, blue));
    let (place, button) = ui.allocate_exact_size(ui.spacing().interact_size, Sense::click());
    let visuals = ui.style().interact(&button);
    ui.painter().rect(place, visuals.corner_radius, shown, visuals.fg_stroke, egui::StrokeKind::Inside);
    let popup = Popup::menu(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    popup.show(|ui| {
        let id = ui.scope_id().with("picked");
        if let Some(picked) = picker(ui, id, shown) {
            let picked = Rgba::from(picked);
            *color = Vec3::new(picked.r(), picked.g(), picked.b());
        }
    });
}

/// Bytes of sRGB, a square of saturation and brightness, a strip of hues. Returns the color if it has changed.
fn picker(ui: &mut Ui, id: Id, shown: Color32) -> Option<Color32> {
    let mut bytes = [shown.r(), shown.g(), shown.b()];
    ui.horizontal(|ui| {
        for (name, byte) in ["R ", "G ", "B "].into_iter().zip(&mut bytes) {
            ui.add(DragValue::new(byte).speed(0.5).prefix(name));
        }
    });
    let mut next = Color32::from_rgb(bytes[0], bytes[1], bytes[2]);
    // Gray has no hue, and black no saturation: those that were picked are remembered.
    let known: Option<HsvaGamma> = ui.data(|data| data.get_temp(id));
    let same = known.filter(|known| Color32::from(*known) == next);
    let mut hsv = same.unwrap_or_else(|| HsvaGamma::from(Hsva::from(next)));
    let opaque = |h, s, v| HsvaGamma { h, s, v, a: 1.0 };
    let before = hsv;
    let (square, dragged) = area(ui, vec2(SIDE, SIDE));
    if let Some(at) = dragged {
        hsv.s = remap_clamp(at.x, square.x_range(), 0.0..=1.0);
        hsv.v = 1.0 - remap_clamp(at.y, square.y_range(), 0.0..=1.0);
    }
    let (strip, dragged) = area(ui, vec2(SIDE, STRIP));
    if let Some(at) = dragged {
        hsv.h = remap_clamp(at.x, strip.x_range(), 0.0..=1.0);
    }
    gradient(ui, square, PARTS, |x, y| opaque(hsv.h, x, 1.0 - y).into());
    gradient(ui, strip, 1, |x, _| opaque(x, 1.0, 1.0).into());
    mark(ui, pos2(lerp(square.x_range(), hsv.s), lerp(square.y_range(), 1.0 - hsv.v)));
    mark(ui, pos2(lerp(strip.x_range(), hsv.h), strip.center().y));
    if hsv != before {
        next = hsv.into();
    }
    ui.data_mut(|data| data.insert_temp(id, hsv));
    (next != shown).then_some(next)
}

/// A place that can be dragged over, and where it is.
fn area(ui: &mut Ui, size: egui::Vec2) -> (Rect, Option<Pos2>) {
    let (place, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    (place, response.interact_pointer_pos())
}

/// Fills a rectangle with the colors at shares of its width and height, in so many rows.
fn gradient(ui: &Ui, place: Rect, rows: usize, color: impl Fn(f32, f32) -> Color32) {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=PARTS {
            let (x, y) = (column as f32 / PARTS as f32, row as f32 / rows as f32);
            mesh.colored_vertex(pos2(lerp(place.x_range(), x), lerp(place.y_range(), y)), color(x, y));
        }
    }
    let width = PARTS as u32 + 1;
    for corner in (0..rows as u32).flat_map(|row| (0..PARTS as u32).map(move |column| row * width + column)) {
        mesh.add_triangle(corner, corner + 1, corner + width);
        mesh.add_triangle(corner + width, corner + 1, corner + width + 1);
    }
    ui.painter().add(mesh);
}

/// A ring around what is picked.
fn mark(ui: &Ui, place: Pos2) {
    ui.painter().circle_stroke(place, 5.0, Stroke::new(3.0, Color32::BLACK));
    ui.painter().circle_stroke(place, 5.0, Stroke::new(1.5, Color32::WHITE));
}
