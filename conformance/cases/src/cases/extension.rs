//! What materials have beyond metallic-roughness: each extension under lights and in an environment, with textures, and
//! all of them in one packet.

use super::environment::around;
use super::material::{NEAR, bump_texel, noise, normals, numbers};
use crate::case::Case;
use crate::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::backend::Shadows;
use rtrt_core::layout::{Texture, Wrap};
use rtrt_core::scene::{Anisotropy, Clearcoat, Iridescence, Light, Material, Mesh, Scene, Sheen};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "extension/specular",
        claim: "Strength and color of what is mirrored come from numbers and from textures.",
        scene: || {
            shown(|build, i| {
                let share = i as f32 / 5.0;
                let strength = colors(build, 5, i).filter(|_| i > 3);
                let color = colors(build, 6, i + 1).filter(|_| i % 2 == 1);
                Material::new([0.3, 0.1, 0.1])
                    .roughness(0.3)
                    .metallic(if i == 5 { 0.5 } else { 0.0 })
                    .specular([0.5 * share, 0.04, 3.0 * share])
                    .specular_strength(1.0 - share)
                    .specular_maps(strength, color)
            })
        },
        samples: 4,
        ..NEAR
    },
    Case {
        name: "extension/clearcoat",
        claim: "A coat mirrors by normals and a roughness of its own, and dims what is below.",
        scene: || {
            shown(|build, i| {
                let coat = Clearcoat {
                    share: 1.0 - i as f32 * 0.1,
                    roughness: i as f32 * 0.15,
                    map: shares(build, 4, i).filter(|_| i == 2),
                    roughness_map: shares(build, 6, i).filter(|_| i == 3),
                    normal_map: Some(normals(build, 9, bump_texel)).filter(|_| i > 3),
                    normal_scale: 0.3,
                };
                let bumps = Some(normals(build, 7, bump_texel)).filter(|_| i % 2 == 0);
                let material = Material::new([0.7, 0.1, 0.1]).roughness(0.7).emission([0.0, 0.05, 0.0]);
                material.normal_map(bumps, 1.0).clearcoat(Some(coat).filter(|_| i != 1))
            })
        },
        ..NEAR
    },
    Case {
        name: "extension/sheen",
        claim: "Fibers scatter light at grazing angles, of every roughness.",
        scene: || {
            shown(|build, i| {
                let sheen = Sheen {
                    color: Vec3::new(0.9, 0.7, 1.0 - i as f32 * 0.2),
                    color_map: colors(build, 5, i).filter(|_| i == 4),
                    roughness: i as f32 * 0.2,
                    roughness_map: colors(build, 8, i).filter(|_| i == 5),
                };
                Material::new([0.1, 0.05, 0.2]).sheen(Some(sheen).filter(|_| i != 0))
            })
        },
        ..NEAR
    },
    Case {
        name: "extension/anisotropy",
        claim: "A brushed highlight follows the tangents, as far as a texture turns them.",
        scene: || {
            shown(|build, i| {
                let brushed = Anisotropy {
                    strength: 1.0 - 0.15 * i as f32,
                    rotation: 0.7 * i as f32,
                    map: shares(build, 5, i).filter(|_| i > 3),
                };
                let metal = Material::new([0.9, 0.7, 0.4]).metallic(1.0).roughness(0.15 + 0.1 * i as f32);
                metal.anisotropy(Some(brushed).filter(|_| i != 2))
            })
        },
        ..NEAR
    },
    Case {
        name: "extension/iridescence",
        claim: "A thin film has the same colors on metal and on what is none, of every thickness.",
        scene: || {
            shown(|build, i| {
                let film = Iridescence {
                    share: if i == 1 { 0.5 } else { 1.0 },
                    map: shares(build, 3, i).filter(|_| i == 2),
                    ior: 1.1 + 0.3 * i as f32,
                    thickness: [50.0, 200.0 + 250.0 * i as f32],
                    thickness_map: shares(build, 6, i).filter(|_| i > 3),
                };
                Material::new([0.6, 0.5, 0.5]).metallic((i % 2) as f32).roughness(0.2).iridescence(film)
            })
        },
        samples: 4,
        ..NEAR
    },
    Case {
        name: "extension/glass",
        claim: "Bodies turn the environment behind them, rough glass blurs it, and what is between stays sharp.",
        scene: glass,
        samples: 4,
        ..NEAR
    },
    Case {
        name: "extension/glass_under_soft_shadows",
        claim: "Where blocks wait for one another, rays keep where light comes from.",
        scene: || {
            let mut scene = glass();
            scene.add_light(Light::point([2.0, 3.0, 3.0]).radius(0.3));
            scene
        },
        shadows: Shadows::Soft,
        ..NEAR
    },
    Case {
        name: "extension/all_at_once",
        claim: "Surfaces of one packet have each their own extensions, without an environment too.",
        scene: many,
        size: [48, 48],
        ..NEAR
    },
];

/// Numbers of noise.
fn shares(build: &mut Build, side: u32, seed: u32) -> Option<Texture> {
    Some(numbers(build, side + seed % 2, |random| [0; 4].map(|_: u8| random.bits() as u8)))
}

/// Colors of noise.
fn colors(build: &mut Build, side: u32, seed: u32) -> Option<Texture> {
    let image = noise(side + seed % 2, |random| [0; 4].map(|_: u8| random.bits() as u8));
    Some(build.scene.add_texture(&image, [Wrap::Repeat; 2]).expect("room"))
}

