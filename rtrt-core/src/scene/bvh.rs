//! The BVH of a mesh: built once, by the surface area heuristic over bins.
//!
//! It is stored in the order of traversal: triangles by leaf, vertices by their first use, siblings
//! side by side in one cache line, subtrees together. Splits go down to leaves of one or two triangles,
//! which orders them well; then splits that cost more visits than they save tests are merged again,
//! from the leaves up.

mod build;

use self::build::Padded;
use crate::kernel::traverse::STACK;
use crate::layout::Node;
use crate::scene::Mesh;
use alloc::vec;
use alloc::vec::Vec;
use bytemuck::Zeroable;

/// Runs two halves of a build, in parallel if the caller has threads.
pub trait Join: Sync {
    /// Runs both and returns their results.
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B);
}

/// One half after the other.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sequential;

impl Join for Sequential {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        (a(), b())
    }
}

/// The BVH of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Bvh {
    /// Nodes, the root first; children are neighbors.
    pub nodes: Vec<Node>,
    /// The mesh's triangles in the order of the leaves.
    pub triangles: Vec<u32>,
}

/// The largest number of triangles in a leaf.
const LEAF: usize = 8;
impl Bvh {
    /// The BVH of the mesh. It does not depend on `join`: workers build disjoint parts, and every sum
    /// runs in one order.
    ///
    /// Splits are the cheapest of the surface area heuristic over 16 bins on each axis
    /// (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007). Where
    /// centers coincide, or below a fixed depth, a node is split into halves. Splits that do not pay are
    /// then merged, from the leaves up. A mesh without triangles has one empty leaf.
    pub fn build(mesh: &Mesh, join: &impl Join) -> Self {
        Self::of_triangles(mesh.positions(), mesh.indices(), join)
    }

    /// The BVH of triangles, three indices each, all of them valid.
    pub(crate) fn of_triangles(positions: &[[f32; 3]], indices: &[u32], join: &impl Join) -> Self {
        Self::over_padded(build::boxes(positions, indices), LEAF, join)
    }

    /// The BVH over boxes, with at most `leaf` of them in a leaf.
    pub(crate) fn over(boxes: &[Bounds], leaf: usize, join: &impl Join) -> Self {
        Self::over_padded(boxes.iter().map(Padded::new).collect(), leaf, join)
    }

    fn over_padded(mut boxes: Vec<Padded>, leaf: usize, join: &impl Join) -> Self {
        let mut triangles: Vec<u32> = (0..boxes.len() as u32).collect();
        if boxes.is_empty() {
            return Self { nodes: vec![Node { kind: 3, ..Node::zeroed() }], triangles };
        }
        // A subtree of n triangles has at most 2n − 2 nodes below its root.
        let mut nodes = vec![Node::zeroed(); 2 * boxes.len() - 1];
        let (root, below) = nodes.split_at_mut(1);
        root[0] = build::build(&mut boxes, &mut triangles, below, leaf, join);
        Self { nodes: compact(nodes), triangles }
    }
}

