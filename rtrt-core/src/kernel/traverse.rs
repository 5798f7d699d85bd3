//! A packet of rays through the tree of one mesh.

use crate::kernel::ray::Ray;
use crate::kernel::slab::{Around, meets};
use crate::kernel::sphere::{Chord, ENTRY, EXIT};
use crate::kernel::tiles::{TILES, Tiles};
use crate::kernel::triangle::{Meeting, Triangle, meet};
use crate::lane::{Bits, Lane, Mask, Row, Select, Word};
use crate::layout::{Hit, NONE, Node, Object};
use core::ops::Mul;

/// How many children can wait on the way down: one a level, so trees are built no deeper.
pub const STACK: usize = 64;

/// So many tiles of a packet ask a box ray by ray: that is as quick, and exact. One more where rays
/// start apart, as the bounds of their tiles take longer to ask and say less.
const FEW: [u32; 2] = [5, 6];

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
    /// Texels, for searches that ask what is not opaque; any words for the others.
    pub texels: &'a [u32],
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

/// What a search keeps of the triangles that rays meet.
pub trait Search<L: Lane>: Copy {
    /// Whether rays are done before they have met everything: they then have the limit −1.
    const ENDS: bool;
    /// Whether only fronts count, of objects that are not double-sided.
    const FRONTS: bool;

    /// Keeps, in `best` or in itself, what a group of rays has met, if any of them has; whether
    /// a limit has changed.
    fn keep(
        &mut self,
        geometry: &Geometry<'_>,
        object: u32,
        id: u32,
        found: &Meeting<L>,
        best: &mut Best<L>,
    ) -> bool;
}

/// The least hit, by `(t, object, triangle)`, of what the camera sees.
#[derive(Clone, Copy)]
pub struct Closest;

impl<L: Lane> Search<L> for Closest {
    const ENDS: bool = false;
    const FRONTS: bool = true;

    #[inline(always)]
    fn keep(
        &mut self,
        _: &Geometry<'_>,
        object: u32,
        id: u32,
        found: &Meeting<L>,
        best: &mut Best<L>,
    ) -> bool {
        if !found.mask.any() {
            return false;
        }
        keep(found, found.mask, object, id, best);
        true
    }
}

/// Whether there is any hit, from either side.
#[derive(Clone, Copy)]
pub struct Any;

impl<L: Lane> Search<L> for Any {
    const ENDS: bool = true;
    const FRONTS: bool = false;

    #[inline(always)]
    fn keep(&mut self, _: &Geometry<'_>, _: u32, _: u32, found: &Meeting<L>, best: &mut Best<L>) -> bool {
        if !found.mask.any() {
            return false;
        }
        best.t = found.mask.select(best.t.like(-1.0), best.t);
        true
    }
}

