//! The lights of the panel.

use super::fields::{coordinates, vector};
use super::tone::tone;
use crate::command::view::viewer::Viewer;
use egui::{CollapsingHeader, DragValue, Ui};
use glam::{DVec3, Vec3};
use rtrt_core::scene::{Light, LightKind};

/// All lights, and the ambient light and the background, which an environment replaces.
pub fn lights(ui: &mut Ui, viewer: &mut Viewer) {
    let origin = viewer.job.origin;
    let scene = &viewer.job.scene;
    let (mut ambient, mut background) = (scene.ambient, scene.background);
    let mut lights = scene.lights().to_vec();
    if !viewer.job.surrounded.has_environment {
        ui.horizontal(|ui| (ui.label("ambient"), tone(ui, &mut ambient)));
        ui.horizontal(|ui| (ui.label("background"), tone(ui, &mut background)));
    }
    for (number, light) in lights.iter_mut().enumerate() {
        let kind = match light.kind {
            LightKind::Point => "point light",
            LightKind::Spot => "spot light",
            LightKind::Sun => "sun",
        };
        let header = CollapsingHeader::new(format!("{number}: {kind}")).id_salt(number);
        header.default_open(number == 0).show(ui, |ui| edit(ui, light, origin));
    }
    let is_same = scene.ambient == ambient && scene.background == background;
    if is_same && scene.lights() == lights {
        return;
    }
    let scene = &mut *viewer.job.scene;
    (scene.ambient, scene.background) = (ambient, background);
    *scene.lights_mut() = lights;
    if let Err(error) = viewer.job.lights_changed() {
        viewer.announce(error);
    }
    viewer.has_own_lights = true;
    viewer.has_own_colors |= !is_same;
    viewer.touch();
}

/// A light. Its position is shown in the coordinates of the file, in which the scene's origin is this.
fn edit(ui: &mut Ui, light: &mut Light, origin: DVec3) {
    let is_sun = light.kind == LightKind::Sun;
    if !is_sun {
        coordinates(ui, "position", &mut light.position, origin);
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
