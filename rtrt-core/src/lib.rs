//! Every algorithm of the rtrt ray tracer, written once.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(test)]
extern crate std;

#[cfg(feature = "alloc")]
pub mod backend;
#[cfg(feature = "alloc")]
pub mod compare;
pub mod grid;
pub mod kernel;
pub mod lane;
pub mod layout;
pub mod num;
#[cfg(feature = "alloc")]
pub mod scene;
pub mod stage;
