//! Scenes built in code: `demo:matchbox`, `demo:glass`, `demo:spheres`, `demo:levels`, `demo:moving`.

mod builder;
mod glass;
mod levels;
mod moving;
mod noise;
mod paint;
mod shape;
mod spheres;

pub use glass::{GLASS, glass};
pub use levels::{LEVELS, levels};
pub use moving::{MOVING, moving};
pub use spheres::{SPHERES, spheres};

use self::builder::{DemoBuilder, loaded};
use crate::import::{ImportError, Loaded};
use glam::{Mat4, Vec3, vec3};
use rtrt_core::scene::{Camera, Join, Light, Material, Projection};
use shape::Shape;
use std::f32::consts::PI;

/// The name of the scene in place of a path.
pub const MATCHBOX: &str = "demo:matchbox";

/// The lower and the upper corner of the room.
const ROOM: [Vec3; 2] = [vec3(-3.2, 0.0, -3.0), vec3(3.2, 3.4, 4.4)];
/// The opening in the left wall: its lower back and upper front corner.
const WINDOW: [Vec3; 2] = [vec3(-3.2, 1.1, -1.9), vec3(-3.2, 3.0, 0.7)];
/// The height of the tiles.
const RAIL: f32 = 0.95;
/// The lamp's bulb.
const BULB: Vec3 = vec3(1.35, 2.5, -1.1);

/// A matchbox, half open, that floats in a room with the sun in its window; a lamp hangs
/// above it. Figure 1a of the paper, in spirit.
///
/// The scene and its textures are computed from integers and by `libm`, so they are the same on every
/// host. `join` runs the halves of work on textures and BVHs.
///
/// # Errors
/// Those of [`crate::import::load`]; the scene causes none.
pub fn matchbox(join: &impl Join) -> Result<Loaded, ImportError> {
    let mut stage = DemoBuilder::new(MATCHBOX, join);
    stage.room()?;
    stage.window()?;
    stage.lamp()?;
    stage.matchbox()?;
    let labels = stage.builder.labels();
    let mut scene = stage.builder.scene;
    scene.ambient = vec3(0.17, 0.175, 0.19);
    scene.background = vec3(0.60, 0.76, 0.95);
    scene.add_light(Light::sun(vec3(1.0, -0.31, 0.08)).color(vec3(1.6, 1.4, 1.08) * PI));
    let below = BULB - Vec3::Y * 0.12;
    let point = |position: Vec3, color: Vec3, reach| Light::point(position).color(color * PI).reach(reach);
    scene.add_light(point(below, vec3(0.95, 0.66, 0.36), 6.5));
    scene.add_light(point(vec3(-1.6, 2.4, 4.0), vec3(0.36, 0.40, 0.48), 9.0));
    let camera = Camera {
        eye: vec3(0.55, 1.95, 3.75),
        look_at: vec3(0.0, 1.32, -0.6),
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 0.85 },
    };
    Ok(loaded(scene, labels, "room", camera, stage.builder.bvh_build_ms))
}

