//! The tree over the instances.

use super::merged::Merged;
use super::source::Parts;
use super::tree::MeshTree;
use super::wear::Wear;
use super::wide::{Child, WIDTH, WideNode, WideTree};
use super::widen::widened;
use crate::layout::{Instance, NONE};
use crate::scene::{Bounds, Bvh, Join};
use alloc::vec;
use alloc::vec::Vec;
use glam::Vec4;

/// A tree over fewer instances is built again for each that is new.
const FEW: usize = 64;

/// The tree over the instances. Its leaves hold one each; those of instances that are hidden or merged hold nothing.
#[derive(Debug)]
pub(crate) struct InstanceTree {
    pub tree: WideTree,
    /// The largest slack in each child.
    pub slacks: Vec<[f32; WIDTH]>,
    /// Where each node is: in this child. The root is nowhere.
    parents: Vec<u32>,
    /// Where each instance is.
    places: Vec<u32>,
    /// The instances that stand in one space.
    pub merged: Merged,
    /// What a search needs of each instance, in one cache line.
    pub entries: Vec<Entry>,
    /// So many moves of the source are in it.
    moves: u64,
    /// So many instances it had when it was built.
    built: usize,
    wear: Wear,
}

/// Where a search of the tree starts.
pub(crate) enum Start {
    /// At the root.
    Root,
    /// At the only instance, with this number.
    Leaf(u32),
    /// Nowhere: all instances are hidden or merged.
    Nowhere,
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
    /// Whether it is met in the merged tree.
    pub is_merged: bool,
}
const _: () = assert!(size_of::<Entry>() == 64);

impl Entry {
    fn new(source: &impl Parts, number: usize, is_merged: bool) -> Self {
        let instance = &source.instances()[number];
        Self {
            to_object: instance.to_object,
            mask: source.tags()[number].mask,
            mesh: source.mesh_of(number) as u32,
            is_identity: instance.is_identity == 1,
            is_sphere: instance.is_sphere(),
            is_merged,
        }
    }
}

impl Default for InstanceTree {
    fn default() -> Self {
        Self {
            tree: WideTree::default(),
            slacks: vec![[0.0; WIDTH]],
            parents: vec![NONE],
            places: vec![],
            merged: Merged::default(),
            entries: vec![],
            moves: 0,
            built: 0,
            wear: Wear::default(),
        }
    }
}

impl InstanceTree {
    /// Where a search starts.
    #[inline(always)]
    pub fn start(&self) -> Start {
        let root = &self.tree.nodes[0];
        match root.child(0) {
            _ if root.is_empty() => Start::Nowhere,
            Child::Leaf(number, _) if self.entries.len() == 1 => Start::Leaf(number),
            _ => Start::Root,
        }
    }

    /// Its bytes.
    pub fn bytes(&self) -> usize {
        let Self { tree, slacks, parents, places, merged, entries, .. } = self;
        let lists = size_of_val(&slacks[..])
            + size_of_val(&parents[..])
            + size_of_val(&places[..])
            + size_of_val(&entries[..]);
        size_of_val(&tree.nodes[..]) + lists + merged.bytes()
    }

    /// Takes over what has changed in the source; workers of `join` build what must be built.
    pub fn update(&mut self, source: &impl Parts, meshes: &[MeshTree], join: &impl Join) {
        let (moves, count) = (source.places().moves(), source.instances().len());
        let is_new = count != self.entries.len();
        if is_new && !self.grow(source, meshes) {
            self.build(source, meshes, join);
        } else if is_new || moves != self.moves {
            let moved = source.places().moved_since(self.moves);
            let follows = match moved {
                Some(moved) => self.merged.follow(source, moved.iter().map(|&instance| instance as usize)),
                None => self.merged.follow(source, 0..self.entries.len()),
            };
            match moved {
                Some(moved) if !follows => {
                    moved.iter().for_each(|&instance| self.refit(source, meshes, instance as usize));
                }
                _ => self.refit_all(source, meshes),
            }
            if self.merged.is_hollow() || self.wear.is_worn(&self.tree.nodes[0].all_bounds()) {
                self.build(source, meshes, join);
            }
        }
        self.moves = moves;
    }

    /// Takes up the instances that are new. Returns whether that was possible: they are at most half as many as the tree
    /// was built over, which were not few, and do not make it too deep.
    fn grow(&mut self, source: &impl Parts, meshes: &[MeshTree]) -> bool {
        let new = self.entries.len()..source.instances().len();
        let is_possible = self.built >= FEW && 2 * new.end <= 3 * self.built;
        is_possible && new.into_iter().all(|instance| self.insert(source, meshes, instance))
    }

