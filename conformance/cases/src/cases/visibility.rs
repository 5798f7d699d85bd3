//! The closest hit: ties, edges, and triangles that are hard to meet.

use crate::case::{Case, Known, look, parallel};
use crate::shape::{Build, Random, Shape};
use glam::{Mat4, Quat, Vec3};
use rtrt_core::scene::{Light, Material, Scene};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "visibility/empty",
        claim: "A scene without instances is its background.",
        scene: empty,
        size: [40, 24],
        blank: true,
        ..Case::USUAL
    },
    Case {
        name: "visibility/nothing_in_sight",
        claim: "Objects behind the camera are not seen.",
        scene: behind,
        blank: true,
        ..Case::USUAL
    },
    Case {
        name: "visibility/one_triangle",
        claim: "A single triangle is seen.",
        scene: one_triangle,
        ..Case::USUAL
    },
    Case {
        name: "visibility/inside_bounds",
        claim: "A camera inside of an instance's bounds sees the instance.",
        scene: inside,
        camera: look([0.2, 0.1, 0.3], [1.0, 0.4, -0.2]),
        ..Case::USUAL
    },
    Case {
        name: "visibility/across_the_camera_plane",
        claim: "Objects that are partly behind the camera are seen as far as they are ahead.",
        scene: across,
        camera: look([0.0, 0.5, 2.0], [0.0; 3]),
        ..Case::USUAL
    },
    Case {
        name: "visibility/parallel_across_the_camera_plane",
        claim: "The same for parallel rays.",
        scene: across,
        camera: parallel(3.0, look([0.0, 0.5, 2.0], [0.0; 3])),
        ..Case::USUAL
    },
    Case {
        name: "visibility/clip_planes",
        claim: "What is nearer than one plane or beyond another is not seen, and casts its shadow all the same.",
        scene: clipped,
        clip: [3.0, 5.0],
        ..Case::USUAL
    },
    Case {
        name: "visibility/parallel_clip_planes",
        claim: "The same for parallel rays.",
        scene: clipped,
        camera: parallel(3.0, look([0.0, 0.5, 4.0], [0.0; 3])),
        clip: [3.5, 4.5],
        ..Case::USUAL
    },
    Case {
        name: "visibility/clip_planes_and_panes",
        claim: "A pane before the near plane tints nothing.",
        scene: clipped_panes,
        clip: [3.0, 5.0],
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "visibility/coplanar_objects",
        claim: "Of instances at the same depth the one with the lowest index is seen.",
        scene: coplanar_objects,
        ..Case::USUAL
    },
    Case {
        name: "visibility/coplanar_triangles",
        claim: "Of an instance's triangles at the same depth the lowest is seen.",
        scene: coplanar_triangles,
        ..Case::USUAL
    },
    Case {
        name: "visibility/coplanar_instances",
        claim: "The same where the instances have a transform of their own.",
        scene: coplanar_instances,
        ..Case::USUAL
    },
    Case {
        name: "visibility/edges_and_corners",
        claim: "Rays exactly through shared edges and corners belong to one triangle.",
        scene: fan,
        // A ray goes through every multiple of 1/8.
        camera: parallel(2.0, look([0.0, 0.0, 4.0], [0.0; 3])),
        size: [24, 16],
        ..Case::USUAL
    },
    Case {
        name: "visibility/no_area",
        claim: "Triangles without area are not met, whatever is around them.",
        scene: no_area,
        ..Case::USUAL
    },
    Case {
        name: "visibility/huge",
        claim: "Triangles a million times larger than the picture are met where they are.",
        scene: huge,
        camera: look([0.0, 1.0, 4.0], [0.0, 0.8, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "visibility/needles",
        claim: "Slivers and triangles that are nearly edge-on are met alike.",
        scene: needles,
        camera: look([0.0, 0.01, 4.0], [0.0; 3]),
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "visibility/edge_on",
        claim: "A triangle in a plane with the camera's rays is met by none of them, or by all alike.",
        scene: edge_on,
        camera: parallel(2.0, look([0.0, 0.0, 4.0], [0.0; 3])),
        size: [24, 16],
        ..Case::USUAL
    },
    Case {
        name: "visibility/instances",
        claim: "Turned, mirrored and stretched instances are met in their own space alike.",
        scene: instances,
        ..Case::USUAL
    },
    Case {
        name: "visibility/flattened",
        claim: "An instance stretched a thousandfold in one direction is not lost to rounding.",
        scene: flattened,
        ..Case::USUAL
    },
    Case {
        name: "visibility/dense",
        claim: "A tree of thousands of triangles loses none of them.",
        scene: dense,
        size: [45, 31],
        ..Case::USUAL
    },
    Case {
        name: "visibility/long_way",
        claim: "A ray may pass tens of thousands of triangles before it ends.",
        scene: thicket,
        size: [20, 12],
        known: Some(Known {
            adapter: "llvmpipe (LLVM 15",
            why: "the driver ends all loops of an invocation after 65535 turns (LP_MAX_TGSI_LOOP_ITERATIONS)",
        }),
        ..Case::USUAL
    },
    Case {
        name: "visibility/leaf_that_cannot_be_split",
        claim: "Many triangles with the same center are all asked.",
        scene: same_center,
        ..Case::USUAL
    },
];

fn empty() -> Scene {
    let mut scene = Scene::new();
    scene.background = Vec3::new(0.3, 0.1, 0.7);
    scene
}

fn behind() -> Scene {
    let mut build = Build::default().shape(Shape::cube().at([0.0, 0.0, 9.0], 1.0));
    build.scene.background = Vec3::new(0.1, 0.7, 0.2);
    build.light(Light::point([0.0, 3.0, 2.0])).scene
}

fn one_triangle() -> Scene {
    let triangle = Shape::triangle([[-1.0, -0.8, 0.0], [1.2, -0.5, 0.3], [0.1, 0.9, -0.4]]);
    Build::default().shape(triangle).light(Light::point([1.0, 2.0, 3.0])).scene
}

fn inside() -> Scene {
    let soup = Shape::soup(&mut Random(5), 60, 0.3).at([0.0; 3], 2.0);
    Build::default()
        .shape(Shape::ball(8).at([0.0; 3], 3.0))
        .shape(soup)
        .light(Light::point([0.3, 0.5, 0.1]))
        .scene
}

fn across() -> Scene {
    let mut build = Build::default().shape(Shape::floor(30.0, -0.7)).shape(Shape::floor(2.0, 0.9));
    let cube = build.mesh(Shape::cube());
    for (i, x) in (0..).zip([-0.9_f32, 0.8, 0.0]) {
        let turn = Mat4::from_rotation_z(0.3 * i as f32) * Mat4::from_rotation_x(0.1);
        let bar = Mat4::from_scale(Vec3::new(0.1, 0.15, 6.0));
        build.instance(cube, Mat4::from_translation(Vec3::new(x, -0.4, 1.0)) * turn * bar);
    }
    build.light(Light::sun([0.3, -1.0, -0.2])).light(Light::point([0.0, 0.4, 2.5])).scene
}

/// A floor and walls before, between and behind the planes.
fn clipped() -> Scene {
    let mut build = Build::default().shape(Shape::floor(30.0, -0.7)).shape(wall(-2.0)).shape(wall(1.5));
    build = build.shape(wall(0.0).at([0.7, 0.2, 0.3], 0.4)).shape(wall(0.5).at([-0.5, 0.0, 0.0], 0.5));
    let sphere = Mat4::from_translation(Vec3::new(0.9, -0.4, 0.9)) * Mat4::from_scale(Vec3::splat(0.3));
    build.scene.add_sphere(build.gray, sphere).expect("room");
    build.light(Light::point([0.0, 1.0, 3.0])).light(Light::sun([0.3, -1.0, -0.2])).scene
}

fn clipped_panes() -> Scene {
    let panes = [1.6, 0.4, -0.5, -1.5];
    let colors = [[1.0, 0.2, 0.2], [0.2, 1.0, 0.2], [0.2, 0.2, 1.0], [1.0; 3]];
    let mut build = Build::default().shape(wall(-0.8));
    for (z, color) in panes.into_iter().zip(colors) {
        let pane = Material::new(color).blend(0.5).double_sided(true);
        build =
            build.shape_of(Shape::quad([-1.0 + 0.3 * z, -1.0, z], [1.2, 0.0, 0.0], [0.0, 1.5, 0.0]), pane);
    }
    build.light(Light::point([0.0, 1.0, 3.0])).scene
}

fn wall(z: f32) -> Shape {
    Shape::quad([-1.0, -1.0, z], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])
}

