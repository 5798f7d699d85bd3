//! Building a scene, on the host: meshes and their trees, mip chains, cameras, lights.
//!
//! ```
//! use rtrt_core::scene::{Attribute, Bvh, Light, Material, Mesh, Scene, Sequential};
//!
//! let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! // Without a normal of its own, a vertex has that of its triangle.
//! let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
//! let mesh = Mesh::new(corners, vec![attribute; 3], vec![0, 1, 2])?;
//! let mut scene = Scene::new();
//! let red = scene.add_material(Material::new([0.8, 0.1, 0.1]).roughness(0.7))?;
//! let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential))?;
//! for x in [-2.0, 0.0, 2.0] {
//!     scene.add_instance(mesh, red, glam::Mat4::from_translation([x, 0.0, 0.0].into()))?;
//! }
//! scene.add_light(Light::sun([0.0, -1.0, -1.0]));
//! assert_eq!((scene.triangles(), scene.drawn_triangles()), (1, 3));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! This is the part of the crate that allocates (feature `alloc`) and the only one that
//! calls `libm`, which makes hosts agree where the standard libraries differ. Kernels read
//! what is built here.

mod brightness;
mod bvh;
mod bvh_bytes;
mod camera;
mod choice;
mod cube;
mod cut;
mod encoder;
mod environment;
mod extensions;
mod floor;
mod image;
mod levels;
mod light;
mod list_cache;
mod material;
mod mesh;
mod motion;
mod origin;
mod place;
mod places;
mod setup;
mod setup_error;
mod store;
mod studio;
mod sun;
mod tangent;
mod views;

pub use crate::layout::{Attribute, Backdrop, COLOR_LIMIT, LIGHT_LIMIT, Texture, Wrap};
pub use crate::request::{Camera, Projection};
pub(crate) use bvh::Bounds;
pub use bvh::{Bvh, BvhError, Join, Sequential};
pub use choice::{Mip, Occluders, Structure};
pub use cube::{Cube, CubeError};
pub use environment::{Panorama, PanoramaError};
pub use extensions::{Anisotropy, Clearcoat, Iridescence, Sheen};
pub use image::{Content, Image, ImageError};
pub use light::{Light, LightKind};
pub use list_cache::{ListCacheKey, ReusableLists};
pub use material::{AlphaMode, Material};
pub use mesh::{COORDINATE_LIMIT, Mesh, MeshError};
pub use motion::Motion;
pub use origin::Origin;
pub(crate) use place::{InstanceMaterial, Stored, from_rows, place};
pub(crate) use places::{Places, Tag};
pub use setup::Setup;
pub use setup_error::SetupError;
pub(crate) use store::Identity;
pub use store::{InstanceIndex, MaterialIndex, MeshIndex, Scene, SceneError, Versions};
pub use studio::studio;
