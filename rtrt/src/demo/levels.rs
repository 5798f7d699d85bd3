//! `demo:levels`: objects with levels of detail.

use super::builder::{DemoBuilder, loaded};
use super::shape::Shape;
use crate::import::geometry::Geometry;
use crate::import::{ImportError, Loaded};
use glam::{Mat4, Vec3, vec3};
use rtrt_core::layout::Attribute;
use rtrt_core::scene::{Camera, Join, Light, Projection};
use std::f32::consts::PI;

/// The name of the scene in place of a path.
pub const LEVELS: &str = "demo:levels";

/// The levels: least distance, rings, and color, of which 255 is 1 in linear light.
const STEPS: [(f32, u32, [f32; 3]); 4] = [
    (0.0, 48, [255.0, 255.0, 255.0]),
    (8.0, 12, [255.0, 208.0, 112.0]),
    (16.0, 6, [128.0, 255.0, 128.0]),
    (32.0, 3, [112.0, 144.0, 255.0]),
];

/// A field of balls with 4,608 triangles near the camera and 18 far away. Each level has its own
/// color.
///
/// # Errors
/// Those of [`crate::import::load`]; the scene causes none.
pub fn levels(join: &impl Join) -> Result<Loaded, ImportError> {
    let mut stage = DemoBuilder::new(LEVELS, join);
    let floor = stage.painted("ground", [0.5, 0.48, 0.45], 0.9)?;
    let shape = Shape::default().tiled(vec3(-60.0, 0.0, -120.0), Vec3::X * 120.0, Vec3::Z * 130.0, 1.0);
    stage.add("ground", shape, floor)?;
    let white = stage.painted("white", [0.9; 3], 0.4)?;
    let mut meshes = Vec::new();
    for (from, rings, color) in STEPS {
        meshes.push((from, stage.mesh(ball(rings, color))?));
    }
    for number in 0..32 * 40 {
        let (column, row) = ((number % 32) as f32, (number / 32) as f32);
        let center = vec3((column - 15.5) * 2.0, 0.6, 2.0 - row * 2.2);
        let place = Mat4::from_translation(center) * Mat4::from_scale(Vec3::splat(0.6));
        let name = format!("ball {number}");
        if let Some(object) = stage.place([&name, "ball"], meshes[0].1, white, place)? {
            let set = stage.builder.scene.set_levels(object, &meshes[1..]);
            set.map_err(|source| ImportError::Scene { path: LEVELS.into(), source })?;
        }
    }
    let labels = stage.builder.labels();
    let mut scene = stage.builder.scene;
    scene.background = vec3(0.55, 0.70, 0.90);
    scene.ambient = vec3(0.2, 0.21, 0.23);
    scene.add_light(Light::sun(vec3(-0.6, -1.0, -0.7)).color(vec3(1.0, 0.96, 0.88) * PI));
    let camera = Camera {
        eye: vec3(0.0, 3.2, 6.5),
        look_at: vec3(0.0, 0.6, -4.0),
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.7 },
    };
    Ok(loaded(scene, labels, "field", camera, stage.builder.bvh_build_ms))
}

/// A ball: so many rings of as many quads.
fn ball(rings: u32, color: [f32; 3]) -> Shape {
    let [r, g, b] = color.map(|channel| channel / 255.0);
    let color = Attribute::pack_color([r, g, b, 1.0]);
    let mut ball = Geometry::default();
    let sides = rings;
    for ring in 0..=rings {
        let (out, up) = libm::sincosf(ring as f32 * (core::f32::consts::PI / rings as f32));
        for side in 0..=sides {
            let (sin, cos) = libm::sincosf(side as f32 * (core::f32::consts::TAU / sides as f32));
            let normal = [out * cos, up, out * sin];
            ball.positions.push(normal);
            ball.attributes.push(Attribute { normal, uv: [0.0; 2], color });
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let above = ring * (sides + 1) + side;
            let below = above + sides + 1;
            ball.indices.extend([above, above + 1, below + 1, above, below + 1, below]);
        }
    }
    Shape(ball)
}