fn coplanar_objects() -> Scene {
    let mut build = Build::default();
    for shift in [0.5, -0.5, 0.0, 0.0] {
        build = build.shape(wall(0.0).at([shift, 0.2 * shift, 0.0], 1.0));
    }
    build.light(Light::point([0.0, 0.0, 3.0])).scene
}

fn coplanar_triangles() -> Scene {
    let twice = wall(0.0).and(wall(0.0)).and(wall(0.0).at([0.4, 0.3, 0.0], 0.7));
    Build::default().shape(twice.clone().and(twice)).light(Light::point([0.0, 0.0, 3.0])).scene
}

fn coplanar_instances() -> Scene {
    let mut build = Build::default();
    let mesh = build.mesh(wall(0.0).and(Shape::cube().at([0.2, 0.3, 0.0], 0.4)));
    let place = Mat4::from_rotation_y(0.7) * Mat4::from_translation(Vec3::new(0.1, 0.0, -0.3));
    for _ in 0..5 {
        build.instance(mesh, place);
    }
    build.light(Light::point([0.0, 0.0, 3.0])).scene
}

fn fan() -> Scene {
    let mut fan = Shape::default();
    let rim: [[f32; 3]; 8] = [[8, 0], [8, 8], [0, 8], [-8, 8], [-8, 0], [-8, -8], [0, -8], [8, -8]]
        .map(|[x, y]: [i32; 2]| [x as f32 / 16.0 + 0.0625, y as f32 / 16.0 + 0.0625, 0.0]);
    for i in 0..8 {
        fan = fan.and(Shape::triangle([[0.0625, 0.0625, 0.0], rim[i], rim[(i + 1) % 8]]));
    }
    let cubes =
        Shape::cube().at([1.0625, 0.0625, 0.0], 0.25).and(Shape::cube().at([1.5625, 0.0625, 0.0], 0.25));
    Build::default().shape(fan).shape(cubes).light(Light::point([0.0, 0.0, 3.0])).scene
}

