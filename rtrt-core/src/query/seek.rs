//! A search of all that is near something: through the trees over the instances, and on through those of meshes.

use super::block::Block;
use super::merged::MergedLeaf;
use super::source::Source;
use super::tree::MeshTree;
use super::wide::{Child, WIDTH, WideNode, WideTree};
use super::world::World;
use crate::kernel::traverse::STACK;
use crate::layout::Instance;
use crate::scene::{Bounds, InstanceIndex, from_rows};
use glam::{DMat3, DVec3};

/// Something that looks at what is near.
pub(super) trait Seeker {
    /// How far a box is, world space.
    fn distance(&self, low: DVec3, high: DVec3) -> f64;
    /// How far it may be.
    fn reach(&self) -> f64;
    /// Whether an instance counts.
    fn accepts(&mut self, instance: InstanceIndex) -> bool;
    /// Looks at a sphere.
    fn sphere(&mut self, instance: InstanceIndex, placed: &Placed);
    /// Looks at triangles of an instance; returns whether it looks at more of them.
    fn triangles(&mut self, instance: InstanceIndex, placed: &Placed, blocks: &[Block]) -> bool;
}

impl<S: Source> World<'_, S> {
    /// Shows a seeker what is in its reach, roughly from near to far. `magnitude` is the largest coordinate of the
    /// world and of what it starts from.
    pub(super) fn seek(&self, magnitude: f32, seeker: &mut impl Seeker) {
        let top = &self.tree.instances;
        let sees = |number: u32| self.source.tags()[number as usize].mask & self.mask != 0;
        let space = Placed::new(&top.merged.space.to_world, &top.merged.space.to_object);
        let placed = |bounds: &Bounds, _| space.bounds(bounds);
        walk(&top.merged.tree, None, seeker, placed, |seeker, leaf, _| {
            let MergedLeaf { instance: number, block, count } = top.merged.leaves[leaf as usize];
            let instance = self.source.numbered(number);
            if top.entries[number as usize].is_merged && sees(number) && seeker.accepts(instance) {
                seeker.triangles(instance, &space, self.mesh(number).blocks(block, count));
            }
            true
        });
        let padded = |bounds: &Bounds, slack: f32| {
            // An instance may reach so far out of its box in the tree.
            let ((low, high), pad) = (corners(bounds), f64::from(magnitude) * f64::from(slack));
            (low - pad, high + pad)
        };
        // The leaves of what is hidden or merged have empty boxes.
        walk(&top.tree, Some(&top.slacks), seeker, padded, |seeker, number, _| {
            let instance = self.source.numbered(number);
            if !sees(number) || !seeker.accepts(instance) {
                return true;
            }
            let record = &self.source.instances()[number as usize];
            let placed = Placed::of(record);
            if record.is_sphere() {
                seeker.sphere(instance, &placed);
                return true;
            }
            let mesh = self.mesh(number);
            walk(
                &mesh.tree,
                None,
                seeker,
                |bounds, _| placed.bounds(bounds),
                |seeker, first, count| seeker.triangles(instance, &placed, mesh.blocks(first, count)),
            );
            true
        });
    }

    /// The tree of an instance's mesh.
    fn mesh(&self, number: u32) -> &MeshTree {
        &self.tree.meshes[self.source.mesh_of(number as usize)]
    }
}

/// An instance's matrices.
pub(super) struct Placed {
    pub to_world: DMat3,
    pub moved: DVec3,
    pub to_ball: DMat3,
    pub ball_moved: DVec3,
}

impl Placed {
    pub fn of(instance: &Instance) -> Self {
        Self::new(&instance.to_world, &instance.to_object)
    }

    fn new(to_world: &[[f32; 4]; 3], to_object: &[[f32; 4]; 3]) -> Self {
        let [to_world, to_object] = [to_world, to_object].map(from_rows);
        let moved = to_world.w_axis.truncate();
        let [to_world, to_ball] = [to_world, to_object].map(DMat3::from_mat4);
        Self { to_world, moved, to_ball, ball_moved: -(to_ball * moved) }
    }

    /// A triangle in world space.
    pub fn triangle(&self, corners: [[f32; 3]; 3]) -> [DVec3; 3] {
        corners.map(|corner| self.to_world * DVec3::from(corner.map(f64::from)) + self.moved)
    }

    /// The bounds of a box in world space.
    fn bounds(&self, bounds: &Bounds) -> (DVec3, DVec3) {
        let (low, high) = corners(bounds);
        let middle = self.to_world * ((low + high) * 0.5) + self.moved;
        let half = self.to_world.abs() * ((high - low) * 0.5);
        (middle - half, middle + half)
    }
}

/// The corners of a box.
pub(super) fn corners(bounds: &Bounds) -> (DVec3, DVec3) {
    (DVec3::from(bounds.low.map(f64::from)), DVec3::from(bounds.high.map(f64::from)))
}

/// How far rounding takes distances: `f64` has 52 bits, of which many are spare.
pub(super) fn rounding(magnitude: f32) -> f64 {
    f64::from(magnitude) * 1e-12
}

/// The children of a node that wait, farthest first.
#[derive(Clone, Copy)]
struct Waiting {
    node: u32,
    count: usize,
    children: [(f64, usize); WIDTH],
}

/// Shows `leaf` the leaves whose boxes are in a seeker's reach, near ones first, until it returns false. `boxed` is the
/// box of a child in world space, of its bounds and its slack.
fn walk<K: Seeker>(
    tree: &WideTree,
    slacks: Option<&[[f32; WIDTH]]>,
    seeker: &mut K,
    boxed: impl Fn(&Bounds, f32) -> (DVec3, DVec3),
    mut leaf: impl FnMut(&mut K, u32, u32) -> bool,
) {
    let mut stack = [Waiting { node: 0, count: 0, children: [(0.0, 0); WIDTH] }; STACK];
    let mut depth = 0;
    let mut index = 0;
    loop {
        let node: &WideNode = &tree.nodes[index as usize];
        let waiting = &mut stack[depth];
        (waiting.node, waiting.count) = (index, 0);
        for slot in 0..WIDTH {
            let bounds = node.bounds(slot);
            if bounds.is_empty() {
                continue;
            }
            let (low, high) = boxed(&bounds, slacks.map_or(0.0, |slacks| slacks[index as usize][slot]));
            let away = seeker.distance(low, high);
            let place = waiting.children[..waiting.count].partition_point(|(other, _)| *other > away);
            waiting.count += 1;
            waiting.children[place..waiting.count].rotate_right(1);
            waiting.children[place] = (away, slot);
        }
        depth += 1;
        index = loop {
            if depth == 0 {
                return;
            }
            let top = &mut stack[depth - 1];
            if top.count == 0 {
                depth -= 1;
                continue;
            }
            top.count -= 1;
            let (away, slot) = top.children[top.count];
            if away > seeker.reach() {
                // So are the others.
                depth -= 1;
                continue;
            }
            match tree.nodes[top.node as usize].child(slot) {
                Child::Node(child) => break child,
                Child::Leaf(first, count) => {
                    if !leaf(seeker, first, count) {
                        return;
                    }
                }
            }
        };
    }
}
