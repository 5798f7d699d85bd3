//! What textures say of a material besides its color: normal maps, roughness, occlusion,
//! emission, and where on a surface each of them lies.

use crate::case::{Case, look};
use crate::shape::{Build, Random, Shape};
use alloc::vec;
use glam::{Mat4, Vec3};
use rtrt_core::layout::{Texture, Wrap};
use rtrt_core::scene::{Content, Image, Light, Material, MaterialIndex, Mesh, Scene};

pub(super) const NEAR: Case = Case { camera: look([0.3, 0.8, 3.4], [0.0; 3]), ..Case::USUAL };

pub(super) const CASES: &[Case] = &[
    Case {
        name: "material/normal_map",
        claim: "A normal map turns normals alike, on flat and on round surfaces.",
        scene: || relief(1.0, &[Mat4::IDENTITY]),
        samples: 4,
        ..NEAR
    },
    Case {
        name: "material/normal_map_scaled",
        claim: "The scale of a normal map may be negative, and large.",
        scene: || relief(-6.0, &[Mat4::IDENTITY]),
        ..NEAR
    },
    Case {
        name: "material/normal_map_on_moved_objects",
        claim: "Mirrored, turned and stretched instances take their relief with them.",
        scene: || {
            let at = |x: f32, scale: Vec3| {
                Mat4::from_translation(Vec3::new(x, 0.0, 0.0))
                    * Mat4::from_rotation_y(x * 0.4)
                    * Mat4::from_scale(scale)
            };
            relief(
                1.0,
                &[
                    at(-1.4, Vec3::new(-0.5, 0.5, 0.5)),
                    at(0.0, Vec3::new(0.3, 0.8, 0.5)),
                    at(1.4, Vec3::new(0.6, -0.4, -0.4)),
                ],
            )
        },
        ..NEAR
    },
    Case {
        name: "material/normal_map_from_within",
        claim: "From the other side a bump is a dent.",
        scene: || relief(1.0, &[Mat4::from_scale(Vec3::splat(8.0))]),
        camera: look([0.3, 0.4, 0.9], [0.0, 0.0, -1.0]),
        ..Case::USUAL
    },
    Case {
        name: "material/normal_map_without_tangents",
        claim: "A mesh without tangents keeps its normals, whatever its material says.",
        scene: || {
            let mut build = Build::default();
            let map = normals(&mut build, 9, bump_texel);
            let material = painted([0.7, 0.7, 0.6]).normal_map(map, 1.0);
            build.shape_of(Shape::ball(6), material).light(Light::point([2.0, 2.0, 3.0])).scene
        },
        ..NEAR
    },
    Case {
        name: "material/roughness_map",
        claim: "Roughness and metalness from a texture shape highlights alike.",
        scene: || {
            let mut build = Build::default();
            let map = numbers(&mut build, 6, |random| [0, random.bits() as u8, random.bits() as u8, 255]);
            let rough =
                Material::new([0.9, 0.6, 0.3]).metallic(1.0).roughness(0.9).metallic_roughness_map(map);
            let scene = build.shape_of(Shape::ball(8), rough);
            let plain = Shape::quad([1.0, -1.0, 0.3], [1.0, 0.0, 0.0], [0.0, 1.6, 0.0]);
            scene.shape(plain).light(Light::point([2.0, 2.0, 3.0])).light(Light::sun([1.0, -1.0, -1.0])).scene
        },
        samples: 4,
        ..NEAR
    },
    Case {
        name: "material/occlusion_map",
        claim: "Occlusion takes from the ambient light only, as much as its strength says.",
        scene: || {
            let mut build = Build::default();
            build.scene.ambient = Vec3::splat(0.6);
            let map = numbers(&mut build, 8, |random| [random.bits() as u8, 255, 255, 255]);
            let scene = build.shape_of(Shape::ball(6), painted([0.8; 3]).occlusion_map(map, 0.7));
            scene.light(Light::point([3.0, 0.5, 1.0])).scene
        },
        ..NEAR
    },
    Case {
        name: "material/emission_map",
        claim: "Emission is the factor times the texture, beyond white too.",
        scene: || {
            let mut build = Build::default();
            let image = noise(7, |random| [0; 4].map(|_: u8| random.bits() as u8));
            let map = build.scene.add_texture(&image, [Wrap::Repeat; 2]).expect("room");
            let glowing = painted([0.1; 3]).emission([3.0, 0.5, 0.2]).emission_map(map);
            build.shape_of(Shape::ball(6), glowing).scene
        },
        ..NEAR
    },
    Case {
        name: "material/unlit",
        claim: "An unlit surface shows its color whatever the light.",
        scene: || {
            let unlit = painted([0.8, 0.3, 0.1]).unlit(true).emission([1.0; 3]);
            let ball = Shape::ball(5).painted(&mut Random(3)).at([-0.7, 0.0, 0.0], 0.6);
            let lit = Shape::ball(5).at([0.7, 0.0, 0.0], 0.6);
            Build::default().shape_of(ball, unlit).shape(lit).light(Light::point([0.0, 2.0, 1.0])).scene
        },
        ..NEAR
    },
    Case {
        name: "material/second_set",
        claim: "Each texture is looked up with the set of coordinates that it asks for.",
        scene: second_set,
        ..NEAR
    },
    Case {
        name: "material/turned_textures",
        claim: "A texture may be scaled, turned and moved on its surface; its levels follow.",
        scene: || {
            let mut build = Build::default();
            let image = noise(32, |random| [0; 4].map(|_: u8| random.bits() as u8));
            let map = build.scene.add_texture(&image, [Wrap::Repeat; 2]).expect("room");
            let map = Texture {
                turn: [[6.0, 2.5], [-3.0, 9.0]],
                shift: [0.3, -7.5],
                log_size: map.log_size + 2.9,
                ..map
            };
            let material = painted([1.0; 3]).base_color_map(map);
            build.shape_of(Shape::floor(9.0, -0.6), material).light(Light::point([1.0, 2.0, 2.0])).scene
        },
        ..NEAR
    },
    Case {
        name: "material/all_maps_at_once",
        claim: "Surfaces of many materials in one packet each take their own maps.",
        scene: many,
        size: [48, 48],
        ..NEAR
    },
];

