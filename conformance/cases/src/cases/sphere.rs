//! Spheres: as an eye, light and layers meet them.

use crate::case::{Case, look, parallel, zoom};
use crate::shape::{Build, Random, Shape};
use alloc::vec::Vec;
use glam::{Mat4, Quat, Vec3};
use rtrt_core::backend::Shadows;
use rtrt_core::layout::Wrap;
use rtrt_core::scene::{Image, Light, Material, MaterialIndex};

const FROM_ABOVE: Case = Case { camera: look([0.5, 2.5, 4.0], [0.0, -0.4, 0.0]), ..Case::USUAL };

pub(super) const CASES: &[Case] = &[
    Case {
        name: "sphere/one",
        claim: "A sphere is met, lit, and casts a round shadow.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
            add(&mut build, ball([0.0; 3], 1.0));
            build.light(Light::point([1.5, 3.0, 2.0])).light(Light::sun([-1.0, -1.0, -0.2])).scene
        },
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "sphere/its_own_space",
        claim: "A sphere without a transform is met without one.",
        scene: || {
            let mut build = Build::default();
            add(&mut build, Mat4::IDENTITY);
            build.light(Light::point([1.0, 1.0, 3.0])).scene
        },
        ..Case::USUAL
    },
    Case {
        name: "sphere/ellipsoids",
        claim: "Matrices turn, stretch and mirror spheres; some are as flat as plates, some needles.",
        scene: || {
            let mut random = Random(5);
            let mut build = Build::default().shape(Shape::floor(4.0, -1.5));
            for _ in 0..40 {
                let size = random.vector(0.5) + 0.01;
                let turn = Quat::from_axis_angle(random.vector(1.0).normalize(), random.within(0.0, 6.0));
                add(&mut build, Mat4::from_scale_rotation_translation(size, turn, random.vector(1.6)));
            }
            build.light(Light::point([1.0, 3.0, 2.0])).light(Light::sun([0.3, -1.0, -0.4])).scene
        },
        size: [61, 47],
        ..Case::USUAL
    },
    Case {
        name: "sphere/among_meshes",
        claim: "Spheres and meshes hide and shadow one another by their distance alone.",
        scene: || {
            let mut build =
                Build::default().shape(Shape::floor(3.0, -1.0)).shape(Shape::cube().at([0.7, 0.0, 0.0], 0.6));
            add(&mut build, ball([0.0, 0.0, 0.2], 0.7));
            let mut build = build.shape(Shape::soup(&mut Random(3), 80, 0.3));
            add(&mut build, ball([-0.9, 0.1, -0.3], 0.6));
            build
                .light(Light::point([0.2, 3.0, 2.0]))
                .light(Light::spot([-2.0, 3.0, 0.0], [1.0, -1.5, 0.0], 0.5))
                .scene
        },
        size: [61, 47],
        ..FROM_ABOVE
    },
    Case {
        name: "sphere/from_within",
        claim: "From inside of a sphere its far side is seen, lit from within.",
        scene: || {
            let mut build = Build::default();
            add(&mut build, ball([0.2, 0.0, 0.0], 2.0));
            add(&mut build, ball([0.4, 0.0, -1.0], 0.3));
            build.light(Light::point([-0.4, 0.9, 0.4])).scene
        },
        camera: look([0.3, 0.0, 0.4], [0.0, 0.2, -1.0]),
        ..Case::USUAL
    },
    Case {
        name: "sphere/the_same_place",
        claim: "Of spheres at the same place the one with the lowest index is seen.",
        scene: || {
            let mut build = Build::default();
            for color in [[0.9, 0.1, 0.1], [0.1, 0.9, 0.1], [0.1, 0.1, 0.9]] {
                let material =
                    build.scene.add_material(Material::new(color).roughness(0.5)).expect("a case's material");
                build.scene.add_sphere(material, ball([0.1, 0.0, 0.0], 0.9)).expect("a case's sphere");
            }
            build.light(Light::sun([-0.3, -0.4, -1.0])).scene
        },
        ..Case::USUAL
    },
    Case {
        name: "sphere/touching",
        claim: "Rays that touch a sphere at its highest point are met or not, alike.",
        scene: || {
            let mut build = Build::default();
            for i in 0..6 {
                add(&mut build, ball([i as f32 * 0.25 - 0.75, 0.0, 0.0], 0.125));
            }
            build.light(Light::sun([0.0, -0.1, -1.0])).scene
        },
        // A ray goes through every odd multiple of 1/32, and so through every edge.
        camera: parallel(2.0, look([0.0, 0.0, 4.0], [0.0; 3])),
        size: [32, 32],
        ..Case::USUAL
    },
    Case {
        name: "sphere/small_and_far",
        claim: "A small sphere far away is round, and does not shadow itself.",
        scene: || {
            let mut build = Build::default();
            add(&mut build, ball([0.0; 3], 1.0));
            build.light(Light::point([3.0, 2.0, 4.0])).scene
        },
        camera: zoom(3e-4, look([3000.0, 2000.0, 6000.0], [0.0; 3])),
        ..Case::USUAL
    },
    Case {
        name: "sphere/a_planet",
        claim: "The ground may be a sphere of a hundred kilometers, and does not shadow itself.",
        scene: || {
            let mut build = Build::default();
            add(&mut build, ball([0.0, -1e5, 0.0], 1e5));
            add(&mut build, ball([0.3, 1.0, -1.0], 1.0));
            build.light(Light::point([3.0, 5.0, 2.0])).scene
        },
        camera: look([0.0, 2.0, 6.0], [0.0, 0.5, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "sphere/flat_light",
        claim: "No sphere shadows itself where light grazes it.",
        scene: || {
            let mut build = Build::default();
            for i in 0..9 {
                add(&mut build, ball([(i % 3) as f32 * 0.9 - 0.9, (i / 3) as f32 * 0.7 - 0.7, 0.0], 0.33));
            }
            build.light(Light::sun([-1.0, -0.02, 0.05])).light(Light::sun([0.01, -1.0, 0.02])).scene
        },
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "sphere/texture",
        claim: "A texture lies on a sphere by longitude and latitude, and is coarser where it is small.",
        scene: || {
            let mut build = Build::default();
            let map = textured(&mut build, 0.0);
            build.scene.add_sphere(map, ball([-0.8, 0.0, 0.0], 0.9)).expect("a case's sphere");
            let tilted = Mat4::from_translation(Vec3::new(1.1, 0.0, 0.3))
                * Mat4::from_rotation_x(0.9)
                * Mat4::from_scale(Vec3::new(0.8, 0.5, 0.6));
            build.scene.add_sphere(map, tilted).expect("a case's sphere");
            build.scene.add_sphere(map, ball([0.2, 0.9, -2.0], 0.2)).expect("a case's sphere");
            build.light(Light::point([1.0, 1.0, 3.0])).scene
        },
        size: [61, 41],
        ..Case::USUAL
    },
    Case {
        name: "sphere/glass",
        claim: "A sphere of glass is two layers, which both take from light.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
            for (color, place) in [([0.9, 0.2, 0.1], [-0.5, 0.0, 0.0]), ([0.1, 0.3, 0.9], [0.5, 0.0, 0.4])] {
                let glass = build.scene.add_material(glass(color, 0.3)).expect("a case's material");
                build.scene.add_sphere(glass, ball(place, 0.8)).expect("a case's sphere");
            }
            add(&mut build, ball([0.0, -0.3, -0.2], 0.3));
            build.light(Light::point([0.6, 3.0, 1.0])).light(Light::sun([0.4, -1.0, -0.3])).scene
        },
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "sphere/one_sided",
        claim: "The camera looks out of a sphere that is not double-sided; its shadow is whole.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
            let one_sided = Material::new([0.7, 0.4, 0.2]).roughness(0.5).double_sided(false);
            let one_sided = build.scene.add_material(one_sided).expect("a case's material");
            for place in [ball([0.1, 0.1, 3.8], 0.9), ball([-0.8, 0.0, 0.0], 0.7)] {
                build.scene.add_sphere(one_sided, place).expect("a case's sphere");
            }
            add(&mut build, ball([0.8, -0.2, 0.0], 0.6));
            build.light(Light::point([2.0, 2.0, 6.0])).light(Light::sun([-0.4, -1.0, -0.6])).scene
        },
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "sphere/mask",
        claim: "A masked sphere has holes, through which its inside is seen.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
            let mask = textured(&mut build, 0.6);
            build.scene.add_sphere(mask, ball([0.0; 3], 1.0)).expect("a case's sphere");
            build.light(Light::point([0.6, 3.0, 2.0])).scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "sphere/moved_and_hidden",
        claim: "Spheres move, and can be hidden.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
            let all: Vec<_> = (0..4)
                .map(|i| {
                    build
                        .scene
                        .add_sphere(build.gray, ball([i as f32, 5.0, 0.0], 0.1))
                        .expect("a case's sphere")
                })
                .collect();
            build.scene.set_transform(all[0], ball([-0.6, 0.0, 0.0], 0.5)).expect("a place");
            build.scene.set_transform(all[2], ball([0.6, 0.0, 0.0], 0.7)).expect("a place");
            build.scene.hide(all[1]).expect("a sphere");
            build.light(Light::point([1.0, 3.0, 2.0])).scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "sphere/lights_that_show",
        claim: "Lights show as spheres, which shadow what other lights shine on and not their own.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
            add(&mut build, ball([0.0, -0.5, 0.0], 0.5));
            for light in [
                Light::point([-0.9, 0.4, 0.3]),
                Light::point([0.8, 0.9, 0.0]),
                Light::spot([0.0, 1.2, 0.9], [0.0, -1.0, -0.4], 0.7),
            ] {
                build = build.light(light.radius(0.2));
            }
            for light in [0, 1, 2, 1] {
                build.scene.show_light(light).expect("it is there").expect("it has a radius");
            }
            build.scene
        },
        shadows: Shadows::Hard,
        size: [61, 45],
        ..FROM_ABOVE
    },
    Case {
        name: "sphere/soft_lights_that_show",
        claim: "The same where their shadows are soft, and panes are between.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
            let glass = build.scene.add_material(glass([0.9, 0.3, 0.1], 0.4)).expect("a case's material");
            build.scene.add_sphere(glass, ball([0.0, -0.4, 0.0], 0.5)).expect("a case's sphere");
            let mut build = build
                .light(Light::point([-0.7, 0.6, 0.3]).radius(0.2))
                .light(Light::point([0.8, 0.9, 0.0]).radius(0.1));
            for light in 0..2 {
                build.scene.show_light(light).expect("it is there").expect("it has a radius");
            }
            build.scene
        },
        size: [61, 45],
        ..FROM_ABOVE
    },
    Case {
        name: "sphere/thousands",
        claim: "Two thousand spheres are binned, met and shadowed alike.",
        scene: || {
            let mut random = Random(12);
            let mut build = Build::default().shape(Shape::floor(4.0, -1.5));
            for _ in 0..2000 {
                let (at, radius) = (random.vector(1.4).to_array(), random.within(0.01, 0.06));
                add(&mut build, ball(at, radius));
            }
            build.light(Light::point([1.0, 3.0, 2.0])).scene
        },
        size: [61, 45],
        ..Case::USUAL
    },
];

/// The matrix of a ball.
fn ball(center: [f32; 3], radius: f32) -> Mat4 {
    Mat4::from_translation(center.into()) * Mat4::from_scale(Vec3::splat(radius))
}

/// Adds a gray sphere.
fn add(build: &mut Build, place: Mat4) {
    build.scene.add_sphere(build.gray, place).expect("a case's sphere");
}

fn glass(base: [f32; 3], alpha: f32) -> Material {
    Material::new(base).roughness(0.4).blend(alpha)
}

/// A material whose texture has a color of its own at each texel; masked at a cutoff above 0.
fn textured(build: &mut Build, cutoff: f32) -> MaterialIndex {
    let mut random = Random(16);
    let rgba = (0..4 * 16 * 8).map(|_| random.bits() as u8).collect();
    let image = Image { width: 16, height: 8, rgba };
    let map = build.scene.add_texture(&image, [Wrap::Repeat, Wrap::Clamp]).expect("room");
    let mut material = Material::new([0.9; 3]).roughness(0.5);
    material.base_color_map = Some(map);
    if cutoff > 0.0 {
        material = material.mask(cutoff);
    }
    build.scene.add_material(material).expect("a case's material")
}
