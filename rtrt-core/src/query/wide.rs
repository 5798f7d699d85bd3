//! Trees of nodes with eight children, which a ray asks all at once.
//!
//! A child's interval is computed as [`slab`](crate::kernel::slab::slab) does, so nothing that a tree of any shape finds
//! is lost.

use super::rows::{cross, enter, load, splat};
use crate::kernel::ray::Ray;
use crate::kernel::traverse::STACK;
use crate::lane::{Lane, Mask, Row};
use crate::scene::Bounds;
use alloc::vec;
use alloc::vec::Vec;
use glam::Vec4;

/// Children of a node.
pub(crate) const WIDTH: usize = 8;
/// The bits of a slot.
const SLOT: u32 = WIDTH as u32 - 1;
/// The levels that trees over few things have at most.
const FLAT: usize = 3;
/// The levels that most trees have at most.
pub(crate) const SHALLOW: usize = 9;
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

    /// What a child is, in numbers: a node, and [`INNER`]; or the first of a leaf's things, and how many there are.
    #[inline(always)]
    pub fn held(&self, slot: u32) -> (u32, u32) {
        let slot = (slot & SLOT) as usize;
        (self.first[slot], self.count[slot])
    }

    /// Makes a child be this, in this box.
    pub fn set_child(&mut self, slot: usize, child: &Child, bounds: &Bounds) {
        (self.first[slot], self.count[slot]) = match *child {
            Child::Node(node) => (node, INNER),
            Child::Leaf(first, count) => (first, count),
        };
        self.set_bounds(slot, bounds);
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

    /// Whether nothing is in any child.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.planes[0].iter().all(|&plane| plane == NOWHERE)
    }

    /// Half of the surfaces of the boxes of all children, summed.
    pub fn area(&self) -> f64 {
        let area = |half: usize| {
            let size = |axis: usize| (self.plane(3 + axis)[half] - self.plane(axis)[half]).max(Vec4::ZERO);
            let [x, y, z] = [size(0), size(1), size(2)];
            (x * y + y * z + z * x).as_dvec4().element_sum()
        };
        area(0) + area(1)
    }

    /// The box of all children.
    pub fn all_bounds(&self) -> Bounds {
        if self.is_empty() {
            return Bounds::EMPTY;
        }
        let low = |axis: usize| {
            let [a, b] = self.plane(axis);
            a.min(b).min_element()
        };
        let high = |axis: usize| {
            let nowhere = Vec4::splat(NOWHERE);
            let there = |planes: Vec4| Vec4::select(planes.cmpeq(nowhere), Vec4::NEG_INFINITY, planes);
            let [a, b] = self.plane(3 + axis);
            there(a).max(there(b)).max_element()
        };
        Bounds { low: [low(0), low(1), low(2)], high: [high(0), high(1), high(2)] }
    }

    /// One of the planes of each child, by fours.
    fn plane(&self, number: usize) -> [Vec4; 2] {
        let planes = &self.planes[number];
        [Vec4::from_slice(planes), Vec4::from_slice(&planes[4..])]
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

impl Entered {
    /// The key of a child. Numbers that are not negative are ordered as their bits.
    #[inline(always)]
    fn key(&self, slot: u32) -> u32 {
        self.near[slot as usize & SLOT as usize].to_bits() & !SLOT | slot
    }
}

impl<L: Lane> Asked<L> {
    /// `magnitude` widens the boxes by that much of their slack; 0 for nodes that have none. `passing` widens
    /// all.
    #[inline(always)]
    pub fn new(token: L::Token, ray: &Ray<f32>, magnitude: f32, passing: f32) -> Self {
        let ([x, y, z], inverse) = (ray.origin.lane(0), ray.inverse.lane(0));
        Self {
            origins: [
                splat(token, [x + passing, y + passing, z + passing]),
                splat(token, [x - passing, y - passing, z - passing]),
            ],
            inverse: splat(token, inverse),
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
            let (near, is_entered) = self.enter_from(node, pad, first, [from, limit]);
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

    /// Where the ray enters the children from `first` on, and which of them it may hit between two `t`.
    #[inline(always)]
    pub fn enter_from(
        &self,
        node: &WideNode,
        pad: Option<L>,
        first: usize,
        [from, limit]: [L; 2],
    ) -> (L, L::Mask) {
        let slabs = [
            self.cross(node, pad, first, 0),
            self.cross(node, pad, first, 1),
            self.cross(node, pad, first, 2),
        ];
        enter(slabs, from, limit)
    }

    /// Where the ray enters and leaves the slabs of the children from `first` on along an axis.
    #[inline(always)]
    fn cross(&self, node: &WideNode, pad: Option<L>, first: usize, axis: usize) -> (L, L) {
        let planes = node.slab(self.magnitude.token(), pad, first, axis);
        cross(planes, [self.origins[0][axis], self.origins[1][axis]], self.inverse[axis])
    }
}

/// A child of a node that waits. Its key is where the ray enters it, the last three bits replaced by the slot.
#[derive(Clone, Copy)]
struct Waiting {
    key: u32,
    node: u32,
}

/// Something that looks at the leaves which a ray comes through.
pub(crate) trait Visitor {
    /// Looks at a leaf that holds something; returns how far the ray is still traced. Below 0, the search ends.
    fn leaf(&mut self, first: u32, count: u32) -> f32;
}

/// Shows a visitor the leaves below a node that a ray may hit within its range, roughly from near to far. `slacks` are
/// those of the nodes' children, if they have any.
#[inline(always)]
pub(crate) fn traverse<L: Lane>(
    tree: &WideTree,
    node: u32,
    slacks: Option<&[[f32; WIDTH]]>,
    asked: &Asked<L>,
    mut range: Range,
    visitor: &mut impl Visitor,
) {
    const NOTHING: Waiting = Waiting { key: 0, node: 0 };
    /// All children of a node but one may wait.
    const REST: usize = WIDTH - 1;
    let nodes = &tree.nodes;
    // A stack is cleared for each search: most trees need a short one.
    let (mut tiny, mut short, mut long);
    let stack: &mut [Waiting] = if tree.depth <= FLAT {
        tiny = [NOTHING; REST * FLAT];
        &mut tiny
    } else if tree.depth <= SHALLOW {
        short = [NOTHING; REST * SHALLOW];
        &mut short
    } else {
        long = [NOTHING; REST * STACK];
        &mut long
    };
    let mut depth = 0;
    // What comes next: a node, or the things of a leaf.
    let (mut first, mut count) = (node, INNER);
    loop {
        // The next node: leaves on the way are looked at.
        let index = loop {
            if count == INNER {
                break first;
            }
            if count != 0 {
                range.limit = visitor.leaf(first, count);
                if range.limit < range.from {
                    return;
                }
            }
            let Some(Waiting { key, node }) = next(stack, &mut depth, range.limit) else { return };
            (first, count) = nodes[node as usize].held(key & SLOT);
        };
        let node = &nodes[index as usize];
        let entered = asked.enter(node, slacks.map(|slacks| &slacks[index as usize]), range);
        (first, count) = (0, 0);
        if entered.mask != 0 {
            let slot = nearest(&entered, index, stack, &mut depth);
            (first, count) = node.held(slot);
        }
    }
}

/// The nearest of the children that are entered, of which there must be one; the others wait, the nearest of them on top.
#[inline(always)]
fn nearest(entered: &Entered, node: u32, stack: &mut [Waiting], depth: &mut usize) -> u32 {
    let slot = entered.mask.trailing_zeros();
    let mut remaining = entered.mask & (entered.mask - 1);
    if remaining == 0 {
        return slot;
    }
    let bottom = *depth;
    let mut nearest = entered.key(slot);
    while remaining != 0 {
        let other = entered.key(remaining.trailing_zeros());
        remaining &= remaining - 1;
        let key = other.max(nearest);
        nearest = other.min(nearest);
        let mut at = *depth;
        while at > bottom && stack[at - 1].key < key {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = Waiting { key, node };
        *depth += 1;
    }
    nearest & SLOT
}

/// The topmost child that is not too far.
#[inline(always)]
fn next(stack: &[Waiting], depth: &mut usize, limit: f32) -> Option<Waiting> {
    while *depth > 0 {
        *depth -= 1;
        let waiting = stack[*depth];
        if waiting.key & !SLOT <= limit.to_bits() {
            return Some(waiting);
        }
    }
    None
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

    /// The blocks that the triangles of all leaves fill, while leaves count triangles.
    pub fn blocks(&self) -> usize {
        let leaves = self.nodes.iter().flat_map(|node| node.count).filter(|count| *count != INNER);
        leaves.map(|count| count.div_ceil(WIDTH as u32) as usize).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::fixture::Random;

    #[test]
    fn the_box_of_a_node_is_around_those_of_its_children() {
        let mut random = Random(3);
        for there in 0..1_u32 << WIDTH {
            let (mut node, mut all, mut area) = (WideNode::EMPTY, Bounds::EMPTY, 0.0);
            for slot in (0..WIDTH).filter(|slot| there >> slot & 1 == 1) {
                let low = random.vector(10.0);
                let high = low + random.vector(3.0).abs();
                let bounds = Bounds { low: low.to_array(), high: high.to_array() };
                node.set_child(slot, &Child::Leaf(0, 1), &bounds);
                all = all.union(&bounds);
                area += f64::from(bounds.area());
            }
            let found = node.all_bounds();
            assert_eq!((found.low, found.high), (all.low, all.high));
            assert!((node.area() - area).abs() <= 1e-9 * area, "{there:b}");
        }
    }
}
