//! The suite that any backend of rtrt can be run through: whether it gives the same bits.
//!
//! For a backend of your own: implement [`rtrt_core::backend::Backend`], give it to [`Suite::run`], and look at what
//! [`Outcome::failures`] says (`examples/custom_backend.rs` is a whole one). For a machine of your own:
//! `cargo run --release -p conformance -- --report out` runs everything that is present, compares it with the hashes
//! in [`golden`], and writes a [`report`].
//!
//! ```
//! use conformance::{Suite, cases};
//! use rtrt_cpu::{Cpu, Options};
//!
//! let suite = Suite::new(cases::named("visibility/one_triangle"));
//! // Any `rtrt_core::backend::Backend` goes here.
//! let mut backend = Cpu::new(Options { lanes: Some(8), threads: None })?;
//! let outcome = suite.run(&mut backend)?;
//! assert_eq!((outcome.cases, outcome.failures.len()), (1, 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! * A [`Case`] is data: a scene built in code, a camera, a size, and what it claims.
//! * The reference is the scalar CPU backend on one thread. It is itself compared with
//!   [`oracle::brute`], which has no acceleration structure, bit for bit, and with
//!   [`oracle::wide`], which shares no code with the renderer and computes in `f64`.
//! * All buffers are compared, in the order of the stages, bit for bit
//!   ([`rtrt_core::compare`]).
//!
//! Limits: the suite says whether backends agree, not whether shading looks right. What a
//! missing device means is decided in [`variants`].

pub mod golden;
pub mod hybrid;
mod image;
pub mod oracle;
pub mod proof;
pub mod report;
mod suite;
pub mod variants;

pub use conformance_cases::{Agree, Case, Known, cases, shape};
pub use image::leave_images;
pub use rtrt_core::compare::{Difference, Place, compare};
pub use suite::{Failed, Failure, Itself, Outcome, Suite, check, reference};

/// Runs the README's examples as tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
