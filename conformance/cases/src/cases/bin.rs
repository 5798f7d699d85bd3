//! The lists of blocks: many instances, and instances where blocks end.

use crate::case::{Case, look, parallel};
use crate::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3, Vec3Swizzles};
use rtrt_core::scene::{Light, Occluders, Scene, Structure};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "bin/thousands_in_one_block",
        claim: "A list may hold thousands of instances; none is lost because it is full.",
        scene: crowd,
        camera: look([0.0, 0.0, 40.0], [0.0; 3]),
        size: [16, 16],
        ..Case::USUAL
    },
    Case {
        name: "bin/no_blocks",
        claim: "Without blocks every ray is asked for every instance, and finds the same.",
        scene: || {
            let mut scene = spread();
            scene.structure = Structure::None;
            scene
        },
        camera: look([0.0, 6.0, 9.0], [0.0; 3]),
        size: [53, 35],
        ..Case::USUAL
    },
    Case {
        name: "bin/parts",
        claim: "Lists of parts, down to leaves, hold every triangle of every instance.",
        scene: || {
            let mut scene = spread();
            scene.structure = Structure::Parts(2);
            scene
        },
        camera: look([0.0, 6.0, 9.0], [0.0; 3]),
        size: [53, 35],
        ..Case::USUAL
    },
    Case {
        name: "bin/shadows_that_are_near",
        claim: "Suns lose the shadows of what is farther from the camera than a distance, and no others.",
        scene: scattered,
        camera: look([0.0, 1.0, 0.5], [0.0, 0.0, -4.0]),
        size: [53, 35],
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
        claim: "An instance that ends where a block ends is in no list too few.",
        scene: edges_of_blocks,
        camera: parallel(32.0, look([0.0, 0.0, 4.0], [0.0; 3])),
        size: [48, 32],
        ..Case::USUAL
    },
    Case {
        name: "bin/corners_of_blocks",
        claim: "An instance with only a tip in the corner of a block, which touches its sphere, is listed there.",
        scene: || {
            needles(|build, at, along, side| {
                let corner = (at - along - side).to_array();
                let needle = Shape::quad(corner, (along * 2.0).to_array(), (side * 2.0).to_array());
                let mesh = build.mesh(needle);
                build.instance(mesh, Mat4::IDENTITY);
            })
        },
        ..FROM_AFAR
    },
    Case {
        name: "bin/corners_of_blocks_stretched",
        claim: "The same where a transform makes the instance, and its sphere, long.",
        scene: || {
            needles(|build, at, along, side| {
                let needle = Shape::quad([-1.0, -0.01, 0.0], [2.0, 0.0, 0.0], [0.0, 0.02, 0.0]);
                let mesh = build.mesh(needle);
                let [x, y, z] = [along, side * 100.0, Vec3::Z].map(|axis| axis.extend(0.0));
                build.instance(mesh, Mat4::from_cols(x, y, z, at.extend(1.0)));
            })
        },
        ..FROM_AFAR
    },
    Case {
        name: "bin/edges_of_a_lights_blocks",
        claim: "What reaches over the edge of a light's block by a hundredth of it casts its shadow there.",
        scene: over_the_edge,
        camera: parallel(1.04, look([2.0, 1.5, 1.5], [4.0, 1.5, 1.5])),
        size: [160, 160],
        ..Case::USUAL
    },
    Case {
        name: "bin/edges_across_a_lights_plane",
        claim: "The same for what is partly behind the light's side that it is seen from.",
        scene: over_the_edge_from_behind,
        camera: parallel(0.078, look([2.0, 1.5, 0.0], [4.0, 1.5, 0.0])),
        size: [640, 12],
        ..Case::USUAL
    },
    Case {
        name: "bin/one_behind_the_other",
        claim: "Near instances end the search, and only those that are certainly nearer.",
        scene: rows_of_walls,
        camera: look([0.3, 0.2, 4.0], [0.0; 3]),
        ..Case::USUAL
    },
    Case {
        name: "bin/almost_at_the_same_depth",
        claim: "The search does not end before an instance that is nearer by a rounding error.",
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
        build.instance(mesh, Mat4::from_translation(random.vector(12.0)) * turn);
    }
    build.light(Light::sun([0.2, -0.5, -1.0])).scene
}

fn spread() -> Scene {
    let mut build = Build::default().shape(Shape::floor(6.0, 0.0));
    let (cube, ball) = (build.mesh(Shape::cube()), build.mesh(Shape::ball(4)));
    let mut random = Random(3);
    for i in 0..300 {
        let at = Vec3::new(random.within(-5.0, 5.0), random.within(0.0, 1.0), random.within(-5.0, 5.0));
        let place = Mat4::from_translation(at) * Mat4::from_rotation_x(random.within(0.0, 6.0));
        build.instance(if i % 2 == 0 { cube } else { ball }, place * Mat4::from_scale(Vec3::splat(0.12)));
    }
    build.light(Light::point([2.0, 3.0, 1.0]).reach(9.0)).light(Light::sun([0.5, -1.0, 0.2])).scene
}

/// Cubes and balls all around the camera, over a floor, under three suns whose
/// shadows end near the camera.
fn scattered() -> Scene {
    let mut build = Build::default().shape(Shape::floor(12.0, -1.0));
    let cube = build.mesh(Shape::cube());
    let mut random = Random(21);
    for i in 0..200 {
        let at = random.vector(8.0) * Vec3::new(1.0, 0.3, 1.0) + Vec3::Y * 1.5;
        let place = Mat4::from_translation(at) * Mat4::from_scale(Vec3::splat(random.within(0.1, 0.6)));
        if i % 3 == 0 {
            build.scene.add_sphere(build.gray, place).expect("a case's sphere");
        } else {
            build.instance(cube, place);
        }
    }
    build.scene.occluders = Occluders::Near(5.0);
    build
        .light(Light::sun([0.9, -1.0, -0.3]))
        .light(Light::sun([-0.2, -0.4, 1.0]))
        .light(Light::sun([0.0, -1.0, 0.0]))
        .scene
}

