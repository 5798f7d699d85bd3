//! Trees for rays: one over the instances, and one for each mesh.

use super::block::Block;
use super::instances::InstanceTree;
use super::source::{MeshNodes, MeshVersion, Parts, Source};
use super::wide::{Child, WIDTH, WideTree};
use super::widen::widened;
use super::world::World;
use crate::scene::{Bounds, Join, Sequential};
use alloc::vec::Vec;
use core::sync::atomic::{AtomicBool, Ordering};

/// Trees over the instances and meshes of a [`Scene`](crate::scene::Scene) or of [`Shapes`](super::Shapes), kept
/// from one change to the next.
///
/// [`Tree::world`] brings them up to date: after a move the boxes above what moved are computed again, and
/// after many moves the tree over the instances is built again if it has become twice as bad, or once a third of
/// its instances are new. Instances with the same transform and meshes that never bent are met in one tree, as long as
/// most of them stay together; new ones once that tree is built again. What rays hit does not depend on it. Memory:
/// about 70 bytes a triangle of each mesh, 15 more if it is one of those, and 150 an instance.
#[derive(Debug, Default)]
pub struct Tree {
    /// What it was made of.
    source: Option<u32>,
    pub(crate) instances: InstanceTree,
    pub(crate) meshes: Vec<MeshTree>,
    /// [`Parts::mesh_changes`] of the source when they were made.
    mesh_changes: Option<u32>,
}

/// The tree of one mesh.
#[derive(Debug)]
pub(crate) struct MeshTree {
    pub version: MeshVersion,
    /// Its leaves hold blocks.
    pub tree: WideTree,
    pub blocks: Vec<Block>,
    /// The box of all triangles.
    pub bounds: Bounds,
}

impl MeshTree {
    fn new(source: &impl Parts, mesh: usize) -> Self {
        let MeshNodes { nodes, version } = source.nodes(mesh);
        let mut tree = widened(nodes, WIDTH as u32);
        let mut blocks = Vec::with_capacity(tree.blocks());
        for node in &mut tree.nodes {
            for slot in 0..WIDTH {
                let Child::Leaf(first, count) = node.child(slot) else { continue };
                let before = blocks.len();
                let starts = (first..first + count).step_by(WIDTH);
                blocks.extend(starts.map(|start| {
                    let held = (first + count - start).min(WIDTH as u32);
                    Block::new(start, held, |triangle| source.mesh_triangle(mesh, triangle))
                }));
                let leaf = Child::Leaf(before as u32, (blocks.len() - before) as u32);
                node.set_child(slot, &leaf, &node.bounds(slot));
            }
        }
        let bounds = tree.nodes[0].all_bounds();
        Self { version, tree, blocks, bounds }
    }

    /// The blocks of a leaf.
    #[inline(always)]
    pub fn blocks(&self, first: u32, count: u32) -> &[Block] {
        &self.blocks[first as usize..][..count as usize]
    }
}

impl Tree {
    /// The trees of a source; [`Tree::world`] makes them as well, but with one worker.
    pub fn new<S: Source>(source: &S, join: &impl Join) -> Self {
        let mut tree = Self::default();
        tree.update(source, join);
        tree
    }

    /// The world that rays are asked of, as the source has it now.
    ///
    /// The time depends on what has moved since the last call, and hardly on how much there is. No memory is
    /// asked for unless instances or meshes were added or a mesh has another shape, the tree over the
    /// instances has become bad, or most of those that were met in one tree have gone apart.
    pub fn world<'a, S: Source>(&'a mut self, source: &'a S) -> World<'a, S> {
        self.update(source, &Sequential);
        World::new(self, source)
    }

    /// Brings the trees up to date; workers of `join` build what must be built.
    pub fn update<S: Source>(&mut self, source: &S, join: &impl Join) {
        self.update_until(source, join, &AtomicBool::new(false));
    }

    /// [`Tree::update`] that ends between two meshes once `stop` is true. Returns whether the trees are up to date; if not,
    /// the next update has less to do.
    pub fn update_until<S: Source>(&mut self, source: &S, join: &impl Join, stop: &AtomicBool) -> bool {
        let is_stopped = || stop.load(Ordering::Relaxed);
        if self.source != Some(source.id()) {
            *self = Self { source: Some(source.id()), ..Self::default() };
        }
        let mesh_changes = Some(source.mesh_changes());
        if self.mesh_changes != mesh_changes {
            for (mesh, tree) in self.meshes.iter_mut().enumerate() {
                if tree.version != source.nodes(mesh).version {
                    if is_stopped() {
                        return false;
                    }
                    *tree = MeshTree::new(source, mesh);
                }
            }
            for mesh in self.meshes.len()..source.meshes() {
                if is_stopped() {
                    return false;
                }
                self.meshes.push(MeshTree::new(source, mesh));
            }
            self.mesh_changes = mesh_changes;
        }
        self.instances.update(source, &self.meshes, join);
        true
    }

    /// Bytes of all trees.
    pub fn bytes(&self) -> usize {
        let meshes: usize = self
            .meshes
            .iter()
            .map(|mesh| size_of_val(&mesh.tree.nodes[..]) + size_of_val(&mesh.blocks[..]))
            .sum();
        meshes + self.instances.bytes()
    }
}
