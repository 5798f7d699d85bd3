//! Runs cases on a backend and compares it with the reference.

use conformance_cases::{Agree, Case, Known};
use rtrt_core::backend::{Backend, Description, Picture, RenderError};
use rtrt_core::compare::{Difference, compare};
use rtrt_core::scene::Scene;
use rtrt_cpu::{Cpu, Options};
use std::time::Instant;

/// The reference: one number at a time, one thread.
///
/// # Panics
/// The system cannot start a thread.
pub fn reference() -> Cpu {
    Cpu::new(Options { lanes: Some(1), threads: Some(1) }).expect("one thread")
}

/// Why a case failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// There is no picture.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The picture differs from the reference's.
    #[error("{0}")]
    Different(Difference),
    /// The reference's picture shows a single color, which the case did not announce.
    #[error("the picture is blank: the case shows nothing")]
    Blank,
    /// The reference's picture shows more than the single color that the case announced.
    #[error("the picture was announced as blank, and is not")]
    NotBlank,
    /// The picture is right, where the case was known to fail.
    #[error("this was known to fail, and passes: {why}")]
    Passes {
        /// Why it was to fail.
        why: &'static str,
    },
}

/// The backend runs as the reference does: comparing the two would show nothing.
#[derive(Debug, thiserror::Error)]
#[error("{0:?} is the reference itself")]
pub struct Itself(pub Description);

/// A case that failed, with the picture if there is one.
#[derive(Debug)]
pub struct Failed {
    /// The case.
    pub case: &'static Case,
    /// Why.
    pub failure: Failure,
    /// What the reference rendered.
    pub expected: Picture,
    /// What the backend rendered.
    pub actual: Picture,
}

/// What became of the cases on one backend.
#[derive(Debug, Default)]
pub struct Outcome {
    /// How many were run.
    pub cases: usize,
    /// Milliseconds that each of them took, in order.
    pub times_ms: Vec<f64>,
    /// Those that failed, in order.
    pub failures: Vec<Failed>,
    /// Those that failed as it was known.
    pub known: Vec<Failed>,
}

/// Cases with the reference's pictures.
#[derive(Debug)]
pub struct Suite {
    reference: Description,
    cases: Vec<Prepared>,
}

#[derive(Debug)]
struct Prepared {
    case: &'static Case,
    scene: Scene,
    expected: Picture,
}

impl Suite {
    /// Builds the scenes and renders them with the [`reference()`].
    ///
    /// # Panics
    /// The reference cannot render a case.
    pub fn new(cases: impl IntoIterator<Item = &'static Case>) -> Self {
        let mut reference = reference();
        let prepare = |case: &'static Case| {
            let scene = (case.scene)();
            let mut expected = Picture::default();
            let rendered = reference.render(&scene, &case.request(), &mut expected);
            rendered.unwrap_or_else(|error| panic!("{}: {error}", case.name));
            Prepared { case, scene, expected }
        };
        let cases = cases.into_iter().map(prepare).collect();
        Self { reference: reference.describe(), cases }
    }

    /// Runs every case on the backend. The memory of one picture is used for all, so that
    /// the state of one frame would show in the next.
    ///
    /// # Errors
    /// The backend is [`Itself`] the reference.
    pub fn run(&self, backend: &mut dyn Backend) -> Result<Outcome, Itself> {
        let description = backend.describe();
        if description == self.reference {
            return Err(Itself(description));
        }
        let mut outcome = Outcome::default();
        let mut actual = Picture::default();
        for Prepared { case, scene, expected } in &self.cases {
            outcome.cases += 1;
            let start = Instant::now();
            let rendered = backend.render(scene, &case.request(), &mut actual);
            outcome.times_ms.push(start.elapsed().as_secs_f64() * 1e3);
            let checked = rendered.map_err(Failure::from).and_then(|()| check(case, expected, &actual));
            let known = case.known.filter(|known| description.adapter.contains(known.adapter));
            let (failure, list) = match (checked, known) {
                (Ok(()), None) => continue,
                (Ok(()), Some(Known { why, .. })) => (Failure::Passes { why }, &mut outcome.failures),
                (Err(failure), None) => (failure, &mut outcome.failures),
                (Err(failure), Some(_)) => (failure, &mut outcome.known),
            };
            let (expected, actual) = (expected.clone(), actual.clone());
            list.push(Failed { case, failure, expected, actual });
        }
        Ok(outcome)
    }

    /// The cases with their scenes and the reference's pictures.
    pub fn pictures(&self) -> impl Iterator<Item = (&'static Case, &Scene, &Picture)> {
        self.cases.iter().map(|p| (p.case, &p.scene, &p.expected))
    }
}

/// Whether a picture passes: the reference shows what the case announced, and the pictures
/// agree.
///
/// # Errors
/// They do not.
pub fn check(case: &Case, expected: &Picture, actual: &Picture) -> Result<(), Failure> {
    let is_blank = expected.pixels.iter().all(|&pixel| pixel == expected.pixels[0]);
    match (is_blank, case.blank) {
        (true, false) => return Err(Failure::Blank),
        (false, true) => return Err(Failure::NotBlank),
        _ => {}
    }
    match case.agree {
        Agree::Bits => compare(&case.request(), expected, actual).map_err(Failure::Different),
    }
}
