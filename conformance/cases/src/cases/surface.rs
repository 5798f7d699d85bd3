//! Normals and vertex colors at a hit.

use crate::case::{Case, look};
use crate::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::scene::{Light, Material};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "surface/smooth_normals",
        claim: "Normals are interpolated alike.",
        scene: || Build::default().shape(Shape::ball(5)).light(Light::point([2.0, 2.0, 3.0])).scene,
        ..Case::USUAL
    },
    Case {
        name: "surface/normals_without_length",
        claim: "A normal that interpolates to nothing is replaced by the triangle's.",
        scene: || {
            let opposed = Shape::triangle([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]);
            let ball = Shape::ball(4).shaded(|_| [0.0; 3]).at([1.5, 0.0, 0.0], 0.7);
            let tiny = Shape::ball(4).shaded(|n| n.map(|c| c * 1e-20)).at([-1.5, 0.0, 0.0], 0.7);
            Build::default().shape(opposed.and(ball).and(tiny)).light(Light::point([2.0, 2.0, 3.0])).scene
        },
        ..Case::USUAL
    },
    Case {
        name: "surface/normals_of_any_length",
        claim: "Normals need not be of unit length.",
        scene: || {
            let long = Shape::ball(5).shaded(|n| n.map(|c| c * 1e10)).at([-0.9, 0.0, 0.0], 0.9);
            let short = Shape::ball(5).shaded(|n| n.map(|c| c * 1e-10)).at([0.9, 0.0, 0.0], 0.9);
            Build::default().shape(long.and(short)).light(Light::point([2.0, 2.0, 3.0])).scene
        },
        ..Case::USUAL
    },
    Case {
        name: "surface/from_within",
        claim: "Surfaces have two sides; normals face the viewer.",
        scene: || {
            Build::default()
                .shape(Shape::ball(7).at([0.0; 3], 2.0))
                .light(Light::point([0.5, 0.8, 0.2]))
                .scene
        },
        camera: look([0.3, 0.0, 0.4], [0.0, 0.5, -1.0]),
        ..Case::USUAL
    },
    Case {
        name: "surface/one_sided",
        claim: "Of what is not double-sided, the camera sees fronts only, also of what is mirrored, and light all.",
        scene: || {
            let mut build = Build::default().shape(Shape::floor(3.0, -1.2));
            let one_sided = Material::new([0.7, 0.4, 0.2]).roughness(0.5).double_sided(false);
            let one_sided = build.scene.add_material(one_sided).expect("a case's material");
            let ball = build.mesh(Shape::ball(6));
            let sheet = build.mesh(Shape::quad([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]));
            let at = |x: f32, y: f32, z: f32| Mat4::from_translation(Vec3::new(x, y, z));
            let mirrored = Mat4::from_scale(Vec3::new(-0.6, 0.6, 0.6));
            for (mesh, to_world) in [
                (ball, at(0.3, 0.0, 3.4)),
                (ball, at(-1.2, -0.4, 0.0) * mirrored),
                (sheet, at(0.2, 0.2, 0.0) * Mat4::from_rotation_y(0.4)),
                (sheet, at(0.2, -0.7, 0.3) * Mat4::from_rotation_y(3.4)),
                (sheet, at(1.2, 0.2, 0.0) * mirrored * Mat4::from_rotation_y(0.4)),
                (sheet, at(1.2, -0.7, 0.3) * mirrored * Mat4::from_rotation_y(3.4)),
            ] {
                build.scene.add_instance(mesh, one_sided, to_world).expect("a case's transform");
            }
            build.light(Light::point([2.0, 2.0, 3.0])).light(Light::sun([-0.4, -1.0, -0.6])).scene
        },
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "surface/stretched_normals",
        claim: "Normals of mirrored and stretched instances are turned alike.",
        scene: || {
            let mut build = Build::default();
            let ball = build.mesh(Shape::ball(6));
            for (x, scale) in [
                (-1.2, Vec3::new(0.3, 1.0, 0.5)),
                (0.0, Vec3::new(-0.5, 0.5, 0.5)),
                (1.2, Vec3::new(0.6, 0.2, -0.9)),
            ] {
                let turn = Mat4::from_rotation_z(x);
                build.instance(
                    ball,
                    Mat4::from_translation(Vec3::new(x, 0.0, 0.0)) * turn * Mat4::from_scale(scale),
                );
            }
            build.light(Light::point([2.0, 2.0, 3.0])).scene
        },
        ..Case::USUAL
    },
    Case {
        name: "surface/vertex_colors",
        claim: "Vertex colors are interpolated, and rounded to bytes, alike.",
        scene: || {
            let painted = Shape::ball(4).painted(&mut Random(9));
            Build::default().shape(painted).light(Light::point([2.0, 2.0, 3.0])).scene
        },
        samples: 4,
        ..Case::USUAL
    },
];
