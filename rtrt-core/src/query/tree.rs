//! Trees for rays: one over the instances, and one for each mesh.

use super::block::Block;
use super::source::{MeshNodes, MeshVersion, Parts, Source};
use super::wear::Wear;
use super::wide::{Child, WIDTH, WideTree, widened};
use super::world::World;
use crate::layout::NONE;
use crate::scene::{Bounds, Bvh, Join, Sequential, around, from_rows};
use alloc::collections::BinaryHeap;
use alloc::vec;
use alloc::vec::Vec;
use core::sync::atomic::{AtomicBool, Ordering};

/// Trees over the instances and meshes of a [`Scene`](crate::scene::Scene) or of [`Shapes`](super::Shapes), kept
/// from one change to the next.
///
/// [`Tree::world`] brings them up to date: after a move the boxes above what moved are computed again, and
/// after many moves the tree over the instances is built again if it has become twice as bad. What rays hit
/// does not depend on it. Memory: about 70 bytes a triangle of each mesh, and 150 an instance.
#[derive(Debug, Default)]
pub struct Tree {
    /// What it was made of.
    source: Option<u32>,
    pub(crate) instances: InstanceTree,
    pub(crate) meshes: Vec<MeshTree>,
}

/// The tree of one mesh.
#[derive(Debug)]
pub(crate) struct MeshTree {
    version: MeshVersion,
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
        let mut blocks = Vec::new();
        for node in &mut tree.nodes {
            for slot in 0..WIDTH {
                let Child::Leaf(first, count) = node.child(slot) else { continue };
                node.set_first(slot, blocks.len() as u32);
                let starts = (first..first + count).step_by(WIDTH);
                blocks.extend(starts.map(|start| {
                    let held = (first + count - start).min(WIDTH as u32);
                    Block::new(start, held, |triangle| source.mesh_triangle(mesh, triangle))
                }));
            }
        }
        let bounds = tree.nodes[0].all_bounds();
        Self { version, tree, blocks, bounds }
    }

    /// The blocks of a leaf that starts at the block `first` and holds so many triangles.
    #[inline(always)]
    pub fn blocks(&self, first: u32, triangles: u32) -> &[Block] {
        &self.blocks[first as usize..][..triangles.div_ceil(WIDTH as u32) as usize]
    }
}

/// A part of an instance: what is below a node of its mesh's tree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    pub instance: u32,
    pub node: u32,
}

/// The most parts of an instance.
const PARTS: usize = 64;
/// So many triangles of all meshes make room for one more part.
const TRIANGLES: usize = 16;

/// The tree over the instances. Its leaves hold one part each.
///
/// An instance that stands where its mesh was modelled has several, so that a ray enters a mesh as deep as if all
/// such meshes were one (after Benthin et al., "Improved Two-Level BVHs using Partial Re-Braiding", HPG 2017). Others
/// have one: a ray would be taken into their space for each.
#[derive(Debug)]
pub(crate) struct InstanceTree {
    pub tree: WideTree,
    /// The largest slack in each child.
    pub slacks: Vec<[f32; WIDTH]>,
    /// Where each node is: in this child. The root is nowhere.
    parents: Vec<u32>,
    /// The parts, those of an instance together.
    pub parts: Vec<Part>,
    /// The first part of each instance, and the end.
    firsts: Vec<u32>,
    /// Where each part is.
    places: Vec<u32>,
    /// The box of all meshes that stand where they were modelled, if any has several parts.
    pub modelled: Option<Bounds>,
    /// What a search needs of each instance, in one cache line.
    pub entries: Vec<Entry>,
    /// So many moves of the source are in it.
    moves: u64,
    wear: Wear,
}

/// What a search needs of an instance.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    /// World to object space, three rows.
    pub to_object: [[f32; 4]; 3],
    /// Its groups.
    pub mask: u32,
    /// Its mesh.
    pub mesh: u32,
    /// Whether the two spaces are the same.
    pub is_identity: bool,
    /// Whether it is a sphere.
    pub is_sphere: bool,
}
const _: () = assert!(size_of::<Entry>() == 64);

impl Entry {
    fn new(source: &impl Parts, number: usize) -> Self {
        let instance = &source.instances()[number];
        Self {
            to_object: instance.to_object,
            mask: source.tags()[number].mask,
            mesh: source.mesh_of(number) as u32,
            is_identity: instance.is_identity == 1,
            is_sphere: instance.is_sphere(),
        }
    }
}

