//! One idea a file: pure functions that stages are composed of.

pub(crate) mod area;
#[doc(hidden)]
pub mod canary;
pub mod closest_hit;
pub(crate) mod cone;
pub(crate) mod environment;
pub mod falloff;
pub mod geometry;
pub mod hit_filter;
pub(crate) mod interpolate;
pub mod lists;
pub(crate) mod mip;
pub(crate) mod offset;
pub mod packet;
pub mod penumbra;
pub mod project;
pub mod ray;
pub(crate) mod reflect;
pub mod screen_bounds;
pub mod shadow_distance;
pub mod slab;
pub mod sphere;
pub(crate) mod tangent;
pub mod texture;
pub mod tiles;
pub mod tone_map;
pub mod transmittance;
pub mod transparency;
pub mod traverse;
pub mod triangle;
pub(crate) mod unique_gather;
pub mod view;
