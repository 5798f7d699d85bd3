//! Lines over the picture: axes, a grid on the floor, what is selected, the pivot.
//!
//! What surfaces hide of a line is found by rays to some of its points, as many as a picture has time for. A buffer of
//! depths was refused: pictures that stay on a GPU would have to be read back for it.

use super::motion::{projected, screen_ends};
use super::viewer::Viewer;
use egui::{Align2, Color32, Context, FontId, LayerId, Painter, Pos2, Stroke, pos2, vec2};
use glam::DVec3;
use rtrt_core::scene::Camera;

/// The length of an axis in the corner, units of the user interface.
const AXIS: f32 = 36.0;
/// Squares of the grid from its middle to its edge, at most.
const SQUARES: i32 = 20;
/// Pixels between the points of a line that are tested, at least.
const STEP: f64 = 5.0;
/// Points of lines that are tested, at most: while things move, and at rest.
const TESTS: [f64; 2] = [1500.0, 6000.0];
/// A step in which a line comes into sight or goes is halved so often.
const HALVES: usize = 3;
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

/// A line between two points of space.
#[derive(Debug, Clone, Copy)]
struct Line {
    ends: [DVec3; 2],
    color: Color32,
    /// The color of what is behind a surface.
    hidden: Color32,
}

/// Draws the lines that are wanted.
pub fn show(context: &Context, viewer: &mut Viewer) {
    let painter = context.layer_painter(LayerId::background());
    let scale = context.pixels_per_point();
    let camera = viewer.job.camera;
    let sheet = Sheet { painter, camera: &camera, size: viewer.size(), scale };
    let mut lines = Vec::new();
    if viewer.settings.grid
        && let Some((low, high)) = viewer.job.scene.extent()
    {
        let origin = viewer.job.origin.y;
        sheet.grid(low.as_dvec3(), high.as_dvec3(), floor(low.y.into(), high.y.into(), origin), &mut lines);
    }
    if viewer.selection.is_some() {
        let (low, high) = viewer.framed_box();
        edges(low, high, &mut lines);
    }
    if !lines.is_empty() {
        let tests = TESTS[usize::from(viewer.is_settled())];
        match viewer.sight() {
            Some(is_seen) => sheet.lines(&lines, tests, is_seen),
            None => sheet.lines(&lines, 0.0, |_| true),
        }
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

    /// Draws lines, with so many tests of what is seen of them.
    fn lines(&self, lines: &[Line], tests: f64, is_seen: impl Fn(DVec3) -> bool) {
        let cut: Vec<_> = lines
            .iter()
            .filter_map(|line| Some((line, screen_ends(self.camera, self.size, line.ends)?)))
            .map(|(line, ends)| {
                let [a, b] = ends.map(|end| projected(self.camera, self.size, end).unwrap_or_default());
                (line, ends, libm::hypot(b[0] - a[0], b[1] - a[1]))
            })
            .collect();
        let pixels: f64 = cut.iter().map(|(.., pixels)| pixels).sum();
        let step = (pixels / tests.max(1.0)).max(STEP);
        for (line, ends, pixels) in cut {
            let steps = if tests > 0.0 { libm::ceil(pixels / step).max(1.0) as u32 } else { 1 };
            for ([from, to], is_seen) in runs(steps, |share| is_seen(self.between(ends, share))) {
                let color = if is_seen { line.color } else { line.hidden };
                let places = [from, to].map(|share| self.place(self.between(ends, share)));
                if let ([Some(from), Some(to)], true) = (places, color != Color32::TRANSPARENT) {
                    self.painter.line_segment([from, to], Stroke::new(1.0, color));
                }
            }
        }
    }

    /// The point at a share of the way between two others in the picture.
    fn between(&self, [a, b]: [DVec3; 2], share: f64) -> DVec3 {
        if matches!(self.camera.projection, rtrt_core::scene::Projection::Orthographic { .. }) {
            return a.lerp(b, share);
        }
        // Shares of the way in space are in proportion to those in the picture, over the depths.
        let [near, far] = [a, b].map(|end| super::camera::depth(self.camera, end).max(1e-9));
        a.lerp(b, share * near / (far + share * (near - far)))
    }

    /// A grid at a height, below the scene's box, in squares of a power of ten.
    fn grid(&self, low: DVec3, high: DVec3, floor: f64, lines: &mut Vec<Line>) {
        let half = ((high - low) * 0.5).max_element();
        let square = square(half);
        let middle = ((low + high) * 0.5 / square).round() * square;
        let count = ((half / square).ceil() as i32).clamp(1, SQUARES);
        let reach = f64::from(count) * square;
        for number in -count..=count {
            let by = f64::from(number) * square;
            let strong = if number == 0 { 110 } else { 50 };
            let at = |x: f64, z: f64| DVec3::new(middle.x + x, floor, middle.z + z);
            let both = [[at(by, -reach), at(by, reach)], [at(-reach, by), at(reach, by)]];
            lines.extend(both.map(|ends| Line {
                ends,
                color: Color32::from_white_alpha(strong),
                hidden: Color32::TRANSPARENT,
            }));
        }
        let text = format!("a square is {square} wide");
        let corner = self.painter.clip_rect().left_bottom() + vec2(8.0, -8.0);
        self.painter.text(corner, Align2::LEFT_BOTTOM, text, FontId::proportional(12.0), Color32::LIGHT_GRAY);
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

/// The height of the floor: that of the file's origin if it is in the lowest tenth of the scene, else the lowest point. A
/// room has walls below its floor.
fn floor(low: f64, high: f64, origin: f64) -> f64 {
    let zero = -origin;
    if (low..=low + (high - low) * 0.1).contains(&zero) { zero } else { low }
}

/// The edges of a box. They are faint behind surfaces, so that what is selected from the list is found.
fn edges(low: DVec3, high: DVec3, lines: &mut Vec<Line>) {
    let corner = |bits: usize| {
        DVec3::new(
            if bits & 1 == 0 { low.x } else { high.x },
            if bits & 2 == 0 { low.y } else { high.y },
            if bits & 4 == 0 { low.z } else { high.z },
        )
    };
    let (color, hidden) =
        (Color32::from_rgb(255, 190, 60), Color32::from_rgba_unmultiplied(255, 190, 60, 45));
    for bits in 0..8 {
        let others = [1, 2, 4].into_iter().filter(|axis| bits & axis == 0).map(|axis| bits | axis);
        lines.extend(others.map(|other| Line { ends: [corner(bits), corner(other)], color, hidden }));
    }
}

/// The parts of a line that are in sight and those that are not, in turn, as shares of 0 to 1: the ends of so many equal
/// steps are tested, and where they differ, halves of the step.
fn runs(steps: u32, is_seen: impl Fn(f64) -> bool) -> Vec<([f64; 2], bool)> {
    let mut runs = Vec::new();
    let (mut from, mut last, mut is_on) = (0.0, 0.0, is_seen(0.0));
    for number in 1..=steps {
        let here = f64::from(number) / f64::from(steps);
        let is_here = is_seen(here);
        if is_here != is_on {
            let (mut before, mut after) = (last, here);
            for _ in 0..HALVES {
                let middle = (before + after) * 0.5;
                if is_seen(middle) == is_on { before = middle } else { after = middle }
            }
            let change = (before + after) * 0.5;
            runs.push(([from, change], is_on));
            (from, is_on) = (change, is_here);
        }
        last = here;
    }
    runs.push(([from, 1.0], is_on));
    runs
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
    fn parts_in_sight_follow_parts_out_of_sight() {
        let found = runs(10, |share| !(0.33..0.71).contains(&share));
        assert_eq!(found.iter().map(|(_, is_seen)| *is_seen).collect::<Vec<_>>(), [true, false, true]);
        let ends: Vec<f64> = found.iter().flat_map(|(ends, _)| *ends).collect();
        let near = |a: f64, b: f64| (a - b).abs() < 0.1 / 8.0;
        assert!(ends[0] == 0.0 && near(ends[1], 0.33) && near(ends[3], 0.71) && ends[5] == 1.0, "{ends:?}");
        assert!(ends[1] == ends[2] && ends[3] == ends[4]);
        assert_eq!(runs(1, |_| false), [([0.0, 1.0], false)]);
    }

    #[test]
    fn the_floor_is_at_the_origin_or_at_the_lowest_point() {
        assert_eq!(floor(-0.1, 9.0, 0.0), 0.0);
        assert_eq!(floor(-1.0, 1.0, 0.0), -1.0);
        assert_eq!(floor(3.0, 4.0, 0.0), 3.0);
        assert_eq!(floor(-1000.5, -990.0, 1000.0), -1000.0);
    }

    #[test]
    fn one_to_ten_squares_reach_the_edge() {
        for half in [1e-6, 0.99, 1.0, 1.01, 37.0, 1e7] {
            let count = half / square(half);
            assert!(count > 0.999 && count < 10.001, "{half}: {count}");
        }
    }
}
