//! Soft shadows: hard ones, blurred as far as penumbras reach.

use crate::case::{Case, look, zoom};
use crate::cases::shadow::room;
use crate::cases::transparency::{glass, panes};
use crate::shape::{Build, Random, Shape};
use rtrt_core::scene::{Light, Scene};

const FROM_ABOVE: Case =
    Case { camera: look([0.5, 2.5, 4.0], [0.0, -0.5, 0.0]), size: [75, 43], ..Case::USUAL };

pub(super) const CASES: &[Case] = &[
    Case {
        name: "soft/bulb",
        claim: "Shadows of a bulb with a radius have penumbras.",
        scene: || room(Light::point([1.5, 2.0, 1.0]).radius(0.3)).scene,
        ..FROM_ABOVE
    },
    Case {
        name: "soft/four_samples",
        claim: "Sub-rays are neighbors as pixels are.",
        scene: || room(Light::point([-1.5, 2.0, 1.0]).radius(0.3)).scene,
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "soft/sixteen_samples",
        claim: "The window and its lattices grow with the sub-rays.",
        scene: || room(Light::point([-1.5, 2.0, 1.0]).radius(0.3)).scene,
        size: [37, 21],
        samples: 16,
        ..FROM_ABOVE
    },
    Case {
        name: "soft/sun",
        claim: "A sun's penumbras grow with the occluder's distance alone.",
        scene: || room(Light::sun([-0.6, -1.0, -0.3]).radius(0.15)).scene,
        ..FROM_ABOVE
    },
    Case {
        name: "soft/beside_hard_ones",
        claim: "Lights without a radius keep their hard shadows beside those with one.",
        scene: || {
            let build = room(Light::point([1.5, 2.0, 1.0]).radius(0.3)).light(Light::point([-1.5, 2.0, 1.0]));
            build.light(Light::spot([0.0, 2.0, 1.0], [0.1, -1.0, -0.4], 0.6).radius(0.2)).scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "soft/wider_than_the_window",
        claim: "Penumbras that are wider than the window end there.",
        scene: || room(Light::point([0.5, 1.0, 0.5]).radius(0.9)).scene,
        camera: zoom(0.3, look([0.5, 2.5, 4.0], [0.0, -1.0, 0.0])),
        ..FROM_ABOVE
    },
    Case {
        name: "soft/far_from_any_penumbra",
        claim: "Blocks that no penumbra reaches, and those that are as dark all over, are as if they were blurred.",
        scene: || room(Light::point([0.2, 2.0, 0.3]).radius(0.1)).scene,
        camera: look([0.5, 2.5, 4.0], [0.6, -0.5, 0.0]),
        size: [240, 135],
        ..FROM_ABOVE
    },
    Case {
        name: "soft/light_around_an_object",
        claim: "Occluders within a light, and at its middle, cast penumbras of some size.",
        scene: || {
            room(Light::point([0.0, 0.0, 0.0]).radius(0.9))
                .light(Light::point([0.9, 0.6, 0.6]).reach(1.5).radius(0.3))
                .scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "soft/many_occluders",
        claim: "Of thousands of triangles in the way the nearest is found.",
        scene: || {
            let leaves = Shape::soup(&mut Random(10), 1500, 0.08).at([0.0, 0.6, 0.0], 1.0);
            let build = Build::default().shape(Shape::floor(3.0, -1.0)).shape(leaves);
            build
                .light(Light::sun([0.2, -1.0, 0.1]).radius(0.05))
                .light(Light::point([0.0, 0.6, 0.0]).radius(0.02))
                .scene
        },
        ..FROM_ABOVE
    },
    Case {
        name: "soft/panes",
        claim: "Colors of shadows are blurred, too.",
        scene: || colored(&[0, 1, 2]),
        ..FROM_ABOVE
    },
    Case {
        name: "soft/behind_panes",
        claim: "The shadows of each layer of surfaces are blurred among those of its own layer.",
        scene: || colored(&[2, 0, 1]),
        camera: look([0.3, 1.5, 1.8], [0.0, -0.6, 0.0]),
        samples: 4,
        ..FROM_ABOVE
    },
    Case {
        name: "soft/thirty_three_lights",
        claim: "More lights than a word of the mask has bits have their penumbras each.",
        scene: || {
            let mut random = Random(4);
            let build = room(Light::sun([0.0, 1.0, 0.0]));
            (0..32)
                .fold(build, |build, _| {
                    let at = random.vector(2.0);
                    build.light(Light::point([at.x, 1.5 + at.y * 0.2, at.z]).radius(0.1))
                })
                .scene
        },
        size: [37, 21],
        ..FROM_ABOVE
    },
    Case {
        name: "soft/lamps_that_reach_some_blocks",
        claim: "A lamp out of reach of a block's rays, in a layer, lights none of them, whatever it lights in front.",
        scene: lamps_of_small_reach,
        camera: look([0.4, 2.4, 2.6], [0.0, -1.0, 0.0]),
        size: [235, 141],
        ..FROM_ABOVE
    },
];

/// Leaves over a floor, and a pane over half of it, among lamps that reach a part of each.
fn lamps_of_small_reach() -> Scene {
    let mut random = Random(6);
    let leaves = Shape::soup(&mut random, 150, 0.15).bent(|[x, y, z]| [1.6 * x, 0.2 * y - 0.75, 1.6 * z]);
    let pane = Shape::quad([-1.6, 0.2, 1.4], [1.7, 0.0, 0.0], [0.0, 0.0, -2.8]);
    let build = Build::default().shape(Shape::floor(3.0, -1.0)).shape(leaves);
    let build = build.shape_of(pane, glass([0.3, 0.9, 0.5], 0.4));
    (0..9)
        .fold(build, |build, lamp| {
            let at = [1.1 * (lamp % 3) as f32 - 1.1, random.within(-0.6, 0.0), 1.1 * (lamp / 3) as f32 - 1.1];
            build.light(Light::point(at).color([3.0; 3]).reach(random.within(0.7, 1.3)).radius(0.1))
        })
        .scene
}

/// Panes in the light of a sun and a bulb with a radius.
fn colored(order: &[usize]) -> Scene {
    let mut scene = panes(order);
    for (light, radius) in scene.lights_mut().iter_mut().zip([0.1, 0.2]) {
        *light = light.radius(radius);
    }
    scene
}