/// Squares whose sides lie on the edges of blocks: a unit is a pixel.
fn edges_of_blocks() -> Scene {
    let mut build = Build::default();
    for (x, y, size) in
        [(-24.0, 0.0, 16.0), (-8.0, -16.0, 16.0), (8.0, 0.0, 1.0), (7.0, -1.0, 2.0), (8.0, -16.0, 15.5)]
    {
        build = build.shape(Shape::quad([x, y, 0.0], [size, 0.0, 0.0], [0.0, size, 0.0]));
    }
    build.light(Light::point([0.0, 3.0, 9.0])).scene
}

/// A unit is a pixel, and the lower left corner of a block is at `(0, -8)`.
const FROM_AFAR: Case =
    Case { camera: parallel(48.0, look([0.0, 0.0, 4.0], [0.0; 3])), size: [64, 48], ..Case::USUAL };

/// Four needles, much longer than a block, that point along a block's diagonal and end just
/// behind the ray in its corner. `add` is given the middle of each, and half of it along and
/// across.
fn needles(add: fn(&mut Build, Vec3, Vec3, Vec3)) -> Scene {
    let mut build = Build::default();
    for (i, [corner_x, corner_y, x, y]) in (0..).zip([
        [0.0, -8.0, 1.0, 1.0],
        [0.0, 8.0, -1.0, -1.0],
        [16.0, 8.0, 1.0, -1.0],
        [-16.0, -8.0, -1.0, 1.0_f32],
    ]) {
        let tip = Vec3::new(corner_x + 0.6 * x, corner_y + 0.6 * y, 0.1 * i as f32);
        let along = Vec3::new(x, y, 0.0) * 140.0;
        add(&mut build, tip - along, along, Vec3::Z.cross(along) / 1000.0);
    }
    build.light(Light::point([0.0, 3.0, 9.0])).scene
}

/// A light's blocks on this side are a quarter high and wide at `x` = 1. The wall is where
/// their shadows are seen.
fn beside_a_light() -> Build {
    let wall = Shape::quad([4.0, -4.0, -4.0], [0.0, 0.0, 8.0], [0.0, 8.0, 0.0]);
    Build::default().shape(wall).light(Light::point([0.0; 3]))
}

/// How far something reaches over an edge: half of 1/64 of a block.
const OVER: f32 = 0.25 / 128.0;

fn over_the_edge() -> Scene {
    let (corner, side) = (0.25 - OVER, 0.25 + 2.0 * OVER);
    let block = Shape::quad([1.0, corner, corner], [0.0, 0.0, side], [0.0, side, 0.0]);
    beside_a_light().shape(block).scene
}

fn over_the_edge_from_behind() -> Scene {
    let plate = |z: f32| Shape::quad([-1.0, 0.27, z], [2.0, 0.0, 0.0], [0.0, 0.21, 0.0]);
    beside_a_light().shape(plate(0.5 - OVER)).shape(plate(OVER - 0.5)).scene
}

fn rows_of_walls() -> Scene {
    let mut build = Build::default();
    for i in 0..40 {
        let z = 1.0 - 0.05 * i as f32;
        let x = -1.5 + 0.07 * i as f32;
        build = build.shape(Shape::quad([x, -1.0, z], [0.4, 0.0, 0.02], [0.0, 2.0, 0.01]));
    }
    build.light(Light::point([0.0, 3.0, 9.0])).scene
}

/// Walls that cross in the middle of the picture at an angle of a few millionths.
fn grazing_walls() -> Scene {
    let wall = |z: f32| Shape::quad([-1.0, -1.0, -z], [2.0, 0.0, 0.0], [0.0, 2.0, 2.0 * z]);
    let walls = [1e-4, 0.0, -3e-5, 1e-5, 0.0, -1e-4];
    walls
        .into_iter()
        .fold(Build::default(), |build, z| build.shape(wall(z)))
        .light(Light::point([0.5, 0.5, 3.0]))
        .scene
}

fn all_around() -> Scene {
    let mut build = Build::default();
    let cube = build.mesh(Shape::cube());
    let mut random = Random(4);
    for _ in 0..200 {
        let at = random.vector(1.0).normalize_or(Vec3::X) * random.within(0.8, 5.0);
        build.instance(cube, Mat4::from_translation(at) * Mat4::from_scale(Vec3::splat(0.3)));
    }
    build.light(Light::point([0.1, 0.2, 0.1])).scene
}

fn light_in_a_cage() -> Scene {
    let mut build = Build::default().shape(Shape::cube().at([0.0, 0.0, -1.0], 4.0));
    let cube = build.mesh(Shape::cube());
    for side in [Vec3::X, Vec3::Y, Vec3::Z] {
        for at in [side, -side, side * 2.0 + side.yzx(), side.zxy() - side * 2.0] {
            build.instance(cube, Mat4::from_translation(at) * Mat4::from_scale(Vec3::splat(0.25)));
        }
    }
    build.light(Light::point([0.05, -0.03, 0.02])).scene
}

fn nothing_and_a_cube() -> Scene {
    let mut build = Build::default();
    let nothing = build.mesh(Shape::default());
    for i in 0..3 {
        build.instance(nothing, Mat4::from_translation(Vec3::new(i as f32, 0.0, 1.0)));
    }
    build.shape(Shape::cube()).light(Light::point([0.0, 3.0, 9.0])).scene
}