impl Default for InstanceTree {
    fn default() -> Self {
        Self {
            tree: WideTree::default(),
            slacks: vec![[0.0; WIDTH]],
            parents: vec![NONE],
            parts: vec![],
            firsts: vec![0],
            places: vec![],
            modelled: None,
            entries: vec![],
            moves: 0,
            wear: Wear::default(),
        }
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
    /// asked for unless instances or meshes were added or a mesh has another shape, or the tree over the
    /// instances has become bad.
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
        for (mesh, tree) in self.meshes.iter_mut().enumerate() {
            if tree.version != source.nodes(mesh).version {
                if is_stopped() {
                    return false;
                }
                // Its nodes may be others.
                self.instances.forget(mesh);
                *tree = MeshTree::new(source, mesh);
            }
        }
        for mesh in self.meshes.len()..source.meshes() {
            if is_stopped() {
                return false;
            }
            self.meshes.push(MeshTree::new(source, mesh));
        }
        self.instances.update(source, &self.meshes, join);
        true
    }

    /// Bytes of all trees.
    pub fn bytes(&self) -> usize {
        let InstanceTree { tree, slacks, parents, parts, firsts, places, entries, .. } = &self.instances;
        let meshes: usize = self
            .meshes
            .iter()
            .map(|mesh| size_of_val(&mesh.tree.nodes[..]) + size_of_val(&mesh.blocks[..]))
            .sum();
        let lists = size_of_val(&slacks[..])
            + size_of_val(&parents[..])
            + size_of_val(&parts[..])
            + size_of_val(&firsts[..])
            + size_of_val(&places[..])
            + size_of_val(&entries[..]);
        meshes + size_of_val(&tree.nodes[..]) + lists
    }
}

impl InstanceTree {
    /// Closes the instances of a mesh whose tree is about to change.
    fn forget(&mut self, mesh: usize) {
        let is_open =
            |part: &Part| part.node != 0 && self.entries[part.instance as usize].mesh == mesh as u32;
        if self.parts.iter().any(is_open) {
            *self = Self::default();
        }
    }

    fn update(&mut self, source: &impl Parts, meshes: &[MeshTree], join: &impl Join) {
        let moves = source.places().moves();
        if self.entries.len() != source.instances().len() || self.is_replaced(source, moves) {
            self.build(source, meshes, join);
        } else if moves != self.moves {
            match source.places().moved_since(self.moves) {
                Some(moved) => {
                    moved.iter().for_each(|&instance| self.refit(source, meshes, instance as usize));
                }
                None => self.refit_all(source, meshes),
            }
            if self.wear.is_worn(&self.tree.nodes[0].all_bounds()) {
                self.build(source, meshes, join);
            }
        }
        self.moves = moves;
    }

    /// Whether the number of an instance with several parts has gone to one of another mesh.
    fn is_replaced(&self, source: &impl Parts, moves: u64) -> bool {
        let is_other = |instance: usize| {
            let parts = self.firsts[instance + 1] - self.firsts[instance];
            parts > 1 && self.entries[instance].mesh != source.mesh_of(instance) as u32
        };
        match source.places().moved_since(self.moves) {
            _ if moves == self.moves => false,
            Some(moved) => moved.iter().any(|&instance| is_other(instance as usize)),
            None => (0..self.entries.len()).any(is_other),
        }
    }

    /// Builds the tree of all instances.
    fn build(&mut self, source: &impl Parts, meshes: &[MeshTree], join: &impl Join) {
        let instances = source.instances();
        self.parts = opened(source, meshes);
        self.firsts = vec![0; instances.len() + 1];
        for part in &self.parts {
            self.firsts[part.instance as usize + 1] += 1;
        }
        for instance in 0..instances.len() {
            self.firsts[instance + 1] += self.firsts[instance];
        }
        let boxes: Vec<_> = self.parts.iter().map(|part| part.bounds(source, meshes)).collect();
        let narrow = Bvh::over(&boxes, 1, join);
        self.tree = widened(&narrow.nodes, 1);
        let count = self.tree.nodes.len();
        self.slacks = vec![[0.0; WIDTH]; count];
        self.parents = vec![NONE; count];
        self.places = vec![NONE; boxes.len()];
        self.entries = (0..instances.len()).map(|instance| Entry::new(source, instance)).collect();
        for index in 0..count {
            for slot in 0..WIDTH {
                let place = (index * WIDTH + slot) as u32;
                match self.tree.nodes[index].child(slot) {
                    Child::Node(node) => self.parents[node as usize] = place,
                    Child::Leaf(_, 0) => {}
                    Child::Leaf(first, _) => {
                        let part = narrow.triangles[first as usize];
                        self.tree.nodes[index].set_first(slot, part);
                        self.places[part as usize] = place;
                    }
                }
            }
        }
        self.refit_all(source, meshes);
        self.wear.set_built(&self.tree.nodes[0].all_bounds());
    }

