//! What is selected: its names, the point that was clicked, its material.

use super::fields::share;
use super::tone::tone;
use crate::command::view::viewer::{Selection, Viewer, textures};
use egui::{Grid, Ui};
use glam::Vec3;

/// Shows what is selected, and applies changes of its material. What can be changed comes first: a small window shows no
/// more.
pub fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let Some(Selection { object, label, material, point }) = viewer.selection.clone() else { return };
    let Some(mut next) = viewer.material(material) else { return };
    let before = next;
    ui.horizontal(|ui| {
        let mut is_visible = viewer.is_visible(object);
        if ui.checkbox(&mut is_visible, "drawn").changed() {
            viewer.show_objects([object], is_visible);
        }
        ui.strong(if label.node.is_empty() { &label.mesh } else { &label.node });
    });
    ui.horizontal(|ui| {
        ui.label("color");
        tone(ui, &mut next.base_color);
        ui.label("emission");
        tone(ui, &mut next.emission);
    });
    ui.horizontal(|ui| {
        share(ui, "metallic", &mut next.metallic);
        share(ui, "roughness", &mut next.roughness);
    });
    ui.horizontal(|ui| {
        share(ui, "alpha", &mut next.alpha);
        share(ui, "transmission", &mut next.transmission);
    });
    if next != before {
        viewer.repaint(material, &next);
    }
    ui.separator();
    let mut lines = vec![("object", object.to_string())];
    let mut line = |what, text: String| {
        if !text.is_empty() {
            lines.push((what, text));
        }
    };
    line("node", format!("{}{}", label.path, label.node));
    line("mesh", label.mesh);
    line("material", if label.material.is_empty() { material.to_string() } else { label.material });
    if let Some(point) = &point {
        let [x, y, z] = point.position.to_array().map(|c| format!("{c:.4}"));
        line("triangle", point.triangle.to_string());
        line("position", format!("{x}  {y}  {z}"));
        let Vec3 { x, y, z } = point.normal;
        line("normal", format!("{x:.3}  {y:.3}  {z:.3}"));
        line("distance", format!("{:.4}", point.distance));
        line("texture at", point.uv.map_or(String::new(), |[u, v]| format!("{u:.4}  {v:.4}")));
    }
    for (what, [width, height]) in textures(&next) {
        line("texture", format!("{what}, {width}x{height}"));
    }
    Grid::new("selected").num_columns(2).show(ui, |ui| {
        for (what, text) in lines {
            ui.strong(what);
            ui.label(text);
            ui.end_row();
        }
    });
}
