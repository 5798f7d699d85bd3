//! The panel: settings and lights.

use super::overlay::MARGIN;
use super::viewer::{Settings, Viewer};
use crate::command::parse::SHADOWS;
use egui::{Align2, Checkbox, CollapsingHeader, ComboBox, Context, DragValue, ScrollArea, Ui, Window, vec2};
use glam::Vec3;
use rtrt::debug::DebugView;
use rtrt_core::backend::ToneMap;
use rtrt_core::scene::{Light, LightKind, Setup};

/// Shows the panel, and applies changes.
pub fn show(context: &Context, viewer: &mut Viewer) {
    let mut is_open = viewer.settings.panel;
    let corner = context.content_rect().right_top() + vec2(-MARGIN, MARGIN);
    let window = Window::new("rtrt").open(&mut is_open).default_width(260.0);
    let window = window.pivot(Align2::RIGHT_TOP).default_pos(corner);
    window.show(context, |ui| {
        ScrollArea::vertical().show(ui, |ui| {
            let is_gpu = viewer.is_gpu();
            picture(ui, &mut viewer.settings, is_gpu);
            ui.separator();
            lights(ui, viewer);
            ui.separator();
            exposure(ui, viewer);
            if viewer.job.surrounded.has_environment {
                environment(ui, viewer);
            }
        });
    });
    viewer.settings.panel = is_open;
}

fn picture(ui: &mut Ui, settings: &mut Settings, is_gpu: bool) {
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
    ComboBox::from_label("shown").selected_text(name(settings.debug)).show_ui(ui, |ui| {
        ui.selectable_value(&mut settings.debug, None, "picture");
        for (name, view) in DebugView::ALL {
            ui.selectable_value(&mut settings.debug, Some(view), name);
        }
    });
}

fn exposure(ui: &mut Ui, viewer: &mut Viewer) {
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

fn environment(ui: &mut Ui, viewer: &mut Viewer) {
    let scene = &viewer.job.scene;
    let before = (scene.environment_rotation, scene.environment_intensity, scene.environment_blur);
    let (mut rotation, mut intensity, mut blur) = before;
    ui.horizontal(|ui| (ui.label("environment's turn"), ui.drag_angle(&mut rotation)));
    ui.horizontal(|ui| {
        ui.label("light");
        ui.add(DragValue::new(&mut intensity).range(0.0..=65_536.0).speed(0.01));
        ui.label("blur behind");
        ui.add(DragValue::new(&mut blur).range(0.0..=1.0).speed(0.01));
    });
    if (rotation, intensity, blur) != before {
        viewer.job.turn_environment(rotation.clamp(-600.0, 600.0), intensity);
        viewer.job.scene.environment_blur = blur;
        viewer.touch();
    }
}

fn lights(ui: &mut Ui, viewer: &mut Viewer) {
    let scene = &mut viewer.job.scene;
    let (mut ambient, mut background) = (scene.ambient, scene.background);
    let mut lights = scene.lights().to_vec();
    ui.horizontal(|ui| (ui.label("ambient"), tone(ui, &mut ambient)));
    ui.horizontal(|ui| (ui.label("background"), tone(ui, &mut background)));
    for (number, light) in lights.iter_mut().enumerate() {
        let kind = match light.kind {
            LightKind::Point => "point light",
            LightKind::Spot => "spot light",
            LightKind::Sun => "sun",
        };
        let header = CollapsingHeader::new(format!("{number}: {kind}")).id_salt(number);
        header.default_open(number == 0).show(ui, |ui| edit(ui, light));
    }
    let is_same = scene.ambient == ambient && scene.background == background;
    if is_same && scene.lights() == lights {
        return;
    }
    (scene.ambient, scene.background) = (ambient, background);
    *scene.lights_mut() = lights;
    if let Err(error) = viewer.job.lights_changed() {
        viewer.announce(error);
    }
    viewer.has_own_lights = true;
    viewer.has_own_colors |= !is_same;
    viewer.touch();
}

/// A button for a color. Without a change the color keeps its bits.
fn tone(ui: &mut Ui, color: &mut Vec3) {
    let mut shown = color.to_array();
    if ui.color_edit_button_rgb(&mut shown).changed() {
        *color = shown.into();
    }
}

fn edit(ui: &mut Ui, light: &mut Light) {
    let is_sun = light.kind == LightKind::Sun;
    if !is_sun {
        vector(ui, "position", &mut light.position);
    }
    if light.kind != LightKind::Point {
        aim(ui, &mut light.direction);
    }
    if light.kind == LightKind::Spot {
        ui.horizontal(|ui| (ui.label("angle"), angle(ui, &mut light.outer)));
        light.inner = light.inner.min(light.outer);
    }
    power(ui, &mut light.color);
    if is_sun {
        ui.horizontal(|ui| {
            ui.label("radius");
            if ui.drag_angle(&mut light.radius).changed() {
                light.radius = light.radius.clamp(0.0, 0.78);
            }
        });
    } else {
        limit(ui, &mut light.reach);
        ui.checkbox(&mut light.inverse_square, "fades with the square of the distance");
        size(ui, &mut light.radius);
    }
}

/// A light's radius, world units.
fn size(ui: &mut Ui, radius: &mut f32) {
    let speed = f64::from(radius.max(0.1)) * 0.01;
    let drag = DragValue::new(radius).speed(speed).range(0.0..=1e6).clamp_existing_to_range(false);
    ui.horizontal(|ui| (ui.label("radius"), ui.add(drag)));
}

/// An angle of a cone, within the range of lights.
fn angle(ui: &mut Ui, angle: &mut f32) {
    if ui.drag_angle(angle).changed() {
        *angle = angle.clamp(0.01, std::f32::consts::FRAC_PI_2);
    }
}

/// The direction of a light, which is never 0.
fn aim(ui: &mut Ui, direction: &mut Vec3) {
    let mut next = *direction;
    vector(ui, "direction", &mut next);
    if next.abs().max_element() > 1e-9 {
        *direction = next;
    }
}

/// Three numbers.
fn vector(ui: &mut Ui, name: &str, v: &mut Vec3) {
    let speed = f64::from(v.abs().max_element().max(0.1)) * 0.01;
    ui.horizontal(|ui| {
        ui.label(name);
        for number in [&mut v.x, &mut v.y, &mut v.z] {
            let drag = DragValue::new(number).speed(speed).range(-1e6..=1e6);
            ui.add(drag.clamp_existing_to_range(false));
        }
    });
}

/// The brightest channel of a color, and the color at full brightness.
fn power(ui: &mut Ui, color: &mut Vec3) {
    let before = color.max_element().max(0.0);
    let mut power = before;
    let shown = if before > 0.0 { *color / before } else { Vec3::ONE };
    let mut next = shown;
    ui.horizontal(|ui| {
        ui.label("power");
        let speed = f64::from(before.max(0.1)) * 0.01;
        ui.add(DragValue::new(&mut power).speed(speed).range(0.0..=1e6).clamp_existing_to_range(false));
        tone(ui, &mut next);
    });
    if power != before || next != shown {
        *color = next * power;
    }
}

/// The reach of a light, if it is limited.
fn limit(ui: &mut Ui, reach: &mut Option<f32>) {
    ui.horizontal(|ui| {
        let mut is_limited = reach.is_some();
        if ui.checkbox(&mut is_limited, "reach").changed() {
            *reach = is_limited.then_some(10.0);
        }
        if let Some(reach) = reach {
            let speed = f64::from(*reach) * 0.01;
            ui.add(DragValue::new(reach).speed(speed).range(1e-3..=1e6).clamp_existing_to_range(false));
        }
    });
}
