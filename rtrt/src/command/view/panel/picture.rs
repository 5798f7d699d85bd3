//! Samples, shadows, debug views, exposure.

use crate::command::parse::SHADOWS;
use crate::command::view::viewer::{Settings, Viewer};
use egui::{Checkbox, ComboBox, DragValue, Ui};
use rtrt::debug::DebugView;
use rtrt_core::backend::ToneMap;
use rtrt_core::scene::Setup;

/// The height of a menu that shows all of its entries, where the window has room.
const ALL: f32 = 300.0;

/// How the picture is made, and which one.
pub fn picture(ui: &mut Ui, settings: &mut Settings, is_gpu: bool) {
    ui.horizontal(|ui| {
        ui.label("samples");
        for samples in [1, 4, 16] {
            ui.selectable_value(&mut settings.samples, samples, samples.to_string());
        }
    });
    let chosen = SHADOWS.iter().find(|(_, how)| *how == settings.shadows);
    let chosen = chosen.map_or("", |(name, _)| *name);
    ComboBox::from_label("shadows").selected_text(chosen).show_ui(ui, |ui| {
        for (name, how) in SHADOWS {
            ui.selectable_value(&mut settings.shadows, how, name);
        }
    });
    let layers = DragValue::new(&mut settings.layers).range(1..=Setup::MAX_LAYERS).speed(0.1);
    ui.horizontal(|ui| (ui.label("transparency depth"), ui.add(layers)));
    let hybrid = Checkbox::new(&mut settings.hybrid, "hybrid, on a GPU");
    ui.add_enabled(is_gpu, hybrid);
    let fps = DragValue::new(&mut settings.fps).range(1.0..=240.0).speed(0.5);
    ui.horizontal(|ui| (ui.label("frames a second while moving"), ui.add(fps)));
    let name = |view| {
        DebugView::ALL.iter().find(|(_, known)| Some(*known) == view).map_or("picture", |(name, _)| *name)
    };
    let shown = ComboBox::from_label("shown").selected_text(name(settings.debug)).height(ALL);
    shown.show_ui(ui, |ui| {
        ui.selectable_value(&mut settings.debug, None, "picture");
        for (name, view) in DebugView::ALL {
            ui.selectable_value(&mut settings.debug, Some(view), name);
        }
    });
}

/// Exposure and tone map.
pub fn exposure(ui: &mut Ui, viewer: &mut Viewer) {
    let settings = &mut viewer.settings;
    let tone_map = ToneMap::ALL.iter().find(|(_, map)| *map == settings.tone_map);
    let name = tone_map.map_or("", |(name, _)| *name);
    ComboBox::from_label("tone map").selected_text(name).show_ui(ui, |ui| {
        for (name, map) in ToneMap::ALL {
            ui.selectable_value(&mut settings.tone_map, map, name);
        }
    });
    let most = Setup::MAX_STOPS;
    let stops = DragValue::new(&mut settings.exposure).range(-most..=most).speed(0.02).suffix(" stops");
    let meters = ui.horizontal(|ui| {
        ui.label("exposure");
        ui.add(stops);
        ui.button("auto").clicked()
    });
    if meters.inner {
        viewer.meter();
    }
}
