//! Every algorithm of the rtrt ray tracer, written once: rays, frames and what they are made of, with the
//! same bits on every machine.
//!
//! The first ray:
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! use rtrt_core::glam::Mat4;
//! use rtrt_core::query::{Ray, Shapes, Tree};
//! use rtrt_core::scene::Sequential;
//!
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let mut shapes = Shapes::new();
//! let mesh = shapes.add_mesh(&positions, &[0, 1, 2], &Sequential)?;
//! shapes.add_instance(mesh, Mat4::IDENTITY)?;
//! let mut tree = Tree::default();
//! let hit = tree.world(&shapes).closest(&Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -1.0]))?;
//! assert!(hit.is_some_and(|hit| (hit.t - 3.0).abs() < 1e-6));
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! All queries and their errors: [`query`]. A scene with materials, lights and spheres: [`scene`]. Transforms
//! and colors are types of [`glam`], which is a part of this crate's interface: `rtrt_core::glam`, or version 0.33 of the
//! crate itself.
//!
//! # Who needs what
//!
//! **Programs that render or ask rays** import these modules, which need the feature `alloc` (the default). A version that breaks them has a new major number (before 1.0, a new minor one).
//!
//! | module | what it holds |
//! |---|---|
//! | `scene` | what there is to render: meshes, instances, [`Material`](scene::Material), [`Light`](scene::Light), textures, [`Camera`](scene::Camera) |
//! | `query` | single rays: what is hit, who sees whom ([`Tree`](query::Tree), [`World`](query::World), [`Ray`](query::Ray)) |
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
//! | [`stage`] | kernels composed for one ray, pixel or block |
//! | [`schedule`] | the order of a frame |
//! | `scene` | [`Setup`](scene::Setup), [`ListCacheKey`](scene::ListCacheKey), [`ReusableLists`](scene::ReusableLists), [`Versions`](scene::Versions), and the records that a [`Scene`](scene::Scene) lends |
//!
//! # Promises
//!
//! `no_std`, no unsafe code; without the feature `alloc` no allocation; no panic
//! for any number, given scenes built by the `scene` module; results are functions of the
//! set of surfaces that a ray meets, never of the order in which they were visited.
//!
//! Limits: coordinates within ±2³⁰, meshes of at most 2²⁵ triangles.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "alloc")]
pub use glam;

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(test)]
extern crate std;

#[cfg(feature = "alloc")]
pub mod backend;
#[cfg(feature = "alloc")]
pub mod compare;
#[cfg(feature = "alloc")]
mod exposure;
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
