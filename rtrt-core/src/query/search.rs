//! The search: a ray through the tree over the instances, and on through those of meshes.

use super::block::AskedBlock;
use super::instances::Entry;
use super::merged::MergedLeaf;
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
    let skip = asked.skip.filter(|skip| source.place_of(*skip).is_some()).map(|skip| skip.number);
    let Limits { magnitude, mask } = limits;
    let top = &tree.instances;
    let mut seen = Seen { tree, source, asked, mask, from: scaled.from, skip, collect };
    if !top.merged.leaves.is_empty() {
        let space = &top.merged.space;
        let local = Local::new(token, scaled.ray, space.is_identity, &space.to_object, &top.merged.bounds);
        let range = Range { from: scaled.from, limit: seen.collect.limit() };
        let mut merged = MergedLeaves::<L, S, _> { local: &local, seen: &mut seen };
        traverse(&top.merged.tree, None, &local.nodes, range, &mut merged);
    }
    let range = Range { from: scaled.from, limit: seen.collect.limit() };
    if range.limit >= range.from {
        let wide = Asked::<L>::new(token, &scaled.ray, magnitude, 0.0);
        let mut instances = Instances::<L, S, _> { token, ray: scaled.ray, seen };
        traverse(&top.tree, Some(&top.slacks), &wide, range, &mut instances);
    }
}

/// A ray in the space of an instance, ready to ask the nodes and blocks of its mesh.
struct Local<L> {
    ray: WorldRay<f32>,
    nodes: Asked<L>,
    blocks: AskedBlock<L>,
}

impl<L: Lane> Local<L> {
    /// `bounds` are those of the mesh, or larger.
    #[inline(always)]
    fn new(
        token: L::Token,
        ray: WorldRay<f32>,
        is_identity: bool,
        to_object: &[[f32; 4]; 3],
        bounds: &Bounds,
    ) -> Self {
        let ray = if is_identity { ray } else { ray.transformed(to_object) };
        let Bounds { low, high } = bounds;
        let reach = RelativeBox::new(ray.origin, low, high).reach();
        let passing = passing(reach, low, high);
        Self { ray, nodes: Asked::new(token, &ray, 0.0, passing), blocks: AskedBlock::new(token, &ray) }
    }
}

/// What a ray sees, and who collects it.
struct Seen<'a, S, C> {
    tree: &'a Tree,
    source: &'a S,
    asked: &'a Ray,
    mask: u32,
    from: f32,
    skip: Option<u32>,
    collect: &'a mut C,
}

impl<S: Parts, C: Collect> Seen<'_, S, C> {
    /// Whether the ray sees an instance.
    #[inline(always)]
    fn sees(&self, number: u32, entry: &Entry) -> bool {
        self.skip != Some(number) && entry.mask & self.mask != 0
    }

    /// The triangles of an instance.
    #[inline(always)]
    fn triangles<'b, L>(
        &'b mut self,
        number: u32,
        entry: &Entry,
        local: &'b Local<L>,
    ) -> Triangles<'b, L, S, C> {
        Triangles {
            mesh: &self.tree.meshes[entry.mesh as usize],
            blocks: &local.blocks,
            source: self.source,
            number,
            ray: &local.ray,
            from: self.from,
            sides: self.asked.sides,
            through_holes: self.asked.through_holes,
            collect: &mut *self.collect,
        }
    }
}

/// Looks at leaves of meshes that stand in one space.
struct MergedLeaves<'a, 'b, L: Lane, S, C> {
    local: &'a Local<L>,
    seen: &'a mut Seen<'b, S, C>,
}

