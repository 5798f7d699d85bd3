//! Scenes whose instances have moved, are hidden, or have another shape than at first.

use crate::case::{Case, look};
use crate::shape::{Build, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::scene::{Light, Motion, Scene};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "motion/moved_and_turned",
        claim: "Objects that were moved are met, and throw shadows, where they are.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(5.0, -1.0));
            let cube = build.mesh(Shape::cube());
            let starts = [-1.5_f32, 0.0, 1.5]
                .map(|x| Mat4::from_translation(Vec3::new(x, 0.0, 0.0)) * Mat4::from_scale(Vec3::splat(0.4)));
            let instances = starts.map(|start| build.instance(cube, start));
            let moved = instances.iter().zip(starts).enumerate().map(|(i, (instance, start))| {
                let i = i as f32;
                let motion =
                    Motion { velocity: Vec3::new(0.1, 0.3 * i, -0.2), axis: Vec3::ONE, rate: 0.5 + i };
                (*instance, motion.at(start, 1.25))
            });
            build.scene.set_transforms(moved).expect("within range");
            build.light(Light::point([2.0, 3.0, 3.0])).scene
        },
        camera: look([0.0, 1.0, 4.0], [0.0; 3]),
        ..Case::USUAL
    },
    Case {
        name: "motion/hidden",
        claim: "A hidden instance is not met and throws no shadow; the others keep their numbers.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(5.0, -1.0));
            let ball = build.mesh(Shape::ball(4));
            let balls = [-1.2, 0.0, 1.2]
                .map(|x| build.instance(ball, Mat4::from_translation(Vec3::new(x, 0.0, 0.0))));
            build.scene.hide(balls[1]).expect("it is there");
            build.light(Light::point([2.0, 3.0, 3.0])).scene
        },
        ..Case::USUAL
    },
    Case {
        name: "motion/levels_of_detail",
        claim: "Each instance has the mesh that its distance asks for, to the eye and to light.",
        scene: levels,
        size: [61, 45],
        camera: look([0.0, 2.0, 4.0], [0.0, 0.0, -2.0]),
        ..Case::USUAL
    },
    Case {
        name: "motion/reshaped",
        claim: "A refitted tree loses no hit, however far corners have gone from where it was built.",
        scene: || {
            let mut build = Build::default();
            let ball = build.mesh(Shape::ball(9));
            build.instance(ball, Mat4::IDENTITY);
            let twist = |p: [f32; 3]| {
                let (sin, cos) = (libm::sinf(4.0 * p[1]), libm::cosf(4.0 * p[1]));
                [p[0] * cos - p[2] * sin + 0.5 * sin, 1.3 * p[1], 0.2 * p[0] * sin + p[2] * cos]
            };
            build.scene.reshape(ball, &Shape::ball(9).bent(twist).mesh()).expect("within range");
            build.shape(Shape::floor(5.0, -1.5)).light(Light::point([2.0, 3.0, 3.0])).scene
        },
        ..Case::USUAL
    },
];

/// Balls in rows, of fewer triangles the farther away they are; some moved, one hidden.
fn levels() -> Scene {
    let mut build = Build::default().shape(Shape::floor(20.0, -0.5));
    let [near, middle, far] = [7, 4, 2].map(|steps| build.mesh(Shape::ball(steps)));
    for i in 0..30 {
        let place = |row: f32| {
            Mat4::from_translation(Vec3::new((i % 5) as f32 - 2.0, 0.0, -row))
                * Mat4::from_scale(Vec3::splat(0.4))
        };
        let ball = build.instance(near, place(0.0));
        build.scene.set_levels(ball, &[(8.0, far), (5.0, middle)]).expect("a case's levels");
        build.scene.set_transform(ball, place((i / 5) as f32 * 1.3)).expect("within range");
    }
    let hidden = build.scene.instance_index(7).expect("it is there");
    build.scene.hide(hidden).expect("it is there");
    build.light(Light::point([2.0, 5.0, 0.0])).scene
}
