//! `demo:glass`: light through colored panes.

use super::builder::{DemoBuilder, loaded};
use super::noise::hash;
use super::shape::Shape;
use crate::import::{ImportError, Loaded};
use glam::{Vec3, vec3};
use rtrt_core::scene::{Camera, Join, Light, Material, MaterialIndex, Projection};
use std::f32::consts::PI;

/// The lower and the upper corner of the room.
const ROOM: [Vec3; 2] = [vec3(-1.9, 0.0, -2.2), vec3(2.6, 3.4, 4.6)];
/// The name of the scene in place of a path.
pub const GLASS: &str = "demo:glass";

/// The colors of the panes.
const COLORS: [(&str, [f32; 3]); 6] = [
    ("red", [0.95, 0.04, 0.03]),
    ("blue", [0.02, 0.12, 0.90]),
    ("yellow", [0.98, 0.62, 0.02]),
    ("green", [0.02, 0.60, 0.12]),
    ("violet", [0.55, 0.03, 0.70]),
    ("cyan", [0.02, 0.65, 0.75]),
];
/// Panes beside and above one another.
const PANES: [u32; 2] = [6, 7];
/// The side of a pane.
const PANE: f32 = 0.36;
/// The window's lower corner at the back.
const CORNER: Vec3 = vec3(-1.9, 0.35, -1.35);

/// A window of stained glass whose colors the sun throws on a wall and a floor; two sheets of
/// glass that overlap, and a ball within a ball of glass.
///
/// # Errors
/// Those of [`crate::import::load`]; the scene causes none.
pub fn glass(join: &impl Join) -> Result<Loaded, ImportError> {
    let mut stage = DemoBuilder::new(GLASS, join);
    stage.glass_room()?;
    stage.stained_window()?;
    stage.sheets()?;
    let labels = stage.builder.labels();
    let mut scene = stage.builder.scene;
    scene.ambient = vec3(0.15, 0.155, 0.17);
    scene.background = vec3(0.55, 0.70, 0.90);
    scene.add_light(Light::sun(vec3(1.0, -0.52, -0.42)).color(vec3(22.0, 20.5, 18.0) * PI));
    scene.add_light(Light::point(vec3(0.8, 3.0, 2.6)).color(vec3(0.16, 0.16, 0.19) * PI).reach(9.0));
    let camera = Camera {
        eye: vec3(1.15, 1.75, 3.9),
        look_at: vec3(0.05, 0.98, -0.8),
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.80 },
    };
    Ok(loaded(scene, labels, "window", camera, stage.builder.bvh_build_ms))
}

impl<J: Join> DemoBuilder<'_, J> {
    /// Glass with a glow in its color, as light that passes through would give it.
    fn glowing(
        &mut self,
        name: &str,
        color: [f32; 3],
        alpha: f32,
        glow: f32,
    ) -> Result<MaterialIndex, ImportError> {
        let glass = Material::new(color).roughness(0.15).emission(color.map(|c| c * glow));
        self.named(name, glass.blend(alpha))
    }

    /// A closed room with an opening for the window.
    fn glass_room(&mut self) -> Result<(), ImportError> {
        let floor = self.painted("floor", [0.60, 0.56, 0.50], 0.7)?;
        let wall = self.painted("wall", [0.80, 0.78, 0.74], 0.95)?;
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        let [low, high] = ROOM;
        let size = high - low;
        self.add("floor", Shape::default().tiled(low, x * size.x, z * size.z, 1.0), floor)?;
        let (from, to) = (CORNER, CORNER + vec3(0.0, PANES[1] as f32, PANES[0] as f32) * PANE);
        let left = |z: f32, y: f32| vec3(low.x, y, z);
        let walls = Shape::default()
            .tiled(low, x * size.x, y * size.y, 1.0)
            .tiled(low + z * size.z, x * size.x, y * size.y, 1.0)
            .tiled(low + x * size.x, z * size.z, y * size.y, 1.0)
            .tiled(high, x * -size.x, z * -size.z, 1.0)
            // Around the window: behind, in front, below, above.
            .tiled(low, z * (from.z - low.z), y * size.y, 1.0)
            .tiled(left(to.z, low.y), z * (high.z - to.z), y * size.y, 1.0)
            .tiled(left(from.z, low.y), z * (to.z - from.z), y * (from.y - low.y), 1.0)
            .tiled(left(from.z, to.y), z * (to.z - from.z), y * (high.y - to.y), 1.0);
        self.add("walls", walls, wall)
    }

    /// Panes between bars of lead.
    fn stained_window(&mut self) -> Result<(), ImportError> {
        let lead = self.painted("lead", [0.03; 3], 0.4)?;
        let size = Vec3::new(0.0, PANES[1] as f32 * PANE, PANES[0] as f32 * PANE);
        let mut panes: [Shape; COLORS.len()] = Default::default();
        for row in 0..PANES[1] {
            for column in 0..PANES[0] {
                let color = (hash(column, row, 5) * COLORS.len() as f32) as usize % COLORS.len();
                let corner = CORNER + vec3(0.0, row as f32, column as f32) * PANE;
                let pane = std::mem::take(&mut panes[color]);
                panes[color] = pane.tiled(corner, Vec3::Z * PANE, Vec3::Y * PANE, 1.0);
            }
        }
        for (shape, (name, color)) in panes.into_iter().zip(COLORS) {
            let glass = self.glowing(&format!("{name} glass"), color, 0.88, 0.4)?;
            self.add(&format!("{name} panes"), shape, glass)?;
        }
        let bar = |from: Vec3, to: Vec3, half: f32| (from - Vec3::splat(half), to + Vec3::splat(half));
        let mut bars = Shape::default();
        for row in 0..=PANES[1] {
            let from = CORNER + Vec3::Y * PANE * row as f32;
            let half = if row % PANES[1] == 0 { 0.05 } else { 0.014 };
            let (low, high) = bar(from, from + Vec3::Z * size.z, half);
            bars = bars.cuboid(low, high, 1.0);
        }
        for column in 0..=PANES[0] {
            let from = CORNER + Vec3::Z * PANE * column as f32;
            let half = if column % PANES[0] == 0 { 0.05 } else { 0.014 };
            let (low, high) = bar(from, from + Vec3::Y * size.y, half);
            bars = bars.cuboid(low, high, 1.0);
        }
        self.add("bars", bars, lead)
    }

    /// Two overlapping sheets on the floor, and a ball within a ball of glass.
    fn sheets(&mut self) -> Result<(), ImportError> {
        let red = self.glowing("red sheet", [0.95, 0.15, 0.05], 0.5, 0.1)?;
        let blue = self.glowing("blue sheet", [0.05, 0.25, 0.95], 0.5, 0.1)?;
        let (up, sheet) = (Vec3::Y * 0.9, Shape::default);
        self.add("red sheet", sheet().tiled(vec3(0.15, 0.0, 0.95), vec3(0.75, 0.0, 0.35), up, 1.0), red)?;
        self.add("blue sheet", sheet().tiled(vec3(0.35, 0.0, 1.35), vec3(0.80, 0.0, -0.45), up, 1.0), blue)?;
        let clear = self.glowing("clear glass", [0.75, 0.95, 0.85], 0.25, 0.0)?;
        let gold = self.painted("gold", [0.85, 0.55, 0.12], 0.3)?;
        let middle = vec3(1.55, 0.36, 0.2);
        self.add("glass ball", Shape::default().ellipsoid(middle, 0.36, 0.36), clear)?;
        self.add("gold ball", Shape::default().ellipsoid(middle - Vec3::Y * 0.12, 0.17, 0.17), gold)
    }
}
