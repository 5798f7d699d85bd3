//! Lines over the picture: axes, a grid on the floor, what is selected, the pivot.

use super::motion::projected;
use super::viewer::Viewer;
use egui::{Align2, Color32, Context, FontId, LayerId, Painter, Pos2, Stroke, pos2, vec2};
use glam::DVec3;
use rtrt_core::scene::Camera;

/// The length of an axis in the corner, units of the user interface.
const AXIS: f32 = 36.0;
/// Squares of the grid from its middle to its edge, at most.
const SQUARES: i32 = 20;
/// Axes with their names and colors.
const AXES: [(&str, DVec3, Color32); 3] = [
    ("x", DVec3::X, Color32::from_rgb(235, 75, 75)),
    ("y", DVec3::Y, Color32::from_rgb(110, 200, 70)),
    ("z", DVec3::Z, Color32::from_rgb(85, 140, 250)),
];

/// A picture on the screen, and its painter.
struct Sheet<'a> {
    painter: Painter,
    camera: &'a Camera,
    size: [u32; 2],
    /// Pixels a unit of the user interface.
    scale: f32,
}

/// Draws the lines that are wanted.
pub fn show(context: &Context, viewer: &Viewer) {
    let painter = context.layer_painter(LayerId::background());
    let scale = context.pixels_per_point();
    let sheet = Sheet { painter, camera: &viewer.job.camera, size: viewer.size(), scale };
    if viewer.settings.grid
        && let Some((low, high)) = viewer.job.scene.extent()
    {
        sheet.grid(low.as_dvec3(), high.as_dvec3());
    }
    if viewer.selection.is_some() {
        let (low, high) = viewer.framed_box();
        sheet.edges(low, high);
    }
    if let Some(pivot) = viewer.turns_around() {
        sheet.pivot(pivot);
    }
    if viewer.settings.axes {
        sheet.axes(context.content_rect().right_bottom() - vec2(AXIS, AXIS) * 1.5);
    }
}

impl Sheet<'_> {
    fn place(&self, point: DVec3) -> Option<Pos2> {
        let [x, y] = projected(self.camera, self.size, point)?;
        Some(pos2(x as f32, y as f32) / self.scale)
    }

    /// A line between two points, as far as it is in front of the camera.
    fn line(&self, a: DVec3, b: DVec3, stroke: Stroke) {
        // The nearest part that is in front of it, found by halves.
        let (mut a, mut b) = (a, b);
        if self.place(a).is_none() {
            std::mem::swap(&mut a, &mut b);
        }
        let Some(from) = self.place(a) else { return };
        let to = self.place(b).or_else(|| {
            let (mut near, mut far) = (0.0, 1.0);
            for _ in 0..16 {
                let middle = (near + far) * 0.5;
                if self.place(a.lerp(b, middle)).is_some() { near = middle } else { far = middle }
            }
            self.place(a.lerp(b, near))
        });
        if let Some(to) = to {
            self.painter.line_segment([from, to], stroke);
        }
    }

    /// A grid on the floor of the scene's box, in squares of a power of ten.
    fn grid(&self, low: DVec3, high: DVec3) {
        let half = ((high - low) * 0.5).max_element();
        let square = square(half);
        let middle = ((low + high) * 0.5 / square).round() * square;
        let count = ((half / square).ceil() as i32).clamp(1, SQUARES);
        let reach = f64::from(count) * square;
        for number in -count..=count {
            let by = f64::from(number) * square;
            let strong = if number == 0 { 110 } else { 50 };
            let stroke = Stroke::new(1.0, Color32::from_white_alpha(strong));
            let at = |x: f64, z: f64| DVec3::new(middle.x + x, low.y, middle.z + z);
            self.line(at(by, -reach), at(by, reach), stroke);
            self.line(at(-reach, by), at(reach, by), stroke);
        }
        let text = format!("a square is {square} wide");
        let corner = self.painter.clip_rect().left_bottom() + vec2(8.0, -8.0);
        self.painter.text(corner, Align2::LEFT_BOTTOM, text, FontId::proportional(12.0), Color32::LIGHT_GRAY);
    }

    /// The edges of a box.
    fn edges(&self, low: DVec3, high: DVec3) {
        let corner = |bits: usize| {
            DVec3::new(
                if bits & 1 == 0 { low.x } else { high.x },
                if bits & 2 == 0 { low.y } else { high.y },
                if bits & 4 == 0 { low.z } else { high.z },
            )
        };
        let stroke = Stroke::new(1.0, Color32::from_rgb(255, 190, 60));
        for bits in 0..8 {
            for axis in [1, 2, 4].into_iter().filter(|axis| bits & axis == 0) {
                self.line(corner(bits), corner(bits | axis), stroke);
            }
        }
    }

    fn pivot(&self, pivot: DVec3) {
        if let Some(place) = self.place(pivot) {
            self.painter.circle_stroke(place, 5.0, Stroke::new(2.0, Color32::from_black_alpha(160)));
            self.painter.circle_stroke(place, 5.0, Stroke::new(1.0, Color32::WHITE));
        }
    }

    /// The directions of the axes, from a point of the screen.
    fn axes(&self, middle: Pos2) {
        let Some(axes) = super::camera::axes(self.camera) else { return };
        let mut all = AXES.map(|(name, axis, color)| {
            let aside = vec2(axis.dot(axes.right) as f32, -axis.dot(axes.up) as f32);
            (axis.dot(axes.forward), name, aside * AXIS, color)
        });
        // Those that point away first.
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, name, aside, color) in all {
            self.painter.line_segment([middle, middle + aside], Stroke::new(2.0, color));
            let place = middle + aside * 1.25;
            self.painter.text(place, Align2::CENTER_CENTER, name, FontId::proportional(13.0), color);
        }
    }
}

/// The width of a square of which about ten reach from the middle of a scene to its edge.
fn square(half: f64) -> f64 {
    let exponent = (half.max(1e-30) / 10.0).log10().ceil();
    10.0_f64.powi(exponent as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_to_ten_squares_reach_the_edge() {
        for half in [1e-6, 0.99, 1.0, 1.01, 37.0, 1e7] {
            let count = half / square(half);
            assert!(count > 0.999 && count < 10.001, "{half}: {count}");
        }
    }
}
