//! A tree over the instances with two children a node, as devices read it.

use super::source::Parts;
use super::wear::Wear;
use super::wide::NOWHERE;
use crate::layout::Node;
use crate::scene::{Bounds, Bvh, Join, Scene};
use alloc::vec;
use alloc::vec::Vec;

/// The tree. Each of its leaves holds the number of one instance; without instances it is one empty leaf. Memory: about
/// 80 bytes an instance.
#[derive(Debug, Clone, Default)]
pub(crate) struct NarrowTree {
    /// The root first, and nodes before their children. What is hidden is nowhere.
    pub nodes: Vec<Node>,
    /// The largest slack below each node.
    slacks: Vec<f32>,
    /// The node above each pair of neighbors.
    parents: Vec<u32>,
    /// The leaf of each instance.
    leaves: Vec<u32>,
    wear: Wear,
}

impl NarrowTree {
    /// Builds the tree.
    pub fn new(scene: &Scene, join: &impl Join) -> Self {
        let instances = scene.instances();
        let boxes: Vec<_> = instances.iter().map(|i| Bounds { low: i.low, high: i.high }).collect();
        let Bvh { mut nodes, triangles: order } = Bvh::over(&boxes, 1, join);
        let (mut parents, mut leaves) = (vec![0; nodes.len() / 2], vec![0; instances.len()]);
        for (index, node) in nodes.iter_mut().enumerate() {
            if !node.is_leaf() {
                parents[pair(node.first as usize)] = index as u32;
            } else if node.triangles() == 1 {
                node.first = order[node.first as usize];
                leaves[node.first as usize] = index as u32;
            }
        }
        let slacks = vec![0.0; nodes.len()];
        let mut tree = Self { nodes, slacks, parents, leaves, wear: Wear::default() };
        tree.refit_all(scene);
        tree.wear.set_built(&tree.bounds(0));
        tree
    }

    /// Whether it is to be built again.
    pub fn is_worn(&self) -> bool {
        self.wear.is_worn(&self.bounds(0))
    }

    /// The largest slack of all instances.
    pub fn slack(&self) -> f32 {
        self.slacks[0]
    }

    /// Takes over where all instances are.
    pub fn refit_all(&mut self, scene: &Scene) {
        for (instance, placed) in scene.instances().iter().enumerate() {
            let leaf = self.leaves[instance] as usize;
            self.set(leaf, Parts::places(scene).bounds(instance), placed.slack);
        }
        self.wear.area = 0.0;
        for index in (0..self.nodes.len()).rev() {
            if !self.nodes[index].is_leaf() {
                let (bounds, slack) = self.below(index);
                self.set(index, &bounds, slack);
            }
            self.wear.area += f64::from(self.bounds(index).area());
        }
    }

    /// Takes over where one instance is; the numbers of nodes that differ now go to `changed`.
    pub fn refit(&mut self, scene: &Scene, instance: usize, changed: &mut Vec<u32>) {
        let mut index = self.leaves[instance] as usize;
        let (mut bounds, mut slack) =
            (*Parts::places(scene).bounds(instance), scene.instances()[instance].slack);
        loop {
            let old = self.bounds(index);
            if (old.low, old.high, self.slacks[index]) == (bounds.low, bounds.high, slack) {
                return;
            }
            self.set(index, &bounds, slack);
            self.wear.replace(&old, &bounds);
            changed.push(index as u32);
            if index == 0 {
                return;
            }
            index = self.parents[pair(index)] as usize;
            (bounds, slack) = self.below(index);
        }
    }

    /// The box around the children of a node, and the largest slack there.
    fn below(&self, index: usize) -> (Bounds, f32) {
        let first = self.nodes[index].first as usize;
        let bounds = self.bounds(first).union(&self.bounds(first + 1));
        (bounds, self.slacks[first].max(self.slacks[first + 1]))
    }

    /// The box of a node; empty if all below it is hidden.
    fn bounds(&self, index: usize) -> Bounds {
        let bounds = Bounds::around(&self.nodes[index]);
        if bounds.low[0] == NOWHERE { Bounds::EMPTY } else { bounds }
    }

