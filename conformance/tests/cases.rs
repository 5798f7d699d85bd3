//! All cases on every backend of the workspace.

use bytemuck::Zeroable;
use conformance::variants::{Variant, cpu, gpu, present, requires_gpu};
use conformance::{Suite, cases, leave_images, reference};
use rtrt_core::backend::{Backend, Picture};
use rtrt_core::kernel::falloff::falloff;
use rtrt_core::layout::{COLOR_LIMIT, LIGHT_LIMIT, View};
use rtrt_core::num::recip;
use rtrt_core::scene::Setup;

fn run(variants: Vec<Variant>) {
    let suite = Suite::new(cases::all());
    let present = present(variants, requires_gpu());
    let mut failed = present.failed;
    for (name, mut backend) in present.backends {
        let outcome = suite.run(backend.as_mut()).expect("a variant other than the reference");
        assert_eq!(outcome.cases, cases::all().count());
        for failure in &outcome.failures {
            let images = leave_images(failure, name).expect("images can be written");
            println!("{name}, {}: {}; see {}", failure.case.name, failure.failure, images.display());
        }
        failed += outcome.failures.len();
    }
    assert_eq!(failed, 0);
}

#[test]
fn cpu_agrees_whatever_its_lanes_and_threads() {
    run(cpu());
}

#[test]
fn gpu_agrees_by_every_route() {
    run(gpu());
}

/// A lane or a device may give another NaN than the next one; a number here is a number there,
/// since they agree.
#[test]
fn no_case_has_a_color_that_is_no_number() {
    let mut reference = reference();
    for case in cases::all() {
        let mut picture = Picture::default();
        reference.render(&(case.scene)(), &case.request(), &mut picture).expect("a case's frame");
        let colors = picture.deferred.expect("deferred buffers were asked for").colors;
        assert!(colors.as_flattened().iter().all(|channel| channel.is_finite()), "{}", case.name);
    }
}

/// What [`LIGHT_LIMIT`] says of a surface that a light touches.
#[test]
fn the_brightest_light_at_no_distance_does_not_overflow() {
    let light = View { inverse_square: 1.0, ..View::zeroed() };
    let (lobe, lights) = (1025.0, Setup::MAX_LIGHTS as f32);
    let most = |left: f32| LIGHT_LIMIT * left * lobe * lights * 3.0 * COLOR_LIMIT;
    for distance in [0.0, 1e-30, 1e-9, 1e-6, 1e-3] {
        assert!(most(falloff(&light, distance)).is_finite(), "{distance}");
    }
    // It takes the end of the falloff.
    assert!(most(recip(0.0)).is_infinite());
}
