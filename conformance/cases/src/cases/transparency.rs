//! Surfaces that are not opaque everywhere: layers, masks, the colors of their shadows.

use crate::case::{Case, look, parallel};
use crate::shape::{Build, Random, Shape};
use alloc::vec::Vec;
use glam::{Mat4, Vec3};
use rtrt_core::backend::Shadows;
use rtrt_core::layout::{Backdrop, Texture, Wrap};
use rtrt_core::scene::{Image, Light, Material, Panorama, Scene};

const FROM_ABOVE: Case = Case { camera: look([0.5, 2.5, 4.0], [0.0, -0.4, 0.0]), ..Case::USUAL };

pub(super) const CASES: &[Case] = &[
    Case {
        name: "transparency/one_sided",
        claim: "A glass that is not double-sided is one layer, and takes from light with both sides.",
        scene: || {
            let one = |base, alpha| glass(base, alpha).double_sided(false);
            let mut build = Build::default()
                .shape(Shape::floor(3.0, -1.0))
                .shape_of(Shape::ball(5).at([-0.6, 0.0, 0.0], 0.8), one([0.2, 0.9, 0.4], 0.4))
                .shape_of(Shape::cube().at([0.9, -0.2, -0.3], 0.6), one([0.9, 0.3, 0.2], 0.3));
            let round = build.scene.add_material(one([0.2, 0.3, 0.9], 0.5)).expect("a case's material");
            let place = Mat4::from_translation(Vec3::new(0.2, 0.0, 0.9)) * Mat4::from_scale(Vec3::splat(0.4));
            build.scene.add_sphere(round, place).expect("a case's sphere");
            build.light(Light::point([0.5, 3.0, 1.5])).light(Light::sun([0.4, -1.0, -0.3])).scene
        },
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/shadow_catcher",
        claim: "A ground shows shadows, colored light among them, and nothing else; it keeps no light from anything.",
        scene: || {
            let mut scene = Build::default()
                .shape_of(Shape::floor(3.0, -0.8), Material::shadow_catcher())
                .shape(Shape::cube().at([-0.7, -0.3, 0.0], 0.5))
                .shape_of(Shape::ball(5).at([0.7, 0.0, 0.2], 0.6), glass([0.9, 0.3, 0.2], 0.6))
                .light(Light::point([0.5, 3.0, 1.5]).inverse_square(true).color([6.0; 3]).radius(0.2))
                .light(Light::spot([0.0, -3.0, 0.0], [0.0, 1.0, 0.0], 0.9).color([1.0, 0.5, 0.2]))
                .scene;
            scene.backdrop = Backdrop::Nothing;
            scene
        },
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/before_and_behind",
        claim: "A pane in front of a wall covers it in part, one behind it is not seen.",
        scene: || {
            let wall = Shape::quad([-1.0, -0.7, 0.0], [2.0, 0.0, 0.0], [0.0, 1.4, 0.0]);
            Build::default()
                .shape_of(pane(0.5, 1.2), glass([0.9, 0.1, 0.1], 0.4))
                .shape(wall)
                .shape_of(pane(-0.5, 1.6), glass([0.1, 0.1, 0.9], 0.5))
                .light(Light::point([1.0, 2.0, 3.0]))
                .scene
        },
        ..Case::USUAL
    },
    Case {
        name: "transparency/four_samples",
        claim: "Each sub-ray has its own layers.",
        scene: || stack(4, 0.3),
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/objects_that_overlap",
        claim: "Balls, cubes and triangles that pass through one another are ordered for each ray.",
        scene: overlapping,
        size: [53, 41],
        ..Case::USUAL
    },
    Case {
        name: "transparency/more_than_the_limit",
        claim: "Of twelve panes eight are looked at, and the eighth counts as opaque.",
        scene: || stack(12, 0.2),
        ..Case::USUAL
    },
    Case {
        name: "transparency/before_a_color_in_an_environment",
        claim: "Panes and gaps show the background's color, and mirrors the environment.",
        scene: || in_the_open(Backdrop::Color),
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "transparency/before_nothing",
        claim: "Before nothing, alpha is what panes cover, and colors are not multiplied by it.",
        scene: || in_the_open(Backdrop::Nothing),
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "transparency/limit_before_nothing",
        claim: "The last layer counts as opaque, but nothing does not.",
        scene: || in_the_open(Backdrop::Nothing),
        layers: 1,
        ..Case::USUAL
    },
    Case {
        name: "transparency/limit_of_one",
        claim: "With one layer everything is opaque to the eye, and shadows keep their colors.",
        scene: || stack(3, 0.4),
        layers: 1,
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/many_layers",
        claim: "Sixty-four layers are ordered alike.",
        scene: || {
            let mut build = Build::default();
            let soup = Shape::soup(&mut Random(8), 400, 1.2);
            let veil = build.scene.add_material(glass([1.0; 3], 0.05)).expect("a case's material");
            let mesh = build.mesh(soup);
            build.scene.add_instance(mesh, veil, Mat4::IDENTITY).expect("a case's instance");
            build.light(Light::point([1.0, 2.0, 3.0])).scene
        },
        layers: 64,
        size: [19, 17],
        ..Case::USUAL
    },
    Case {
        name: "transparency/coplanar",
        claim: "Panes at the same depth all count, in the order of their instances.",
        scene: || {
            Build::default()
                .shape_of(pane(0.0, 1.0), glass([1.0, 0.0, 0.0], 0.5))
                .shape_of(pane(0.0, 0.8), glass([0.0, 1.0, 0.0], 0.5))
                .shape_of(pane(0.0, 0.6), glass([0.0, 0.0, 1.0], 0.5))
                .shape(pane(0.0, 0.3))
                .shape(Shape::floor(3.0, -1.0))
                .light(Light::sun([0.3, -1.0, -0.8]))
                .scene
        },
        ..Case::USUAL
    },
    Case {
        name: "transparency/copies_in_one_place",
        claim: "Copies of an object in one place all count, to eye and light, and others between them.",
        scene: copies,
        layers: 32,
        samples: 4,
        size: [29, 23],
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/edges_within_a_pane",
        claim: "Rays exactly through the edge of two triangles of a pane meet it once.",
        scene: || Build::default().shape_of(pane(0.0, 0.9), glass([0.9, 0.5, 0.1], 0.5)).scene,
        camera: parallel(2.0, look([0.0, 0.0, 4.0], [0.0; 3])),
        size: [32, 32],
        ..Case::USUAL
    },
    Case {
        name: "transparency/alpha_of_texture_and_vertex",
        claim: "Alpha is the product of material, texture and vertex color.",
        scene: || {
            let mut build = Build::default();
            let map = noise(&mut build, 9);
            let material = glass([0.9, 0.8, 0.7], 0.8).base_color_map(map);
            let quad = pane(0.3, 1.0).painted_through(&mut Random(4)).textured([2.0, 1.5], [0.2, 0.1]);
            build.shape_of(quad, material).shape(Shape::ball(5)).light(Light::point([1.0, 2.0, 3.0])).scene
        },
        samples: 4,
        ..Case::USUAL
    },
    Case {
        name: "transparency/mask",
        claim: "A mask is there or not, without layers, to the eye and to light, and also where it repeats.",
        scene: || masked(0.5),
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/mask_cutoff_of_nothing",
        claim: "A cutoff of 0 leaves everything, whatever its alpha.",
        scene: || masked(0.0),
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/mask_cutoff_of_more_than_all",
        claim: "A cutoff above 1 leaves nothing.",
        scene: || masked(1.01),
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/mask_cutoff_exactly_met",
        claim: "Alpha that equals the cutoff is there.",
        scene: || {
            let quad = |z: f32, alpha: f32| (pane(z, 0.9), glass([0.8; 3], alpha).mask(0.25));
            let (there, exactly) = quad(-0.4, 0.25);
            let (not, below) = quad(0.4, f32::from_bits(0.25_f32.to_bits() - 1));
            Build::default()
                .shape_of(there, exactly)
                .shape_of(not, below)
                .light(Light::point([1.0, 1.0, 3.0]))
                .scene
        },
        ..Case::USUAL
    },
    Case {
        name: "transparency/leaves",
        claim: "Hundreds of masked leaves among panes, turned and stretched, are met alike.",
        scene: leaves,
        size: [41, 33],
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/shadows_of_panes",
        claim: "Panes color the light of bulbs and suns, one by one and one behind the other.",
        scene: || panes(&[0, 1, 2]),
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/shadows_of_panes_in_another_order",
        claim: "The order of the panes does not matter to the light.",
        scene: || panes(&[2, 0, 1]),
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/no_light_leaks",
        claim: "Four panes of a quarter let no light through, nor does a wall behind panes.",
        scene: || {
            let above = |y: f32, alpha: f32| (Shape::floor(0.8, y), glass([1.0, 0.9, 0.8], alpha));
            let mut build = Build::default().shape(Shape::floor(3.0, -1.0)).shape(Shape::floor(0.3, 0.1));
            for y in [0.0, 0.2, 0.4, 0.6] {
                let (shape, material) = above(y, 0.25);
                build = build.shape_of(shape, material);
            }
            build.light(Light::sun([0.05, -1.0, 0.1])).light(Light::point([1.4, 1.6, 0.2])).scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/many_lights",
        claim: "Forty lights, of two words of the shadow mask, each have their own color of shadow.",
        scene: || {
            let mut random = Random(12);
            let mut scene = panes(&[0, 1, 2]);
            for _ in 0..38 {
                scene.add_light(Light::point((random.vector(1.5) + Vec3::Y * 2.0).to_array()));
            }
            scene
        },
        size: [24, 20],
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/without_shadows",
        claim: "Without shadows panes are seen through and color nothing.",
        scene: || panes(&[0, 1, 2]),
        shadows: Shadows::Off,
        ..FROM_ABOVE
    },
    Case {
        name: "transparency/from_within",
        claim: "A camera inside of glass sees its far side.",
        scene: || {
            Build::default()
                .shape_of(Shape::ball(6).at([0.0; 3], 2.0), glass([0.2, 0.9, 0.4], 0.3))
                .shape(Shape::floor(5.0, -1.5))
                .shape_of(Shape::ball(4).at([0.0, 0.0, -1.0], 0.5), glass([0.9, 0.2, 0.4], 0.6))
                .light(Light::point([0.0, 3.0, 1.0]))
                .scene
        },
        camera: look([0.0, 0.2, 1.0], [0.0, 0.0, -1.0]),
        ..Case::USUAL
    },
];

/// Veils, masked leaves, walls and bubbles, each several times in one place, their numbers mixed.
fn copies() -> Scene {
    let mut random = Random(31);
    let mut build = Build::default().shape(Shape::floor(3.0, -1.0));
    let map = noise(&mut build, 9);
    let materials = [
        glass([0.9, 0.5, 0.2], 0.2),
        glass([0.3, 0.8, 0.4], 0.9).base_color_map(map).mask(0.5).double_sided(false),
        Material::new([0.7; 3]),
        glass([0.3, 0.4, 0.9], 0.25),
    ];
    let materials = materials.map(|material| build.scene.add_material(material).expect("a case's material"));
    let meshes =
        [Shape::ball(5), Shape::soup(&mut random, 40, 1.0), Shape::cube()].map(|shape| build.mesh(shape));
    let places = [[-0.6, 0.1, 0.2], [0.3, 0.0, 0.4], [0.9, -0.2, -0.8], [0.4, 0.3, -0.2]].map(|place| {
        Mat4::from_translation(place.into()) * Mat4::from_rotation_y(0.4) * Mat4::from_scale(Vec3::splat(0.6))
    });
    for _ in 0..28 {
        let which = random.below(4) as usize;
        let (material, place) = (materials[which], places[which]);
        if which == 3 {
            build.scene.add_sphere(material, place).expect("a case's sphere");
        } else {
            build.scene.add_instance(meshes[which], material, place).expect("a case's instance");
        }
    }
    build.light(Light::point([0.5, 3.0, 1.5])).light(Light::sun([0.4, -1.0, -0.3])).scene
}

/// A material that blends.
pub(super) fn glass(base: [f32; 3], alpha: f32) -> Material {
    Material::new(base).roughness(0.4).blend(alpha)
}

/// A square that faces the usual camera.
fn pane(z: f32, half: f32) -> Shape {
    Shape::quad([-half, -half, z], [2.0 * half, 0.0, 0.0], [0.0, 2.0 * half, 0.0])
}

/// A texture whose texels, alpha too, look random.
fn noise(build: &mut Build, side: u32) -> Texture {
    let mut random = Random(u64::from(side));
    let rgba = (0..4 * side * side).map(|_| random.bits() as u8).collect();
    build.scene.add_texture(&Image { width: side, height: side, rgba }, [Wrap::Repeat; 2]).expect("room")
}

/// Panes one behind the other, each a bit smaller, before a ball on a floor.
fn stack(count: u32, alpha: f32) -> Scene {
    let mut build = Build::default()
        .shape(Shape::floor(3.0, -1.0))
        .shape(Shape::ball(5).at([0.0, 0.0, -1.2], 0.8))
        .light(Light::point([0.6, 2.0, 3.0]))
        .light(Light::sun([0.2, -0.6, -1.0]));
    let mut random = Random(u64::from(count));
    for i in 0..count {
        let color = random.vector(0.5) + 0.5;
        let shape = pane(-0.3 + 0.1 * i as f32, 1.3 - 0.09 * i as f32);
        build = build.shape_of(shape, glass(color.to_array(), alpha));
    }
    build.scene
}

/// Panes and a ball with an environment and much nothing around them.
fn in_the_open(backdrop: Backdrop) -> Scene {
    let build = Build::default()
        .shape_of(pane(0.5, 1.2), glass([0.2, 0.9, 0.3], 0.4))
        .shape_of(pane(0.2, 1.0), glass([0.3, 0.2, 0.9], 0.3))
        .shape_of(
            Shape::ball(6).at([0.9, 0.2, 0.0], 0.5),
            Material::new([0.9; 3]).metallic(1.0).roughness(0.1),
        )
        .light(Light::point([1.0, 2.0, 3.0]));
    let mut scene = build.scene;
    (scene.backdrop, scene.background) = (backdrop, Vec3::new(0.9, 0.2, 0.1));
    let rgb = (0..16 * 8).map(|i| [i as f32 / 128.0, 0.4, 0.6]).collect();
    scene.set_environment(&Panorama { width: 16, height: 8, rgb }).expect("a panorama");
    scene
}

/// Shapes that pass through one another, opaque ones among them.
fn overlapping() -> Scene {
    let soup = Shape::soup(&mut Random(5), 40, 0.8);
    let mut build = Build::default()
        .shape_of(Shape::ball(6), glass([0.9, 0.2, 0.2], 0.35))
        .shape_of(Shape::cube().at([0.4, 0.2, 0.3], 0.7), glass([0.2, 0.9, 0.3], 0.4))
        .shape_of(soup, glass([0.9; 3], 0.5))
        .shape(Shape::cube().at([-0.6, -0.3, 0.1], 0.35));
    let turned = build.mesh(Shape::cube());
    let blue = build.scene.add_material(glass([0.2, 0.3, 0.9], 0.3)).expect("a case's material");
    let place = Mat4::from_rotation_y(0.7) * Mat4::from_scale(Vec3::new(1.3, 0.4, 0.5));
    build.scene.add_instance(turned, blue, place).expect("a case's instance");
    build.light(Light::point([1.0, 2.0, 3.0])).light(Light::sun([-1.0, -1.0, -0.4])).scene
}

/// A masked square over a floor, and a masked ball of the second set of coordinates.
fn masked(cutoff: f32) -> Scene {
    let mut build = Build::default();
    let map = noise(&mut build, 8);
    let mask = glass([0.8, 0.9, 0.7], 1.0).mask(cutoff);
    let flat = mask.base_color_map(Texture { turn: [[3.0, 0.4], [-0.4, 2.0]], ..map });
    let second =
        build.scene.add_material(mask.base_color_map(Texture { set: 1, ..map })).expect("a case's material");
    let ball = Shape::ball(5).at([0.9, 0.0, 0.4], 0.5);
    let uv: Vec<[f32; 2]> = (0..66).map(|i| [(i % 11) as f32 * 0.3, (i / 11) as f32 * 0.4]).collect();
    let mesh = build.mesh_of(ball, |mesh| mesh.with_second_uv(uv.clone()).expect("as many as vertices"));
    build.scene.add_instance(mesh, second, Mat4::IDENTITY).expect("a case's instance");
    build
        .shape_of(Shape::floor(1.0, 0.2), flat)
        .shape(Shape::floor(3.0, -1.0))
        .light(Light::sun([0.3, -1.0, -0.2]))
        .light(Light::point([0.0, 1.5, 1.0]))
        .scene
}

/// Small masked squares all over, and panes among them.
fn leaves() -> Scene {
    let mut build = Build::default();
    let map = noise(&mut build, 6);
    let leaf = glass([0.3, 0.8, 0.2], 1.0).mask(0.5);
    let leaf = build.scene.add_material(leaf.base_color_map(map)).expect("a case's material");
    let veil = build.scene.add_material(glass([0.9, 0.7, 0.3], 0.3)).expect("a case's material");
    let square = build.mesh(pane(0.0, 0.5));
    let mut random = Random(31);
    for i in 0..300 {
        let turn =
            Mat4::from_rotation_y(random.within(0.0, 6.0)) * Mat4::from_rotation_x(random.within(0.0, 6.0));
        let size = Mat4::from_scale(Vec3::new(random.within(0.1, 0.5), random.within(0.1, 0.5), 1.0));
        let at = Mat4::from_translation(random.vector(1.0));
        let material = if i % 6 == 0 { veil } else { leaf };
        build.scene.add_instance(square, material, at * turn * size).expect("a case's instance");
    }
    build
        .shape(Shape::floor(3.0, -1.2))
        .light(Light::sun([0.3, -1.0, -0.2]))
        .light(Light::point([0.0, 2.0, 1.0]))
        .scene
}

/// Three panes above one another over a floor, those of these numbers from the top.
pub(super) fn panes(order: &[usize]) -> Scene {
    let mut build = Build::default();
    let map = noise(&mut build, 5);
    let panes = [
        glass([1.0, 0.1, 0.0], 0.3),
        glass([0.0, 0.2, 1.0], 0.45),
        glass([0.9, 0.9, 0.2], 0.6).base_color_map(map),
    ];
    for (place, &number) in order.iter().enumerate() {
        let y = 0.7 - 0.3 * place as f32;
        // Each is a hand's breadth further to the right, whatever its place.
        let shift = 0.3 * number as f32 - 0.3;
        let shape = Shape::quad([shift - 0.7, y, 0.6], [1.4, 0.0, 0.0], [0.0, 0.0, -1.2]);
        build = build.shape_of(shape, panes[number]);
    }
    build
        .shape(Shape::floor(3.0, -1.0))
        .light(Light::sun([0.0, -1.0, -0.2]))
        .light(Light::point([0.6, 2.5, 0.4]))
        .scene
}