impl<L: Lane, S: Parts, C: Collect> Visitor for MergedLeaves<'_, '_, L, S, C> {
    #[inline(always)]
    fn leaf(&mut self, leaf: u32, count: u32) -> f32 {
        if count == 0 {
            return self.seen.collect.limit();
        }
        let top = &self.seen.tree.instances;
        let MergedLeaf { instance, block, triangles } = top.merged.leaves[leaf as usize];
        let entry = &top.entries[instance as usize];
        if !entry.is_merged || !self.seen.sees(instance, entry) {
            return self.seen.collect.limit();
        }
        self.seen.triangles(instance, entry, self.local).leaf(block, triangles)
    }
}

/// Looks at instances.
struct Instances<'a, L: Lane, S, C> {
    token: L::Token,
    ray: WorldRay<f32>,
    seen: Seen<'a, S, C>,
}

impl<L: Lane, S: Parts, C: Collect> Visitor for Instances<'_, L, S, C> {
    #[inline(always)]
    fn leaf(&mut self, number: u32, count: u32) -> f32 {
        // What is hidden or merged is not in its leaf.
        if count == 0 {
            return self.seen.collect.limit();
        }
        let tree = self.seen.tree;
        let entry = &tree.instances.entries[number as usize];
        if !self.seen.sees(number, entry) {
            return self.seen.collect.limit();
        }
        let mesh = &tree.meshes[entry.mesh as usize];
        let local = Local::<L>::new(self.token, self.ray, entry.is_identity, &entry.to_object, &mesh.bounds);
        let mut triangles = self.seen.triangles(number, entry, &local);
        if entry.is_sphere {
            triangles.sphere();
        } else {
            let range = Range { from: triangles.from, limit: triangles.collect.limit() };
            traverse(&mesh.tree, None, &local.nodes, range, &mut triangles);
        }
        self.seen.collect.limit()
    }
}

/// Looks at the triangles of one instance.
struct Triangles<'a, L, S, C> {
    mesh: &'a MeshTree,
    blocks: &'a AskedBlock<L>,
    source: &'a S,
    number: u32,
    /// In the instance's space.
    ray: &'a WorldRay<f32>,
    from: f32,
    sides: Sides,
    through_holes: bool,
    collect: &'a mut C,
}

impl<L: Lane, S: Parts, C: Collect> Visitor for Triangles<'_, L, S, C> {
    #[inline(always)]
    fn leaf(&mut self, first: u32, count: u32) -> f32 {
        let mesh = self.mesh;
        for block in mesh.blocks(first, count) {
            let mut remaining = self.blocks.may_hit(block);
            while remaining != 0 {
                let lane = remaining.trailing_zeros();
                remaining &= remaining - 1;
                let [a, b, c] = block.triangle(lane as usize);
                let triangle = Triangle::new(a, b, c);
                let relative = triangle.relative_to(self.ray.origin);
                let found = intersect(self.ray, &relative, self.collect.limit());
                if found.mask {
                    self.offer(block.first + lane, &found, relative.front(found.t));
                }
            }
        }
        self.collect.limit()
    }
}

impl<L, S: Parts, C: Collect> Triangles<'_, L, S, C> {
    /// Asks a sphere.
    fn sphere(&mut self) {
        let chord = Chord::new(self.ray);
        for side in [ENTRY, EXIT] {
            let found = chord.side(self.ray.direction, side, self.collect.limit());
            if found.mask {
                self.offer(side, &found, side == ENTRY);
            }
        }
    }

    /// Passes a hit on if the ray asks for it.
    fn offer(&mut self, triangle: u32, found: &Intersection<f32>, is_front: bool) {
        let is_side = match self.sides {
            Sides::Fronts => is_front,
            Sides::Backs => !is_front,
            Sides::Both => true,
            Sides::Drawn => is_front || self.source.instances()[self.number as usize].double_sided == 1,
        };
        let counts = is_side
            && found.t >= self.from
            && !(self.through_holes && self.source.is_hole(self.number, triangle, found));
        if counts {
            let &Intersection { t, u, v, .. } = found;
            self.collect.take(Found { t, instance: self.number, triangle, u, v });
        }
    }
}
