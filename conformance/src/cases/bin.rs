//! The lists of blocks: many objects, and objects where blocks end.

use crate::case::{Case, look, parallel};
use crate::shape::{Build, Random, Shape, bulb, lamp, sun};
use glam::{Mat4, Vec3, Vec3Swizzles};
use rtrt_core::scene::Scene;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "bin/thousands_in_one_block",
        claim: "A list may hold thousands of objects; none is lost because it is full.",
        scene: crowd,
        camera: look([0.0, 0.0, 40.0], [0.0; 3]),
        size: [16, 16],
        ..Case::USUAL
    },
    Case {
        name: "bin/many_small",
        claim: "Objects spread over the frame are each in the lists of their blocks.",
        scene: spread,
        camera: look([0.0, 6.0, 9.0], [0.0; 3]),
        size: [53, 35],
        ..Case::USUAL
    },
    Case {
        name: "bin/edges_of_blocks",
        claim: "An object that ends where a block ends is in no list too few.",
        scene: edges_of_blocks,
        camera: parallel(32.0, look([0.0, 0.0, 4.0], [0.0; 3])),
        size: [48, 32],
        ..Case::USUAL
    },
    Case {
        name: "bin/one_behind_the_other",
        claim: "Near objects end the search, and only those that are certainly nearer.",
        scene: rows_of_walls,
        camera: look([0.3, 0.2, 4.0], [0.0; 3]),
        ..Case::USUAL
    },
    Case {
        name: "bin/almost_at_the_same_depth",
        claim: "The search does not end before an object that is nearer by a rounding error.",
        scene: grazing_walls,
        ..Case::USUAL
    },
    Case {
        name: "bin/around_the_camera",
        claim: "Objects all around the camera are in the lists that see them.",
        scene: all_around,
        camera: look([0.0; 3], [1.0, 0.3, -0.7]),
        ..Case::USUAL
    },
    Case {
        name: "bin/around_a_light",
        claim: "Objects on all six sides of a light cast their shadows.",
        scene: light_in_a_cage,
        camera: look([0.0, 0.0, 9.0], [0.0; 3]),
        ..Case::USUAL
    },
    Case {
        name: "bin/objects_without_triangles",
        claim: "A mesh without triangles is met by no ray and costs nothing else.",
        scene: nothing_and_a_cube,
        ..Case::USUAL
    },
];

fn crowd() -> Scene {
    let mut build = Build::default();
    let mesh = build.mesh(Shape::triangle([[-0.5, -0.5, 0.0], [0.5, -0.4, 0.1], [0.1, 0.5, -0.1]]));
    let mut random = Random(2);
    for _ in 0..3000 {
        let turn = Mat4::from_rotation_y(random.within(-3.0, 3.0));
        build.object(mesh, Mat4::from_translation(random.vector(12.0)) * turn);
    }
    build.light(sun([0.2, -0.5, -1.0])).scene
}

fn spread() -> Scene {
    let mut build = Build::default().shape(Shape::floor(6.0, 0.0));
    let (cube, ball) = (build.mesh(Shape::cube()), build.mesh(Shape::ball(4)));
    let mut random = Random(3);
    for i in 0..300 {
        let at = Vec3::new(random.within(-5.0, 5.0), random.within(0.0, 1.0), random.within(-5.0, 5.0));
        let place = Mat4::from_translation(at) * Mat4::from_rotation_x(random.within(0.0, 6.0));
        build.object(if i % 2 == 0 { cube } else { ball }, place * Mat4::from_scale(Vec3::splat(0.12)));
    }
    build.light(lamp([2.0, 3.0, 1.0], 9.0)).light(sun([0.5, -1.0, 0.2])).scene
}

/// Squares whose sides lie on the edges of blocks: a unit is a pixel.
fn edges_of_blocks() -> Scene {
    let mut build = Build::default();
    for (x, y, size) in
        [(-24.0, 0.0, 16.0), (-8.0, -16.0, 16.0), (8.0, 0.0, 1.0), (7.0, -1.0, 2.0), (8.0, -16.0, 15.5)]
    {
        build = build.shape(Shape::quad([x, y, 0.0], [size, 0.0, 0.0], [0.0, size, 0.0]));
    }
    build.light(bulb([0.0, 3.0, 9.0])).scene
}

fn rows_of_walls() -> Scene {
    let mut build = Build::default();
    for i in 0..40 {
        let z = 1.0 - 0.05 * i as f32;
        let x = -1.5 + 0.07 * i as f32;
        build = build.shape(Shape::quad([x, -1.0, z], [0.4, 0.0, 0.02], [0.0, 2.0, 0.01]));
    }
    build.light(bulb([0.0, 3.0, 9.0])).scene
}

/// Walls that cross in the middle of the picture at an angle of a few millionths.
fn grazing_walls() -> Scene {
    let wall = |z: f32| Shape::quad([-1.0, -1.0, -z], [2.0, 0.0, 0.0], [0.0, 2.0, 2.0 * z]);
    let walls = [1e-4, 0.0, -3e-5, 1e-5, 0.0, -1e-4];
    walls
        .into_iter()
        .fold(Build::default(), |build, z| build.shape(wall(z)))
        .light(bulb([0.5, 0.5, 3.0]))
        .scene
}

fn all_around() -> Scene {
    let mut build = Build::default();
    let cube = build.mesh(Shape::cube());
    let mut random = Random(4);
    for _ in 0..200 {
        let at = random.vector(1.0).normalize_or(Vec3::X) * random.within(0.8, 5.0);
        build.object(cube, Mat4::from_translation(at) * Mat4::from_scale(Vec3::splat(0.3)));
    }
    build.light(bulb([0.1, 0.2, 0.1])).scene
}

fn light_in_a_cage() -> Scene {
    let mut build = Build::default().shape(Shape::cube().at([0.0, 0.0, -1.0], 4.0));
    let cube = build.mesh(Shape::cube());
    for side in [Vec3::X, Vec3::Y, Vec3::Z] {
        for at in [side, -side, side * 2.0 + side.yzx(), side.zxy() - side * 2.0] {
            build.object(cube, Mat4::from_translation(at) * Mat4::from_scale(Vec3::splat(0.25)));
        }
    }
    build.light(bulb([0.05, -0.03, 0.02])).scene
}

fn nothing_and_a_cube() -> Scene {
    let mut build = Build::default();
    let nothing = build.mesh(Shape::default());
    for i in 0..3 {
        build.object(nothing, Mat4::from_translation(Vec3::new(i as f32, 0.0, 1.0)));
    }
    build.shape(Shape::cube()).light(bulb([0.0, 3.0, 9.0])).scene
}