    /// Puts an instance that is new where boxes grow least.
    fn insert(&mut self, source: &impl Parts, meshes: &[MeshTree], instance: usize) -> bool {
        let &Instance { low, high, .. } = &source.instances()[instance];
        let bounds = Bounds { low, high };
        let (mut index, mut level) = (0, 1);
        let place = loop {
            if let Some(slot) = (0..WIDTH).find(|&slot| self.is_free(index, slot)) {
                break index * WIDTH + slot;
            }
            let node = &self.tree.nodes[index];
            let growth = |slot: usize| {
                let old = node.bounds(slot);
                old.union(&bounds).area() - old.area()
            };
            let slot = (1..WIDTH).fold(0, |best, slot| if growth(slot) < growth(best) { slot } else { best });
            index = match node.child(slot) {
                Child::Node(below) => below as usize,
                Child::Leaf(other, _) => {
                    let Some(below) = self.tree.lower(index, slot, level) else { return false };
                    self.wear.area += f64::from(self.tree.nodes[below].bounds(0).area());
                    self.slacks.push([0.0; WIDTH]);
                    self.slacks[below][0] = self.slacks[index][slot];
                    self.parents.push((index * WIDTH + slot) as u32);
                    self.places[other as usize] = (below * WIDTH) as u32;
                    below
                }
            };
            level += 1;
        };
        let (index, slot) = (place / WIDTH, place % WIDTH);
        self.tree.nodes[index].set_first(slot, instance as u32);
        self.places.push(place as u32);
        self.entries.push(Entry::new(source, instance, false));
        self.refit(source, meshes, instance);
        true
    }

    /// Whether nothing has this place.
    fn is_free(&self, index: usize, slot: usize) -> bool {
        let Child::Leaf(first, _) = self.tree.nodes[index].child(slot) else { return false };
        self.places.get(first as usize) != Some(&((index * WIDTH + slot) as u32))
    }

    /// Builds the tree of all instances.
    fn build(&mut self, source: &impl Parts, meshes: &[MeshTree], join: &impl Join) {
        self.merged.renew(source, meshes, join);
        let instances = source.instances();
        let boxes: Vec<_> = instances.iter().map(|i| Bounds { low: i.low, high: i.high }).collect();
        let narrow = Bvh::over(&boxes, 1, join);
        self.tree = widened(&narrow.nodes, 1);
        let count = self.tree.nodes.len();
        self.slacks = vec![[0.0; WIDTH]; count];
        self.parents = vec![NONE; count];
        self.places = vec![NONE; boxes.len()];
        self.entries = (0..boxes.len()).map(|instance| Entry::new(source, instance, false)).collect();
        for index in 0..count {
            for slot in 0..WIDTH {
                let place = (index * WIDTH + slot) as u32;
                match self.tree.nodes[index].child(slot) {
                    Child::Node(node) => self.parents[node as usize] = place,
                    Child::Leaf(_, 0) => {}
                    Child::Leaf(first, _) => {
                        let instance = narrow.triangles[first as usize];
                        self.tree.nodes[index].set_first(slot, instance);
                        self.places[instance as usize] = place;
                    }
                }
            }
        }
        // Its cost is that of all instances: merged ones may come out.
        self.wear.area = self.tree.nodes.iter().map(WideNode::area).sum();
        self.wear.set_built(&self.tree.nodes[0].all_bounds());
        self.built = boxes.len();
        self.refit_all(source, meshes);
    }

    /// Takes over where all instances are.
    fn refit_all(&mut self, source: &impl Parts, meshes: &[MeshTree]) {
        for instance in 0..self.entries.len() {
            let bounds = self.enter(source, meshes, instance);
            let (node, slot) = split(self.places[instance]);
            self.tree.nodes[node].set_leaf(slot, &bounds);
            self.slacks[node][slot] = source.instances()[instance].slack;
        }
        self.wear.area = 0.0;
        for index in (0..self.tree.nodes.len()).rev() {
            let node = &self.tree.nodes[index];
            self.wear.area += node.area();
            if self.parents[index] != NONE {
                let (bounds, slack) = (node.all_bounds(), largest(&self.slacks[index]));
                let (above, slot) = split(self.parents[index]);
                self.tree.nodes[above].set_bounds(slot, &bounds);
                self.slacks[above][slot] = slack;
            }
        }
    }