impl<J: Join> DemoBuilder<'_, J> {
    /// Floor, ceiling, walls half tiled and half plastered, and a picture.
    fn room(&mut self) -> Result<(), ImportError> {
        let [low, high] = ROOM;
        let size = high - low;
        let (x, y, z) = (Vec3::X * size.x, Vec3::Y, Vec3::Z * size.z);
        let texture = self.texture(paint::planks)?;
        let floor = self.material("planks", [0.95; 3], 0.45, texture)?;
        self.add("floor", Shape::default().tiled(low, x, z, 2.4), floor)?;

        let texture = self.texture(paint::plaster)?;
        let plaster = self.material("plaster", [1.0; 3], 0.95, texture)?;
        let upper = high.y - RAIL;
        let corner = |x: f32, z: f32| vec3(x, high.y, z);
        let [open_low, open_high] = WINDOW;
        let (above, beside) = (y * (high.y - open_high.y), y * (high.y - RAIL));
        let walls = Shape::default()
            .tiled(corner(low.x, low.z), x, z, 2.0)
            .tiled(corner(low.x, low.z), x, y * -upper, 2.0)
            .tiled(corner(low.x, high.z), x, y * -upper, 2.0)
            .tiled(corner(high.x, low.z), z, y * -upper, 2.0)
            // The left wall around its opening: behind, in front, above, below.
            .tiled(corner(low.x, low.z), Vec3::Z * (open_low.z - low.z), -beside, 2.0)
            .tiled(corner(low.x, open_high.z), Vec3::Z * (high.z - open_high.z), -beside, 2.0)
            .tiled(corner(low.x, open_low.z), Vec3::Z * (open_high.z - open_low.z), -above, 2.0)
            .tiled(open_low, Vec3::Z * (open_high.z - open_low.z), y * (RAIL - open_low.y), 2.0);
        self.add("walls", walls, plaster)?;

        let texture = self.texture(paint::tiles)?;
        let tiles = self.material("tiles", [1.0; 3], 0.25, texture)?;
        let corner = |x: f32, z: f32| vec3(x, RAIL, z);
        let dado = Shape::default()
            .tiled(corner(low.x, low.z), x, y * -RAIL, 1.52)
            .tiled(corner(low.x, high.z), x, y * -RAIL, 1.52)
            .tiled(corner(low.x, low.z), z, y * -RAIL, 1.52)
            .tiled(corner(high.x, low.z), z, y * -RAIL, 1.52);
        self.add("dado", dado, tiles)?;

        let wood = self.painted("dark wood", [0.20, 0.10, 0.05], 0.35)?;
        let mut trim = Shape::default();
        for (bottom, height, depth) in [(RAIL - 0.03, 0.07, 0.06), (0.0, 0.12, 0.04)] {
            let (bottom, top) = (Vec3::Y * bottom, Vec3::Y * (bottom + height));
            trim = trim
                .cuboid(low + bottom, vec3(high.x, 0.0, low.z + depth) + top, 1.0)
                .cuboid(low + bottom, vec3(low.x + depth, 0.0, high.z) + top, 1.0)
                .cuboid(vec3(high.x - depth, 0.0, low.z) + bottom, vec3(high.x, 0.0, high.z) + top, 1.0);
        }
        self.add("trim", trim, wood)?;

        let texture = self.texture(paint::landscape)?;
        let canvas = self.material("landscape", [1.0; 3], 0.8, texture)?;
        let frame = self.painted("gilded wood", [0.45, 0.28, 0.08], 0.3)?;
        let (corner, wide, tall) = (vec3(-1.95, 2.75, low.z + 0.05), Vec3::X * 1.5, Vec3::Y * -1.0);
        self.add("picture", Shape::default().quad(corner, wide, tall, [[0.0; 2], [1.0; 2]]), canvas)?;
        let bar = |from: Vec3, to: Vec3| (from - vec3(0.07, 0.07, 0.05), to + vec3(0.07, 0.07, 0.04));
        let mut bars = Shape::default();
        for (from, to) in
            [(corner, wide), (corner + tall, wide), (corner + tall, -tall), (corner + tall + wide, -tall)]
        {
            // As thick as it is wide, around the edge of the picture.
            let (from, to) = bar(from, from + to);
            bars = bars.cuboid(from, to, 1.0);
        }
        self.add("picture frame", bars, frame)
    }

    /// The frame of the window and its sill.
    fn window(&mut self) -> Result<(), ImportError> {
        let white = self.painted("white paint", [0.80, 0.78, 0.74], 0.4)?;
        let [low, high] = WINDOW;
        let (middle, thin) = ((low + high) * 0.5, 0.035);
        let upright =
            |z: f32, half: f32| (vec3(low.x - 0.06, low.y, z - half), vec3(low.x + 0.04, high.y, z + half));
        let level =
            |y: f32, half: f32| (vec3(low.x - 0.06, y - half, low.z), vec3(low.x + 0.04, y + half, high.z));
        let sill = (vec3(low.x - 0.06, low.y - 0.06, low.z - 0.1), vec3(low.x + 0.22, low.y, high.z + 0.1));
        let bars = [
            upright(low.z, 0.07),
            upright(low.z + (high.z - low.z) / 3.0, thin),
            upright(high.z - (high.z - low.z) / 3.0, thin),
            upright(high.z, 0.07),
            level(low.y, 0.05),
            level(middle.y, thin),
            level(high.y, 0.07),
            sill,
        ];
        let shape =
            bars.into_iter().fold(Shape::default(), |shape, (low, high)| shape.cuboid(low, high, 1.0));
        self.add("window", shape, white)
    }

    /// A bulb under a shade, on a cord.
    fn lamp(&mut self) -> Result<(), ImportError> {
        let enamel = self.painted("enamel", [0.05, 0.16, 0.13], 0.2)?;
        let lining = self.painted("lining", [0.9, 0.88, 0.8], 0.6)?;
        let glow = Material::new([0.0; 3]).emission([1.0, 0.86, 0.6]);
        let glow = self.named("glow", glow)?;
        let outside = [[0.02, 0.32], [0.1, 0.28], [0.16, 0.18], [0.42, -0.06]];
        let inside = outside.map(|[radius, height]| [radius - 0.008, height - 0.008]);
        let normals = [[0.3, 1.0], [0.6, 0.8], [0.8, 0.6], [0.7, 0.7]];
        self.add("lamp shade", Shape::default().turned(BULB, &outside, &normals), enamel)?;
        self.add("lamp lining", Shape::default().turned(BULB, &inside, &normals), lining)?;
        self.add("bulb", Shape::default().ellipsoid(BULB, 0.08, 0.09), glow)?;
        let top = vec3(BULB.x, ROOM[1].y, BULB.z);
        let cord =
            Shape::default().cuboid(BULB + vec3(-0.012, 0.3, -0.012), top + vec3(0.012, 0.0, 0.012), 1.0);
        self.add("cord", cord, enamel)
    }

    /// Sleeve, tray and matches, and three loose matches.
    fn matchbox(&mut self) -> Result<(), ImportError> {
        /// Half of the sleeve's size.
        const HALF: Vec3 = vec3(0.78, 0.2, 0.52);
        let at = Mat4::from_translation(vec3(-0.25, 1.42, 0.2))
            * turned(Vec3::Y, -24.0)
            * turned(Vec3::X, 33.0)
            * turned(Vec3::Z, 9.0);
        let (x, y, z) = (Vec3::X * HALF.x, Vec3::Y * HALF.y, Vec3::Z * HALF.z);
        let whole = [[0.0; 2], [1.0; 2]];

        let texture = self.texture(paint::label)?;
        let label = self.material("label", [1.0; 3], 0.5, texture)?;
        let lids = Shape::default().quad(-x + y - z, x * 2.0, z * 2.0, whole).quad(
            -x - y + z,
            x * 2.0,
            z * -2.0,
            whole,
        );
        let lids = self.mesh(lids)?;
        self.place(["sleeve", "lids"], lids, label, at)?;
        let texture = self.texture(paint::striker)?;
        let striker = self.material("striker", [1.0; 3], 0.7, texture)?;
        let strips = [[0.0; 2], [2.0, 0.5]];
        let sides = Shape::default().quad(-x + y + z, x * 2.0, y * -2.0, strips).quad(
            -x + y - z,
            x * 2.0,
            y * -2.0,
            strips,
        );
        let sides = self.mesh(sides)?;
        self.place(["sleeve", "sides"], sides, striker, at)?;

        // The tray's floor and four walls, with room in the sleeve.
        let texture = self.texture(paint::board)?;
        let board = self.material("board", [1.0; 3], 0.9, texture)?;
        let (half, wall) = (HALF - 0.03, 0.02);
        let side = |low: Vec3, high: Vec3| (low.max(-half), high.min(half));
        let far = Vec3::splat(9.0);
        let walls = [
            side(-far, vec3(9.0, -half.y + wall, 9.0)),
            side(-far, vec3(-half.x + wall, 9.0, 9.0)),
            side(vec3(half.x - wall, -9.0, -9.0), far),
            side(-far, vec3(9.0, 9.0, -half.z + wall)),
            side(vec3(-9.0, -9.0, half.z - wall), far),
        ];
        let tray =
            walls.into_iter().fold(Shape::default(), |shape, (low, high)| shape.cuboid(low, high, 0.8));
        let tray = self.mesh(tray)?;
        let drawn = at * Mat4::from_translation(vec3(0.62, 0.0, 0.0));
        self.place(["tray"; 2], tray, board, drawn)?;

        // A match lies along x, its head to the right.
        let stick =
            self.mesh(Shape::default().cuboid(vec3(-0.62, -0.03, -0.03), vec3(0.6, 0.03, 0.03), 1.0))?;
        let head = self.mesh(Shape::default().ellipsoid(Vec3::ZERO, 0.05, 0.085))?;
        let wood = self.painted("wood", [0.72, 0.53, 0.30], 0.8)?;
        let red = self.painted("red phosphorus", [0.55, 0.04, 0.03], 0.45)?;
        let on_end = Mat4::from_translation(vec3(0.6, 0.0, 0.0)) * turned(Vec3::Z, 90.0);
        let mut matches = Vec::new();
        for number in 0..27_u32 {
            let (layer, place) = (number / 9, number % 9);
            let random = |seed| noise::hash(number, 0, seed) - 0.5;
            let position = vec3(
                0.04 * random(1),
                -half.y + 0.07 + 0.1 * layer as f32,
                (place as f32 - 4.0) * 0.105 + 0.02 * random(2),
            );
            let turn = turned(Vec3::Y, 3.0 * random(3)) * turned(Vec3::X, 40.0 * random(4));
            matches.push(drawn * Mat4::from_translation(position) * turn);
        }
        let loose = |position, y: f32, z: f32| {
            Mat4::from_translation(position) * turned(Vec3::Y, y) * turned(Vec3::Z, z)
        };
        matches.push(loose(vec3(1.25, 1.62, 0.5), 35.0, 48.0));
        matches.push(loose(vec3(1.62, 1.12, 0.1), -20.0, 15.0));
        matches.push(loose(vec3(1.15, 0.62, 0.7), 60.0, -28.0));
        for (number, place) in matches.into_iter().enumerate() {
            let name = format!("match {number}");
            self.place([&name, "stick"], stick, wood, place)?;
            self.place([&name, "head"], head, red, place * on_end)?;
        }
        Ok(())
    }
}

/// A turn around an axis of length 1.
fn turned(axis: Vec3, degrees: f32) -> Mat4 {
    let (sin, cos) = libm::sincosf(degrees.to_radians() * 0.5);
    Mat4::from_quat(glam::Quat::from_xyzw(axis.x * sin, axis.y * sin, axis.z * sin, cos))
}
