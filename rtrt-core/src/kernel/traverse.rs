//! A packet of rays through the tree of one mesh.

use crate::kernel::ray::Ray;
use crate::kernel::slab::meets;
use crate::kernel::span::Span;
use crate::kernel::triangle::{Triangle, meet};
use crate::lane::{Bits, Lane, Mask, Row, Select, Word};
use crate::layout::{Hit, NONE, Node, Object};

/// How many children can wait on the way down: one a level, so trees are built no deeper.
pub const STACK: usize = 64;

/// Everything that a ray can meet.
#[derive(Clone, Copy)]
pub struct Geometry<'a> {
    /// Objects, placed in the world.
    pub objects: &'a [Object],
    /// Nodes of all mesh trees.
    pub nodes: &'a [Node],
    /// Of each mesh: vertex indices, three a triangle, and the tree's references.
    pub words: &'a [u32],
    /// Vertex positions, object space.
    pub positions: &'a [[f32; 3]],
    /// The frame's magnitude (see [`crate::layout::Frame`]).
    pub magnitude: f32,
}

impl Geometry<'_> {
    /// The corners of a triangle of the object's mesh.
    #[inline(always)]
    pub fn corners(&self, object: &Object, triangle: u32) -> [u32; 3] {
        object.corners(self.words, triangle)
    }

    /// A triangle of the object's mesh, object space.
    #[inline(always)]
    pub fn triangle(&self, object: &Object, triangle: u32) -> Triangle {
        let [a, b, c] = self.corners(object, triangle);
        Triangle::new(self.positions[a as usize], self.positions[b as usize], self.positions[c as usize])
    }
}

/// The best hit found so far for one lane-group of rays.
///
/// `t` is also the limit of the search: a group that looks for nothing has a negative one.
#[derive(Clone, Copy)]
pub struct Best<L: Lane> {
    /// Where on the ray.
    pub t: L,
    /// The object.
    pub object: L::Bits,
    /// The triangle of the object's mesh.
    pub triangle: L::Bits,
    /// Barycentric weight of the second corner.
    pub u: L,
    /// Barycentric weight of the third corner.
    pub v: L,
}

/// A [`Best`] whose lanes are in memory, one after another.
#[derive(Clone, Copy)]
pub struct BestRows<L: Lane> {
    t: L::Row,
    object: <L::Bits as Bits>::Row,
    triangle: <L::Bits as Bits>::Row,
    u: L::Row,
    v: L::Row,
}

impl<L: Lane> Best<L> {
    /// The lanes one by one. Take them out once, before a loop over lanes.
    #[inline(always)]
    pub fn rows(&self) -> BestRows<L> {
        BestRows {
            t: self.t.row(),
            object: self.object.row(),
            triangle: self.triangle.row(),
            u: self.u.row(),
            v: self.v.row(),
        }
    }
}

impl<L: Lane> BestRows<L> {
    /// The object in one lane.
    #[inline(always)]
    pub fn object(&self, lane: usize) -> u32 {
        self.object.at(lane)
    }
    /// The triangle in one lane.
    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> u32 {
        self.triangle.at(lane)
    }
    /// The weights of the second and third corner in one lane.
    #[inline(always)]
    pub fn weights(&self, lane: usize) -> [f32; 2] {
        [self.u.at(lane), self.v.at(lane)]
    }
    /// The record of one lane.
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> Hit {
        let object = self.object.at(lane);
        if object == NONE {
            return Hit::MISS;
        }
        Hit {
            t: self.t.at(lane),
            object,
            triangle: self.triangle.at(lane),
            u: self.u.at(lane),
            v: self.v.at(lane),
        }
    }
}

impl Best<f32> {
    /// A lane of width 1 from its record.
    #[inline(always)]
    pub fn new(hit: &Hit) -> Self {
        Self { t: hit.t, object: Word(hit.object), triangle: Word(hit.triangle), u: hit.u, v: hit.v }
    }
}

/// The largest limit in the first `count` groups; negative when every ray is done.
#[inline(always)]
pub fn widest<L: Lane, const G: usize>(best: &[Best<L>; G], count: usize) -> f32 {
    let mut limit = best[0].t;
    let mut g = 1;
    while g < count {
        limit = limit.max(best[g].t);
        g += 1;
    }
    let row = limit.row();
    let mut widest = row.at(0);
    let mut lane = 1;
    while lane < L::WIDTH {
        widest = Lane::max(widest, row.at(lane));
        lane += 1;
    }
    widest
}

