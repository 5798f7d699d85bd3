//! Runs every case on every variant that this machine has.
//!
//! A line a variant: cases run and failed, or why it was skipped. Exit code 5 where a
//! backend differs from the reference, or one is missing that `RTRT_REQUIRE_GPU=1` demands.

use conformance::variants::{all, present, requires_gpu};
use conformance::{Suite, cases, leave_images};
use std::process::ExitCode;

fn main() -> ExitCode {
    let suite = Suite::new(cases::all());
    let present = present(all(), requires_gpu());
    let mut failed = present.failed;
    for (name, mut backend) in present.backends {
        let adapter = backend.describe().adapter;
        let outcome = match suite.run(backend.as_mut()) {
            Ok(outcome) => outcome,
            Err(error) => {
                println!("{name}: {error}");
                failed += 1;
                continue;
            }
        };
        let [count, failures, known] = [outcome.cases, outcome.failures.len(), outcome.known.len()];
        println!("{name} ({adapter}): {count} cases, {failures} failed, {known} failed as known");
        for failure in outcome.failures.iter().chain(&outcome.known) {
            println!("  {}: {}", failure.case.name, failure.failure);
        }
        for failure in &outcome.failures {
            match leave_images(failure, name) {
                Ok(folder) => println!("  see {}", folder.display()),
                Err(error) => println!("  the images of {} cannot be written: {error}", failure.case.name),
            }
        }
        failed += usize::from(failures != 0);
    }
    println!("{failed} variants failed, {} skipped", present.skipped);
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::from(5) }
}
