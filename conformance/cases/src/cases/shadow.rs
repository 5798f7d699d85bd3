//! Shadows: which lights reach a surface.

use crate::case::{Case, look};
use crate::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::backend::Shadows;
use rtrt_core::scene::Light;

const FROM_ABOVE: Case = Case { camera: look([0.5, 2.5, 4.0], [0.0, -0.5, 0.0]), ..Case::USUAL };

pub(super) const CASES: &[Case] = &[
    Case {
        name: "shadow/point",
        claim: "Objects cast shadows in the light of a bulb.",
        scene: || room(Light::point([1.5, 2.0, 1.0])).scene,
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/four_samples",
        claim: "Each sub-ray has its own shadow rays.",
        scene: || room(Light::point([-1.5, 2.0, 1.0])).scene,
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/sun",
        claim: "Objects cast shadows in parallel light.",
        scene: || room(Light::sun([-0.6, -1.0, -0.3])).scene,
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/sun_along_an_axis",
        claim: "Directions with zeros, and faces along the light, are decided alike.",
        scene: || room(Light::sun([0.0, -1.0, 0.0])).scene,
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/off",
        claim: "Without shadows everything that faces a light is lit.",
        scene: || room(Light::point([1.5, 2.0, 1.0])).scene,
        shadows: Shadows::Off,
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/light_inside_an_object",
        claim: "A light inside of a ball lights only the inside.",
        scene: || {
            let ball = Shape::ball(6).at([0.0, 0.2, 0.0], 0.8);
            Build::default()
                .shape(Shape::floor(3.0, -1.0))
                .shape(ball)
                .light(Light::point([0.1, 0.3, 0.1]))
                .light(Light::sun([1.0, -1.0, 0.0]))
                .scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/light_in_a_surface",
        claim: "A light exactly in a surface, and in a corner, is decided alike.",
        scene: || room(Light::point([0.0, -1.0, 0.0])).light(Light::point([0.4, 0.0, 0.4])).scene,
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/beyond_the_light",
        claim: "What is beyond the light casts no shadow on this side.",
        scene: || {
            let ceiling = Shape::floor(3.0, 1.0);
            room(Light::point([0.0, 0.8, 0.9])).shape(ceiling).scene
        },
        camera: look([0.5, 0.5, 4.0], [0.0, -0.5, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "shadow/from_a_diagonal",
        claim: "Shadow rays between two faces of a light's cube find what stands there.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(2.0, -1.0));
            let cube = build.mesh(Shape::cube());
            for (x, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0), (0.5, 0.5), (0.0, 0.5)] {
                let at = Mat4::from_translation(Vec3::new(x * 0.5, -0.5, z * 0.5));
                build.instance(cube, at * Mat4::from_scale(Vec3::splat(0.08)));
            }
            build.light(Light::point([0.0; 3])).scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/beyond_the_reach",
        claim: "A light lights nothing beyond its reach, and its lists hold nothing there.",
        scene: || room(Light::point([0.9, 0.6, 0.6]).reach(1.5)).scene,
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/terminator",
        claim: "Smooth normals and flat triangles disagree at the edge of light alike.",
        scene: || {
            Build::default()
                .shape(Shape::ball(4))
                .light(Light::point([6.0, 1.0, 1.0]))
                .light(Light::sun([0.0, 1.0, -0.1]))
                .scene
        },
        ..Case::USUAL
    },
    Case {
        name: "shadow/touching",
        claim: "Surfaces that touch, overlap and repeat shadow each other alike.",
        scene: || {
            let cube = Shape::cube().at([0.0, -0.5, 0.0], 0.5);
            let floor = Shape::floor(3.0, -1.0);
            Build::default()
                .shape(floor.clone().and(cube.clone()))
                .shape(floor)
                .shape(cube)
                .light(Light::point([2.0, 1.0, 1.0]))
                .light(Light::sun([1.0, -0.5, 0.2]))
                .scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/from_far_away",
        claim: "A bulb at a distance of 100,000 still finds what stands before it.",
        scene: || room(Light::point([3e4, 8e4, 5e4])).scene,
        ..FROM_ABOVE
    },
    Case {
        name: "shadow/many_occluders",
        claim: "Thousands of triangles in the way of every light are all asked.",
        scene: || {
            let leaves = Shape::soup(&mut Random(10), 1500, 0.08).at([0.0, 0.6, 0.0], 1.0);
            Build::default()
                .shape(Shape::floor(3.0, -1.0))
                .shape(leaves)
                .light(Light::sun([0.2, -1.0, 0.1]))
                .light(Light::point([0.0, 0.6, 0.0]))
                .scene
        },
        ..FROM_ABOVE
    },
];

/// A cube, a ball and a turned bar on a floor.
pub(super) fn room(light: Light) -> Build {
    let fixed = Shape::floor(3.0, -1.0).and(Shape::ball(5).at([0.8, -0.4, -0.3], 0.6));
    let mut build = Build::default().shape(fixed).shape(Shape::cube().at([0.0, -0.4, 0.0], 0.4));
    let bar = build.mesh(Shape::cube());
    let turn = Mat4::from_rotation_y(0.8) * Mat4::from_rotation_x(0.5);
    let place = Mat4::from_translation(Vec3::new(-1.0, -0.3, 0.2));
    build.instance(bar, place * turn * Mat4::from_scale(Vec3::new(0.1, 0.7, 0.15)));
    build.light(light)
}
