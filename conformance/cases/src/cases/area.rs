//! Area lights: every sub-ray of a pixel asks for another point of a light.

use crate::case::{Case, look};
use crate::cases::shadow::room;
use crate::cases::transparency::panes;
use crate::shape::{Build, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::backend::Shadows;
use rtrt_core::scene::Light;

const JITTERED: Case = Case {
    camera: look([0.5, 2.5, 4.0], [0.0, -0.5, 0.0]),
    shadows: Shadows::Area { jitter: Some(0) },
    ..Case::USUAL
};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "area/four_points",
        claim: "Four sub-rays ask for four points of a bulb, the same ones in every pixel.",
        scene: || room(Light::point([1.5, 2.0, 1.0]).radius(0.4)).scene,
        samples: 4,
        shadows: Shadows::Area { jitter: None },
        ..JITTERED
    },
    Case {
        name: "area/sixteen_points_jittered",
        claim: "Sixteen sub-rays ask for points of a bulb that differ from pixel to pixel.",
        scene: || room(Light::point([1.5, 2.0, 1.0]).radius(0.4)).scene,
        samples: 16,
        ..JITTERED
    },
    Case {
        name: "area/one_point_jittered",
        claim: "One ray a pixel asks for one point, which differs from pixel to pixel.",
        scene: || {
            room(Light::point([1.5, 2.0, 1.0]).radius(0.4))
                .light(Light::point([-1.0, 1.0, 1.0]).radius(0.1))
                .scene
        },
        ..JITTERED
    },
    Case {
        name: "area/sun",
        claim: "A sun's points are directions, and its lists hold what stands in any of them.",
        scene: || room(Light::sun([-0.6, -1.0, -0.3]).radius(0.2)).scene,
        samples: 4,
        ..JITTERED
    },
    Case {
        name: "area/spot",
        claim: "A spot light's cone moves with its points, into faces that its middle does not reach.",
        scene: || room(Light::spot([0.3, 0.6, 0.9], [-0.1, -1.0, -0.4], 0.7).radius(0.5)).scene,
        samples: 4,
        ..JITTERED
    },
    Case {
        name: "area/light_around_an_object",
        claim: "Objects within a light, and surfaces within it, are decided alike.",
        scene: || room(Light::point([0.2, -0.2, 0.1]).radius(0.9)).scene,
        samples: 4,
        ..JITTERED
    },
    Case {
        name: "area/beyond_the_reach",
        claim: "Reach is counted from each point.",
        scene: || room(Light::point([0.9, 0.6, 0.6]).reach(1.5).radius(0.3)).scene,
        samples: 4,
        ..JITTERED
    },
    Case {
        name: "area/small_occluders_all_around",
        claim: "What a ray to any point of a light meets is in the list of the block it starts in.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(2.0, -1.0));
            let cube = build.mesh(Shape::cube());
            for i in 0..600 {
                let [x, y, z] = [i % 10, i / 10 % 6, i / 60].map(|n| n as f32 * 0.37);
                let at = Mat4::from_translation(Vec3::new(x - 1.7, y * 0.4 - 0.9, z - 1.7));
                build.instance(cube, at * Mat4::from_scale(Vec3::splat(0.02)));
            }
            build
                .light(Light::point([0.1, -0.3, 0.2]).radius(0.15))
                .light(Light::sun([0.3, -1.0, 0.2]).radius(0.1))
                .scene
        },
        samples: 4,
        ..JITTERED
    },
    Case {
        name: "area/panes",
        claim: "Rays to different points of a light cross different panes, and take their colors.",
        scene: || {
            let mut scene = panes(&[0, 1, 2]);
            scene.lights_mut()[0] = scene.lights()[0].radius(0.2);
            scene
        },
        samples: 4,
        ..JITTERED
    },
];
