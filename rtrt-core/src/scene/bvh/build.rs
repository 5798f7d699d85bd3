//! The build of a BVH, by the surface area heuristic over bins.

use super::{Bounds, Join};
use crate::kernel::traverse::STACK;
use crate::layout::Node;
use alloc::vec::Vec;
use glam::{Vec3A, Vec3Swizzles};

/// Bins along each axis.
const BINS: usize = 16;
/// Cost of a visit to a node, in triangle tests, as long as triangles are put in order.
const SPLIT_COST: f32 = 0.6;
/// The cost that decides which splits are merged: it includes caches and branches. Measured: 1 to 2 make
/// visibility of dragon_res2 a tenth faster, 2.5 and more make that of Sponza slower. (It does not change
/// the order of triangles, whose numbers decide between equal hits.)
pub(super) const VISIT_COST: f32 = 1.75;
/// Below this depth nodes are split into halves, which bounds the depth of the tree.
const DEEP: usize = 36;
const _: () = assert!(DEEP + 26 < STACK);
/// Nodes with fewer triangles are built by one worker.
const PARALLEL: usize = 4096;

/// A box in two registers.
#[derive(Clone, Copy)]
pub(super) struct Padded {
    low: Vec3A,
    high: Vec3A,
}

impl Padded {
    const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    /// Zeros get one sign, since the minima and maxima of processors differ in theirs.
    pub fn new(bounds: &Bounds) -> Self {
        Self { low: Vec3A::from(bounds.low) + Vec3A::ZERO, high: Vec3A::from(bounds.high) + Vec3A::ZERO }
    }
    fn bounds(&self) -> Bounds {
        Bounds { low: self.low.into(), high: self.high.into() }
    }
    /// Grows to hold a box with these corners.
    #[inline(always)]
    fn add(&mut self, low: Vec3A, high: Vec3A) {
        (self.low, self.high) = (low.min(self.low), high.max(self.high));
    }
    /// Twice the center.
    #[inline(always)]
    fn center2(&self) -> Vec3A {
        self.low + self.high
    }
    /// [`Bounds::area`], in registers.
    #[inline(always)]
    fn area(&self) -> f32 {
        let size = (self.high - self.low).max(Vec3A::ZERO);
        let [a, b, c] = (size * size.yzx()).to_array();
        a + b + c
    }
}

/// The part of a BVH that one worker builds: the place of its nodes, and its boxes with their numbers.
struct Part<'a> {
    nodes: &'a mut [Node],
    first_node: usize,
    boxes: &'a mut [Padded],
    numbers: &'a mut [u32],
    first: usize,
}

/// A plane between bins.
struct Split {
    axis: usize,
    cost: f32,
    bin: usize,
    scale: Scale,
}

/// The map from centers to bins, on each axis.
#[derive(Clone, Copy)]
struct Scale {
    low: Vec3A,
    /// 0 where all centers coincide.
    bins_per_unit: Vec3A,
}

impl Scale {
    fn new(centers: &Padded) -> Self {
        let along = |extent: f32| {
            let bins = BINS as f32 / extent;
            if extent > 0.0 && bins.is_finite() { bins } else { 0.0 }
        };
        let [x, y, z] = (centers.high - centers.low).to_array().map(along);
        Self { low: centers.low, bins_per_unit: Vec3A::new(x, y, z) }
    }

    /// The bins of a center along the axes.
    #[inline(always)]
    fn bins(&self, center2: Vec3A) -> [usize; 3] {
        const { assert!(BINS == 16) };
        let bins = ((center2 - self.low) * self.bins_per_unit).min(Vec3A::splat(15.5));
        // Of a number from 16 to 32, the first four bits of the fraction are an integer.
        (bins + 16.0).to_array().map(|bin| (bin.to_bits() >> 19) as usize & 15)
    }
}

/// Builds over the boxes, and puts `numbers` in the order of the leaves, which hold at most `leaf` boxes. `nodes` has
/// room for the root and two nodes for each box but one. Returns the root.
pub(super) fn build(
    boxes: &mut [Padded],
    numbers: &mut [u32],
    nodes: &mut [Node],
    leaf: usize,
    join: &impl Join,
) -> Node {
    let part = Part { nodes, first_node: 1, boxes, numbers, first: 0 };
    Build { leaf, join }.node(part, 0).0
}

