//! How trees with eight children a node are made of trees with two.
//!
//! Of all such trees whose nodes are nodes of the old one that with the least cost is chosen (after Ylitie, Karras and
//! Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.1): a ray
//! visits a box about as often as its surface is large.

use super::wide::{Child, WIDTH, WideNode, WideTree};
use crate::layout::Node;
use crate::scene::Bounds;
use alloc::vec;
use alloc::vec::Vec;

/// What eight things of a leaf cost, in visits of a node.
const LEAF: f32 = 1.5;

/// What a tree of two becomes.
struct Widening<'a> {
    nodes: &'a [Node],
    /// The most things of a leaf.
    leaf: u32,
    held: Vec<Held>,
    /// What the things below each node cost as a child of a wide node, as up to two children, and so on.
    costs: Vec<[f32; WIDTH - 1]>,
}

/// The things below a node.
#[derive(Clone, Copy)]
struct Held {
    first: u32,
    count: u32,
    /// Whether their numbers follow one another.
    is_range: bool,
}

/// What each node holds.
fn held(nodes: &[Node]) -> Vec<Held> {
    let mut held = vec![Held { first: 0, count: 0, is_range: true }; nodes.len()];
    for (index, node) in nodes.iter().enumerate().rev() {
        held[index] = if node.is_leaf() {
            Held { first: node.first, count: node.triangles(), is_range: true }
        } else {
            let (a, b) = (held[node.first as usize], held[node.first as usize + 1]);
            let (a, b) = if a.first < b.first { (a, b) } else { (b, a) };
            let is_range = a.is_range && b.is_range && a.first + a.count == b.first;
            Held { first: a.first, count: a.count + b.count, is_range }
        };
    }
    held
}

/// The cheapest tree whose leaves hold up to `leaf` things, or as many as a leaf of two.
pub(crate) fn widened(nodes: &[Node], leaf: u32) -> WideTree {
    let mut widening =
        Widening { nodes, leaf, held: held(nodes), costs: vec![[0.0; WIDTH - 1]; nodes.len()] };
    for index in (0..nodes.len()).rev() {
        widening.costs[index] = widening.cost(index);
    }
    widening.tree()
}

