//! What a ray, a pixel or a block needs, in the order of a frame: compositions of
//! kernels that backends only dispatch.

pub mod bin;
pub mod detail;
pub mod edges;
pub mod inspect;
pub mod layers;
pub mod light;
pub mod occlusion;
pub mod penumbra;
pub mod prepare;
pub mod raster;
pub mod resolve;
pub mod shade;
pub mod soften;
pub mod surface;
pub mod visibility;
