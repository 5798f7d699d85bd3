//! What arrives from lights: how they fade, how many there are, how surfaces answer.

use crate::case::{Case, look};
use crate::shape::{Build, Random, Shape};
use core::f32::consts::PI;
use glam::{Mat4, Vec3};
use rtrt_core::backend::Shadows;
use rtrt_core::layout::{COLOR_LIMIT, LIGHT_LIMIT};
use rtrt_core::scene::{Light, Material, Scene};

const FROM_ABOVE: Case = Case { camera: look([0.5, 2.5, 4.0], [0.0, -0.5, 0.0]), ..Case::USUAL };

pub(super) const CASES: &[Case] = &[
    Case {
        name: "light/none",
        claim: "A scene without lights shows its ambient light.",
        scene: || {
            let ball = Shape::ball(5).painted(&mut Random(11));
            Build::default().shape(ball).scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "light/linear",
        claim: "Light that fades linearly is 0 at its reach.",
        scene: || lit([Light::point([0.6, 0.3, 0.4]).reach(2.0)]),
        ..FROM_ABOVE
    },
    Case {
        name: "light/just_within_its_reach",
        claim: "The last hundredth of a light's reach is lit, and what stands there casts a shadow.",
        scene: || {
            let stone = Shape::quad([0.0005, -0.993, 0.0015], [0.002, 0.0, 0.0], [0.0, 0.0, -0.003]);
            Build::default()
                .shape(Shape::floor(0.02, -1.0))
                .shape(stone)
                .light(Light::point([0.0; 3]).reach(1.005))
                .scene
        },
        // From between the two.
        camera: look([0.0, -0.996, 0.003], [0.0, -1.0, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "light/as_bright_as_may_be",
        claim: "The brightest lights at the brightest surfaces, touching them, give numbers.",
        scene: || {
            let dazzling = Material::new([COLOR_LIMIT; 3])
                .metallic(0.5)
                .roughness(0.0)
                .emission([LIGHT_LIMIT; 3])
                .specular([COLOR_LIMIT, 0.0, 0.5]);
            let mut build = Build::default().shape_of(Shape::floor(2.0, -0.5), dazzling);
            let dull = Material::new([1.0, 0.5, 0.0]);
            build = build.shape_of(Shape::ball(6).at([0.5, 0.0, 0.0], 0.4), dull);
            for (x, height) in [(-0.4, 0.0), (-0.2, 1e-9), (0.0, 1e-6), (0.2, 1e-3), (0.4, 1.0)] {
                build = build.light(
                    Light::point(Vec3::new(x, height - 0.5, 0.3))
                        .color(Vec3::new(LIGHT_LIMIT, 1e-3, -LIGHT_LIMIT))
                        .inverse_square(true),
                );
            }
            build.light(Light::sun([0.2, -1.0, -0.3])).scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "light/inverse_square",
        claim: "Light that fades by the square ends at its reach.",
        scene: || lit([square([0.6, 0.3, 0.4], Some(2.5))]),
        ..FROM_ABOVE
    },
    Case {
        name: "light/inverse_square_without_reach",
        claim: "Light that fades by the square needs no reach.",
        scene: || lit([square([0.6, 0.3, 0.4], None)]),
        ..FROM_ABOVE
    },
    Case {
        name: "light/without_reach",
        claim: "Light may not fade at all.",
        scene: || lit([Light::point([-0.6, 0.3, 0.4])]),
        ..FROM_ABOVE
    },
    Case {
        name: "light/very_near",
        claim: "A light a millionth of a unit above a surface is as bright everywhere.",
        scene: || lit([square([0.3, -1.0 + 1e-6, 0.9], None), Light::point([-0.6, -1.0 + 1e-3, 0.4])]),
        ..FROM_ABOVE
    },
    Case {
        name: "light/spot",
        claim: "A spot light casts shadows within its cone, and ends at its edge.",
        scene: || lit([Light::spot([1.0, 1.5, 0.5], [-1.0, -2.0, -0.5], 0.5)]),
        ..FROM_ABOVE
    },
    Case {
        name: "light/spot_with_a_hard_edge",
        claim: "The inner angle of a cone may be the outer one.",
        scene: || {
            let light = Light::spot([0.2, 0.9, 0.1], [0.1, -1.0, 0.1], 0.7);
            lit([light.inner(light.outer).reach(2.3).inverse_square(true)])
        },
        ..FROM_ABOVE
    },
    Case {
        name: "light/spots_through_edges_and_corners",
        claim: "A cone may cross edges and corners of the cube around its light, or be half of space.",
        scene: || {
            lit([
                Light::spot([0.0, 0.6, 0.0], [1.0, -1.0, 0.0], 0.3),
                Light::spot([0.0, 0.6, 0.0], [-1.0, -1.0, 1.0], 0.2),
                Light::spot([0.0, 0.6, 0.0], [-1.0, 0.01, -1.0], core::f32::consts::FRAC_PI_2),
            ])
        },
        ..FROM_ABOVE
    },
    Case {
        name: "light/spot_through_the_last_face",
        claim: "A spot light's cone may miss the first face of its cube.",
        scene: || lit([Light::spot([0.2, -0.4, 3.0], [0.0, 0.0, -1.0], 0.2)]),
        ..FROM_ABOVE
    },
    Case {
        name: "light/without_shadows",
        claim: "A light without shadows lights what faces it, whatever stands between; the others cast theirs.",
        scene: || {
            let shadowless = [
                Light::sun([-1.0, -1.0, -0.5]).color(Vec3::new(0.3, 0.0, 0.0) * PI).radius(0.1),
                Light::point([1.5, 1.0, 0.5]).color(Vec3::new(0.0, 0.3, 0.0) * PI).radius(0.2),
                Light::spot([0.0, 1.5, 1.0], [0.0, -1.5, -1.0], 0.5).color(Vec3::new(0.0, 0.0, 0.3) * PI),
            ];
            let [sun, lamp, spot] = shadowless.map(|light| light.casts_shadows(false));
            lit([sun, Light::point([-1.0, 1.0, 0.5]).color(Vec3::splat(PI / 3.0)), lamp, spot])
        },
        ..FROM_ABOVE
    },
    Case {
        name: "light/thirty_two",
        claim: "Thirty-two lights fill one word of the shadow mask.",
        scene: || many(32),
        ..FROM_ABOVE
    },
    Case {
        name: "light/thirty_three",
        claim: "Thirty-three lights take two words of the shadow mask.",
        scene: || many(33),
        ..FROM_ABOVE
    },
    Case {
        name: "light/seventy",
        claim: "Seventy lights take three words of the shadow mask.",
        scene: || many(70),
        size: [23, 14],
        ..FROM_ABOVE
    },
    Case {
        name: "light/thirty_two_among_objects",
        claim: "Each of many lights asks more than a thousand instances.",
        scene: meadow_of_lights,
        size: [20, 12],
        ..FROM_ABOVE
    },
    Case {
        name: "light/thirty_three_without_shadows",
        claim: "The words of the mask do not depend on shadows.",
        scene: || many(33),
        shadows: Shadows::Off,
        ..FROM_ABOVE
    },
    Case {
        name: "light/highlights",
        claim: "Highlights, from dull to sharp, metal or not, are the same bits.",
        scene: || {
            let mut build =
                Build::default().light(Light::point([1.0, 2.0, 4.0])).light(Light::sun([1.0, -1.0, -1.0]));
            for (i, roughness) in (0..).zip([0.0, 0.15, 0.4, 1.0]) {
                let at = [0.8 * i as f32 - 1.2, 0.0, 0.0];
                let metallic = f32::from(i % 2 == 1);
                let material = Material::new([0.9, 0.6, 0.2]).metallic(metallic).roughness(roughness);
                build = build.shape_of(Shape::ball(6).at(at, 0.4), material);
            }
            build.scene
        },
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "light/brighter_than_white",
        claim: "Light beyond white, and of its own, ends at white alike.",
        scene: || {
            let color = Vec3::new(30.0, 2.0, 0.5) * PI;
            let strong = Light::point(Vec3::new(1.0, 2.0, 2.0)).color(color);
            let glowing = Material::new([0.2; 3]).roughness(0.5).emission([0.1, 5.0, 0.3]);
            Build::default()
                .shape_of(Shape::ball(5).at([1.0, 0.0, 0.0], 0.7), glowing)
                .shape(Shape::floor(3.0, -1.0))
                .light(strong)
                .scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "light/black_and_negative",
        claim: "Lights without color add nothing; one that takes light away does so alike.",
        scene: || {
            let dark =
                |x: f32, color: f32| Light::point(Vec3::new(x, 1.0, 1.0)).color(Vec3::splat(color * PI));
            lit([dark(1.0, 0.0), dark(-1.0, -0.5), Light::point([0.0, 2.0, 1.0])])
        },
        ..FROM_ABOVE
    },
];

fn square(position: [f32; 3], reach: Option<f32>) -> Light {
    Light::point(position).color(Vec3::new(1.0, 0.9, 0.7) * PI).reach(reach).inverse_square(true)
}

/// A ball on a floor.
fn lit<const N: usize>(lights: [Light; N]) -> Scene {
    let build =
        Build::default().shape(Shape::floor(3.0, -1.0)).shape(Shape::ball(6).at([0.0, -0.5, 0.0], 0.5));
    lights.into_iter().fold(build, Build::light).scene
}

fn many(count: u32) -> Scene {
    let mut random = Random(12);
    let mut build =
        Build::default().shape(Shape::floor(3.0, -1.0)).shape(Shape::cube().at([0.3, -0.5, 0.0], 0.4));
    for i in 0..count {
        let position = random.vector(2.0) + Vec3::Y * 1.2;
        let color = (random.vector(0.5) + 0.5) * (0.1 * PI);
        let reach = (i % 3 == 0).then_some(2.5);
        build = build.light(match i % 5 {
            4 => Light::sun(position - Vec3::Y * 4.0).color(color),
            _ => Light::point(position).color(color).reach(reach).inverse_square(i % 2 == 0),
        });
    }
    build.scene
}

/// Blades in rows, all of them in the way of every light: the lights are low.
fn meadow_of_lights() -> Scene {
    let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
    let blade = build.mesh(Shape::triangle([[-0.01, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.1, 0.01]]));
    for i in 0..1444 {
        let at = Vec3::new((i % 38) as f32 * 0.08 - 1.5, -1.0, (i / 38) as f32 * 0.08 - 1.5);
        build.instance(blade, Mat4::from_translation(at));
    }
    let light = |i: u32| {
        let position = Vec3::new(2.0 + 0.01 * i as f32, -0.94, 0.03 * i as f32);
        Light::point(position).color(Vec3::splat(0.05 * PI))
    };
    (0..32).map(light).fold(build, Build::light).scene
}
