//! The search: a ray through the tree over the instances, and on through those of meshes.

use super::block::AskedBlock;
use super::instances::{Entry, Start};
use super::merged::{MergedLeaf, Space};
use super::ray::{Ray, ScaledRay, Sides};
use super::source::Parts;
use super::tree::{MeshTree, Tree};
use super::wide::{Asked, Range, Visitor, traverse};
use crate::kernel::ray::Ray as WorldRay;
use crate::kernel::slab::RelativeBox;
use crate::kernel::sphere::{Chord, ENTRY, EXIT};
use crate::kernel::triangle::{Intersection, Triangle, intersect, passing};
use crate::lane::Lane;
use crate::scene::Bounds;

/// What a search meets.
#[derive(Clone, Copy)]
pub(crate) struct Found {
    /// Of the scaled ray.
    pub t: f32,
    pub instance: u32,
    pub triangle: u32,
    pub u: f32,
    pub v: f32,
}

impl Found {
    /// Whether this comes before another: by `t`, then instance, then triangle.
    pub fn is_before(&self, other: &Self) -> bool {
        let numbers = |found: &Self| (found.instance, found.triangle);
        self.t < other.t || (self.t == other.t && numbers(self) < numbers(other))
    }
}

/// What becomes of the hits that a search meets, in any order.
pub(crate) trait Collect {
    /// How far the ray is still traced; below 0 if it is done.
    fn limit(&self) -> f32;
    /// Takes a hit that is not beyond the limit.
    fn take(&mut self, found: Found);
}

/// Of a search.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    /// The largest coordinate of the world and the ray's start.
    pub magnitude: f32,
    /// The groups of instances that count.
    pub mask: u32,
}

/// Shows `collect` every hit on the ray that can change the result.
#[inline(always)]
pub(crate) fn search<L: Lane, S: Parts>(
    token: L::Token,
    tree: &Tree,
    source: &S,
    asked: &Ray,
    scaled: &ScaledRay,
    limits: Limits,
    collect: &mut impl Collect,
) {
    let Limits { magnitude, mask } = limits;
    let skip = skipped(source, asked);
    let mut seen = Seen { tree, source, asked, mask, from: scaled.span.from, skip, collect };
    let merged = &tree.instances.merged;
    if !merged.leaves.is_empty() {
        let Space { is_identity, to_object, .. } = &merged.space;
        let local = Local::<L>::placed(token, scaled.ray, *is_identity, to_object);
        MergedLeaves::<L, S, _> { local: &local, seen: &mut seen }.search(token, 0);
    }
    if seen.collect.limit() < seen.from {
        return;
    }
    match tree.instances.start() {
        Start::Nowhere => {}
        Start::Leaf(number) => {
            let top = &tree.instances;
            let (root, pad) = (&top.tree.nodes[0], top.slacks[0][0] * magnitude);
            let (asked, Range { from, limit }) = (Asked::<f32>::new((), &scaled.ray, 0.0, 0.0), seen.range());
            if asked.enter_from(root, Some(pad), 0, [from, limit]).1 {
                Instances::<L, S, _, false> { token, ray: scaled.ray, seen }.leaf(number, 1);
            }
        }
        Start::Root => Instances::<L, S, _, true> { token, ray: scaled.ray, seen }.search(0, magnitude),
    }
}

/// The number of the instance that a ray skips.
#[inline(always)]
pub(super) fn skipped(source: &impl Parts, asked: &Ray) -> Option<u32> {
    asked.skip.filter(|skip| source.place_of(*skip).is_some()).map(|skip| skip.number)
}

/// A ray in the space of an instance, ready to ask the blocks of its mesh.
pub(super) struct Local<L> {
    ray: WorldRay<f32>,
    blocks: AskedBlock<L>,
}

impl<L: Lane> Local<L> {
    /// Of a ray in that space.
    #[inline(always)]
    pub fn new(token: L::Token, ray: WorldRay<f32>) -> Self {
        Self { ray, blocks: AskedBlock::new(token, &ray) }
    }

