//! Fields of the panel: points, numbers.

use egui::{DragValue, Ui};
use glam::{DVec3, Vec3};

/// Three numbers.
pub fn vector(ui: &mut Ui, name: &str, v: &mut Vec3) {
    let speed = f64::from(v.abs().max_element().max(0.1)) * 0.01;
    ui.horizontal(|ui| {
        ui.label(name);
        for number in [&mut v.x, &mut v.y, &mut v.z] {
            let drag = DragValue::new(number).speed(speed).range(-1e6..=1e6);
            ui.add(drag.clamp_existing_to_range(false));
        }
    });
}

/// A point, shown in the coordinates of the file, in which the scene's origin is this. Without a change it keeps its bits.
pub fn coordinates(ui: &mut Ui, name: &str, point: &mut Vec3, origin: DVec3) {
    let shown = point.as_dvec3() + origin;
    let mut next = shown;
    let speed = f64::from(point.abs().max_element().max(0.1)) * 0.01;
    ui.horizontal(|ui| {
        ui.label(name);
        for number in [&mut next.x, &mut next.y, &mut next.z] {
            ui.add(DragValue::new(number).speed(speed).range(-1e9..=1e9).clamp_existing_to_range(false));
        }
    });
    if next != shown {
        *point = (next - origin).as_vec3();
    }
}

/// A share of 0 to 1, in a row.
pub fn share(ui: &mut Ui, name: &str, value: &mut f32) {
    let drag = DragValue::new(value).speed(0.005).range(0.0..=1.0).clamp_existing_to_range(false);
    ui.label(name);
    ui.add(drag);
}
