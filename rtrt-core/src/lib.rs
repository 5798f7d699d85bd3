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
//! # Who needs what
//!
//! **Programs that render** import two modules, which need the feature `alloc` (the default), and
//! perhaps a third. A version that breaks them has a new major number (before 1.0, a new minor one).
//!
//! | module | what it holds |
//! |---|---|
//! | `scene` | what there is to render: meshes, instances, [`Material`](scene::Material), [`Light`](scene::Light), textures, [`Camera`](scene::Camera) |
//! | `backend` | what is rendered and what comes back: [`Backend`](backend::Backend), [`Request`](backend::Request), [`Picture`](backend::Picture) |
//! | `compare` | the first difference between two pictures |
//!
//! **Authors of backends**, and programs that trace rays of their own, import the rest as well. Any
//! version may change it. In reading order:
//!
//! | module | what it holds |
//! |---|---|
//! | [`lane`] | the number type |
//! | [`num`] | division, roots and everything transcendental |
//! | [`grid`] | where pixels, rays and blocks lie |
//! | [`layout`] | the records that backends share in memory |
//! | [`kernel`] | pure functions, one idea a file |
//! | [`stage`] | what a ray or a block needs |
//! | [`schedule`] | the order of a frame |
//! | `scene` | [`Setup`](scene::Setup), [`ListCacheKey`](scene::ListCacheKey), [`ReusableLists`](scene::ReusableLists), [`Versions`](scene::Versions), and the records that a [`Scene`](scene::Scene) lends |
//!
//! # Promises
//!
//! Guarantees: `no_std`, no unsafe code; without the feature `alloc` no allocation; no panic
//! for any number, given scenes built by the `scene` module; results are functions of the
//! set of surfaces that a ray meets, never of the order in which they were visited.
//!
//! Limits: coordinates within ±2³⁰, meshes of at most 2²⁵ triangles.
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
pub mod query;
#[cfg(feature = "alloc")]
mod request;
#[cfg(feature = "alloc")]
pub mod scene;
pub mod schedule;
pub mod stage;