fn painted(base: [f32; 3]) -> Material {
    Material::new(base).roughness(0.4)
}

/// A square image of texels that look random.
pub(super) fn noise(side: u32, texel: impl Fn(&mut Random) -> [u8; 4]) -> Image {
    let mut random = Random(u64::from(side));
    Image { width: side, height: side, rgba: (0..side * side).flat_map(|_| texel(&mut random)).collect() }
}

/// The same as a texture of numbers.
pub(super) fn numbers(build: &mut Build, side: u32, texel: impl Fn(&mut Random) -> [u8; 4]) -> Texture {
    build.scene.add_map(&noise(side, texel), [Wrap::Repeat; 2], Content::Numbers).expect("room")
}

/// The same as a normal map.
pub(super) fn normals(build: &mut Build, side: u32, texel: impl Fn(&mut Random) -> [u8; 4]) -> Texture {
    build.scene.add_map(&noise(side, texel), [Wrap::Repeat; 2], Content::Normals).expect("room")
}

/// Up to about 45° off.
pub(super) fn bump_texel(random: &mut Random) -> [u8; 4] {
    let mut lean = || 128 + (random.below(160) as i32 - 80);
    let (x, y) = (lean(), lean());
    [x as u8, y as u8, 220, 255]
}

/// A ball and a tile with tangents, of a material with a normal map.
fn relief(scale: f32, places: &[Mat4]) -> Scene {
    let mut build = Build::default();
    let map = normals(&mut build, 12, bump_texel);
    let material = painted([0.8, 0.75, 0.7]).normal_map(map, scale);
    let material = build.scene.add_material(material).expect("a case's material");
    // The tile's texture is mirrored, the ball's is not.
    let tile =
        Shape::quad([-1.2, -0.8, -0.9], [2.4, 0.0, 0.0], [0.0, 1.6, 0.3]).textured([-2.0, 2.0], [0.0, 0.0]);
    let ball = Shape::ball(6).at([0.1, 0.0, 0.0], 0.7).textured([3.0, 2.0], [0.0, 0.0]);
    for shape in [ball, tile] {
        let mesh = build.mesh_of(shape, |mesh: Mesh| mesh.with_made_tangents(false));
        for &place in places {
            build.scene.add_instance(mesh, material, place).expect("a case's instance");
        }
    }
    build.light(Light::point([2.0, 2.0, 3.0])).light(Light::sun([0.4, -1.0, 0.2])).scene
}

