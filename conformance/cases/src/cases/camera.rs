//! Sizes, samples and cameras.

use crate::case::{Case, look, off_center, parallel, zoom};
use crate::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::scene::{Camera, Light, Scene};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "camera/one_pixel",
        claim: "A frame of one pixel has one block, whose other rays hit nothing.",
        scene: still_life,
        size: [1, 1],
        blank: true,
        ..Case::USUAL
    },
    Case {
        name: "camera/off_center",
        claim: "The middle of the picture may be beside the view, and its pixels wider than high.",
        scene: still_life,
        camera: off_center(-0.9, 0.3, -0.2, 0.5, look([0.0, 0.0, 4.0], [0.0, -0.2, 0.0])),
        size: [50, 37],
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "camera/one_column",
        claim: "A frame one pixel wide has blocks that reach outside of it.",
        scene: still_life,
        size: [1, 33],
        ..Case::USUAL
    },
    Case {
        name: "camera/one_row",
        claim: "A frame one pixel high has blocks that reach outside of it.",
        scene: still_life,
        camera: zoom(0.04, look([0.0, 0.0, 4.0], [0.0, -0.2, 0.0])),
        size: [47, 1],
        ..Case::USUAL
    },
    Case {
        name: "camera/whole_blocks",
        claim: "A frame of whole blocks has no ray outside.",
        scene: still_life,
        size: [48, 32],
        ..Case::USUAL
    },
    Case {
        name: "camera/odd_size",
        claim: "A frame may have any number of columns and rows.",
        scene: still_life,
        size: [61, 43],
        ..Case::USUAL
    },
    Case {
        name: "camera/four_samples",
        claim: "Four sub-rays are averaged in one order.",
        scene: still_life,
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "camera/sixteen_samples",
        claim: "Sixteen sub-rays are averaged in one order.",
        scene: still_life,
        samples: 16,
        size: [19, 13],
        ..Case::USUAL
    },
    Case {
        name: "camera/one_pixel_of_sixteen_samples",
        claim: "A block may hold more sub-rays than the frame has.",
        scene: still_life,
        samples: 16,
        size: [1, 1],
        blank: true,
        ..Case::USUAL
    },
    Case {
        name: "camera/wide",
        claim: "A field of view of 170 degrees loses nothing at its edges.",
        scene: still_life,
        camera: zoom(2.967, look([0.0, 0.0, 1.6], [0.0; 3])),
        ..Case::USUAL
    },
    Case {
        name: "camera/narrow",
        claim: "A field of view of half a degree hits what it shows.",
        scene: still_life,
        camera: zoom(0.01, look([30.0, 20.0, 100.0], [0.0, -0.2, 0.0])),
        ..Case::USUAL
    },
    Case {
        name: "camera/parallel",
        claim: "Parallel rays meet the same surfaces everywhere.",
        scene: still_life,
        camera: parallel(3.0, look([2.0, 1.5, 4.0], [0.0; 3])),
        ..Case::USUAL
    },
    Case {
        name: "camera/parallel_along_an_axis",
        claim: "Directions with zeros, and faces parallel to every ray, are decided alike.",
        scene: still_life,
        camera: parallel(3.0, look([0.0, 0.0, 4.0], [0.0; 3])),
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "camera/parallel_from_within",
        claim: "Rays that start inside of an instance's bounds meet only what is ahead.",
        scene: still_life,
        camera: parallel(2.0, look([0.0, 0.0, 0.0], [1.0, -1.0, -2.0])),
        ..Case::USUAL
    },
    Case {
        name: "camera/upside_down",
        claim: "The camera may be turned any way.",
        scene: still_life,
        camera: Camera { up: Vec3::new(0.3, -1.0, 0.2), ..look([-2.0, 1.0, 3.0], [0.0; 3]) },
        ..Case::USUAL
    },
    Case {
        name: "camera/straight_down",
        claim: "The camera may look along the axis that is usually up.",
        scene: still_life,
        camera: Camera { up: Vec3::Z, ..look([0.0, 5.0, 0.0], [0.0; 3]) },
        ..Case::USUAL
    },
    Case {
        name: "camera/far_away",
        claim: "Culling loses nothing to rounding at a distance of 100,000.",
        scene: still_life,
        camera: zoom(3e-5, look([30_000.0, 40_000.0, 80_000.0], [0.0; 3])),
        ..Case::USUAL
    },
    Case {
        name: "camera/large_coordinates",
        claim: "Culling loses nothing to rounding at coordinates of 1,000,000.",
        scene: far_from_the_origin,
        camera: look([1e6, -5e5, 2e6 + 4.0], [1e6, -5e5, 2e6]),
        ..Case::USUAL
    },
    Case {
        name: "camera/large_scene",
        claim: "A scene may be a million units large.",
        scene: large,
        camera: look([1e6, 5e5, 4e6], [0.0; 3]),
        ..Case::USUAL
    },
    Case {
        name: "camera/small_scene",
        claim: "A scene may be a millionth of a unit small.",
        scene: small,
        camera: look([1e-6, 5e-7, 4e-6], [0.0; 3]),
        ..Case::USUAL
    },
    Case {
        name: "camera/moved_far",
        claim: "An instance's own coordinates may be small where its place is far away.",
        scene: moved_far,
        camera: look([1e4 + 2.0, 1.0, -1e4 + 4.0], [1e4, 0.0, -1e4]),
        ..Case::USUAL
    },
];

/// A cube, a ball and some triangles on a floor, with two lights.
fn shapes(center: [f32; 3], scale: f32) -> Shape {
    Shape::floor(3.0, -1.0)
        .and(Shape::cube().at([-0.8, -0.5, 0.0], 0.5))
        .and(Shape::ball(6).at([0.7, -0.3, 0.1], 0.6))
        .and(Shape::soup(&mut Random(1), 30, 0.3))
        .at(center, scale)
}

fn still_life() -> Scene {
    Build::default()
        .shape(shapes([0.0; 3], 1.0))
        .light(Light::point([1.0, 3.0, 2.0]))
        .light(Light::sun([-0.4, -1.0, 0.3]))
        .scene
}

fn far_from_the_origin() -> Scene {
    let center = [1e6, -5e5, 2e6];
    Build::default().shape(shapes(center, 1.0)).light(Light::point([1e6 + 1.0, 3.0 - 5e5, 2e6 + 2.0])).scene
}

fn large() -> Scene {
    Build::default().shape(shapes([0.0; 3], 1e6)).light(Light::point([1e6, 3e6, 2e6]).reach(1e7)).scene
}

fn small() -> Scene {
    Build::default().shape(shapes([0.0; 3], 1e-6)).light(Light::point([1e-6, 3e-6, 2e-6])).scene
}

fn moved_far() -> Scene {
    let mut build = Build::default();
    let mesh = build.mesh(shapes([0.0; 3], 1.0));
    build.instance(mesh, Mat4::from_translation(Vec3::new(1e4, 0.0, -1e4)));
    build.light(Light::point([1e4 + 1.0, 3.0, 2.0 - 1e4])).scene
}
