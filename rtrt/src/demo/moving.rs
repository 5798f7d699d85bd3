//! `demo:moving`: objects with a velocity and a rotation of their own.

use super::builder::{DemoBuilder, loaded};
use super::paint;
use super::shape::Shape;
use crate::import::{Animation, ImportError, Loaded};
use glam::{Mat4, Quat, Vec3, vec3};
use rtrt_core::scene::{
    Camera, InstanceIndex, Join, Light, Material, MaterialIndex, MeshIndex, Motion, Projection,
};
use std::f32::consts::PI;

/// The name of the scene in place of a path.
pub const MOVING: &str = "demo:moving";

/// The number of lanes, and their distance.
const LANES: u32 = 7;
const APART: f32 = 1.5;
/// The number of objects on a lane.
const OBJECTS: u32 = 14;
/// The end of all motions, seconds.
const END: f64 = 4.0;

/// The shapes on the lanes.
struct Goods {
    cube: MeshIndex,
    board: MaterialIndex,
    metal: MaterialIndex,
    glass: [MaterialIndex; 3],
}

/// Lanes of boxes, ellipsoids and panes of glass above a floor. Each object flies along its lane,
/// every other lane the other way, and turns around an axis of its own; the animation is
/// [`Motion`]s, which end after four seconds.
///
/// # Errors
/// Those of [`crate::import::load`]; the scene causes none.
pub fn moving(join: &impl Join) -> Result<Loaded, ImportError> {
    let mut stage = DemoBuilder::new(MOVING, join);
    let planks = stage.texture(paint::planks)?;
    let floor = stage.material("planks", [0.95; 3], 0.6, planks)?;
    let shape = Shape::default().tiled(vec3(-16.0, 0.0, -9.0), Vec3::X * 32.0, Vec3::Z * 18.0, 2.4);
    stage.add("floor", shape, floor)?;
    let motions = stage.lanes()?;
    let labels = stage.builder.labels();
    let mut scene = stage.builder.scene;
    scene.ambient = vec3(0.16, 0.17, 0.19);
    scene.background = vec3(0.55, 0.70, 0.90);
    scene.add_light(Light::sun(vec3(0.4, -1.0, -0.35)).color(vec3(0.95, 0.9, 0.8) * PI).radius(0.02));
    scene.add_light(Light::point(vec3(-3.0, 4.5, 3.0)).color(vec3(0.5, 0.4, 0.3) * PI).reach(12.0));
    let camera = Camera {
        eye: vec3(3.2, 5.4, 9.5),
        look_at: vec3(0.0, 0.6, -0.4),
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.75 },
    };
    let animation = Some(Animation::of_motions(MOVING, motions, END));
    Ok(Loaded { animation, ..loaded(scene, labels, "lanes", camera, stage.builder.bvh_build_ms) })
}

impl<J: Join> DemoBuilder<'_, J> {
    /// The objects with their starts and motions.
    fn lanes(&mut self) -> Result<Vec<(InstanceIndex, Mat4, Motion)>, ImportError> {
        let board = self.texture(paint::board)?;
        let tints = [
            ("red glass", [0.9, 0.25, 0.15]),
            ("green glass", [0.15, 0.7, 0.3]),
            ("blue glass", [0.15, 0.35, 0.9]),
        ];
        let [red, green, blue] = tints.map(|(name, tint)| self.glass(name, tint, 0.35));
        let goods = Goods {
            cube: self
                .builder
                .add_mesh(MOVING, Shape::default().cuboid(Vec3::splat(-1.0), Vec3::ONE, 0.8).0)?,
            board: self.material("board", [1.0; 3], 0.8, board)?,
            metal: self.named("metal", Material::new([0.9, 0.7, 0.4]).metallic(1.0).roughness(0.3))?,
            glass: [red?, green?, blue?],
        };
        let mut motions = Vec::new();
        for lane in 0..LANES {
            let way = if lane % 2 == 0 { 1.0 } else { -1.0 };
            let z = (lane as f32 - (LANES - 1) as f32 * 0.5) * APART;
            for number in 0..OBJECTS {
                let random = |seed: u32| super::noise::hash(number, lane, seed);
                let x = (number as f32 - (OBJECTS - 1) as f32 * 0.5) * 1.7 + random(1) * 0.5;
                let center = vec3(x - way * 3.0, 0.75 + 0.5 * random(2), z);
                let axis = vec3(random(3) - 0.5, random(4) - 0.5, random(5) - 0.5);
                let motion = Motion {
                    velocity: vec3(way * (0.8 + 0.15 * lane as f32), 0.0, 0.0),
                    axis,
                    rate: 0.5 + 1.5 * random(6),
                };
                let name = format!("lane {lane}, {number}");
                if let Some((object, start)) = self.flying(&name, &goods, lane + number, center)? {
                    motions.push((object, start, motion));
                }
            }
        }
        Ok(motions)
    }

    /// A box, an ellipsoid, or a pane.
    fn flying(
        &mut self,
        name: &str,
        goods: &Goods,
        number: u32,
        center: Vec3,
    ) -> Result<Option<(InstanceIndex, Mat4)>, ImportError> {
        let at = |size| Mat4::from_scale_rotation_translation(size, Quat::IDENTITY, center);
        let (material, start) = match number % 3 {
            0 => (goods.board, at(Vec3::splat(0.36))),
            1 => (goods.metal, at(vec3(0.5, 0.3, 0.3))),
            _ => (goods.glass[(number / 3 % 3) as usize], at(vec3(0.5, 0.4, 0.03))),
        };
        let object = match number % 3 {
            1 => Some(self.sphere(name, material, start)?),
            _ => self.place([name, "cube"], goods.cube, material, start)?,
        };
        Ok(object.map(|object| (object, start)))
    }
}
