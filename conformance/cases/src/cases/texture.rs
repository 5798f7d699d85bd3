//! Textures: sizes, wrap modes, and mip levels.

use crate::case::{Case, look};
use crate::shape::{Build, Random, Shape};
use rtrt_core::layout::{Filter, Texture, Wrap};
use rtrt_core::scene::{Image, Light, Material, Mip, Scene};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "texture/magnified",
        claim: "A few texels over many pixels are mixed alike.",
        scene: || wall([5, 3], [Wrap::Clamp; 2], [1.0, 1.0], [0.0, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "texture/nearest",
        claim: "The nearest texel alone counts where a filter says so: near or far, in colors, alphas and holes.",
        scene: || {
            let mut build = Build::default().light(Light::sun([0.3, -1.0, -0.5]));
            let map = build.scene.add_texture(&noise([8, 8]), [Wrap::Repeat; 2]).expect("a case's texture");
            let filters = [Filter::NearestMagnified, Filter::Nearest, Filter::NearestMinified];
            for (filter, x) in filters.into_iter().zip([-3.0_f32, -1.0, 1.0]) {
                let map = Texture { filter: filter as u32, ..map };
                let strip = Shape::quad([x, -1.0, 2.5], [1.9, 0.0, 0.0], [0.0, 0.0, -40.0]);
                build = build.shape_of(
                    strip.textured([1.0, 20.0], [0.1, 0.0]),
                    Material::default().base_color_map(map),
                );
                let pane = Shape::quad([x, 0.2, 0.0], [1.5, 0.0, 0.0], [0.0, 1.0, 0.0]);
                let leaf = Material::default().base_color_map(map);
                let leaf = if filter == Filter::Nearest { leaf.blend(0.9) } else { leaf.mask(0.5) };
                build = build.shape_of(pane, leaf);
            }
            build.scene
        },
        ..Case::USUAL
    },
    Case {
        name: "texture/not_a_power_of_two",
        claim: "A texture may have any size; its mip levels lose nothing.",
        scene: || wall([67, 45], [Wrap::Repeat; 2], [1.5, 1.5], [0.1, 0.2]),
        ..Case::USUAL
    },
    Case {
        name: "texture/one_texel",
        claim: "A texture of one texel is that color.",
        scene: || wall([1, 1], [Wrap::Repeat; 2], [3.0, 3.0], [0.0, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "texture/one_row",
        claim: "A texture one texel high halves in one direction only.",
        scene: || wall([64, 1], [Wrap::Mirror; 2], [2.0, 1.0], [0.0, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "texture/repeat",
        claim: "A texture repeats, on the negative side too.",
        scene: || wall([8, 8], [Wrap::Repeat; 2], [5.0, -3.0], [-2.3, 0.7]),
        ..Case::USUAL
    },
    Case {
        name: "texture/clamp",
        claim: "The edge of a texture goes on.",
        scene: || wall([8, 8], [Wrap::Clamp; 2], [3.0, -3.0], [-1.0, 2.0]),
        ..Case::USUAL
    },
    Case {
        name: "texture/mirror",
        claim: "A texture is mirrored every other time.",
        scene: || wall([8, 8], [Wrap::Mirror, Wrap::Repeat], [5.0, 3.0], [-2.3, 0.7]),
        ..Case::USUAL
    },
    Case {
        name: "texture/minified_at_a_grazing_angle",
        claim: "Mip levels are chosen and mixed alike, up to the horizon.",
        scene: || {
            let floor = Shape::floor(200.0, -0.5).textured([300.0, 300.0], [0.0, 0.0]);
            textured(floor, [32, 32], [Wrap::Repeat; 2])
        },
        camera: look([0.0, 0.0, 4.0], [0.0, -0.3, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "texture/levels_by_angle",
        claim: "Levels that are chosen by the angle of view too are the same everywhere, up to the horizon.",
        scene: || {
            let floor = Shape::floor(200.0, -0.5).textured([300.0, 300.0], [0.0, 0.0]);
            let mut scene =
                textured(floor.and(Shape::ball(6).at([0.0, 0.4, 1.0], 0.6)), [32, 32], [Wrap::Repeat; 2]);
            scene.mip = Mip::Angle;
            scene
        },
        camera: look([0.0, 0.0, 4.0], [0.0, -0.3, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "texture/far_coordinates",
        claim: "Texture coordinates of any size give some texel, everywhere the same.",
        scene: || wall([8, 8], [Wrap::Repeat; 2], [4e6, 3e9], [-1e6, 0.0]),
        ..Case::USUAL
    },
    Case {
        name: "texture/no_area_in_the_texture",
        claim: "A triangle that is a line or a point in its texture takes the finest level.",
        scene: || wall([16, 16], [Wrap::Repeat; 2], [1.0, 0.0], [0.0, 0.3]),
        ..Case::USUAL
    },
];

/// An image of noise.
fn noise([width, height]: [u32; 2]) -> Image {
    let mut random = Random(u64::from(width * 1000 + height));
    Image { width, height, rgba: (0..width * height * 4).map(|_| random.bits() as u8).collect() }
}

fn textured(shape: Shape, size: [u32; 2], wrap: [Wrap; 2]) -> Scene {
    let mut build = Build::default();
    let texture = build.scene.add_texture(&noise(size), wrap).expect("a case's texture");
    let material = Material::new([0.9, 0.8, 0.7]).roughness(0.5).base_color_map(texture);
    // Another texture, and a surface without one, beside it.
    let second = build.scene.add_texture(&noise([3, 7]), [Wrap::Clamp; 2]).expect("a case's texture");
    let small = Shape::quad([-2.0, -0.4, 0.5], [0.6, 0.0, 0.0], [0.0, 0.8, 0.2]);
    let plain = Shape::quad([1.4, -0.4, 0.5], [0.6, 0.0, 0.0], [0.0, 0.8, 0.2]);
    build
        .shape_of(shape, material)
        .shape_of(
            small,
            Material::new([1.0; 3])
                .metallic(0.5)
                .roughness(0.3)
                .base_color_map(second)
                .emission([0.1, 0.0, 0.0]),
        )
        .shape_of(plain, Material::new([0.2, 0.5, 1.0]).roughness(0.9))
        .light(Light::point([1.0, 2.0, 5.0]))
        .scene
}

/// A wall that fills the picture.
fn wall(size: [u32; 2], wrap: [Wrap; 2], scale: [f32; 2], offset: [f32; 2]) -> Scene {
    let wall = Shape::quad([-3.0, -2.0, 0.0], [6.0, 0.0, 0.5], [0.0, 4.0, -1.0]);
    textured(wall.textured(scale, offset), size, wrap)
}