/// Meets the tiles of a packet whose bits are set in `among` with one object, or a part of one, and keeps in
/// `best`, for each ray, what its group's search keeps of the object's hits. `limits` are those
/// of the tiles.
///
/// The rays are in the object's space. The result is a function of the set of triangles: the
/// tree, its order and the packet's shape only decide how soon it is found. A node is passed
/// over when its box is, for every ray, empty, behind the start, or beyond the best hit;
/// nested boxes have nested intervals and a hit lies in its triangle's (see [`meet`]), so no
/// hit is lost.
///
/// A packet of one group, as a GPU invocation has it, asks its rays; a larger one asks its
/// [`Tiles`], and takes those that met a node further down.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn traverse<L: Lane + Mul<O, Output = L>, O: Lane, S: Search<L>, const G: usize>(
    geometry: &Geometry<'_>,
    object_index: u32,
    rays: &[Ray<L, O>; G],
    tiles: &Tiles<L, G>,
    among: u32,
    limits: &mut [f32; TILES],
    searches: &mut [S; G],
    best: &mut [Best<L>; G],
) {
    let object = &geometry.objects[object_index as usize];
    let object_index = object.whole(object_index);
    // Its way up or down decides for all which child is nearer.
    let rising = rays[leader::<L, G>(among)].direction.lane(0);
    let mut stack = [0_u32; STACK];
    let mut stack_among = [0_u32; STACK];
    let mut waiting = 0_usize;
    // So many of those that wait were met before the last hit was found.
    let mut stale = 0_usize;
    let mut index = object.start;
    let mut among = among;
    loop {
        let node = geometry.nodes[index as usize];
        let mut near_among = 0;
        if node.is_leaf() {
            if leaf(geometry, object, object_index, &node, among, rays, limits, searches, best) {
                if S::ENDS && is_done(best, limits) {
                    return;
                }
                stale = waiting;
            }
        } else {
            // Near child first: the lower one when the packet's first ray goes up.
            let far_first = (rising[node.kind as usize] < 0.0) as u32;
            let children = object.root + node.first;
            let (near, far) = (children + far_first, children + 1 - far_first);
            near_among = met(geometry, near, rays, tiles, among, limits, best);
            let far_among = met(geometry, far, rays, tiles, among, limits, best);
            index = near;
            among = near_among;
            if near_among == 0 {
                index = far;
                among = far_among;
                near_among = far_among;
            } else if far_among != 0 {
                stack[waiting] = far;
                if G > 1 {
                    stack_among[waiting] = far_among;
                }
                waiting += 1;
            }
        }
        while near_among == 0 {
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            index = stack[waiting];
            among = if G > 1 { stack_among[waiting] } else { 1 };
            if waiting < stale {
                stale = waiting;
                among = met(geometry, index, rays, tiles, among, limits, best);
            }
            near_among = among;
        }
    }
}

/// Meets the tiles of a packet whose bits are set in `among` with one sphere, as [`traverse`]
/// does with a mesh. The rays are in world space.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn meet_sphere<L: Lane + Mul<O, Output = L>, O: Lane, S: Search<L>, const G: usize>(
    geometry: &Geometry<'_>,
    object_index: u32,
    rays: &[Ray<L, O>; G],
    among: u32,
    limits: &mut [f32; TILES],
    searches: &mut [S; G],
    best: &mut [Best<L>; G],
) {
    let object = &geometry.objects[object_index as usize];
    let last = if is_one_sided::<L, S>(object) { ENTRY } else { EXIT };
    let mut left = among;
    while left != 0 {
        let tile = if G == 1 { 0 } else { left.trailing_zeros() as usize };
        left &= left - 1;
        let (mut g, end) = if G == 1 { (0, 1) } else { Tiles::<L, G>::groups(tile) };
        let mut closer = false;
        while g < end {
            let ray = if object.is_identity == 1 { rays[g] } else { rays[g].to_object(object) };
            let chord = Chord::new(&ray);
            let mut side = ENTRY;
            while side <= last {
                let found = chord.side(ray.direction, side, best[g].t);
                closer |= searches[g].keep(geometry, object_index, side, &found, &mut best[g]);
                side += 1;
            }
            g += 1;
        }
        if G > 1 && closer {
            limits[tile] = Tiles::<L, G>::limit(best, tile);
        }
    }
}

/// The tiles of `among` that may meet the node's box.
#[inline(always)]
fn met<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize>(
    geometry: &Geometry<'_>,
    node: u32,
    rays: &[Ray<L, O>; G],
    tiles: &Tiles<L, G>,
    among: u32,
    limits: &[f32; TILES],
    best: &[Best<L>; G],
) -> u32 {
    let node = geometry.nodes[node as usize];
    if G == 1 || among.count_ones() <= FEW[(O::WIDTH == L::WIDTH) as usize] {
        met_by_rays(rays, &node.low, &node.high, among, best)
    } else {
        tiles.meets::<O>(&node.low, &node.high, limits, among)
    }
}

/// Whether a search asks for the front of an object only.
#[inline(always)]
fn is_one_sided<L: Lane, S: Search<L>>(object: &Object) -> bool {
    S::FRONTS && object.double_sided == 0
}

/// The first group of the first tile in `among`.
#[inline(always)]
fn leader<L: Lane, const G: usize>(among: u32) -> usize {
    if G == 1 { 0 } else { Tiles::<L, G>::groups(among.trailing_zeros() as usize).0 }
}

