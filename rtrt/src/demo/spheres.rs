//! `demo:spheres`: spheres and ellipsoids.

use super::builder::{DemoBuilder, loaded};
use super::paint;
use super::shape::Shape;
use crate::import::{ImportError, Loaded};
use glam::{Mat4, Quat, Vec3, vec3};
use rtrt_core::layout::Texture;
use rtrt_core::scene::{Camera, Join, Light, Material, MaterialIndex, Projection};
use std::f32::consts::PI;

/// The name of the scene in place of a path.
pub const SPHERES: &str = "demo:spheres";

/// Spheres on a floor: plain, textured, of glass, of metal, and drawn out to ellipsoids.
///
/// # Errors
/// Those of [`crate::import::load`]; the scene causes none.
pub fn spheres(join: &impl Join) -> Result<Loaded, ImportError> {
    let mut stage = DemoBuilder::new(SPHERES, join);
    let planks = stage.texture(paint::planks)?;
    let floor = stage.material("planks", [0.95; 3], 0.5, planks)?;
    let corner = vec3(-6.0, 0.0, -7.0);
    let shape = Shape::default().tiled(corner, Vec3::X * 12.0, Vec3::Z * 12.0, 2.4);
    stage.add("floor", shape, floor)?;
    stage.large()?;
    stage.small()?;
    let labels = stage.builder.labels();
    let mut scene = stage.builder.scene;
    scene.ambient = vec3(0.16, 0.17, 0.19);
    scene.background = vec3(0.55, 0.70, 0.90);
    scene.add_light(Light::sun(vec3(0.7, -1.0, -0.5)).color(vec3(1.15, 1.08, 0.95) * PI));
    scene.add_light(Light::point(vec3(-1.2, 2.4, 2.6)).color(vec3(0.55, 0.42, 0.28) * PI).reach(8.0));
    let camera = Camera {
        eye: vec3(0.4, 2.3, 5.2),
        look_at: vec3(0.0, 0.72, 0.0),
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.72 },
    };
    Ok(loaded(scene, labels, "table", camera, stage.builder.bvh_build_ms))
}

impl<J: Join> DemoBuilder<'_, J> {
    pub(super) fn glass(
        &mut self,
        name: &str,
        color: [f32; 3],
        alpha: f32,
    ) -> Result<MaterialIndex, ImportError> {
        self.named(name, Material::new(color).roughness(0.1).blend(alpha))
    }

    /// An ellipsoid with these half axes.
    fn ball(
        &mut self,
        name: &str,
        material: MaterialIndex,
        center: Vec3,
        size: Vec3,
        turn: Quat,
    ) -> Result<(), ImportError> {
        let place = Mat4::from_scale_rotation_translation(size, turn, center);
        self.sphere(name, material, place)?;
        Ok(())
    }

    /// A globe of tiles, two of glass with something in them, a disc and an egg.
    fn large(&mut self) -> Result<(), ImportError> {
        let tiles = self.texture(paint::tiles)?;
        let tiles =
            self.material("tiles", [1.0; 3], 0.25, Texture { turn: [[4.0, 0.0], [0.0, 2.0]], ..tiles })?;
        let tilt = Quat::from_rotation_z(0.4) * Quat::from_rotation_y(0.6);
        self.ball("globe", tiles, vec3(-1.45, 0.95, -0.6), Vec3::splat(0.95), tilt)?;
        let gold = self.named("gold", Material::new([0.9, 0.6, 0.2]).metallic(1.0).roughness(0.3))?;
        for (name, center, color) in [
            ("red glass", vec3(0.35, 0.62, 0.9), [0.95, 0.25, 0.1]),
            ("blue glass", vec3(1.3, 0.75, 0.2), [0.1, 0.35, 0.95]),
        ] {
            let glass = self.glass(name, color, 0.3)?;
            let inside = format!("in the {name}");
            self.ball(name, glass, center, Vec3::splat(center.y), Quat::IDENTITY)?;
            self.ball(&inside, gold, center - Vec3::Y * 0.1, Vec3::splat(0.25), Quat::IDENTITY)?;
        }
        let jade = self.painted("jade", [0.25, 0.6, 0.4], 0.3)?;
        self.ball("disc", jade, vec3(0.55, 1.55, -1.9), vec3(1.1, 1.1, 0.12), Quat::from_rotation_y(-0.5))?;
        let egg = self.painted("shell", [0.85, 0.8, 0.7], 0.6)?;
        self.ball("egg", egg, vec3(-0.35, 0.42, 1.55), vec3(0.3, 0.42, 0.3), Quat::IDENTITY)
    }

    /// A spiral of beads.
    fn small(&mut self) -> Result<(), ImportError> {
        const BEADS: u32 = 60;
        let colors = [("red", [0.8, 0.2, 0.2]), ("yellow", [0.85, 0.7, 0.25]), ("blue", [0.25, 0.5, 0.8])];
        let beads = colors.map(|(name, color)| self.painted(name, color, 0.3));
        let beads = beads.into_iter().collect::<Result<Vec<_>, _>>()?;
        for bead in 0..BEADS {
            let share = bead as f32 / BEADS as f32;
            let (sin, cos) = libm::sincosf(share * 4.0 * core::f32::consts::TAU);
            let radius = 0.03 + 0.05 * share;
            let center =
                vec3(2.6 + 0.7 * share * cos, radius + 1.8 * (1.0 - share), -1.4 + 0.7 * share * sin);
            let paint = beads[bead as usize % beads.len()];
            self.ball(&format!("bead {bead}"), paint, center, Vec3::splat(radius), Quat::IDENTITY)?;
        }
        Ok(())
    }
}
