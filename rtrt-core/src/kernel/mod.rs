//! One idea a file: pure functions that stages are composed of.

pub mod area;
pub mod canary;
pub mod cone;
pub mod environment;
pub mod falloff;
pub mod frustum;
pub mod interpolate;
pub mod lists;
pub mod mip;
pub mod offset;
pub mod penumbra;
pub mod project;
pub mod ray;
pub mod reflect;
pub mod screen_bounds;
pub mod slab;
pub mod sphere;
pub mod tangent;
pub mod texture;
pub mod tiles;
pub mod transmittance;
pub mod transparency;
pub mod traverse;
pub mod triangle;
pub mod unique_gather;
pub mod view;
