//! Trees of nodes with eight children, which a ray asks all at once.
//!
//! They are made of trees with two children by opening the largest nodes. A child's interval is computed
//! as [`slab`](crate::kernel::slab::slab) does, so nothing that a tree of any shape finds is lost.

use super::rows::{cross, enter, load};
use crate::kernel::ray::Ray;
use crate::kernel::traverse::STACK;
use crate::lane::{Lane, Mask, Row};
use crate::layout::Node;
use crate::scene::Bounds;
use alloc::vec;
use alloc::vec::Vec;

/// Children of a node.
pub(crate) const WIDTH: usize = 8;
/// The bits of a slot.
const SLOT: u32 = WIDTH as u32 - 1;
/// The levels that most trees have at most.
pub(crate) const SHALLOW: usize = 12;
/// The count of a child that is a node.
const INNER: u32 = u32::MAX;
/// Where children are that are not there: no ray comes so far.
pub(crate) const NOWHERE: f32 = f32::MAX;

/// A node: the boxes of its children, and what they are.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy)]
pub(crate) struct WideNode {
    /// Lower planes along x, y, z; then the upper ones.
    pub planes: [[f32; WIDTH]; 6],
    /// A node, or the first of the things that a leaf holds.
    first: [u32; WIDTH],
    /// How many a leaf holds; [`INNER`] for a node.
    count: [u32; WIDTH],
}
const _: () = assert!(size_of::<WideNode>() == 256);

/// What a child is.
pub(crate) enum Child {
    /// Another node.
    Node(u32),
    /// The first of a leaf's things, and how many there are.
    Leaf(u32, u32),
}

impl WideNode {
    /// Without children.
    pub const EMPTY: Self = Self { planes: [[NOWHERE; WIDTH]; 6], first: [0; WIDTH], count: [0; WIDTH] };

    /// What a child is; a leaf of nothing if there is none.
    #[inline(always)]
    pub fn child(&self, slot: usize) -> Child {
        match self.count[slot] {
            INNER => Child::Node(self.first[slot]),
            count => Child::Leaf(self.first[slot], count),
        }
    }

    /// Makes a leaf hold its thing, in this box; or nothing, if the box is empty.
    pub fn set_leaf(&mut self, slot: usize, bounds: &Bounds) {
        self.set_count(slot, bounds);
        self.set_bounds(slot, bounds);
    }

    /// Makes a leaf hold its thing, or nothing if the box is empty.
    pub fn set_count(&mut self, slot: usize, bounds: &Bounds) {
        self.count[slot] = u32::from(!bounds.is_empty());
    }

    /// Changes the first of the things that a leaf holds.
    pub fn set_first(&mut self, slot: usize, first: u32) {
        self.first[slot] = first;
    }

    /// The lower and upper planes along an axis of the children from `first` on, `pad` farther apart on both sides.
    #[inline(always)]
    pub fn slab<L: Lane>(&self, token: L::Token, pad: Option<L>, first: usize, axis: usize) -> [L; 2] {
        let low = load::<L>(token, &self.planes[axis], first);
        let high = load::<L>(token, &self.planes[3 + axis], first);
        match pad {
            Some(pad) => [low - pad, high + pad],
            None => [low, high],
        }
    }

    /// The box of a child; empty if nothing is in it.
    pub fn bounds(&self, slot: usize) -> Bounds {
        let at = |plane: usize| self.planes[plane][slot];
        if at(0) == NOWHERE {
            return Bounds::EMPTY;
        }
        Bounds { low: [at(0), at(1), at(2)], high: [at(3), at(4), at(5)] }
    }

    /// Changes the box of a child.
    pub fn set_bounds(&mut self, slot: usize, bounds: &Bounds) {
        for axis in 0..3 {
            let is_empty = bounds.is_empty();
            self.planes[axis][slot] = if is_empty { NOWHERE } else { bounds.low[axis] };
            self.planes[3 + axis][slot] = if is_empty { NOWHERE } else { bounds.high[axis] };
        }
    }

    /// Half of the surfaces of the boxes of all children, summed.
    pub fn area(&self) -> f64 {
        (0..WIDTH).map(|slot| f64::from(self.bounds(slot).area())).sum()
    }

    /// The box of all children.
    pub fn all_bounds(&self) -> Bounds {
        (0..WIDTH).fold(Bounds::EMPTY, |all, slot| all.union(&self.bounds(slot)))
    }
}

/// The range of `t` that is left of a ray's, in lanes of eight.
#[derive(Clone, Copy)]
pub(crate) struct Range {
    pub from: f32,
    pub limit: f32,
}