    /// Of a ray in the world.
    #[inline(always)]
    fn placed(token: L::Token, ray: WorldRay<f32>, is_identity: bool, to_object: &[[f32; 4]; 3]) -> Self {
        Self::new(token, if is_identity { ray } else { ray.transformed(to_object) })
    }

    /// The ray, ready to ask the nodes of the mesh. `bounds` are those of the mesh, or larger.
    #[inline(always)]
    fn nodes(&self, token: L::Token, Bounds { low, high }: &Bounds) -> Asked<L> {
        let reach = RelativeBox::new(self.ray.origin, low, high).reach();
        Asked::new(token, &self.ray, 0.0, passing(reach, low, high))
    }
}

/// What a ray sees, and who collects it.
pub(super) struct Seen<'a, S, C> {
    pub tree: &'a Tree,
    pub source: &'a S,
    pub asked: &'a Ray,
    pub mask: u32,
    pub from: f32,
    pub skip: Option<u32>,
    pub collect: &'a mut C,
}

impl<'a, S: Parts, C: Collect> Seen<'a, S, C> {
    /// Whether the ray sees an instance.
    #[inline(always)]
    pub fn sees(&self, number: u32, entry: &Entry) -> bool {
        self.skip != Some(number) && entry.mask & self.mask != 0
    }

    /// The range of `t` that is still searched.
    #[inline(always)]
    pub fn range(&self) -> Range {
        Range { from: self.from, limit: self.collect.limit() }
    }

    /// The triangles of an instance.
    #[inline(always)]
    pub fn triangles<'b, L>(
        &'b mut self,
        number: u32,
        entry: &Entry,
        local: &'b Local<L>,
    ) -> Triangles<'b, 'a, L, S, C> {
        Triangles { mesh: &self.tree.meshes[entry.mesh as usize], local, number, seen: self }
    }

    /// Passes a hit on if the ray asks for it.
    pub fn offer(&mut self, number: u32, triangle: u32, found: &Intersection<f32>, is_front: bool) {
        let is_side = match self.asked.sides {
            Sides::Fronts => is_front,
            Sides::Backs => !is_front,
            Sides::Both => true,
            Sides::Drawn => is_front || self.source.instances()[number as usize].double_sided == 1,
        };
        let counts = is_side
            && found.t >= self.from
            && !(self.asked.through_holes && self.source.is_hole(number, triangle, found));
        if counts {
            let &Intersection { t, u, v, .. } = found;
            self.collect.take(Found { t, instance: number, triangle, u, v });
        }
    }
}

/// Looks at leaves of meshes that stand in one space.
pub(super) struct MergedLeaves<'a, 'b, L: Lane, S, C> {
    pub local: &'a Local<L>,
    pub seen: &'a mut Seen<'b, S, C>,
}

impl<L: Lane, S: Parts, C: Collect> Visitor for MergedLeaves<'_, '_, L, S, C> {
    #[inline(always)]
    fn leaf(&mut self, leaf: u32, _: u32) -> f32 {
        let top = &self.seen.tree.instances;
        let MergedLeaf { instance, block, count } = top.merged.leaves[leaf as usize];
        let entry = &top.entries[instance as usize];
        if !entry.is_merged || !self.seen.sees(instance, entry) {
            return self.seen.collect.limit();
        }
        self.seen.triangles(instance, entry, self.local).leaf(block, count)
    }
}

impl<L: Lane, S: Parts, C: Collect> MergedLeaves<'_, '_, L, S, C> {
    /// Searches the tree from a node on.
    #[inline(always)]
    fn search(&mut self, token: L::Token, node: u32) {
        let (merged, range) = (&self.seen.tree.instances.merged, self.seen.range());
        let nodes = self.local.nodes(token, &merged.bounds);
        traverse(&merged.tree, node, None, &nodes, range, self);
    }

    /// The same in a function of its own.
    pub fn search_outlined(&mut self, token: L::Token, node: u32) {
        L::outlined(
            token,
            #[inline(always)]
            || self.search(token, node),
        );
    }
}

