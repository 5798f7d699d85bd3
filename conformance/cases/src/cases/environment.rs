//! Environments: behind everything, mirrored, and as light.

use crate::case::{Case, look, parallel};
use crate::shape::{Build, Random, Shape};
use alloc::vec;
use glam::Vec3;
use rtrt_core::layout::Wrap;
use rtrt_core::scene::{Cube, Image, Light, Material, Panorama, Scene};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "environment/alone",
        claim: "Rays that hit nothing see the environment, in every direction.",
        scene: || around(Build::default(), 64, 32),
        camera: look([0.0; 3], [1.0, -0.7, 0.6]),
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "environment/in_parallel",
        claim: "Parallel rays all see the same place of it.",
        scene: || around(Build::default().shape(Shape::ball(5)), 64, 32),
        camera: parallel(4.0, look([2.0, 3.0, 4.0], [0.0; 3])),
        ..Case::USUAL
    },
    Case {
        name: "environment/mirrored",
        claim: "Mirrors, from smooth to rough, of metal or not, show it alike.",
        scene: mirrors,
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "environment/as_light",
        claim: "It lights diffuse surfaces by their normals, besides the scene's lights.",
        scene: || {
            let rough = Material::new([0.8; 3]);
            let build = Build::default().shape_of(Shape::ball(8), rough).shape(Shape::floor(3.0, -1.2));
            around(build.light(Light::point([2.0, 1.0, 2.0])), 64, 32)
        },
        ..Case::USUAL
    },
    Case {
        name: "environment/turned",
        claim: "Turned, brighter, and blurred behind everything, it lights and is mirrored from elsewhere.",
        scene: || {
            let mut scene = mirrors();
            scene.environment_rotation = 1.9;
            scene.environment_intensity = 1.75;
            scene.environment_blur = 0.4;
            scene.backdrop_strength = 0.75;
            scene
        },
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "environment/behind_and_in_textures",
        claim: "A texture colors what a metal mirrors; unlit surfaces mirror nothing.",
        scene: || {
            let mut build = Build::default();
            let mut random = Random(5);
            let rgba = (0..9 * 9 * 4).map(|_| random.bits() as u8).collect();
            let image = Image { width: 9, height: 9, rgba };
            let map = build.scene.add_texture(&image, [Wrap::Repeat; 2]).expect("room");
            let metal = Material::new([0.9, 0.8, 0.6]).metallic(1.0).roughness(0.2).base_color_map(map);
            let unlit = metal.unlit(true);
            let build = build
                .shape_of(Shape::ball(6).at([-0.9, 0.0, 0.0], 0.8), metal)
                .shape_of(Shape::ball(6).at([0.9, 0.0, 0.0], 0.8), unlit);
            around(build, 64, 32)
        },
        ..Case::USUAL
    },
    Case {
        name: "environment/cube",
        claim: "A cube is looked up alike on all of its sides.",
        scene: || {
            let mut scene = Build::default().shape(Shape::ball(6)).scene;
            let mut random = Random(12);
            let faces = core::array::from_fn(|_| {
                let tone = random.vector(0.5) + 0.5;
                (0..9 * 9).map(|_| (tone + random.vector(0.2)).to_array()).collect()
            });
            scene.set_cube(&Cube { side: 9, faces }).expect("a cube");
            scene
        },
        camera: look([0.0, 0.4, 1.1], [1.0, -0.7, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "environment/of_few_pixels",
        claim: "A panorama may have any size, and be brighter than texels can tell.",
        scene: || {
            let build = Build::default().shape(Shape::ball(6));
            let mut scene = build.scene;
            // Only the reflection in the ball shows the environment behind the camera.
            let mut rgb = vec![[0.2, -3.0, 1e-9], [1e-12, 0.5, 0.1], [0.3, 0.1, f32::NAN], [0.05, 0.0, 0.4]];
            rgb.extend([[0.1, 0.3, 0.1], [0.2; 3], [1e9, 0.0, 3.0]]);
            scene.set_environment(&Panorama { width: 7, height: 1, rgb }).expect("a panorama");
            scene
        },
        ..Case::USUAL
    },
];

/// The scene in the middle of a sky with a sun, and a ground, both of noise.
pub(super) fn around(build: Build, width: u32, height: u32) -> Scene {
    let mut random = Random(99);
    let light = |i: u32| {
        let (x, y) = (i % width, i / width);
        let noise = random.vector(0.3) + 0.3;
        let sun = x / 3 == 5 && y / 3 == 3;
        let color = match (sun, y < height / 2) {
            (true, _) => Vec3::new(80.0, 70.0, 50.0),
            (false, true) => Vec3::new(0.3, 0.5, 0.9) + noise,
            (false, false) => Vec3::new(0.4, 0.3, 0.2) * noise,
        };
        color.to_array()
    };
    let rgb = (0..width * height).map(light).collect();
    let mut scene = build.scene;
    scene.set_environment(&Panorama { width, height, rgb }).expect("a panorama");
    scene
}

fn mirrors() -> Scene {
    let mut build = Build::default();
    for i in 0..10_u32 {
        let (column, row) = ((i % 5) as f32, (i / 5) as f32);
        let material = Material::new([0.9, 0.7, 0.4]).metallic(row).roughness(column / 4.0);
        build =
            build.shape_of(Shape::ball(7).at([0.8 * column - 1.6, 0.9 * row - 0.45, 0.0], 0.38), material);
    }
    around(build, 64, 32)
}
