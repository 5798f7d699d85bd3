//! Every algorithm of the rtrt ray tracer, written once: pure functions over SIMD lanes that
//! return the same bits on every machine.
//!
//! ```
//! use rtrt_core::kernel::ray::Ray;
//! use rtrt_core::kernel::triangle::{Triangle, intersect};
//! use rtrt_core::lane::V3;
//!
//! // A lane of width 1, as a GPU invocation runs it.
//! let at = |v| V3::<f32>::splat((), v);
//! let ray = Ray::new(at([0.25, 0.25, 3.0]), at([0.0, 0.0, -1.0]));
//! let triangle = Triangle::new([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
//! let met = intersect(&ray, &triangle, &triangle.relative_to(ray.origin), f32::MAX);
//! assert!(met.mask && (met.t - 3.0).abs() < 1e-6);
//! ```
//!
//! In reading order: [`lane`] (the number type), [`num`] (the only file that divides),
//! [`grid`] (where pixels, rays and blocks lie), [`layout`] (what backends share in memory),
//! [`kernel`] (one idea a file), [`stage`] (what a ray or a block needs, in the order of a
//! frame).
//!
//! Guarantees: `no_std`, no unsafe code; without the feature `alloc` no allocation; no panic
//! for any number, given scenes built by the `scene` module; results are functions of the
//! set of surfaces that a ray meets, never of the order in which they were visited.
//!
//! Limits: coordinates within ±2³⁰, meshes of at most 2²⁵ triangles. With `alloc` (the
//! default) come `scene` (building a scene), `backend` (what every backend implements) and
//! `compare` (the first difference of two frames).
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
mod request;
#[cfg(feature = "alloc")]
pub mod scene;
pub mod stage;
