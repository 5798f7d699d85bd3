//! A packet of rays through the tree of one mesh.

use crate::kernel::ray::Ray;
use crate::kernel::slab::{RelativeBox, intersects};
use crate::kernel::sphere::{Chord, ENTRY, EXIT};
use crate::kernel::tiles::{TILES, Tiles};
use crate::kernel::triangle::{Intersection, Triangle, intersect};
use crate::lane::{Bits, Lane, Mask, Row, Select, Word};
use crate::layout::{Hit, Instance, NONE, Node};
use core::ops::Mul;

/// How many children can wait on the way down: one a level, so trees are built no deeper.
pub const STACK: usize = 64;

/// So many tiles of a packet ask a box ray by ray: that is as quick, and exact. One more where rays
/// start apart, as the bounds of their tiles take longer to ask and say less.
const RAY_TEST_MAX_TILES: [u32; 2] = [5, 6];

/// Everything that a ray can meet.
#[derive(Clone, Copy)]
pub struct Geometry<'a> {
    /// Objects, placed in the world.
    pub instances: &'a [Instance],
    /// Nodes of all mesh trees.
    pub nodes: &'a [Node],
    /// Vertex indices of all meshes, three a triangle, in the order of their trees' leaves.
    pub mesh_data: &'a [u32],
    /// Vertex positions, object space.
    pub positions: &'a [[f32; 3]],
    /// Texels, for searches that ask what is not opaque; any words for the others.
    pub texels: &'a [u32],
    /// The frame's magnitude (see [`crate::layout::Frame`]).
    pub magnitude: f32,
}

impl Geometry<'_> {
    /// The corners of a triangle of the instance's mesh.
    #[inline(always)]
    pub fn corners(&self, instance: &Instance, triangle: u32) -> [u32; 3] {
        instance.corners(self.mesh_data, triangle)
    }

    /// A triangle of the instance's mesh, object space.
    #[inline(always)]
    pub fn triangle(&self, instance: &Instance, triangle: u32) -> Triangle {
        let [a, b, c] = self.corners(instance, triangle);
        Triangle::new(self.positions[a as usize], self.positions[b as usize], self.positions[c as usize])
    }
}

/// The best hit found so far for one lane-group of rays.
///
/// `t` is also the limit of the search: a group that looks for nothing has a negative one.
#[derive(Clone, Copy)]
pub struct ClosestHit<L: Lane> {
    /// Where on the ray.
    pub t: L,
    /// The instance.
    pub instance: L::Bits,
    /// The triangle of the instance's mesh.
    pub triangle: L::Bits,
    /// Barycentric weight of the second corner.
    pub u: L,
    /// Barycentric weight of the third corner.
    pub v: L,
}

/// A [`ClosestHit`] whose lanes are in memory, one after another.
#[derive(Clone, Copy)]
pub struct ClosestHitRows<L: Lane> {
    t: L::Row,
    instance: <L::Bits as Bits>::Row,
    triangle: <L::Bits as Bits>::Row,
    u: L::Row,
    v: L::Row,
}

impl<L: Lane> ClosestHit<L> {
    /// The lanes one by one. Take them out once, before a loop over lanes.
    #[inline(always)]
    pub fn rows(&self) -> ClosestHitRows<L> {
        ClosestHitRows {
            t: self.t.row(),
            instance: self.instance.row(),
            triangle: self.triangle.row(),
            u: self.u.row(),
            v: self.v.row(),
        }
    }
}

impl<L: Lane> ClosestHitRows<L> {
    /// The instance in one lane.
    #[inline(always)]
    pub fn instance(&self, lane: usize) -> u32 {
        self.instance.at(lane)
    }
    /// The triangle in one lane.
    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> u32 {
        self.triangle.at(lane)
    }
    /// The record of one lane.
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> Hit {
        let instance = self.instance.at(lane);
        if instance == NONE {
            return Hit::MISS;
        }
        Hit {
            t: self.t.at(lane),
            instance,
            triangle: self.triangle.at(lane),
            u: self.u.at(lane),
            v: self.v.at(lane),
        }
    }
}

