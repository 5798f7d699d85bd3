//! Tone maps and exposure: from light to what a display shows.

use crate::case::{Case, look};
use crate::shape::{Build, Shape};
use core::f32::consts::PI;
use glam::Vec3;
use rtrt_core::backend::{Shadows, ToneMap};
use rtrt_core::layout::Backdrop;
use rtrt_core::scene::{Light, Material, Scene};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "tone/neutral",
        claim: "Khronos PBR Neutral is computed alike, from black to far beyond white.",
        tone_map: ToneMap::Neutral,
        ..BALLS
    },
    Case { name: "tone/agx", claim: "So is AgX.", tone_map: ToneMap::Agx, ..BALLS },
    Case { name: "tone/aces", claim: "So is ACES.", tone_map: ToneMap::Aces, ..BALLS },
    Case {
        name: "tone/exposed",
        claim: "Light is raised by stops, and cut off at white.",
        exposure: 2.5,
        ..BALLS
    },
    Case {
        name: "tone/behind_nothing",
        claim: "Pixels that surfaces cover in part are mapped as if they covered all of them.",
        scene: || {
            let mut scene = balls();
            scene.backdrop = Backdrop::Nothing;
            scene
        },
        tone_map: ToneMap::Neutral,
        exposure: -1.25,
        ..BALLS
    },
];

const BALLS: Case = Case {
    name: "",
    claim: "",
    scene: balls,
    camera: look([0.0, 1.0, 4.0], [0.0; 3]),
    samples: 4,
    shadows: Shadows::Hard,
    ..Case::USUAL
};

/// Balls of some colors under a lamp so near that light spans many stops.
fn balls() -> Scene {
    let colors = [[0.9, 0.1, 0.05], [0.05, 0.8, 0.1], [0.1, 0.1, 0.9], [0.8, 0.8, 0.8]];
    let mut build = Build::default().shape(Shape::floor(6.0, -0.7));
    for (color, x) in colors.into_iter().zip([-1.8_f32, -0.6, 0.6, 1.8]) {
        let material = Material::new(color).roughness(0.5);
        build = build.shape_of(Shape::ball(8).at([x, 0.0, 0.0], 0.5), material);
    }
    build.light(Light::point([1.0, 0.9, 0.6]).color(Vec3::new(3.0, 2.6, 2.0) * PI).inverse_square(true)).scene
}