/// The tiles of `among` in which a ray meets the box.
#[inline(always)]
pub fn met_by_rays<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize>(
    rays: &[Ray<L, O>; G],
    low: &[f32; 3],
    high: &[f32; 3],
    among: u32,
    best: &[Best<L>; G],
) -> u32 {
    let shared = Around::new(rays[leader::<L, G>(among)].origin, low, high);
    if G == 1 {
        return meets(&rays[0], &shared, best[0].t).any() as u32;
    }
    let mut met = 0;
    let mut left = among;
    while left != 0 {
        let tile = left.trailing_zeros();
        left &= left - 1;
        let (mut g, end) = Tiles::<L, G>::groups(tile as usize);
        while g < end {
            let ray = &rays[g];
            let around = if O::WIDTH < L::WIDTH { shared } else { Around::new(ray.origin, low, high) };
            met |= (meets(ray, &around, best[g].t).any() as u32) << tile;
            g += 1;
        }
    }
    met
}

/// Whether no ray looks for anything.
#[inline(always)]
fn is_done<L: Lane, const G: usize>(best: &[Best<L>; G], limits: &[f32; TILES]) -> bool {
    if G == 1 { best[0].t.largest() < 0.0 } else { Tiles::<L, G>::widest(best[0].t.token(), limits) < 0.0 }
}

/// Meets the tiles whose bits are set in `met` with every triangle of a leaf; whether any
/// limit has changed.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
fn leaf<L: Lane + Mul<O, Output = L>, O: Lane, S: Search<L>, const G: usize>(
    geometry: &Geometry<'_>,
    object: &Object,
    object_index: u32,
    node: &Node,
    met: u32,
    rays: &[Ray<L, O>; G],
    limits: &mut [f32; TILES],
    searches: &mut [S; G],
    best: &mut [Best<L>; G],
) -> bool {
    let one_sided = is_one_sided::<L, S>(object);
    let mut changed = 0_u32;
    let mut id = node.first;
    let end = id + node.triangles();
    while id < end {
        let triangle = geometry.triangle(object, id);
        let shared = triangle.seen_from(rays[leader::<L, G>(met)].origin);
        let is_of_all = G == 1 || O::WIDTH < L::WIDTH;
        let turns_away = one_sided && is_of_all && !shared.front(best[0].t).any();
        let mut left = if turns_away { 0 } else { met };
        while left != 0 {
            let tile = if G == 1 { 0 } else { left.trailing_zeros() as usize };
            left &= left - 1;
            let (mut g, end) = if G == 1 { (0, 1) } else { Tiles::<L, G>::groups(tile) };
            let mut closer = false;
            while g < end {
                let seen = if O::WIDTH < L::WIDTH { shared } else { triangle.seen_from(rays[g].origin) };
                let mut found = meet(&rays[g], &triangle, &seen, best[g].t);
                if one_sided {
                    found.mask = found.mask & seen.front(best[g].t);
                }
                closer |= searches[g].keep(geometry, object_index, id, &found, &mut best[g]);
                g += 1;
            }
            changed |= (closer as u32) << tile;
        }
        id += 1;
    }
    let mut left = changed;
    while G > 1 && left != 0 {
        let tile = left.trailing_zeros() as usize;
        left &= left - 1;
        limits[tile] = Tiles::<L, G>::limit(best, tile);
    }
    changed != 0
}

/// Keeps the least of what a group has found so far and, in the lanes of `mask`, the triangle
/// that it has met.
#[inline(always)]
pub fn keep<L: Lane>(found: &Meeting<L>, mask: L::Mask, object: u32, id: u32, best: &mut Best<L>) {
    let (object, id) = (best.object.like(object), best.object.like(id));
    // Equal t: the lower object, then the lower triangle.
    let earlier = object.less_than(best.object) | (object.equal(best.object) & id.less_than(best.triangle));
    let closer = mask & (found.t.less_than(best.t) | (found.t.less_equal(best.t) & earlier));
    best.t = closer.select(found.t, best.t);
    best.u = closer.select(found.u, best.u);
    best.v = closer.select(found.v, best.v);
    best.object = closer.select(object, best.object);
    best.triangle = closer.select(id, best.triangle);
}
