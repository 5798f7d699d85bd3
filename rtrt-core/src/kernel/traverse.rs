//! A packet of rays through the tree of one mesh.

use crate::kernel::ray::Ray;
use crate::kernel::slab::{Around, meets};
use crate::kernel::span::Span;
use crate::kernel::triangle::{Meeting, Triangle, meet};
use crate::lane::{Bits, Lane, Mask, Row, Select, Word};
use crate::layout::{Hit, NONE, Node, Object};
use core::ops::Mul;

/// How many children can wait on the way down: one a level, so trees are built no deeper.
pub const STACK: usize = 64;

/// Everything that a ray can meet.
#[derive(Clone, Copy)]
pub struct Geometry<'a> {
    /// Objects, placed in the world.
    pub objects: &'a [Object],
    /// Nodes of all mesh trees.
    pub nodes: &'a [Node],
    /// Vertex indices of all meshes, three a triangle, in the order of their trees' leaves.
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
        let first = (object.first_index + 3 * triangle) as usize;
        let base = object.first_vertex;
        [base + self.words[first], base + self.words[first + 1], base + self.words[first + 2]]
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
    limit.largest()
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
pub fn traverse<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize, const ANY: bool>(
    geometry: &Geometry<'_>,
    object_index: u32,
    rays: &[Ray<L, O>; G],
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
        let shared = Around::new(rays[0].origin, &node.low, &node.high);
        let mut group = first;
        if !reaches(rays, group, &node, &shared, best) {
            if G > 1 && span.misses(&node.low, &node.high, limit) {
                group = count;
            } else {
                group += 1;
                while group < count && !reaches(rays, group, &node, &shared, best) {
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
            let mut groups = 1_u32 << group;
            if G > 1 {
                let mut g = group + 1;
                while g < count {
                    groups |= (reaches(rays, g, &node, &shared, best) as u32) << g;
                    g += 1;
                }
            }
            let changed = leaf::<L, O, G, ANY>(geometry, object, object_index, &node, groups, rays, best);
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

/// Whether any ray of the group meets the node's box. `shared` is the box seen from the
/// first ray's start.
#[inline(always)]
fn reaches<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize>(
    rays: &[Ray<L, O>; G],
    group: usize,
    node: &Node,
    shared: &Around<O>,
    best: &[Best<L>; G],
) -> bool {
    let ray = &rays[group];
    if O::WIDTH < L::WIDTH {
        meets(ray, shared, best[group].t).any()
    } else {
        meets(ray, &Around::new(ray.origin, &node.low, &node.high), best[group].t).any()
    }
}

/// Meets the groups whose bits are set with every triangle of a leaf; whether any was met.
#[inline(always)]
fn leaf<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize, const ANY: bool>(
    geometry: &Geometry<'_>,
    object: &Object,
    object_index: u32,
    node: &Node,
    groups: u32,
    rays: &[Ray<L, O>; G],
    best: &mut [Best<L>; G],
) -> bool {
    let mut changed = false;
    let mut id = node.first;
    let end = id + node.triangles();
    while id < end {
        let triangle = geometry.triangle(object, id);
        let shared = triangle.seen_from(rays[0].origin);
        let mut left = groups;
        while left != 0 {
            let g = if G == 1 { 0 } else { left.trailing_zeros() as usize };
            left &= left - 1;
            let seen = if O::WIDTH < L::WIDTH { shared } else { triangle.seen_from(rays[g].origin) };
            let found = meet(&rays[g], &triangle, &seen, best[g].t);
            changed |= keep::<L, ANY>(&found, object_index, id, &mut best[g]);
        }
        id += 1;
    }
    changed
}

/// Keeps the least of what a group has found so far and the triangle it has met, if any ray
/// of it has; whether one has.
#[inline(always)]
fn keep<L: Lane, const ANY: bool>(found: &Meeting<L>, object: u32, id: u32, best: &mut Best<L>) -> bool {
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
