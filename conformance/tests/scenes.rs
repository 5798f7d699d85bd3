//! Real scenes, where they are: the folder `shared/scenes` beside the repository.

use conformance::oracle::brute;
use conformance::variants::{all, present, requires_gpu};
use conformance::{compare, reference};
use rtrt::import::Loaded;
use rtrt_core::backend::{Backend, Picture, Request};
use rtrt_core::scene::Camera;
use std::path::Path;

const SCENES: [&str; 15] = [
    "sponza/sponza_dabrovic_cc0tex.glb",
    "sponza/sponza_dabrovic.obj",
    "stanford/dragon_res2.glb",
    "stanford/bunny.glb",
    "hero/FlightHelmet/FlightHelmet.gltf",
    "hero/chess-board.glb",
    "cornell/cornell_box/scene.gltf",
    "outdoor/forest_2000_instances.glb",
    "lights/Lights.glb",
    "cad/2CylinderEngine.glb",
    "alpha/AlphaBlendModeTest.glb",
    "alpha/TransmissionRoughnessTest.glb",
    "alpha/glass-table.glb",
    "alpha/love_neon.glb",
    "outdoor/house.glb",
];

/// The oracle tests one ray in this many against every triangle.
const STEP: usize = 37;

/// The scenes that are there, by name.
fn scenes() -> impl Iterator<Item = (&'static str, Loaded)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    SCENES.into_iter().filter_map(move |name| {
        let path = folder.join(name);
        if !path.exists() {
            println!("SKIPPED: {} is not there", path.display());
            return None;
        }
        let mut loaded =
            rtrt::import::load(&path, &rtrt_cpu::Parallel).unwrap_or_else(|why| panic!("{name}: {why}"));
        rtrt::import::light_by_default(&mut loaded.scene).unwrap_or_else(|why| panic!("{name}: {why}"));
        Some((name, loaded))
    })
}

fn request(camera: &Camera, samples: u32) -> Request<'_> {
    Request::new(camera, [97, 55]).samples(samples).deferred(true)
}

#[test]
fn the_reference_is_what_the_oracle_says_on_real_scenes() {
    let (mut reference, mut expected) = (reference(), Picture::default());
    for (name, loaded) in scenes() {
        let request = request(&loaded.camera, 1);
        reference.render(&loaded.scene, &request, &mut expected).unwrap();
        let checked = brute::check(&loaded.scene, &request, &expected, STEP);
        checked.unwrap_or_else(|why| panic!("{name}: {why}"));
    }
}

#[test]
fn every_variant_agrees_on_real_scenes() {
    let mut reference = reference();
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    let (mut expected, mut actual) = (Picture::default(), Picture::default());
    let mut differences = 0;
    for (name, loaded) in scenes() {
        for samples in [1, 4] {
            let request = request(&loaded.camera, samples);
            reference.render(&loaded.scene, &request, &mut expected).unwrap();
            let is_blank = expected.pixels.iter().all(|&pixel| pixel == expected.pixels[0]);
            assert!(!is_blank, "{name} shows nothing");
            for (variant, backend) in &mut variants.backends {
                backend.render(&loaded.scene, &request, &mut actual).unwrap();
                if let Err(why) = compare(&request, &expected, &actual) {
                    println!("{name}, {samples} samples, {variant}: {why}");
                    differences += 1;
                }
            }
        }
    }
    assert_eq!(differences, 0);
}