fn no_area() -> Scene {
    let (a, b) = ([-0.5, -0.5, 0.5], [0.5, 0.5, 0.5]);
    let middle = [0.0, 0.0, 0.5];
    let nothing = Shape::triangle([a, a, a])
        .and(Shape::triangle([a, b, a]))
        .and(Shape::triangle([a, middle, b]))
        .and(Shape::triangle([[0.0; 3]; 3]));
    let mut build = Build::default().shape(nothing.clone()).shape(nothing.and(wall(0.0)));
    let flat = build.mesh(Shape::triangle([a, a, b]));
    build.instance(flat, Mat4::from_rotation_y(1.0));
    build.light(Light::point([0.0, 0.0, 3.0])).scene
}

fn huge() -> Scene {
    Build::default()
        .shape(Shape::triangle([[-4e6, 0.0, 5e6], [5e6, 0.0, 4e6], [1e5, 0.1, -6e6]]))
        .shape(Shape::triangle([[-4e6, -3e6, -50.0], [5e6, -3e6, -40.0], [1e5, 7e6, -60.0]]))
        .shape(Shape::cube().at([0.0, 0.6, 0.0], 0.4))
        .light(Light::point([1.0, 3.0, 2.0]))
        .light(Light::sun([0.1, -1.0, -0.3]))
        .scene
}

fn needles() -> Scene {
    let mut random = Random(6);
    let mut shape = Shape::default();
    for i in 0..60 {
        let at = random.vector(1.2);
        let along = random.vector(1.5);
        let thin = random.vector(1.0) * [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6][i % 7];
        shape = shape.and(Shape::triangle([at, at + along, at + along * 0.5 + thin].map(|p| p.to_array())));
    }
    // Seen almost from its edge.
    shape = shape.and(Shape::floor(1.5, 0.0099));
    Build::default().shape(shape).light(Light::point([0.0, 1.0, 3.0])).scene
}