/// Color from the first set of coordinates, emission and normal map from the second.
fn second_set() -> Scene {
    let mut build = Build::default();
    let image = noise(16, |random| [0; 4].map(|_: u8| random.bits() as u8));
    let color = build.scene.add_texture(&image, [Wrap::Repeat; 2]).expect("room");
    let spots = noise(5, |random| [random.bits() as u8, 0, 40, 255]);
    let glow = build.scene.add_texture(&spots, [Wrap::Clamp; 2]).expect("room");
    let relief = normals(&mut build, 8, bump_texel);
    let material = painted([1.0; 3])
        .emission([1.0; 3])
        .base_color_map(color)
        .normal_map(Texture { set: 1, ..relief }, 1.0)
        .emission_map(Texture { set: 1, ..glow });
    let material = build.scene.add_material(material).expect("a case's material");
    let wall =
        Shape::quad([-2.0, -1.2, -0.3], [4.0, 0.0, 0.0], [0.0, 2.4, 0.4]).textured([5.0, 3.0], [0.2, 0.1]);
    let mesh = build.mesh_of(wall, |mesh| {
        let second = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        mesh.with_second_uv(second).expect("as many as vertices").with_made_tangents(true)
    });
    build.scene.add_instance(mesh, material, Mat4::IDENTITY).expect("a case's instance");
    // A mesh without a second set, of the same material.
    let other = build.mesh(Shape::ball(4).at([1.2, 0.4, 0.8], 0.4));
    build.scene.add_instance(other, material, Mat4::IDENTITY).expect("a case's instance");
    build.light(Light::point([1.0, 2.0, 3.0])).scene
}

/// Small tiles, each of a material of its own, some of them without this or that map.
fn many() -> Scene {
    let mut build = Build::default();
    let relief = normals(&mut build, 8, bump_texel);
    let rough = numbers(&mut build, 7, |random| [random.bits() as u8; 4]);
    let image = noise(10, |random| [0; 4].map(|_: u8| random.bits() as u8));
    let color = build.scene.add_texture(&image, [Wrap::Mirror; 2]).expect("room");
    let mut random = Random(77);
    let tile = build.mesh_of(Shape::quad([0.0; 3], [0.2, 0.0, 0.0], [0.0, 0.2, 0.05]), |mesh: Mesh| {
        mesh.with_made_tangents(false)
    });
    for i in 0..100_u32 {
        let mut material = painted([0.8, 0.6, 0.5]);
        let maps = random.bits();
        let if_set = |bit: u32, map| (maps >> bit & 1 == 1).then_some(map);
        material.base_color_map = if_set(0, color);
        material.normal_map = if_set(1, relief);
        material.metallic_roughness_map = if_set(2, rough);
        material.occlusion_map = if_set(3, rough);
        material.emission_map = if_set(4, color);
        material.emission = Vec3::splat(0.2 * random.within(0.0, 1.0));
        material.unlit = maps.is_multiple_of(7);
        material.metallic = random.within(0.0, 1.0);
        let material: MaterialIndex = build.scene.add_material(material).expect("a case's material");
        let at = Vec3::new((i % 10) as f32 * 0.22 - 1.1, (i / 10) as f32 * 0.22 - 1.1, 0.0);
        build.scene.add_instance(tile, material, Mat4::from_translation(at)).expect("a case's instance");
    }
    build.light(Light::point([2.0, 2.0, 3.0])).scene
}