/// Why links make no BVH.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("not a tree of the mesh: {0}")]
pub struct BvhError(pub(super) &'static str);

impl Bvh {
    /// Whether this is a tree of the mesh: its links make a tree, and its boxes are those of the mesh.
    pub(super) fn check(&self, mesh: &Mesh) -> Result<(), BvhError> {
        self.check_shape(mesh.positions(), mesh.indices())
    }

    /// [`Bvh::check`] of triangles, three indices each, all of them valid.
    pub(crate) fn check_shape(&self, positions: &[[f32; 3]], indices: &[u32]) -> Result<(), BvhError> {
        let fitted = Self::of_links(positions, indices, &self.links(), self.triangles.clone())?;
        if fitted.nodes == self.nodes { Ok(()) } else { Err(BvhError("its boxes are those of another mesh")) }
    }

    /// `[first, kind]` of each node: the data that cannot be computed from the mesh again.
    pub fn links(&self) -> Vec<[u32; 2]> {
        self.nodes.iter().map(|node| [node.first, node.kind]).collect()
    }

    /// The BVH with these [`Bvh::links`] and with `triangles` in the order of its leaves, such as a file
    /// stores them. Its boxes are computed from the mesh, so wrong links lose no hit.
    ///
    /// # Errors
    /// The links are no tree, hold a triangle never or twice, or are too deep.
    pub fn from_links(mesh: &Mesh, links: &[[u32; 2]], triangles: Vec<u32>) -> Result<Self, BvhError> {
        Self::of_links(mesh.positions(), mesh.indices(), links, triangles)
    }

    /// [`Bvh::from_links`] of triangles, three indices each, all of them valid.
    pub(super) fn of_links(
        positions: &[[f32; 3]],
        indices: &[u32],
        links: &[[u32; 2]],
        triangles: Vec<u32>,
    ) -> Result<Self, BvhError> {
        check(indices.len() / 3, links, &triangles)?;
        let node = |&[first, kind]: &[u32; 2]| Node { first, kind, ..Node::zeroed() };
        let mut nodes: Vec<Node> = links.iter().map(node).collect();
        refit(&mut nodes, |corner| {
            let index = indices[3 * triangles[corner / 3] as usize + corner % 3];
            positions[index as usize]
        });
        Ok(Self { nodes, triangles })
    }
}

/// Whether the links make a tree: every node but the root is one of two neighbors below one earlier
/// node, every triangle is in one leaf, and the depth fits the stack of a traversal.
fn check(count: usize, links: &[[u32; 2]], triangles: &[u32]) -> Result<(), BvhError> {
    let once = |seen: &mut Vec<bool>, index: usize, what| match seen.get_mut(index) {
        Some(seen) if !*seen => {
            *seen = true;
            Ok(())
        }
        _ => Err(BvhError(what)),
    };
    let mut seen = vec![false; count];
    for &triangle in triangles {
        once(&mut seen, triangle as usize, "a triangle is there twice, or not in the mesh")?;
    }
    if triangles.len() != count || links.len().is_multiple_of(2) {
        return Err(BvhError("the number of triangles or nodes is wrong"));
    }
    let mut depths = vec![0_u8; links.len()];
    let mut children = vec![false; links.len()];
    let mut held = vec![false; count];
    for (index, &[first, kind]) in links.iter().enumerate() {
        let (first, depth) = (first as usize, depths[index] + 1);
        if kind & 3 == 3 {
            let last = first + (kind >> 2) as usize;
            if last > count || (kind == 3 && links.len() > 1) {
                return Err(BvhError("a leaf is empty, or beyond the mesh"));
            }
            (first..last).try_for_each(|i| once(&mut held, i, "a triangle is in two leaves"))?;
        } else {
            if kind > 3 || first <= index || first.is_multiple_of(2) || usize::from(depth) >= STACK {
                return Err(BvhError("a node's children are before it, or too deep"));
            }
            once(&mut children, first, "a node has two parents, or is not there")?;
            once(&mut children, first + 1, "a node has two parents, or is not there")?;
            depths[first..first + 2].fill(depth);
        }
    }
    if held.contains(&false) || children[1..].contains(&false) {
        return Err(BvhError("a triangle or a node is left out"));
    }
    Ok(())
}

/// Computes the boxes of a BVH from its leaves up. `corner(3 · i + k)` is the position of corner `k` of
/// triangle `i` in the order of the leaves. Nodes come before their children.
pub(crate) fn refit(nodes: &mut [Node], corner: impl Fn(usize) -> [f32; 3]) {
    for index in (0..nodes.len()).rev() {
        let Node { first, .. } = nodes[index];
        let first = first as usize;
        let bounds = if nodes[index].is_leaf() {
            Bounds::of((3 * first..3 * (first + nodes[index].triangles() as usize)).map(&corner))
        } else {
            let [a, b] = [&nodes[first], &nodes[first + 1]].map(Bounds::around);
            a.union(&b)
        };
        if !bounds.is_empty() {
            (nodes[index].low, nodes[index].high) = (bounds.low, bounds.high);
        }
    }
}

/// The nodes without the gaps between subtrees. A subtree stays together, lower half first,
/// so that a ray on its way down reads on in memory.
fn compact(mut nodes: Vec<Node>) -> Vec<Node> {
    let mut count = 1;
    let mut todo = vec![0];
    while let Some(index) = todo.pop() {
        let node: &mut Node = &mut nodes[index];
        if !node.is_leaf() {
            // They move to the front, or stay.
            let children = node.first as usize;
            node.first = count as u32;
            nodes.copy_within(children..children + 2, count);
            todo.extend([count + 1, count]);
            count += 2;
        }
    }
    nodes.truncate(count);
    nodes.shrink_to_fit();
    nodes
}

/// A box that can be empty.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Bounds {
    pub const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    pub fn around(node: &Node) -> Self {
        Self { low: node.low, high: node.high }
    }
    pub fn of(points: impl Iterator<Item = [f32; 3]>) -> Self {
        points.fold(Self::EMPTY, |b, p| b.union(&Self::at(p)))
    }
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        let mut both = *self;
        for axis in 0..3 {
            if other.low[axis] < both.low[axis] {
                both.low[axis] = other.low[axis];
            }
            if other.high[axis] > both.high[axis] {
                both.high[axis] = other.high[axis];
            }
        }
        both
    }
    /// Whether the box holds no point.
    pub fn is_empty(&self) -> bool {
        self.low[0] > self.high[0]
    }
    /// That of a point.
    pub fn at(point: [f32; 3]) -> Self {
        Self { low: point, high: point }
    }
    /// The longest side; 0 if empty.
    pub fn side(&self) -> f32 {
        (0..3).fold(0.0, |longest, axis| (self.high[axis] - self.low[axis]).max(longest))
    }
    /// Half of the surface; 0 if empty.
    pub fn area(&self) -> f32 {
        let size = |axis: usize| (self.high[axis] - self.low[axis]).max(0.0);
        size(0) * size(1) + size(1) * size(2) + size(2) * size(0)
    }
}

