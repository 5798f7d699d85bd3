//! The camera of the panel.

use crate::command::view::motion::Mode;
use crate::command::view::viewer::Viewer;
use egui::{ComboBox, DragValue, Ui};
use rtrt_core::scene::Projection;

/// Mode, lens and cameras of the file.
pub fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let mode = viewer.mode();
    ComboBox::from_label("drag").selected_text(mode.name()).show_ui(ui, |ui| {
        for (name, known) in Mode::ALL {
            ui.selectable_value(mode, known, name);
        }
    });
    let mut projection = viewer.job.camera.projection;
    match &mut projection {
        Projection::Perspective { fov_y } => {
            let before = fov_y.to_degrees();
            let mut degrees = before;
            let drag = DragValue::new(&mut degrees).range(0.5..=169.0).speed(0.2).suffix("°");
            ui.horizontal(|ui| (ui.label("angle of view"), ui.add(drag.clamp_existing_to_range(false))));
            if degrees != before {
                *fov_y = degrees.to_radians();
            }
        }
        Projection::Orthographic { height } => {
            let speed = f64::from(*height) * 0.01;
            let drag = DragValue::new(height).range(1e-6..=1e6).speed(speed).clamp_existing_to_range(false);
            ui.horizontal(|ui| (ui.label("height of the view"), ui.add(drag)));
        }
        Projection::OffCenter { .. } => drop(ui.label("the file gives the edges of the view")),
    }
    viewer.set_projection(projection);
    let mut chosen = None;
    for (number, name) in viewer.job.camera_names().iter().enumerate() {
        let name = if name.is_empty() { format!("camera {number}") } else { name.clone() };
        if ui.button(name).clicked() {
            chosen = Some(number);
        }
    }
    if let Some(number) = chosen {
        viewer.choose_camera(number);
    }
    ui.checkbox(&mut viewer.settings.axes, "axes");
    ui.checkbox(&mut viewer.settings.grid, "grid");
    ui.checkbox(&mut viewer.settings.full_screen, "full screen");
}