/// The boxes of triangles, three indices each.
pub(super) fn boxes(positions: &[[f32; 3]], indices: &[u32]) -> Vec<Padded> {
    let triangles = indices.chunks_exact(3);
    triangles.map(|t| Padded::new(&Bounds::of(t.iter().map(|&i| positions[i as usize])))).collect()
}

/// What all nodes of one build share.
struct Build<'a, J> {
    leaf: usize,
    join: &'a J,
}

impl<J: Join> Build<'_, J> {
    /// Builds the part. Returns its root and the cost of a visit to it, in triangle tests.
    fn node(&self, part: Part<'_>, depth: usize) -> (Node, f32) {
        let Part { nodes, first_node, boxes, numbers, first } = part;
        let count = boxes.len();
        let (mut bounds, mut centers) = (Padded::EMPTY, Padded::EMPTY);
        for item in boxes.iter() {
            let center = item.center2();
            bounds.add(item.low, item.high);
            centers.add(center, center);
        }
        let bounds = bounds.bounds();
        let leaf =
            Node { low: bounds.low, high: bounds.high, first: first as u32, kind: 4 * count as u32 + 3 };
        let tests = count as f32;
        if count == 1 {
            return (leaf, tests);
        }
        let split = if depth < DEEP { cheapest(boxes, &bounds, &centers) } else { None };
        let (axis, middle) = match split {
            Some(split) if split.cost >= tests && count <= self.leaf => return (leaf, tests),
            Some(split) => (split.axis, partition(boxes, numbers, &split)),
            None if count <= self.leaf => return (leaf, tests),
            None => (0, count / 2),
        };
        let (pair, below) = nodes.split_at_mut(2);
        let (left_nodes, right_nodes) = below.split_at_mut(2 * middle - 2);
        let (left_boxes, right_boxes) = boxes.split_at_mut(middle);
        let (left_numbers, right_numbers) = numbers.split_at_mut(middle);
        let left = Part {
            nodes: left_nodes,
            first_node: first_node + 2,
            boxes: left_boxes,
            numbers: left_numbers,
            first,
        };
        let right = Part {
            nodes: right_nodes,
            first_node: first_node + 2 * middle,
            boxes: right_boxes,
            numbers: right_numbers,
            first: first + middle,
        };
        let (left, right) = if count > PARALLEL {
            self.join.join(|| self.node(left, depth + 1), || self.node(right, depth + 1))
        } else {
            (self.node(left, depth + 1), self.node(right, depth + 1))
        };
        let share = |node: &Node| Bounds::around(node).area() / bounds.area().max(f32::MIN_POSITIVE);
        let cost = VISIT_COST + share(&left.0) * left.1 + share(&right.0) * right.1;
        if cost >= tests && count <= self.leaf {
            return (leaf, tests);
        }
        (pair[0], pair[1]) = (left.0, right.0);
        (Node { first: first_node as u32, kind: axis as u32, ..leaf }, cost)
    }
}

/// The boxes of one axis by the bins of their centers.
#[derive(Clone, Copy)]
struct Bins {
    boxes: [Padded; BINS],
    counts: [u32; BINS],
    /// The bins that hold any, one a bit.
    held: u32,
}

impl Bins {
    const EMPTY: Self = Self { boxes: [Padded::EMPTY; BINS], counts: [0; BINS], held: 0 };

    #[inline(always)]
    fn add(&mut self, bin: usize, item: &Padded) {
        self.boxes[bin].add(item.low, item.high);
        self.counts[bin] += 1;
        self.held |= 1 << bin;
    }

    /// Adds a bin to those on one side of a plane.
    #[inline(always)]
    fn join(&self, side: &mut (Padded, u32), bin: usize) {
        side.0.add(self.boxes[bin].low, self.boxes[bin].high);
        side.1 += self.counts[bin];
    }
}