impl ClosestHit<f32> {
    /// A lane of width 1 from its record.
    #[inline(always)]
    pub fn new(hit: &Hit) -> Self {
        Self { t: hit.t, instance: Word(hit.instance), triangle: Word(hit.triangle), u: hit.u, v: hit.v }
    }
}

/// What a search keeps of the triangles that rays meet.
pub trait HitFilter<L: Lane>: Copy {
    /// Whether rays are done before they have hit_mask everything: they then have the limit −1.
    const TERMINATES: bool;
    /// Whether only fronts count, of instances that are not double-sided.
    const CULLS_BACK_FACES: bool;

    /// Keeps, in `best` or in itself, what a group of rays has hit_mask, if any of them has; whether
    /// a limit has changed.
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        id: u32,
        found: &Intersection<L>,
        best: &mut ClosestHit<L>,
    ) -> bool;
}

/// The least hit, by `(t, instance, triangle)`, of what the camera sees.
#[derive(Clone, Copy)]
pub struct Closest;

impl<L: Lane> HitFilter<L> for Closest {
    const TERMINATES: bool = false;
    const CULLS_BACK_FACES: bool = true;

    #[inline(always)]
    fn accept(
        &mut self,
        _: &Geometry<'_>,
        instance: u32,
        id: u32,
        found: &Intersection<L>,
        best: &mut ClosestHit<L>,
    ) -> bool {
        if !found.mask.any() {
            return false;
        }
        keep_closest(found, found.mask, instance, id, best);
        true
    }
}

/// Whether there is any hit, from either side.
#[derive(Clone, Copy)]
pub struct Any;

impl<L: Lane> HitFilter<L> for Any {
    const TERMINATES: bool = true;
    const CULLS_BACK_FACES: bool = false;

    #[inline(always)]
    fn accept(
        &mut self,
        _: &Geometry<'_>,
        _: u32,
        _: u32,
        found: &Intersection<L>,
        best: &mut ClosestHit<L>,
    ) -> bool {
        if !found.mask.any() {
            return false;
        }
        best.t = found.mask.select(best.t.broadcast(-1.0), best.t);
        true
    }
}

/// Meets the tiles of a packet whose bits are set in `active` with one instance, or a part of one, and keeps in
/// `best`, for each ray, what its group's search keeps of the instance's hits. `limits` are those
/// of the tiles.
///
/// The rays are in the object's space. The result is a function of the set of triangles: the
/// tree, its order and the packet's shape only decide how soon it is found. A node is passed
/// over when its box is, for every ray, empty, behind the start, or beyond the best hit;
/// nested boxes have nested intervals and a hit lies in its triangle's (see [`intersect`]), so no
/// hit is lost.
///
/// A packet of one group, as a GPU invocation has it, asks its rays; a larger one asks its
/// [`Tiles`], and takes those that hit_mask a node further down.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn traverse<L: Lane + Mul<O, Output = L>, O: Lane, S: HitFilter<L>, const G: usize>(
    geometry: &Geometry<'_>,
    instance_index: u32,
    rays: &[Ray<L, O>; G],
    tiles: &Tiles<L, G>,
    active: u32,
    limits: &mut [f32; TILES],
    filters: &mut [S; G],
    best: &mut [ClosestHit<L>; G],
) {
    let instance = &geometry.instances[instance_index as usize];
    let instance_index = instance.source_instance(instance_index);
    // Its way up or down decides for all which child is nearer.
    let rising = rays[first_active_group::<L, G>(active)].direction.lane(0);
    let mut stack = [0_u32; STACK];
    let mut stack_active = [0_u32; STACK];
    let mut waiting = 0_usize;
    // So many of those that wait were hit_mask before the last hit was found.
    let mut stale = 0_usize;
    let mut index = instance.start;
    let mut active = active;
    loop {
        let node = geometry.nodes[index as usize];
        let mut near_active = 0;
        if node.is_leaf() {
            if leaf(geometry, instance, instance_index, &node, active, rays, limits, filters, best) {
                if S::TERMINATES && is_done(best, limits) {
                    return;
                }
                stale = waiting;
            }
        } else {
            // Near child first: the lower one when the packet's first ray goes up.
            let far_first = (rising[node.kind as usize] < 0.0) as u32;
            let children = instance.root + node.first;
            let (near, far) = (children + far_first, children + 1 - far_first);
            near_active = hit_mask(geometry, near, rays, tiles, active, limits, best);
            let far_active = hit_mask(geometry, far, rays, tiles, active, limits, best);
            index = near;
            active = near_active;
            if near_active == 0 {
                index = far;
                active = far_active;
                near_active = far_active;
            } else if far_active != 0 {
                stack[waiting] = far;
                if G > 1 {
                    stack_active[waiting] = far_active;
                }
                waiting += 1;
            }
        }
        while near_active == 0 {
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            index = stack[waiting];
            active = if G > 1 { stack_active[waiting] } else { 1 };
            if waiting < stale {
                stale = waiting;
                active = hit_mask(geometry, index, rays, tiles, active, limits, best);
            }
            near_active = active;
        }
    }
}

