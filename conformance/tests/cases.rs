//! All cases on every backend of the workspace.

use conformance::variants::{Variant, cpu, gpu, present, requires_gpu};
use conformance::{Suite, cases, leave_images};

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