fn edge_on() -> Scene {
    let leaves = |x: f32| Shape::quad([x, -0.6, -1.0], [0.0, 0.0, 2.0], [0.0, 1.2, 0.0]);
    let both = leaves(0.0).and(leaves(0.0625)).and(leaves(-0.1875).shaded(|_| [0.0; 3]));
    Build::default().shape(both).shape(wall(-1.5)).light(Light::point([1.0, 0.0, 3.0])).scene
}

fn instances() -> Scene {
    let mut build = Build::default();
    let soup = build.mesh(Shape::cube().and(Shape::ball(5).at([0.0, 1.2, 0.0], 0.7)));
    let places = [
        (Vec3::new(-1.2, 0.0, 0.0), Vec3::splat(0.4), 0.5),
        (Vec3::new(0.0, 0.2, -0.5), Vec3::new(-0.4, 0.4, 0.4), 1.0),
        (Vec3::new(1.1, -0.3, 0.2), Vec3::new(0.8, 0.1, 0.3), 2.0),
        (Vec3::new(0.4, 0.8, 0.3), Vec3::new(-0.2, -0.2, -0.2), 3.0),
        (Vec3::new(-0.4, -0.8, 0.6), Vec3::splat(0.25), 0.0),
    ];
    for (at, scale, turn) in places {
        let rotation = Quat::from_axis_angle(Vec3::new(0.36, 0.48, 0.8), turn);
        build.instance(soup, Mat4::from_scale_rotation_translation(scale, rotation, at));
    }
    // Sheared.
    let sheared = Mat4::from_cols_array(&[
        0.3, 0.0, 0.0, 0.0, 0.2, 0.3, 0.0, 0.0, 0.0, -0.1, 0.3, 0.0, -0.9, 0.9, 0.0, 1.0,
    ]);
    build.instance(soup, sheared);
    build.light(Light::point([1.0, 3.0, 2.0])).light(Light::sun([0.5, -0.5, -1.0])).scene
}

fn flattened() -> Scene {
    let mut build = Build::default();
    let mesh = build.mesh(Shape::soup(&mut Random(7), 80, 0.4));
    for (turn, scale) in
        [(0.0, Vec3::new(1.0, 1.0, 1e-3)), (1.2, Vec3::new(1e-3, 1.2, 0.8)), (2.0, Vec3::new(1e3, 0.3, 0.3))]
    {
        build.instance(mesh, Mat4::from_rotation_y(turn) * Mat4::from_scale(scale));
    }
    build.light(Light::point([1.0, 3.0, 2.0])).scene
}

fn dense() -> Scene {
    let soup = Shape::soup(&mut Random(8), 3000, 0.06).at([0.0; 3], 1.3);
    Build::default().shape(soup).light(Light::sun([0.3, -0.6, -1.0])).scene
}

fn same_center() -> Scene {
    let mut shape = Shape::default();
    for i in 0..50 {
        let size = 1.2 - 0.02 * i as f32;
        let tilt = 0.02 * i as f32;
        // The same center for all.
        shape = shape.and(Shape::quad(
            [-size, -size, tilt],
            [2.0 * size, 0.0, 0.0],
            [0.0, 2.0 * size, -2.0 * tilt],
        ));
    }
    Build::default().shape(shape).light(Light::point([0.5, 0.4, 3.0])).scene
}

/// Slivers along the diagonal of the same square: every ray enters all of their boxes, and
/// few meet one.
fn thicket() -> Scene {
    let mut random = Random(13);
    let mut corners =
        || [-1.5, 1.5, 1.49].map(|side| (random.vector(0.05) + Vec3::new(side, side, 0.0)).to_array());
    let shape = (0..60_000).fold(Shape::default(), |all, _| all.and(Shape::triangle(corners())));
    Build::default().shape(shape).light(Light::point([0.5, 0.4, 3.0])).scene
}