#[cfg(test)]
mod tests {
    use super::build::VISIT_COST;
    use super::*;
    use crate::layout::Attribute;

    fn mesh(triangles: &[[[f32; 3]; 3]]) -> Mesh {
        let positions: Vec<_> = triangles.iter().flatten().copied().collect();
        let count = positions.len();
        Mesh::new(positions, vec![Attribute::zeroed(); count], (0..count as u32).collect()).unwrap()
    }

    /// Checks that every triangle is in exactly one leaf and in the box of every node above it. Returns
    /// the depth.
    fn check(mesh: &Mesh) -> usize {
        let tree = Bvh::build(mesh, &Sequential);
        let mut seen = vec![0; mesh.triangles()];
        let mut deepest = 0;
        let mut todo = vec![(0_u32, vec![])];
        while let Some((index, above)) = todo.pop() {
            let node = tree.nodes[index as usize];
            let mut boxes = above.clone();
            boxes.push((node.low, node.high));
            deepest = deepest.max(boxes.len());
            if !node.is_leaf() {
                todo.push((node.first, boxes.clone()));
                todo.push((node.first + 1, boxes));
                continue;
            }
            for i in 0..node.triangles() {
                let triangle = tree.triangles[(node.first + i) as usize] as usize;
                seen[triangle] += 1;
                for &vertex in &mesh.indices()[3 * triangle..3 * triangle + 3] {
                    let p = mesh.positions()[vertex as usize];
                    for (low, high) in &boxes {
                        assert!((0..3).all(|a| low[a] <= p[a] && p[a] <= high[a]));
                    }
                }
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
        deepest
    }

    fn scattered(count: usize) -> Vec<[[f32; 3]; 3]> {
        let mut state = 7_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 65536.0
        };
        (0..count)
            .map(|_| {
                let p = [next(), next(), next()];
                [p, [p[0] + next() * 0.01, p[1], p[2]], [p[0], p[1] + next() * 0.01, p[2] + 0.3]]
            })
            .collect()
    }

    #[test]
    fn holds_every_triangle_once_inside_its_boxes() {
        assert!(check(&mesh(&scattered(10_000))) < STACK);
    }

    #[test]
    fn stands_up_to_duplicate_degenerate_and_huge_triangles() {
        let mut triangles = vec![[[1.0; 3], [2.0, 1.0, 1.0], [1.0, 2.0, 1.0]]; 3000];
        triangles.extend(vec![[[5.0; 3]; 3]; 3000]);
        triangles.push([[-1e9, 0.0, -1e9], [1e9, 0.0, -1e9], [0.0, 0.0, 1e9]]);
        // Centers in geometric progression: every split leaves one behind.
        triangles.extend((0..60).map(|i| [[f32::from_bits((127 - i) << 23); 3]; 3]));
        assert!(check(&mesh(&triangles)) < STACK);
    }

    /// The cost of a visit to a node, and its number of triangles. Counts leaves of more than one triangle,
    /// and inner nodes small enough for a leaf; those must cost less than their triangles.
    fn cost(tree: &Bvh, node: &Node, small: &mut [u32; 2]) -> (f32, u32) {
        if node.is_leaf() {
            small[0] += u32::from(node.triangles() > 1);
            return (node.triangles() as f32, node.triangles());
        }
        let area = |node: &Node| Bounds::around(node).area();
        let (mut sum, mut triangles) = (VISIT_COST, 0);
        for child in &tree.nodes[node.first as usize..][..2] {
            let (below, count) = cost(tree, child, small);
            sum += area(child) / area(node) * below;
            triangles += count;
        }
        if triangles as usize <= LEAF {
            small[1] += 1;
            assert!(sum < triangles as f32, "a split of {triangles} triangles costs {sum}");
        }
        (sum, triangles)
    }

    #[test]
    fn splits_that_stay_pay() {
        // Ten times as large, triangles lie in each other's boxes.
        let larger = |[p, q, r]: [[f32; 3]; 3]| {
            [p, q, r].map(|corner| core::array::from_fn(|i| p[i] + (corner[i] - p[i]) * 10.0))
        };
        let triangles: Vec<_> = scattered(2000).into_iter().map(larger).collect();
        let tree = Bvh::build(&mesh(&triangles), &Sequential);
        let mut small = [0; 2];
        let (_, count) = cost(&tree, &tree.nodes[0], &mut small);
        assert!(count == 2000 && small.iter().all(|&count| count > 50), "{small:?}");
    }

    #[test]
    fn kept_links_give_the_same_tree() {
        for count in [0, 1, 2, 5000] {
            let mesh = mesh(&scattered(count));
            let tree = Bvh::build(&mesh, &Sequential);
            assert_eq!(Bvh::from_links(&mesh, &tree.links(), tree.triangles.clone()), Ok(tree));
        }
    }

    #[test]
    fn links_that_are_no_tree_are_refused() {
        let mesh = mesh(&scattered(40));
        let tree = Bvh::build(&mesh, &Sequential);
        let links = tree.links();
        let refused = |links: &[[u32; 2]], triangles: &[u32]| {
            Bvh::from_links(&mesh, links, triangles.to_vec()).is_err()
        };
        for node in 0..links.len() {
            for (word, value) in [(0, 0), (0, u32::MAX), (0, 1), (1, 3), (1, 7), (1, u32::MAX), (1, 4)] {
                let mut bad = links.clone();
                bad[node][word] = value;
                assert!(bad == links || refused(&bad, &tree.triangles), "node {node}: {value}");
            }
        }
        assert!(refused(&links[..1], &tree.triangles) && refused(&[], &tree.triangles));
        assert!(refused(&links, &tree.triangles[1..]));
        let mut twice = tree.triangles.clone();
        twice[0] = twice[1];
        assert!(refused(&links, &twice));
        // A chain deeper than any stack: one triangle a level.
        let mut chain: Vec<[u32; 2]> = vec![[1, 0]];
        for level in 0..70 {
            chain.extend([[level, 7], [2 * level + 3, 0]]);
        }
        *chain.last_mut().unwrap() = [70, 7];
        let mesh = self::mesh(&scattered(71));
        let error = Bvh::from_links(&mesh, &chain, (0..71).collect()).unwrap_err();
        assert!(error.0.contains("deep"), "{error}");
    }

    #[test]
    fn an_empty_mesh_has_an_empty_leaf() {
        let tree = Bvh::build(&mesh(&[]), &Sequential);
        assert!(tree.nodes.len() == 1 && tree.nodes[0].is_leaf() && tree.nodes[0].triangles() == 0);
    }
}