    /// Takes over where all instances are.
    fn refit_all(&mut self, source: &impl Parts, meshes: &[MeshTree]) {
        for instance in 0..self.entries.len() {
            self.entries[instance] = Entry::new(source, instance);
        }
        for (part, &place) in self.parts.iter().zip(&self.places) {
            let (node, slot) = split(place);
            self.tree.nodes[node].set_leaf(slot, &part.visible_bounds(source, meshes));
            self.slacks[node][slot] = source.instances()[part.instance as usize].slack;
        }
        let is_modelled = |entry: &&Entry| entry.is_identity && !entry.is_sphere;
        let modelled =
            self.entries.iter().filter(is_modelled).map(|entry| meshes[entry.mesh as usize].bounds);
        let has_parts = self.parts.len() > self.entries.len();
        self.modelled = has_parts.then(|| modelled.fold(Bounds::EMPTY, |all, bounds| all.union(&bounds)));
        self.wear.area = 0.0;
        for index in (0..self.tree.nodes.len()).rev() {
            let node = &self.tree.nodes[index];
            self.wear.area += (0..WIDTH).map(|slot| f64::from(node.bounds(slot).area())).sum::<f64>();
            if self.parents[index] != NONE {
                let (bounds, slack) = (node.all_bounds(), largest(&self.slacks[index]));
                let (above, slot) = split(self.parents[index]);
                self.tree.nodes[above].set_bounds(slot, &bounds);
                self.slacks[above][slot] = slack;
            }
        }
    }

    /// Takes over where one instance is.
    fn refit(&mut self, source: &impl Parts, meshes: &[MeshTree], instance: usize) {
        let entry = Entry::new(source, instance);
        self.entries[instance] = entry;
        if let Some(modelled) = self.modelled.as_mut().filter(|_| entry.is_identity && !entry.is_sphere) {
            *modelled = modelled.union(&meshes[entry.mesh as usize].bounds);
        }
        for part in self.firsts[instance]..self.firsts[instance + 1] {
            let bounds = self.parts[part as usize].visible_bounds(source, meshes);
            self.refit_part(part, bounds, source.instances()[instance].slack);
        }
    }

    /// Takes over where a part is.
    fn refit_part(&mut self, part: u32, mut bounds: Bounds, mut slack: f32) {
        let mut place = self.places[part as usize];
        let (node, slot) = split(place);
        self.tree.nodes[node].set_count(slot, &bounds);
        while place != NONE {
            let (index, slot) = split(place);
            let node = &mut self.tree.nodes[index];
            let old = node.bounds(slot);
            if (old.low, old.high, self.slacks[index][slot]) == (bounds.low, bounds.high, slack) {
                return;
            }
            node.set_bounds(slot, &bounds);
            self.slacks[index][slot] = slack;
            self.wear.replace(&old, &bounds);
            (bounds, slack) = (node.all_bounds(), largest(&self.slacks[index]));
            place = self.parents[index];
        }
    }
}

impl Part {
    /// Its box, empty if the instance is hidden.
    fn visible_bounds(&self, source: &impl Parts, meshes: &[MeshTree]) -> Bounds {
        let whole = source.places().bounds(self.instance as usize);
        if whole.is_empty() { *whole } else { self.bounds(source, meshes) }
    }

    /// Its box, world space.
    fn bounds(&self, source: &impl Parts, meshes: &[MeshTree]) -> Bounds {
        let instance = &source.instances()[self.instance as usize];
        if self.node == 0 {
            return Bounds { low: instance.low, high: instance.high };
        }
        let mesh = &meshes[source.mesh_of(self.instance as usize)];
        let bounds = mesh.tree.nodes[self.node as usize].all_bounds();
        if instance.is_identity == 1 { bounds } else { around(&from_rows(&instance.to_world), &bounds) }
    }
}