/// Meets the tiles of a packet whose bits are set in `active` with one sphere, as [`traverse`]
/// does with a mesh. The rays are in world space.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn intersect_sphere<L: Lane + Mul<O, Output = L>, O: Lane, S: HitFilter<L>, const G: usize>(
    geometry: &Geometry<'_>,
    instance_index: u32,
    rays: &[Ray<L, O>; G],
    active: u32,
    limits: &mut [f32; TILES],
    filters: &mut [S; G],
    best: &mut [ClosestHit<L>; G],
) {
    let instance = &geometry.instances[instance_index as usize];
    let last = if is_one_sided::<L, S>(instance) { ENTRY } else { EXIT };
    let mut left = active;
    while left != 0 {
        let tile = if G == 1 { 0 } else { left.trailing_zeros() as usize };
        left &= left - 1;
        let (mut g, end) = if G == 1 { (0, 1) } else { Tiles::<L, G>::groups(tile) };
        let mut closer = false;
        while g < end {
            let ray = if instance.is_identity == 1 { rays[g] } else { rays[g].to_object(instance) };
            let chord = Chord::new(&ray);
            let mut side = ENTRY;
            while side <= last {
                let found = chord.side(ray.direction, side, best[g].t);
                closer |= filters[g].accept(geometry, instance_index, side, &found, &mut best[g]);
                side += 1;
            }
            g += 1;
        }
        if G > 1 && closer {
            limits[tile] = Tiles::<L, G>::limit(best, tile);
        }
    }
}

/// The tiles of `active` that may meet the node's box.
#[inline(always)]
fn hit_mask<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize>(
    geometry: &Geometry<'_>,
    node: u32,
    rays: &[Ray<L, O>; G],
    tiles: &Tiles<L, G>,
    active: u32,
    limits: &[f32; TILES],
    best: &[ClosestHit<L>; G],
) -> u32 {
    let node = geometry.nodes[node as usize];
    if G == 1 || active.count_ones() <= RAY_TEST_MAX_TILES[(O::WIDTH == L::WIDTH) as usize] {
        ray_hit_mask(rays, &node.low, &node.high, active, best)
    } else {
        tiles.hit_mask::<O>(&node.low, &node.high, limits, active)
    }
}

/// Whether a search asks for the front of an instance only.
#[inline(always)]
fn is_one_sided<L: Lane, S: HitFilter<L>>(instance: &Instance) -> bool {
    S::CULLS_BACK_FACES && instance.double_sided == 0
}

/// The first group of the first tile in `active`.
#[inline(always)]
fn first_active_group<L: Lane, const G: usize>(active: u32) -> usize {
    if G == 1 { 0 } else { Tiles::<L, G>::groups(active.trailing_zeros() as usize).0 }
}