/// Six balls with tangents, of these materials, under lights in an environment.
fn shown(material: impl Fn(&mut Build, u32) -> Material) -> Scene {
    let mut build = Build::default();
    let ball = Shape::ball(8).at([0.0; 3], 0.42).textured([3.0, 2.0], [0.0, 0.0]);
    let ball = build.mesh_of(ball, |mesh: Mesh| mesh.with_made_tangents(false));
    for i in 0..6 {
        let material = material(&mut build, i);
        let material = build.scene.add_material(material).expect("a case's material");
        let at = Vec3::new((i % 3) as f32 * 0.9 - 0.9, (i / 3) as f32 * 0.9 - 0.45, 0.0);
        // Moved, turned and mirrored ones too.
        let place = Mat4::from_translation(at)
            * Mat4::from_rotation_x(i as f32)
            * Mat4::from_scale(Vec3::new(if i == 4 { -1.0 } else { 1.0 }, 1.0, 1.0));
        build.scene.add_instance(ball, material, place).expect("a case's instance");
    }
    around(build.light(Light::point([2.0, 2.0, 3.0])).light(Light::sun([0.6, -1.0, 0.1])), 64, 32)
}

/// Balls and panes of glass of several kinds, some behind others, with opaque things between them.
fn glass() -> Scene {
    let mut build = Build::default();
    let ball = build.mesh(Shape::ball(8).at([0.0; 3], 0.42));
    let pane = build.mesh(Shape::quad([-0.7, -0.7, 0.0], [1.4, 0.0, 0.0], [0.0, 1.4, 0.3]));
    let rough = shares(&mut build, 6, 0);
    let kinds = [
        (ball, Material::new([1.0, 0.9, 0.8]).roughness(0.0).refraction(1.5)),
        (ball, Material::new([0.8, 0.9, 1.0]).roughness(0.4).refraction(1.2)),
        (ball, Material::default().roughness(0.1).refraction(2.4).transmission(0.7, None)),
        (pane, Material::new([0.9, 1.0, 0.9]).roughness(0.5)),
        (ball, Material::new([0.7, 0.2, 0.1])),
        (ball, Material::default().roughness(1.0).metallic_roughness_map(rough).refraction(1.33)),
    ];
    for (i, (mesh, material)) in (0..).zip(kinds) {
        let clear =
            if material.transmission > 0.0 || i == 4 { material } else { material.transmission(1.0, None) };
        let material = build.scene.add_material(clear).expect("a case's material");
        let (x, y) = ((i % 3) as f32 * 0.8 - 0.8, (i / 3) as f32 * 0.8 - 0.4);
        let at = Vec3::new(x, y, if i == 4 { -0.8 } else { 0.2 * i as f32 });
        build.scene.add_instance(mesh, material, Mat4::from_translation(at)).expect("a case's instance");
    }
    around(build.light(Light::sun([0.6, -1.0, 0.1])), 64, 32)
}

/// Small tiles, each with some of the extensions.
fn many() -> Scene {
    let mut build = Build::default();
    build.scene.ambient = Vec3::new(0.2, 0.25, 0.3);
    let relief = normals(&mut build, 8, bump_texel);
    let share = shares(&mut build, 7, 0);
    let color = colors(&mut build, 10, 0);
    let mut random = Random(31);
    let tile = Shape::quad([0.0; 3], [0.2, 0.0, 0.0], [0.0, 0.2, 0.05]);
    let bare = build.mesh(tile.clone());
    let tile = build.mesh_of(tile, |mesh: Mesh| mesh.with_made_tangents(false));
    for i in 0..100_u32 {
        let (has, maps) = (random.bits(), random.bits());
        let map = |bit: u32, map: Option<Texture>| map.filter(|_| maps >> bit & 1 == 1);
        let some = |bit: u32| has >> bit & 1 == 1;
        let material = Material::new([0.7, 0.5, 0.4])
            .roughness(random.within(0.0, 1.0))
            .metallic(random.within(0.0, 1.0))
            .normal_map(map(0, Some(relief)), 0.5)
            .specular_strength(random.within(0.0, 1.0))
            .specular_maps(map(1, color), map(2, color))
            .clearcoat(some(0).then(|| Clearcoat {
                map: map(3, share),
                roughness: random.within(0.0, 0.5),
                normal_map: map(4, Some(relief)),
                ..Clearcoat::default()
            }))
            .sheen(some(1).then(|| Sheen {
                color: random.vector(0.5) + 0.5,
                roughness: random.within(0.0, 1.0),
                color_map: map(5, color),
                ..Sheen::default()
            }))
            .anisotropy(some(2).then(|| Anisotropy {
                strength: random.within(0.0, 1.0),
                rotation: random.within(0.0, 6.0),
                map: map(6, share),
            }))
            .iridescence(
                some(3).then(|| Iridescence { thickness_map: map(7, share), ..Iridescence::default() }),
            );
        let material = build.scene.add_material(material).expect("a case's material");
        let at = Vec3::new((i % 10) as f32 * 0.22 - 1.1, (i / 10) as f32 * 0.22 - 1.1, 0.0);
        let mesh = if i % 9 == 0 { bare } else { tile };
        build.scene.add_instance(mesh, material, Mat4::from_translation(at)).expect("a case's instance");
    }
    build.light(Light::point([1.0, 2.0, 3.0])).scene
}
