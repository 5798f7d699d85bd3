//! Light from all around, hidden by what is near.

use crate::case::{Case, look, parallel};
use crate::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::backend::Shadows;
use rtrt_core::scene::{AlphaMode, Light, Material, Scene, Structure};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "ambient/corner",
        claim: "Corners, and what stands on a floor, are darker.",
        scene: corner,
        camera: look([2.0, 1.5, 4.0], [0.0; 3]),
        ambient_occlusion: 1.5,
        ..Case::USUAL
    },
    Case {
        name: "ambient/parallel",
        claim: "The same for parallel rays, four to a pixel, with soft shadows.",
        scene: corner,
        camera: parallel(4.0, look([2.0, 1.5, 4.0], [0.0; 3])),
        samples: 4,
        shadows: Shadows::Soft,
        ambient_occlusion: 1.5,
        ..Case::USUAL
    },
    Case {
        name: "ambient/behind_panes",
        claim: "Panes hide nothing; what is behind them is as dark as without them.",
        scene: panes,
        samples: 4,
        ambient_occlusion: 2.0,
        ..Case::USUAL
    },
    Case {
        name: "ambient/without_lists",
        claim: "Lists of blocks decide nothing.",
        scene: || {
            let mut scene = swarm();
            scene.structure = Structure::None;
            scene
        },
        ambient_occlusion: 0.7,
        ..Case::USUAL
    },
    Case {
        name: "ambient/swarm",
        claim: "Many objects, among them spheres, hide light from one another.",
        scene: swarm,
        samples: 16,
        ambient_occlusion: 0.7,
        ..Case::USUAL
    },
    Case {
        name: "ambient/caught",
        claim: "A surface that catches shadows shows this darkness too.",
        scene: || {
            let mut ground = Material::default();
            ground.alpha_mode = AlphaMode::Shadows;
            let ball = Shape::ball(6).at([0.0, -0.4, 0.0], 0.6);
            let mut build = Build::default().shape_of(Shape::floor(3.0, -1.0), ground).shape(ball);
            build.scene.ambient = Vec3::splat(0.7);
            build.scene.background = Vec3::new(0.3, 0.5, 0.7);
            build.light(Light::sun([0.4, -1.0, -0.3])).scene
        },
        camera: look([0.0, 1.0, 4.0], [0.0, -0.5, 0.0]),
        ambient_occlusion: 1.0,
        ..Case::USUAL
    },
];

fn corner() -> Scene {
    let ball = Shape::ball(6).at([0.3, -0.4, 0.2], 0.6);
    let cube = Shape::cube().at([-0.9, -0.7, -0.3], 0.3);
    let walls = Shape::quad([-1.5, -1.0, -1.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]).and(Shape::quad(
        [-1.5, -1.0, 3.0],
        [0.0, 0.0, -4.0],
        [0.0, 3.0, 0.0],
    ));
    let glossy = Material::new([0.8, 0.6, 0.3]).metallic(1.0).roughness(0.3);
    let mut build =
        Build::default().shape(Shape::floor(3.0, -1.0)).shape(walls).shape_of(ball, glossy).shape(cube);
    build.scene.ambient = Vec3::new(0.8, 0.9, 1.0);
    build.light(Light::point([1.5, 1.0, 2.0]).radius(0.3)).scene
}

fn panes() -> Scene {
    let pane = Material::new([0.9, 0.5, 0.4]).blend(0.4).double_sided(true);
    let mut build =
        Build::default().shape(Shape::floor(3.0, -1.0)).shape(Shape::ball(6).at([0.0, -0.5, 0.0], 0.5));
    for z in [0.6, 1.2] {
        build = build.shape_of(Shape::quad([-1.0, -1.0, z], [1.5, 0.0, 0.0], [0.0, 1.5, 0.0]), pane);
    }
    build.scene.ambient = Vec3::splat(0.9);
    build.light(Light::point([0.0, 1.0, 3.0])).scene
}

fn swarm() -> Scene {
    let mut random = Random(11);
    let mut build = Build::default();
    let cube = build.mesh(Shape::cube());
    for number in 0..60 {
        let place = Mat4::from_translation(random.vector(1.2))
            * Mat4::from_scale(Vec3::splat(random.within(0.1, 0.3)));
        let turned = place * Mat4::from_rotation_y(random.within(0.0, 3.0));
        if number % 3 == 0 {
            build.scene.add_sphere(build.gray, turned).expect("room");
        } else {
            build.instance(cube, turned);
        }
    }
    build.scene.ambient = Vec3::splat(1.0);
    build.scene
}
