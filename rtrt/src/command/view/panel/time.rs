//! The animation of the panel: a timeline.

use crate::command::view::viewer::Viewer;
use egui::{ComboBox, DragValue, Slider, Ui};

/// Play, time, speed, and the animations of the file.
pub fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let Some(end) = viewer.job.end() else {
        ui.label("nothing in the scene is animated");
        return;
    };
    let mut time = viewer.time().map_or(0.0, |(now, _)| now);
    ui.horizontal(|ui| {
        if ui.button(if viewer.is_playing() { "stop" } else { "play" }).clicked() {
            viewer.toggle_play();
        }
        if ui.add(Slider::new(&mut time, 0.0..=end).fixed_decimals(2).suffix(" s")).changed() {
            viewer.scrub(time);
        }
    });
    let speed = DragValue::new(&mut viewer.settings.speed).range(0.01..=100.0).speed(0.01).suffix(" times");
    ui.horizontal(|ui| (ui.label("speed"), ui.add(speed)));
    let names = viewer.job.animation_names().to_vec();
    if names.len() < 2 {
        return;
    }
    let name = |number: usize| match names.get(number) {
        Some(name) if !name.is_empty() => name.clone(),
        _ => format!("animation {number}"),
    };
    let playing = viewer.job.played_animation();
    let mut chosen = None;
    ComboBox::from_label("animation").selected_text(playing.map_or("all".into(), name)).show_ui(ui, |ui| {
        for number in (0..names.len()).map(Some).chain([None]) {
            let text = number.map_or("all".into(), name);
            if ui.selectable_label(number == playing, text).clicked() {
                chosen = Some(number);
            }
        }
    });
    if let Some(number) = chosen {
        viewer.choose_animation(number);
    }
}
