//! What a ray, a pixel or a block needs: compositions of kernels that backends only dispatch, in
//! the order of [`schedule`](crate::schedule).

pub mod bin;
pub mod context;
pub mod detail;
#[doc(hidden)]
pub mod inspect;
pub mod light;
pub mod occlusion;
pub mod peel;
pub mod penumbra_blocks;
pub mod penumbra_filter;
pub mod prepare;
pub mod raster;
pub mod resolve;
pub mod shade;
pub mod surface;
pub mod visibility;