/// Looks at instances. `OUTLINED` leaves the search of a mesh to a function of its own, which costs a ray that meets one
/// mesh alone a tenth.
pub(super) struct Instances<'a, L: Lane, S, C, const OUTLINED: bool> {
    pub token: L::Token,
    pub ray: WorldRay<f32>,
    pub seen: Seen<'a, S, C>,
}

impl<L: Lane, S: Parts, C: Collect, const OUTLINED: bool> Visitor for Instances<'_, L, S, C, OUTLINED> {
    #[inline(always)]
    fn leaf(&mut self, number: u32, _: u32) -> f32 {
        let tree = self.seen.tree;
        let entry = &tree.instances.entries[number as usize];
        if !self.seen.sees(number, entry) {
            return self.seen.collect.limit();
        }
        let local = Local::<L>::placed(self.token, self.ray, entry.is_identity, &entry.to_object);
        let mut triangles = self.seen.triangles(number, entry, &local);
        if entry.is_sphere {
            triangles.sphere();
        } else if OUTLINED {
            triangles.search_outlined(self.token, 0);
        } else {
            triangles.search(self.token, 0);
        }
        self.seen.collect.limit()
    }
}

impl<L: Lane, S: Parts, C: Collect, const OUTLINED: bool> Instances<'_, L, S, C, OUTLINED> {
    /// Searches the tree from a node on. `magnitude` is the largest coordinate of the world and the ray's start.
    #[inline(always)]
    fn search(&mut self, node: u32, magnitude: f32) {
        let (top, range) = (&self.seen.tree.instances, self.seen.range());
        let nodes = Asked::<L>::new(self.token, &self.ray, magnitude, 0.0);
        traverse(&top.tree, node, Some(&top.slacks), &nodes, range, self);
    }

    /// The same in a function of its own.
    pub fn search_outlined(&mut self, node: u32, magnitude: f32) {
        L::outlined(
            self.token,
            #[inline(always)]
            || self.search(node, magnitude),
        );
    }
}

/// Looks at the triangles of one instance.
pub(super) struct Triangles<'a, 'b, L, S, C> {
    mesh: &'a MeshTree,
    /// In the instance's space.
    local: &'a Local<L>,
    number: u32,
    seen: &'a mut Seen<'b, S, C>,
}

impl<L: Lane, S: Parts, C: Collect> Visitor for Triangles<'_, '_, L, S, C> {
    #[inline(always)]
    fn leaf(&mut self, first: u32, count: u32) -> f32 {
        let (mesh, Local { ray, blocks }) = (self.mesh, self.local);
        for block in mesh.blocks(first, count) {
            let mut remaining = blocks.may_hit(block);
            while remaining != 0 {
                let lane = remaining.trailing_zeros();
                remaining &= remaining - 1;
                let [a, b, c] = block.triangle(lane as usize);
                let triangle = Triangle::new(a, b, c);
                let relative = triangle.relative_to(ray.origin);
                let found = intersect(ray, &relative, self.seen.collect.limit());
                if found.mask {
                    self.seen.offer(self.number, block.first + lane, &found, relative.front(found.t));
                }
            }
        }
        self.seen.collect.limit()
    }
}

impl<L: Lane, S: Parts, C: Collect> Triangles<'_, '_, L, S, C> {
    /// Searches the mesh's tree from a node on.
    #[inline(always)]
    fn search(&mut self, token: L::Token, node: u32) {
        let (mesh, range) = (self.mesh, self.seen.range());
        let nodes = self.local.nodes(token, &mesh.bounds);
        traverse(&mesh.tree, node, None, &nodes, range, self);
    }

    /// The same in a function of its own.
    pub fn search_outlined(&mut self, token: L::Token, node: u32) {
        L::outlined(
            token,
            #[inline(always)]
            || self.search(token, node),
        );
    }

    /// Asks a sphere.
    fn sphere(&mut self) {
        let ray = &self.local.ray;
        let chord = Chord::new(ray);
        for side in [ENTRY, EXIT] {
            let found = chord.side(ray.direction, side, self.seen.collect.limit());
            if found.mask {
                self.seen.offer(self.number, side, &found, side == ENTRY);
            }
        }
    }
}
