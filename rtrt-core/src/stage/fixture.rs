//! A frame of a small scene, ready for the stages that trace rays, for tests.

use crate::grid::RayIndex;
use crate::kernel::closest_hit::ClosestHit;
use crate::kernel::lists::{BlockLists, ListEntry};
use crate::lane::{Lane, groups};
use crate::layout::{Attribute, Frame};
use crate::request::{Camera, Projection, Request};
use crate::scene::{Bvh, Material, Mesh, MeshIndex, Scene, Sequential, Setup};
use crate::stage::context::Context;
use crate::stage::surface::{Surfaces, surface};
use crate::stage::visibility::{directions, visibility};
use crate::stage::{bin, prepare};
use glam::{Mat4, Vec3};
use std::vec;
use std::vec::Vec;

/// A camera at z = 4 that looks along −z, with parallel rays a unit apart; the picture reaches from −8 to 8.
pub(crate) const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 0.0, 4.0),
    look_at: Vec3::ZERO,
    up: Vec3::Y,
    projection: Projection::Orthographic { height: 16.0 },
};

/// Adds the square from −1 to 1 in the plane z = 0, which faces +z, its texture coordinates from 0 to 1.
pub(crate) fn add_square(scene: &mut Scene, material: Material, to_world: Mat4) {
    let material = scene.add_material(material).unwrap();
    let mesh = add_square_mesh(scene);
    scene.add_instance(mesh, material, to_world).unwrap();
}

/// Adds the mesh of [`add_square`].
pub(crate) fn add_square_mesh(scene: &mut Scene) -> MeshIndex {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let attribute = |[x, y, _]: [f32; 3]| Attribute {
        normal: [0.0, 0.0, 1.0],
        uv: [x * 0.5 + 0.5, 0.5 - y * 0.5],
        color: Attribute::WHITE,
    };
    let mesh = Mesh::new(corners.to_vec(), corners.map(attribute).to_vec(), vec![0, 1, 2, 0, 2, 3]).unwrap();
    scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap()
}

/// The square, larger and elsewhere.
pub(crate) fn square_at(size: f32, place: [f32; 3]) -> Mat4 {
    Mat4::from_translation(place.into()) * Mat4::from_scale(Vec3::splat(size))
}

/// The frame.
pub(crate) struct Prepared {
    pub scene: Scene,
    setup: Setup,
    lists: Vec<u32>,
}

impl Prepared {
    /// A frame of 16 by 16 rays, which are one block.
    pub fn new(scene: Scene, change: impl FnOnce(Request<'_>) -> Request<'_>) -> Self {
        let mut setup = Setup::default();
        setup.prepare(&scene, &change(Request::new(&CAMERA, [16, 16]))).unwrap();
        let (frame, views, instances) = (&setup.frame, &setup.views[..], setup.instances(&scene));
        let bounds: Vec<_> =
            (0..prepare::count(frame)).map(|i| prepare::prepare(frame, views, instances, i)).collect();
        let mut blocks: Vec<Vec<ListEntry>> = vec![vec![]; frame.blocks as usize];
        for index in 0..bounds.len() as u32 {
            bin::each_block(frame, views, instances, &bounds, index, |block, entry| {
                blocks[block as usize].push(entry);
            });
        }
        let mut lists = vec![0];
        for block in &mut blocks {
            block.sort_unstable_by_key(|entry| (entry.key, entry.instance));
            lists.push(lists[lists.len() - 1] + block.len() as u32);
        }
        lists.extend(blocks.iter().flatten().flat_map(|entry| [entry.key, entry.instance]));
        Self { scene, setup, lists }
    }

    pub fn context(&self) -> Context<'_> {
        let Self { scene, setup, lists } = self;
        Context {
            frame: &setup.frame,
            views: &setup.views,
            lists: BlockLists { data: lists, blocks: setup.frame.blocks },
            geometry: setup.geometry(scene),
        }
    }

    pub fn frame(&self) -> &Frame {
        &self.setup.frame
    }
}

/// What a group of rays hits. Compiled once for all tests.
#[inline(never)]
pub(crate) fn closest<L: Lane<Token = ()>, const G: usize>(
    prepared: &Prepared,
    first: RayIndex,
) -> [ClosestHit<L>; G] {
    visibility::<L, G>((), &prepared.context(), first)
}

/// The surfaces that a group of rays hits. Compiled once for all tests.
#[inline(never)]
pub(crate) fn surfaces<L: Lane<Token = ()>, const G: usize>(
    prepared: &Prepared,
    first: RayIndex,
) -> [Surfaces<L>; G] {
    let (context, attributes) = (prepared.context(), prepared.scene.attributes());
    let closest = closest::<L, G>(prepared, first);
    let directions = directions::<L, G>((), prepared.frame(), context.camera(), first);
    groups(|g| surface(context.camera(), &context.geometry, attributes, directions[g], &closest[g]))
}