/// A ray, ready to ask the eight children of a node, as many at a time as there are lanes.
pub(crate) struct Asked<L> {
    /// The origin, moved by as much as boxes are wider: what lower planes are measured from, and upper ones.
    origins: [[L; 3]; 2],
    inverse: [L; 3],
    /// How much wider boxes are than in the nodes, per unit of their slack.
    magnitude: L,
}

/// The children that a ray may hit, and where it enters each.
struct Entered {
    mask: u32,
    near: [f32; WIDTH],
}

impl<L: Lane> Asked<L> {
    /// `magnitude` widens the boxes by that much of their slack; 0 for nodes that have none. `passing` widens
    /// all.
    #[inline(always)]
    pub fn new(token: L::Token, ray: &Ray<f32>, magnitude: f32, passing: f32) -> Self {
        let each = |v: [f32; 3]| v.map(|c| L::splat(token, c));
        let (origin, inverse) = (ray.origin.lane(0), ray.inverse.lane(0));
        Self {
            origins: [each(origin.map(|c| c + passing)), each(origin.map(|c| c - passing))],
            inverse: each(inverse),
            magnitude: L::splat(token, magnitude),
        }
    }

    /// The children that the ray may hit within its range.
    #[inline(always)]
    fn enter(&self, node: &WideNode, slack: Option<&[f32; WIDTH]>, range: Range) -> Entered {
        let like = self.magnitude;
        let token = like.token();
        let (from, limit) = (like.broadcast(range.from), like.broadcast(range.limit));
        let mut entered = Entered { mask: 0, near: [0.0; WIDTH] };
        let mut first = 0;
        while first < WIDTH {
            let pad = slack.map(
                #[inline(always)]
                |slack| load::<L>(token, slack, first) * self.magnitude,
            );
            let slabs = [
                self.cross(node, pad, first, 0),
                self.cross(node, pad, first, 1),
                self.cross(node, pad, first, 2),
            ];
            let (near, is_entered) = enter(slabs, from, limit);
            entered.mask |= is_entered.bits() << first;
            let row = near.row();
            let mut lane = 0;
            while lane < L::WIDTH {
                entered.near[first + lane] = row.at(lane);
                lane += 1;
            }
            first += L::WIDTH;
        }
        entered
    }

    /// Where the ray enters and leaves the slabs of the children from `first` on along an axis.
    #[inline(always)]
    fn cross(&self, node: &WideNode, pad: Option<L>, first: usize, axis: usize) -> (L, L) {
        let planes = node.slab(self.magnitude.token(), pad, first, axis);
        cross(planes, [self.origins[0][axis], self.origins[1][axis]], self.inverse[axis])
    }
}

/// The children of a node that wait, farthest first. A key is where the ray enters, its last three bits
/// replaced by the slot.
#[derive(Clone, Copy)]
struct Waiting {
    node: u32,
    count: u32,
    keys: [u32; WIDTH],
}

/// Something that looks at the leaves which a ray comes through.
pub(crate) trait Visitor {
    /// Looks at a leaf; returns how far the ray is still traced. Below 0, the search ends.
    fn leaf(&mut self, first: u32, count: u32) -> f32;
}

/// Shows a visitor the leaves below a node that a ray may hit within its range, roughly from near to far. `slacks` are
/// those of the nodes' children, if they have any.
#[inline(always)]
pub(crate) fn traverse<L: Lane>(
    tree: &WideTree,
    mut index: u32,
    slacks: Option<&[[f32; WIDTH]]>,
    asked: &Asked<L>,
    mut range: Range,
    visitor: &mut impl Visitor,
) {
    const NO_NODE: Waiting = Waiting { node: 0, count: 0, keys: [0; WIDTH] };
    let nodes = &tree.nodes;
    // A stack is cleared for each search: most trees need a short one.
    let (mut short, mut long);
    let stack: &mut [Waiting] = if tree.depth <= SHALLOW {
        short = [NO_NODE; SHALLOW];
        &mut short
    } else {
        long = [NO_NODE; STACK];
        &mut long
    };
    let mut depth = 0;
    loop {
        let node = &nodes[index as usize];
        let entered = asked.enter(node, slacks.map(|slacks| &slacks[index as usize]), range);
        let (mut parent, mut slot) = (node, 0);
        let mut is_entered = entered.mask != 0;
        if is_entered {
            let waiting = &mut stack[depth];
            waiting.node = index;
            slot = nearest(&entered, waiting);
            depth += usize::from(waiting.count > 0);
        }
        // The next node: leaves on the way are looked at.
        index = loop {
            if is_entered {
                match parent.child(slot) {
                    Child::Node(child) => break child,
                    Child::Leaf(first, count) => {
                        range.limit = visitor.leaf(first, count);
                        if range.limit < range.from {
                            return;
                        }
                    }
                }
            }
            if depth == 0 {
                return;
            }
            let top = &mut stack[depth - 1];
            top.count -= 1;
            let key = top.keys[top.count as usize & (WIDTH - 1)];
            // If it is too far by now, so are the others.
            is_entered = key & !SLOT <= range.limit.to_bits();
            (parent, slot) = (&nodes[top.node as usize], (key & SLOT) as usize);
            depth -= usize::from(top.count == 0 || !is_entered);
        };
    }
}

