//! Rays for programs of any kind: what is hit, who sees whom, what is near.
//!
//! ```
//! use glam::{Mat4, Vec3};
//! use rtrt_core::query::{Ray, Tree};
//! use rtrt_core::scene::{Material, Scene};
//!
//! let mut scene = Scene::new();
//! let white = scene.add_material(Material::default())?;
//! let ball = scene.add_sphere(white, Mat4::from_translation(Vec3::new(0.0, 0.0, -5.0)))?;
//!
//! let mut tree = Tree::default();
//! let world = tree.world(&scene);
//! let hit = world.closest(&Ray::new([0.0; 3], [0.0, 0.0, -1.0]))?.ok_or("a miss")?;
//! assert!(hit.instance == ball && (hit.t - 4.0).abs() < 1e-6);
//! assert!(world.occluded(&Ray::between([0.0; 3], [0.0, 0.0, -9.0]))?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | to | call |
//! |---|---|
//! | ask for a hit, or whether there is one | [`World::closest`], [`World::occluded`] |
//! | ask many rays, which are traced together by 64 | [`World::closest_each`], [`World::occluded_each`] |
//! | ask for all hits on a ray, in order | [`World::all`] |
//! | decide which hits count | [`World::closest_where`], [`World::occluded_where`], [`World::all_where`] |
//! | ask what is near, or what a box or a ball overlaps | [`World::nearest`], [`World::overlaps`], [`World::overlapped_instances`] |
//! | know the surface at a hit | [`World::surface`] |
//! | limit a ray, or what it meets | the setters of [`Ray`] |
//! | ask some groups of instances only | [`World::masked`] |
//! | keep meshes where they are, without a scene | [`Shapes`] |
//! | ask far from the origin of `f32` | [`Origin`](crate::scene::Origin) |
//! | store what takes long to build | [`Bvh::to_bytes`](crate::scene::Bvh::to_bytes), [`Shapes::add_mesh_with`] |
//! | move something | [`Scene::set_transform`](crate::scene::Scene::set_transform), then [`Tree::world`] |
//!
//! # Errors
//!
//! A ray without a direction (zero, NaN, infinite) or with a start that is NaN or beyond ±2³⁰ is a [`QueryError`]. A
//! ray that ends before it starts hits nothing. Directions of other lengths are right, whatever the length: `t`
//! counts in it. An index of another scene names nothing: a ray skips nothing by it, and what is asked of a hit
//! is `None`.

mod block;
mod collect;
mod device;
#[cfg(test)]
mod fixture;
mod instances;
mod merged;
mod narrow;
mod near;
mod overlap;
mod packet;
mod ray;
mod rows;
mod search;
mod seek;
mod shape;
mod shapes;
mod source;
mod surface;
mod tree;
mod wear;
mod wide;
mod widen;
mod world;

pub use device::{Changed, DeviceChanges, DeviceWorld};
pub use overlap::{Overlap, Volume};
pub use ray::{QueryError, Ray, Sides};
pub use shapes::Shapes;
pub use source::Source;
pub use surface::Surface;
pub use tree::Tree;
pub use world::{Hit, World};
