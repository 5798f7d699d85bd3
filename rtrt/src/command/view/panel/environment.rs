//! What surrounds the scene.

use crate::command::parse::{Environment, environment};
use crate::command::view::viewer::{Viewer, named};
use egui::{ComboBox, DragValue, Id, Key, TextEdit, Ui};
use std::path::PathBuf;
use std::sync::Arc;

/// The environment, and how it is shown.
pub fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let current = viewer.environment();
    let mut chosen = None;
    let name = |environment: &Environment| match environment {
        Environment::At(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        other => named(other),
    };
    // The folder is read when the menu opens.
    let id = Id::unique("environments");
    let menu = ComboBox::from_label("environment").selected_text(name(&current)).show_ui(ui, |ui| {
        let known: Option<Arc<[Environment]>> = ui.data(|data| data.get_temp(id));
        let all = known.unwrap_or_else(|| offered(viewer));
        for known in &*all {
            if ui.selectable_label(*known == current, name(known)).clicked() {
                chosen = Some(known.clone());
            }
        }
        all
    });
    ui.data_mut(|data| {
        data.remove_temp::<Arc<[Environment]>>(id);
        if let Some(all) = menu.inner {
            data.insert_temp(id, all);
        }
    });
    ui.horizontal(|ui| {
        ui.label("its file");
        chosen = typed(ui).or(chosen.take());
    });
    if let Some(chosen) = chosen.filter(|chosen| *chosen != current) {
        viewer.open_environment(chosen);
    }
    if viewer.job.surrounded.has_environment {
        light(ui, viewer);
    }
}

/// The environments that can be chosen.
fn offered(viewer: &Viewer) -> Arc<[Environment]> {
    let files = viewer.environments().into_iter().map(Environment::At);
    [Environment::Nothing, Environment::Studio].into_iter().chain(files).collect()
}

/// A path that was typed, at Enter.
fn typed(ui: &mut Ui) -> Option<Environment> {
    let id = Id::unique("environment's path");
    let mut path: String = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let field = ui.add(TextEdit::singleline(&mut path).hint_text("path, then Enter"));
    let is_entered =
        field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) && !path.is_empty();
    let typed = is_entered.then(|| environment(PathBuf::from(&path)));
    ui.data_mut(|data| data.insert_temp(id, if is_entered { String::new() } else { path }));
    typed
}

/// Turn, brightness, blur.
fn light(ui: &mut Ui, viewer: &mut Viewer) {
    let scene = &viewer.job.scene;
    let before = (scene.environment_rotation, scene.environment_intensity, scene.environment_blur);
    let (mut rotation, mut intensity, mut blur) = before;
    ui.horizontal(|ui| {
        ui.label("turn");
        ui.drag_angle(&mut rotation);
        ui.label("intensity");
        ui.add(DragValue::new(&mut intensity).range(0.0..=65_536.0).speed(0.01));
    });
    ui.horizontal(|ui| {
        ui.label("blur behind");
        ui.add(DragValue::new(&mut blur).range(0.0..=1.0).speed(0.01));
    });
    if (rotation, intensity, blur) != before {
        viewer.job.turn_environment(rotation.clamp(-600.0, 600.0), intensity);
        viewer.job.scene.environment_blur = blur;
        viewer.touch();
    }
}