/// The nearest of the children that are entered, of which there must be one; the others wait, in order.
#[inline(always)]
fn nearest(entered: &Entered, waiting: &mut Waiting) -> usize {
    // Numbers that are not negative are ordered as their bits.
    let key = |slot: u32| entered.near[slot as usize & (WIDTH - 1)].to_bits() & !SLOT | slot;
    let keys = &mut waiting.keys;
    let mut count = 0;
    let mut remaining = entered.mask;
    let mut nearest = key(remaining.trailing_zeros());
    remaining &= remaining - 1;
    while remaining != 0 {
        let other = key(remaining.trailing_zeros());
        remaining &= remaining - 1;
        let farther = other.max(nearest);
        nearest = other.min(nearest);
        let mut at = count;
        while at > 0 && keys[at - 1] < farther {
            keys[at] = keys[at - 1];
            at -= 1;
        }
        keys[at] = farther;
        count += 1;
    }
    waiting.count = count as u32;
    (nearest & SLOT) as usize
}

/// A tree with eight children a node.
#[derive(Debug)]
pub(crate) struct WideTree {
    /// The root first, and nodes before their children.
    pub nodes: Vec<WideNode>,
    /// The number of levels.
    pub depth: usize,
}

impl Default for WideTree {
    fn default() -> Self {
        Self { nodes: vec![WideNode::EMPTY], depth: 1 }
    }
}

impl WideTree {
    /// Puts a node in the place of a leaf, which becomes its first child. `level` is that of the node above, 1 for the
    /// root. Returns its number; `None` where trees may not be deeper.
    pub fn lower(&mut self, index: usize, slot: usize, level: usize) -> Option<usize> {
        if level + 1 >= STACK {
            return None;
        }
        let (number, above) = (self.nodes.len(), &mut self.nodes[index]);
        let mut node = WideNode::EMPTY;
        (node.first[0], node.count[0]) = (above.first[slot], above.count[slot]);
        node.set_bounds(0, &above.bounds(slot));
        (above.first[slot], above.count[slot]) = (number as u32, INNER);
        self.nodes.push(node);
        self.depth = self.depth.max(level + 1);
        Some(number)
    }

    /// The blocks that the things of all leaves fill.
    pub fn blocks(&self) -> usize {
        let leaves = self.nodes.iter().flat_map(|node| node.count).filter(|count| *count != INNER);
        leaves.map(|count| count.div_ceil(WIDTH as u32) as usize).sum()
    }
}

/// The things below a node of two.
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

/// The tree that is made of one with two children a node, by opening the nodes with the largest surfaces.
/// Nodes that hold no more than `leaf` things become leaves.
pub(crate) fn widened(nodes: &[Node], leaf: u32) -> WideTree {
    let held = held(nodes);
    let is_leaf = |node: usize| nodes[node].is_leaf() || (held[node].is_range && held[node].count <= leaf);
    let WideTree { nodes: mut wide, mut depth } = WideTree::default();
    // A node of two, the wide one that it becomes, and that one's level.
    let mut todo = vec![(0, 0, 1)];
    while let Some((narrow, index, level)) = todo.pop() {
        depth = depth.max(level);
        let mut open = [narrow; WIDTH];
        let mut count = 1;
        if held[narrow].count == 0 {
            continue;
        }
        while count < WIDTH {
            let area = |&at: &usize| Bounds::around(&nodes[open[at]]).area();
            let inner = (0..count).filter(|&at| !is_leaf(open[at]));
            let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
            let first = nodes[open[largest]].first as usize;
            (open[largest], open[count]) = (first, first + 1);
            count += 1;
        }
        let start = todo.len();
        for (slot, &child) in open[..count].iter().enumerate() {
            let node = &nodes[child];
            let (first, count) = if is_leaf(child) {
                (held[child].first, held[child].count)
            } else {
                wide.push(WideNode::EMPTY);
                todo.push((child, wide.len() - 1, level + 1));
                (wide.len() as u32 - 1, INNER)
            };
            (wide[index].first[slot], wide[index].count[slot]) = (first, count);
            wide[index].set_bounds(slot, &Bounds::around(node));
        }
        // The first child's subtree follows first.
        todo[start..].reverse();
    }
    WideTree { nodes: wide, depth }
}