/// The parts of all instances: those with the largest boxes are opened first.
fn opened(source: &impl Parts, meshes: &[MeshTree]) -> Vec<Part> {
    let instances = source.instances();
    let mut parts: Vec<Part> =
        (0..instances.len() as u32).map(|instance| Part { instance, node: 0 }).collect();
    // Numbers that are not negative are ordered as their bits.
    let size = |part: &Part| part.bounds(source, meshes).area().max(0.0).to_bits();
    let can_open = |instance: usize| {
        let placed = &instances[instance];
        let is_modelled = placed.is_identity == 1 && !placed.is_sphere();
        is_modelled && meshes[source.mesh_of(instance)].version.shape == 0
    };
    if instances.len() < 2 {
        return parts;
    }
    let triangles: usize =
        (0..instances.len()).filter(|&i| can_open(i)).map(|i| instances[i].triangles as usize).sum();
    let mut room = triangles / TRIANGLES;
    let (open, mut closed): (Vec<_>, Vec<_>) =
        parts.drain(..).partition(|part| can_open(part.instance as usize));
    let mut counts = vec![1; instances.len()];
    let mut heap: BinaryHeap<_> = open.iter().map(|part| (size(part), part.instance, part.node)).collect();
    while let Some((_, instance, node)) = heap.pop() {
        let mesh = &meshes[source.mesh_of(instance as usize)];
        let wide = &mesh.tree.nodes[node as usize];
        let children =
            (0..WIDTH).map(|slot| wide.child(slot)).filter(|child| !matches!(child, Child::Leaf(_, 0)));
        let inner: Option<Vec<u32>> = children
            .map(|child| match child {
                Child::Node(node) => Some(node),
                Child::Leaf(..) => None,
            })
            .collect();
        let count = &mut counts[instance as usize];
        match inner {
            Some(inner)
                if inner.len() > 1 && inner.len() - 1 <= room && *count + inner.len() - 1 <= PARTS =>
            {
                room -= inner.len() - 1;
                *count += inner.len() - 1;
                let parts = inner.into_iter().map(|node| Part { instance, node });
                heap.extend(parts.map(|part| (size(&part), part.instance, part.node)));
            }
            _ => closed.push(Part { instance, node }),
        }
    }
    closed.sort_unstable_by_key(|part| (part.instance, part.node));
    closed
}

/// The node and the slot of a place.
fn split(place: u32) -> (usize, usize) {
    (place as usize / WIDTH, place as usize % WIDTH)
}

/// The largest of some slacks.
fn largest(slacks: &[f32; WIDTH]) -> f32 {
    slacks.iter().fold(0.0, |most, slack| most.max(*slack))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Attribute;
    use crate::query::{Hit, Volume};
    use crate::scene::{Material, Mesh, Scene};
    use glam::{Mat4, Vec3};

    #[test]
    fn only_what_stands_where_it_was_modelled_has_parts() {
        let positions: Vec<_> = (0..3000_u32)
            .map(|i| [(i * 37 % 101) as f32, (i * 53 % 89) as f32 + (i % 3) as f32, (i * 29 % 97) as f32])
            .collect();
        let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
        let mesh = Mesh::new(positions, vec![attribute; 3000], (0..3000).collect()).unwrap();
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let index = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
        let whole = scene.add_instance(index, white, Mat4::IDENTITY).unwrap();
        let parts = |tree: &Tree, number: usize| {
            let InstanceTree { firsts, parts, .. } = &tree.instances;
            let range = firsts[number] as usize..firsts[number + 1] as usize;
            assert!(parts[range.clone()].iter().all(|part| part.instance as usize == number));
            range.len()
        };
        // One alone gains nothing.
        assert_eq!(parts(&Tree::new(&scene, &Sequential), 0), 1);
        let moved = scene.add_instance(index, white, Mat4::from_translation(Vec3::X)).unwrap();
        let mut tree = Tree::new(&scene, &Sequential);
        assert!(parts(&tree, 0) > 10 && parts(&tree, 0) <= PARTS);
        assert_eq!(parts(&tree, 1), 1);
        // An instance is named once, however many of its parts are met.
        let mut met = [Hit::NONE.instance; 8];
        let all = Volume::between([-1e3; 3], [1e3; 3]);
        let count = tree.world(&scene).overlapped_instances(&all, &mut met).unwrap();
        assert_eq!(met[..count], [whole, moved]);
        // Parts go with their instance.
        scene.set_transform(whole, Mat4::from_translation(Vec3::Y)).unwrap();
        tree.world(&scene);
        for part in &tree.instances.parts[..parts(&tree, 0)] {
            let bounds = part.visible_bounds(&scene, &tree.meshes);
            let modelled = tree.meshes[0].tree.nodes[part.node as usize].all_bounds();
            assert_eq!(bounds.low[1], modelled.low[1] + 1.0);
        }
        // A mesh that bends is closed.
        scene.reshape(index, &mesh).unwrap();
        tree.world(&scene);
        assert_eq!(parts(&tree, 0), 1);
    }
}