impl Widening<'_> {
    fn area(&self, index: usize) -> f32 {
        Bounds::around(&self.nodes[index]).area()
    }

    /// The cost of a node as a leaf; infinite if it cannot be one.
    fn leaf_cost(&self, index: usize) -> f32 {
        let Held { count, is_range, .. } = self.held[index];
        if self.nodes[index].is_leaf() || (is_range && count <= self.leaf) {
            return self.area(index) * LEAF * count.div_ceil(WIDTH as u32) as f32;
        }
        f32::INFINITY
    }

    /// Whether a node becomes a leaf, if it is a child of a wide one.
    fn is_leaf(&self, index: usize) -> bool {
        self.leaf_cost(index) <= self.costs[index][0]
    }

    /// The cost of the two children of a node as `count` children of a wide one, of which so many are the first one's.
    fn split_cost(&self, index: usize, count: usize, of_first: usize) -> f32 {
        let first = self.nodes[index].first as usize;
        self.costs[first][of_first - 1] + self.costs[first + 1][count - of_first - 1]
    }

    /// The least such cost.
    fn split(&self, index: usize, count: usize) -> f32 {
        (1..count).fold(f32::INFINITY, |least, of_first| least.min(self.split_cost(index, count, of_first)))
    }

    fn cost(&self, index: usize) -> [f32; WIDTH - 1] {
        let as_leaf = self.leaf_cost(index);
        let mut costs = [as_leaf; WIDTH - 1];
        if !self.nodes[index].is_leaf() {
            costs[0] = as_leaf.min(self.area(index) + self.split(index, WIDTH));
            for count in 2..WIDTH {
                costs[count - 1] = costs[count - 2].min(self.split(index, count));
            }
        }
        costs
    }

    /// Finds the nodes of two that become the children of a wide one, of which there are at most `count`, below a node
    /// of two.
    fn children(&self, index: usize, count: usize, children: &mut Vec<usize>) {
        let least = self.costs[index][count - 1];
        let is_split = !self.nodes[index].is_leaf() && self.leaf_cost(index) > least;
        // As many as help, and no fewer if that costs the same.
        match (2..=count).rev().find(|&count| is_split && self.split(index, count) <= least) {
            Some(count) => self.split_children(index, count, children),
            None => children.push(index),
        }
    }

    fn split_children(&self, index: usize, count: usize, children: &mut Vec<usize>) {
        let first = self.nodes[index].first as usize;
        // Of the same costs, as of boxes in one place, the most even split counts.
        let uneven = |of_first: &usize| count.abs_diff(2 * of_first);
        let cost = |of_first: &usize| self.split_cost(index, count, *of_first);
        let splits = (1..count).min_by(|a, b| cost(a).total_cmp(&cost(b)).then(uneven(a).cmp(&uneven(b))));
        let of_first = splits.unwrap_or(1);
        self.children(first, of_first, children);
        self.children(first + 1, count - of_first, children);
    }

    fn tree(&self) -> WideTree {
        let WideTree { nodes: mut wide, mut depth } = WideTree::default();
        // A node of two, the wide one that it becomes, and that one's level.
        let mut todo = vec![(0, 0, 1)];
        let mut children = Vec::with_capacity(WIDTH);
        while let Some((narrow, index, level)) = todo.pop() {
            depth = depth.max(level);
            children.clear();
            if self.is_leaf(narrow) {
                // The root.
                children.push(narrow);
            } else {
                self.split_children(narrow, WIDTH, &mut children);
            }
            let start = todo.len();
            for (slot, &child) in children.iter().enumerate() {
                let Held { first, count, .. } = self.held[child];
                let what = if self.is_leaf(child) {
                    Child::Leaf(first, count)
                } else {
                    wide.push(WideNode::EMPTY);
                    todo.push((child, wide.len() - 1, level + 1));
                    Child::Node(wide.len() as u32 - 1)
                };
                if count > 0 {
                    wide[index].set_child(slot, &what, &Bounds::around(&self.nodes[child]));
                }
            }
            // The first child's subtree follows first.
            todo[start..].reverse();
        }
        WideTree { nodes: wide, depth }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::fixture::Random;
    use crate::scene::{Bvh, Sequential};

    fn boxes(random: &mut Random, count: usize) -> Vec<Bounds> {
        let mut one = || {
            let (low, size) = (random.vector(9.0), random.vector(0.5).abs());
            Bounds { low: low.into(), high: (low + size).into() }
        };
        (0..count).map(|_| one()).collect()
    }

    /// The things in leaves below a wide node, and what they and the nodes cost.
    fn walk(wide: &WideTree, index: usize, most: u32, things: &mut Vec<u32>) -> f32 {
        let node = &wide.nodes[index];
        let mut cost = 0.0;
        for slot in 0..WIDTH {
            let area = node.bounds(slot).area();
            cost += match node.child(slot) {
                Child::Leaf(_, 0) => 0.0,
                Child::Leaf(first, count) => {
                    assert!(count <= most);
                    things.extend(first..first + count);
                    area * LEAF
                }
                Child::Node(child) => {
                    assert!(child as usize > index);
                    area + walk(wide, child as usize, most, things)
                }
            };
        }
        cost
    }

    #[test]
    fn the_tree_has_the_least_cost_and_each_thing_once() {
        let mut random = Random(5);
        for count in [1, 2, 7, 8, 9, 40, 700] {
            for most in [1, 8] {
                let Bvh { nodes, .. } = Bvh::over(&boxes(&mut random, count), 1, &Sequential);
                let wide = widened(&nodes, most);
                let mut things = vec![];
                let cost = walk(&wide, 0, most, &mut things);
                things.sort_unstable();
                assert!(things.into_iter().eq(0..count as u32));
                let costs = vec![[0.0; WIDTH - 1]; nodes.len()];
                let mut least = Widening { nodes: &nodes, leaf: most, held: held(&nodes), costs };
                for index in (0..nodes.len()).rev() {
                    least.costs[index] = least.cost(index);
                }
                let is_leaf = least.leaf_cost(0) <= least.costs[0][0];
                let root = if is_leaf { 0.0 } else { least.area(0) };
                let expected = least.costs[0][0] - root;
                assert!((cost - expected).abs() <= 1e-4 * expected, "{count} {most}: {cost} {expected}");
            }
        }
    }

    #[test]
    fn boxes_in_one_place_make_a_shallow_tree() {
        let point = Bounds { low: [0.0; 3], high: [0.0; 3] };
        let Bvh { nodes, .. } = Bvh::over(&[point; 1000], 1, &Sequential);
        let wide = widened(&nodes, 1);
        assert!(wide.depth <= 5 && wide.nodes.len() <= 600, "{} {}", wide.depth, wide.nodes.len());
    }

    #[test]
    fn nothing_is_one_node_without_children() {
        let Bvh { nodes, .. } = Bvh::over(&[], 1, &Sequential);
        let wide = widened(&nodes, 1);
        assert!(wide.nodes.len() == 1 && wide.nodes[0].is_empty() && wide.depth == 1);
    }
}