/// The cheapest split with its cost in triangle tests; `None` if all centers coincide.
fn cheapest(boxes: &[Padded], bounds: &Bounds, centers: &Padded) -> Option<Split> {
    let scale = Scale::new(centers);
    let area = bounds.area().max(f32::MIN_POSITIVE);
    if let [a, b] = boxes {
        // Each axis parts them, into the first bin and the last, at the same cost.
        let axis = scale.bins_per_unit.to_array().iter().position(|bins| *bins > 0.0)?;
        let cost = SPLIT_COST + (a.area() + b.area()) / area;
        return Some(Split { axis, cost, bin: 1, scale });
    }
    let mut all = [Bins::EMPTY; 3];
    for item in boxes {
        for (bins, bin) in all.iter_mut().zip(scale.bins(item.center2())) {
            bins.add(bin, item);
        }
    }
    let mut best: Option<Split> = None;
    for (axis, bins) in all.iter().enumerate() {
        // A plane behind an empty bin parts the boxes as the one in front of it does.
        let mut above = [(0.0, 0); BINS];
        let mut right = (Padded::EMPTY, 0);
        let mut held = bins.held;
        while held & (held - 1) != 0 {
            let bin = held.ilog2() as usize;
            held &= !(1 << bin);
            bins.join(&mut right, bin);
            above[bin] = (right.0.area(), right.1);
        }
        let mut left = (Padded::EMPTY, 0);
        let mut held = bins.held;
        while held & (held - 1) != 0 {
            let bin = held.trailing_zeros() as usize;
            held &= held - 1;
            bins.join(&mut left, bin);
            let (right, count) = above[held.trailing_zeros() as usize];
            let tests = left.0.area() * left.1 as f32 + right * count as f32;
            // A box without area is hit by chance only: any split will do.
            let cost = SPLIT_COST + tests / area;
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Split { axis, cost, bin: bin + 1, scale });
            }
        }
    }
    best
}

/// Moves the boxes on the lower side of the split to the front. Returns their number: at least 1, and less than all.
fn partition(boxes: &mut [Padded], numbers: &mut [u32], split: &Split) -> usize {
    let mut middle = 0;
    for i in 0..boxes.len() {
        let is_left = split.scale.bins(boxes[i].center2())[split.axis] < split.bin;
        // Without a branch, which no processor could foresee.
        let to = if is_left { middle } else { i };
        boxes.swap(to, i);
        numbers.swap(to, i);
        middle += usize::from(is_left);
    }
    middle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_have_one_sign() {
        let bounds = Padded::new(&Bounds { low: [-0.0, 0.0, -1.0], high: [-0.0, 1.0, -0.0] }).bounds();
        assert_eq!(bounds.low.map(f32::to_bits), [0.0, 0.0, -1.0].map(f32::to_bits));
        assert_eq!(bounds.high.map(f32::to_bits), [0.0_f32, 1.0, 0.0].map(f32::to_bits));
    }

    #[test]
    fn no_plane_between_bins_is_cheaper_than_the_one_that_is_taken() {
        let mut seed = 3_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        for count in (2..60).chain([1000]) {
            // Few places on the third axis: most of its bins are empty.
            let mut items: Vec<Padded> = (0..count)
                .map(|_| {
                    let low = [random(), random() * 9.0, (random() * 3.0).floor()];
                    let high = low.map(|c| c + 0.3 * random());
                    Padded::new(&Bounds { low, high: [high[0], high[1], low[2]] })
                })
                .collect();
            let around = |items: &[Padded]| items.iter().fold(Bounds::EMPTY, |all, b| all.union(&b.bounds()));
            let mut centers = Padded::EMPTY;
            items.iter().for_each(|item| centers.add(item.center2(), item.center2()));
            let (bounds, scale) = (around(&items), Scale::new(&centers));
            let cost = |axis: usize, plane: usize| {
                let (left, right): (Vec<_>, Vec<_>) =
                    items.iter().partition(|item| scale.bins(item.center2())[axis] < plane);
                let tests =
                    around(&left).area() * left.len() as f32 + around(&right).area() * right.len() as f32;
                let is_split = !left.is_empty() && !right.is_empty();
                if is_split { SPLIT_COST + tests / bounds.area() } else { f32::INFINITY }
            };
            let least = (0..3)
                .flat_map(|axis| (1..BINS).map(move |plane| (axis, plane)))
                .fold(f32::INFINITY, |least, (axis, plane)| least.min(cost(axis, plane)));
            let split = cheapest(&items, &bounds, &centers).unwrap();
            assert_eq!((split.cost, cost(split.axis, split.bin)), (least, least));
            let mut numbers: Vec<u32> = (0..count).collect();
            let copies = items.clone();
            let middle = partition(&mut items, &mut numbers, &split);
            for (place, (item, number)) in items.iter().zip(numbers).enumerate() {
                assert_eq!(item.low, copies[number as usize].low);
                assert_eq!(scale.bins(item.center2())[split.axis] < split.bin, place < middle);
            }
        }
    }
}
