//! The cases of the conformance suite: scenes built in code, cameras and requests, and what each claims.
//!
//! A crate of its own, `no_std` with `alloc`, so that a machine without an operating system can render them. The
//! suite itself, and where cases are run, is in the crate `conformance`.
#![no_std]

extern crate alloc;

mod case;
pub mod cases;
pub mod shape;

pub use case::{Agree, Case, Known};