    fn set(&mut self, index: usize, bounds: &Bounds, slack: f32) {
        let corners = if bounds.is_empty() { [[NOWHERE; 3]; 2] } else { [bounds.low, bounds.high] };
        [self.nodes[index].low, self.nodes[index].high] = corners;
        self.slacks[index] = slack;
    }
}

/// The number of the pair that a node other than the root belongs to.
fn pair(index: usize) -> usize {
    (index - 1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::fixture::Random;
    use crate::scene::{InstanceIndex, Material, Sequential};
    use glam::{Mat4, Vec3};

    fn balls(random: &mut Random, count: usize) -> (Scene, Vec<InstanceIndex>) {
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let balls = (0..count).map(|_| scene.add_sphere(white, random.place(20.0)).unwrap()).collect();
        (scene, balls)
    }

    /// Each box and slack is that of what is below; each instance is in one leaf.
    fn check(tree: &NarrowTree, scene: &Scene) {
        let mut held = vec![0; scene.instances().len()];
        for (index, node) in tree.nodes.iter().enumerate() {
            let (bounds, slack) = if node.is_leaf() {
                let instance = node.first as usize;
                held[instance] += 1;
                (*Parts::places(scene).bounds(instance), scene.instances()[instance].slack)
            } else {
                tree.below(index)
            };
            let own = tree.bounds(index);
            assert_eq!((own.low, own.high, tree.slacks[index]), (bounds.low, bounds.high, slack), "{index}");
        }
        assert!(held.iter().all(|&times| times == 1));
        let area: f64 = (0..tree.nodes.len()).map(|index| f64::from(tree.bounds(index).area())).sum();
        assert!((tree.wear.area - area).abs() <= 1e-9 * area.max(1.0), "{} {area}", tree.wear.area);
    }

    #[test]
    fn every_box_is_that_of_what_is_below_it_whatever_moved() {
        let mut random = Random(1);
        for count in [1, 2, 3, 50, 300] {
            let (mut scene, balls) = balls(&mut random, count);
            let mut tree = NarrowTree::new(&scene, &Sequential);
            check(&tree, &scene);
            for step in 0..200 {
                let ball = balls[random.below(count)];
                if random.below(4) == 0 {
                    scene.hide(ball).unwrap();
                } else {
                    scene.set_transform(ball, random.place(20.0)).unwrap();
                }
                let (before, mut changed) = (tree.nodes.clone(), vec![]);
                if step % 20 == 19 {
                    tree.refit_all(&scene);
                } else {
                    tree.refit(&scene, ball.number() as usize, &mut changed);
                    for (index, (old, new)) in before.iter().zip(&tree.nodes).enumerate() {
                        assert!(old == new || changed.contains(&(index as u32)), "{index}");
                    }
                }
                check(&tree, &scene);
            }
        }
    }

    #[test]
    fn a_path_that_stays_as_it_is_ends_where_it_does() {
        let (mut scene, balls) = balls(&mut Random(2), 1000);
        let mut tree = NarrowTree::new(&scene, &Sequential);
        let place = |scale: f32| Mat4::from_scale(Vec3::splat(scale));
        // In the middle of all, and a little less of it: the whole stays.
        scene.set_transform(balls[7], place(0.5)).unwrap();
        tree.refit(&scene, 7, &mut vec![]);
        scene.set_transform(balls[7], place(0.4)).unwrap();
        let mut changed = vec![];
        tree.refit(&scene, 7, &mut changed);
        assert!(!changed.is_empty() && !changed.contains(&0), "{changed:?}");
        changed.clear();
        tree.refit(&scene, 7, &mut changed);
        assert_eq!(changed, []);
    }

    #[test]
    fn it_is_worn_once_everything_is_somewhere_else() {
        let mut random = Random(3);
        let (mut scene, balls) = balls(&mut random, 300);
        let mut tree = NarrowTree::new(&scene, &Sequential);
        assert!(!tree.is_worn());
        for &ball in &balls {
            scene.set_transform(ball, random.place(20.0)).unwrap();
        }
        tree.refit_all(&scene);
        assert!(tree.is_worn());
        assert!(!NarrowTree::new(&scene, &Sequential).is_worn());
    }
}