/// The tiles of `active` in which a ray meets the box.
#[inline(always)]
pub fn ray_hit_mask<L: Lane + Mul<O, Output = L>, O: Lane, const G: usize>(
    rays: &[Ray<L, O>; G],
    low: &[f32; 3],
    high: &[f32; 3],
    active: u32,
    best: &[ClosestHit<L>; G],
) -> u32 {
    let shared = RelativeBox::new(rays[first_active_group::<L, G>(active)].origin, low, high);
    if G == 1 {
        return intersects(&rays[0], &shared, best[0].t).any() as u32;
    }
    let mut hit_mask = 0;
    let mut left = active;
    while left != 0 {
        let tile = left.trailing_zeros();
        left &= left - 1;
        let (mut g, end) = Tiles::<L, G>::groups(tile as usize);
        while g < end {
            let ray = &rays[g];
            let relative = if O::WIDTH < L::WIDTH { shared } else { RelativeBox::new(ray.origin, low, high) };
            hit_mask |= (intersects(ray, &relative, best[g].t).any() as u32) << tile;
            g += 1;
        }
    }
    hit_mask
}

/// Whether no ray looks for anything.
#[inline(always)]
fn is_done<L: Lane, const G: usize>(best: &[ClosestHit<L>; G], limits: &[f32; TILES]) -> bool {
    if G == 1 { best[0].t.largest() < 0.0 } else { Tiles::<L, G>::widest(best[0].t.token(), limits) < 0.0 }
}

/// Meets the tiles whose bits are set in `hit_mask` with every triangle of a leaf; whether any
/// limit has changed.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
fn leaf<L: Lane + Mul<O, Output = L>, O: Lane, S: HitFilter<L>, const G: usize>(
    geometry: &Geometry<'_>,
    instance: &Instance,
    instance_index: u32,
    node: &Node,
    hit_mask: u32,
    rays: &[Ray<L, O>; G],
    limits: &mut [f32; TILES],
    filters: &mut [S; G],
    best: &mut [ClosestHit<L>; G],
) -> bool {
    let one_sided = is_one_sided::<L, S>(instance);
    let mut changed = 0_u32;
    let mut id = node.first;
    let end = id + node.triangles();
    while id < end {
        let triangle = geometry.triangle(instance, id);
        let shared = triangle.relative_to(rays[first_active_group::<L, G>(hit_mask)].origin);
        let is_of_all = G == 1 || O::WIDTH < L::WIDTH;
        let turns_away = one_sided && is_of_all && !shared.front(best[0].t).any();
        let mut left = if turns_away { 0 } else { hit_mask };
        while left != 0 {
            let tile = if G == 1 { 0 } else { left.trailing_zeros() as usize };
            left &= left - 1;
            let (mut g, end) = if G == 1 { (0, 1) } else { Tiles::<L, G>::groups(tile) };
            let mut closer = false;
            while g < end {
                let seen = if O::WIDTH < L::WIDTH { shared } else { triangle.relative_to(rays[g].origin) };
                let mut found = intersect(&rays[g], &triangle, &seen, best[g].t);
                if one_sided {
                    found.mask = found.mask & seen.front(best[g].t);
                }
                closer |= filters[g].accept(geometry, instance_index, id, &found, &mut best[g]);
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
/// that it has hit_mask.
#[inline(always)]
pub fn keep_closest<L: Lane>(
    found: &Intersection<L>,
    mask: L::Mask,
    instance: u32,
    id: u32,
    best: &mut ClosestHit<L>,
) {
    let (instance, id) = (best.instance.broadcast(instance), best.instance.broadcast(id));
    // Equal t: the lower instance, then the lower triangle.
    let earlier = instance.lt(best.instance) | (instance.eq(best.instance) & id.lt(best.triangle));
    let closer = mask & (found.t.lt(best.t) | (found.t.le(best.t) & earlier));
    best.t = closer.select(found.t, best.t);
    best.u = closer.select(found.u, best.u);
    best.v = closer.select(found.v, best.v);
    best.instance = closer.select(instance, best.instance);
    best.triangle = closer.select(id, best.triangle);
}
