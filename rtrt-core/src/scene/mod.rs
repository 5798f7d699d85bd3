//! Building a scene, on the host: meshes and their trees, mip chains, cameras, lights.
//!
//! This is the part of the crate that allocates (feature `alloc`) and the only one that
//! calls `libm`, which makes hosts agree where the standard libraries differ. Kernels read
//! what is built here.

mod camera;
mod environment;
mod floor;
mod image;
mod levels;
mod light;
mod material;
mod mesh;
mod motion;
mod place;
mod setup;
mod store;
mod tangent;
mod tree;

pub use camera::{Camera, Projection};
pub use environment::{Panorama, PanoramaError};
pub use image::{Content, Image, ImageError};
pub use light::Light;
pub use material::phong;
pub use mesh::{COORDINATE_LIMIT, Mesh, MeshError};
pub use motion::Motion;
pub use setup::{Setup, SetupError};
pub use store::{
    MaterialIndex, MeshIndex, Mip, ObjectIndex, Occluders, Scene, SceneError, Structure, Versions,
};
pub use tree::{Join, MeshTree, Sequential, TreeError};