    /// Makes the entry of an instance; returns its box in the tree.
    fn enter(&mut self, source: &impl Parts, meshes: &[MeshTree], instance: usize) -> Bounds {
        let is_merged = self.merged.holds(source, meshes, instance);
        if is_merged != self.entries[instance].is_merged {
            self.merged.count(instance, is_merged);
        }
        self.entries[instance] = Entry::new(source, instance, is_merged);
        if is_merged { Bounds::EMPTY } else { *source.places().bounds(instance) }
    }

    /// Takes over where one instance is.
    fn refit(&mut self, source: &impl Parts, meshes: &[MeshTree], instance: usize) {
        let mut bounds = self.enter(source, meshes, instance);
        let mut slack = source.instances()[instance].slack;
        let mut place = self.places[instance];
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

/// The node and the slot of a place.
fn split(place: u32) -> (usize, usize) {
    (place as usize / WIDTH, place as usize % WIDTH)
}

/// The largest of some slacks.
fn largest(slacks: &[f32; WIDTH]) -> f32 {
    Vec4::from_slice(slacks).max(Vec4::from_slice(&slacks[4..])).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::fixture::{Random, add};
    use crate::query::{Hit, Ray, Tree};
    use crate::scene::{InstanceIndex, Material, Scene, Sequential};
    use glam::{Mat4, Vec3};

    /// Asserts that rays to these instances find the same as in trees that were built at once.
    fn assert_same(scene: &Scene, tree: &mut Tree, random: &mut Random, seen: &[InstanceIndex]) {
        let mut whole = Tree::new(scene, &Sequential);
        let (world, whole) = (tree.world(scene), whole.world(scene));
        let mut hits = 0;
        for instance in seen {
            let at = Vec3::from(scene.instances()[instance.number as usize].center);
            let start = random.vector(40.0);
            let ray = Ray::new(start, at + random.vector(0.5) - start);
            let (hit, expected) = (world.closest(&ray).unwrap(), whole.closest(&ray).unwrap());
            let found = |hit: Hit| (hit.instance, hit.triangle, hit.t.to_bits());
            assert_eq!(hit.map(found), expected.map(found));
            assert_eq!(world.nearest(start, 30.0), whole.nearest(start, 30.0));
            hits += usize::from(hit.is_some());
        }
        assert!(3 * hits > seen.len(), "{hits} of {}", seen.len());
    }

    #[test]
    fn new_instances_join_the_tree_that_is_there() {
        let mut random = Random(7);
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let mesh = add(&mut scene, &random.mesh(60, 1.0));
        let mut place = {
            let mut random = Random(8);
            move || random.place(20.0)
        };
        let mut instances: Vec<_> =
            (0..80).map(|_| scene.add_instance(mesh, white, place()).unwrap()).collect();
        let mut tree = Tree::new(&scene, &Sequential);
        for number in 0..30 {
            let new = match number % 4 {
                0 => scene.add_sphere(white, place()).unwrap(),
                _ => scene.add_instance(mesh, white, place()).unwrap(),
            };
            instances.push(new);
            match number % 5 {
                0 => scene.hide(new).unwrap(),
                1 => scene.set_transform(new, place()).unwrap(),
                2 => scene.set_transform(instances[number], place()).unwrap(),
                _ => {}
            }
            assert_same(&scene, &mut tree, &mut random, &instances);
            assert_eq!(tree.instances.built, 80);
        }
        scene.set_transform(instances[100], place()).unwrap();
        (0..11).for_each(|_| instances.push(scene.add_instance(mesh, white, place()).unwrap()));
        assert_same(&scene, &mut tree, &mut random, &instances);
        assert_eq!(tree.instances.built, 121);
    }

    #[test]
    fn instances_in_one_place_make_no_tree_too_deep() {
        let mut random = Random(9);
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let mut instances: Vec<_> =
            (0..1200).map(|_| scene.add_sphere(white, random.place(20.0)).unwrap()).collect();
        let mut tree = Tree::new(&scene, &Sequential);
        for _ in 0..600 {
            instances.push(scene.add_sphere(white, Mat4::IDENTITY).unwrap());
            tree.update(&scene, &Sequential);
        }
        assert!(tree.instances.built > 1200, "{}", tree.instances.built);
        assert_same(&scene, &mut tree, &mut random, &instances);
    }
}
