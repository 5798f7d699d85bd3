//! Sub-rays that are shaded as one.

use crate::case::Case;
use crate::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::backend::{Shading, Shadows};
use rtrt_core::layout::Backdrop;
use rtrt_core::scene::{Light, Material, Scene};

const SHARED: Case = Case { samples: 4, shading: Shading::Pixel, shadows: Shadows::Hard, ..Case::USUAL };

/// Balls of triangles and a true one, above a painted floor, with two lights.
fn balls() -> Scene {
    let rough = Shape::ball(9).painted(&mut Random(3)).at([-1.2, 0.0, 0.0], 0.9);
    let mut build = Build::default().shape(rough).shape(Shape::floor(4.0, -1.0));
    let red =
        build.scene.add_material(Material::new([0.8, 0.2, 0.1]).roughness(0.3)).expect("a case's material");
    let place = Mat4::from_translation(Vec3::new(1.1, 0.0, 0.2));
    build.scene.add_sphere(red, place).expect("a case's sphere");
    build.light(Light::point([2.0, 2.0, 3.0])).light(Light::sun([-0.4, -1.0, -0.6])).scene
}

pub(super) const CASES: &[Case] = &[
    Case {
        name: "share/balls",
        claim: "Sub-rays that meet one triangle take one color.",
        scene: balls,
        ..SHARED
    },
    Case { name: "share/sixteen", claim: "So do sixteen.", scene: balls, samples: 16, ..SHARED },
    Case {
        name: "share/sky",
        claim: "Sub-rays that meet nothing show the environment, each its own part.",
        scene: || {
            let mut scene = balls();
            scene.set_environment(&rtrt_core::scene::studio().0).expect("a case's environment");
            scene.backdrop = Backdrop::Environment;
            scene
        },
        ..SHARED
    },
    Case {
        name: "share/masked",
        claim: "A sheet is shaded, and so is the floor behind its holes, in one pixel.",
        scene: || {
            let build = Build::default().shape(Shape::floor(4.0, -1.0));
            let sheet = Material::new([0.3, 0.7, 0.4]).mask(0.5);
            let quad = Shape::quad([-1.0, -0.8, 0.0], [2.0, 0.0, 0.0], [0.0, 1.6, 0.0]);
            let quad = quad.painted_through(&mut Random(2));
            build.shape_of(quad, sheet).light(Light::point([2.0, 2.0, 3.0])).scene
        },
        ..SHARED
    },
    Case {
        name: "share/many_small",
        claim: "Where every sub-ray meets another object, each has its color.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(4.0, -1.0));
            let speck = build.mesh(Shape::ball(3));
            let mut random = Random(5);
            for _ in 0..300 {
                let place = Mat4::from_translation(random.vector(1.5));
                build.instance(speck, place * Mat4::from_scale(Vec3::splat(0.03)));
            }
            build.light(Light::point([2.0, 2.0, 3.0])).scene
        },
        ..SHARED
    },
    Case {
        name: "share/soft",
        claim: "Frames with penumbras shade each sub-ray.",
        scene: || {
            let mut scene = balls();
            scene.add_light(Light::point([-2.0, 3.0, 1.0]).radius(0.3));
            scene
        },
        shadows: Shadows::Soft,
        ..SHARED
    },
];