/// Meets the first `count` groups of a packet with one object and keeps in `best`, for each
/// ray, the least of what it holds and of the object's hits, by `(t, object, triangle)`.
/// With `ANY`, a ray that meets something at all gets the limit −1 instead, and is done.
///
/// `rays` are in the object's space and `span` bounds them. The result is a function of
/// the set of triangles: the tree, its order and the packet's shape only decide how soon
/// it is found. A node is passed over when its box is, for every ray, empty, behind the
/// start, or beyond the best hit; nested boxes have nested intervals and a hit lies in
/// its triangle's (see [`meet`]), so no hit is lost.
///
/// The first ray group that meets a node decides for the packet; only when it fails are
/// the others asked, after [`Span`] (Wald, Slusallek, Benthin and Wagner's packets, with
/// Reshetov's first-hit tests).
#[inline(always)]
pub fn traverse<L: Lane, const G: usize, const ANY: bool>(
    geometry: &Geometry<'_>,
    object_index: u32,
    rays: &[Ray<L>; G],
    count: usize,
    span: &Span,
    best: &mut [Best<L>; G],
) {
    let object = &geometry.objects[object_index as usize];
    let mut stack = [0_u32; STACK];
    let mut waiting = 0_usize;
    let mut index = 0_u32;
    let mut first = 0_usize;
    let mut limit = widest(best, count);
    loop {
        let node = geometry.nodes[(object.root + index) as usize];
        let mut group = first;
        if !meets(&rays[group], &node.low, &node.high, best[group].t).any() {
            if G > 1 && span.misses(&node.low, &node.high, limit) {
                group = count;
            } else {
                group += 1;
                while group < count && !meets(&rays[group], &node.low, &node.high, best[group].t).any() {
                    group += 1;
                }
            }
        }
        if group < count {
            if !node.is_leaf() {
                // Near child first: the lower one when the packet's first ray goes up.
                let axis = node.kind;
                let rising = &rays[group].direction;
                let slope = if axis == 0 {
                    rising.x
                } else if axis == 1 {
                    rising.y
                } else {
                    rising.z
                };
                let far_first = (slope.row().at(0) < 0.0) as u32;
                stack[waiting] = (node.first + 1 - far_first) | (group as u32) << 26;
                waiting += 1;
                index = node.first + far_first;
                first = group;
                continue;
            }
            let changed = leaf::<L, G, ANY>(geometry, object, object_index, &node, group, rays, count, best);
            if (G > 1 || ANY) && changed {
                limit = widest(best, count);
                if ANY && limit < 0.0 {
                    return;
                }
            }
        }
        if waiting == 0 {
            return;
        }
        waiting -= 1;
        index = stack[waiting] & 0x03ff_ffff;
        first = (stack[waiting] >> 26) as usize;
    }
}

/// Meets the groups from `group` on with every triangle of a leaf; whether any was met.
#[inline(always)]
fn leaf<L: Lane, const G: usize, const ANY: bool>(
    geometry: &Geometry<'_>,
    object: &Object,
    object_index: u32,
    node: &Node,
    group: usize,
    rays: &[Ray<L>; G],
    count: usize,
    best: &mut [Best<L>; G],
) -> bool {
    let mut changed = false;
    let mut groups = 1_u32 << group;
    if G > 1 {
        let mut g = group + 1;
        while g < count {
            if meets(&rays[g], &node.low, &node.high, best[g].t).any() {
                groups |= 1 << g;
            }
            g += 1;
        }
    }
    let mut i = 0;
    while i < node.triangles() {
        let id = geometry.words[(object.first_reference + node.first + i) as usize];
        let triangle = geometry.triangle(object, id);
        let mut left = groups;
        while left != 0 {
            let g = if G == 1 { 0 } else { left.trailing_zeros() as usize };
            left &= left - 1;
            changed |= keep::<L, ANY>(&rays[g], &triangle, object_index, id, &mut best[g]);
        }
        i += 1;
    }
    changed
}

/// Meets one group with one triangle; whether any ray met it.
#[inline(always)]
fn keep<L: Lane, const ANY: bool>(
    ray: &Ray<L>,
    triangle: &Triangle,
    object: u32,
    id: u32,
    best: &mut Best<L>,
) -> bool {
    let found = meet(ray, triangle, best.t);
    if !found.mask.any() {
        return false;
    }
    if ANY {
        best.t = found.mask.select(best.t.like(-1.0), best.t);
        return true;
    }
    let (object, id) = (best.object.like(object), best.object.like(id));
    // Equal t: the lower object, then the lower triangle.
    let earlier = object.less_than(best.object) | (object.equal(best.object) & id.less_than(best.triangle));
    let closer = found.mask & (found.t.less_than(best.t) | (found.t.less_equal(best.t) & earlier));
    best.t = closer.select(found.t, best.t);
    best.u = closer.select(found.u, best.u);
    best.v = closer.select(found.v, best.v);
    best.object = closer.select(object, best.object);
    best.triangle = closer.select(id, best.triangle);
    true
}
