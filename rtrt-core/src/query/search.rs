//! The search: a ray through the tree over the instances, and on through those of meshes.

use super::block::AskedBlock;
use super::ray::{Ray, ScaledRay, Sides};
use super::source::Parts;
use super::tree::{MeshTree, Part, Tree};
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
    let modelled = top.modelled.map(|bounds| Local::new(token, scaled.ray, &bounds));
    let mut instances =
        Instances::<L, S, _> { token, tree, source, asked, mask, scaled, skip, modelled, collect };
    let range = Range { from: scaled.from, limit: instances.collect.limit() };
    let wide = Asked::<L>::new(token, &scaled.ray, magnitude, 0.0);
    traverse(&top.tree, 0, Some(&top.slacks), &wide, range, &mut instances);
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
    fn new(token: L::Token, ray: WorldRay<f32>, bounds: &Bounds) -> Self {
        let Bounds { low, high } = bounds;
        let reach = RelativeBox::new(ray.origin, low, high).reach();
        let passing = passing(reach, low, high);
        Self { ray, nodes: Asked::new(token, &ray, 0.0, passing), blocks: AskedBlock::new(token, &ray) }
    }
}

/// Looks at instances.
struct Instances<'a, L: Lane, S, C> {
    token: L::Token,
    tree: &'a Tree,
    source: &'a S,
    asked: &'a Ray,
    mask: u32,
    scaled: &'a ScaledRay,
    skip: Option<u32>,
    /// The ray where meshes stand as they were modelled, if any has parts.
    modelled: Option<Local<L>>,
    collect: &'a mut C,
}

impl<L: Lane, S: Parts, C: Collect> Visitor for Instances<'_, L, S, C> {
    #[inline(always)]
    fn leaf(&mut self, part: u32, count: u32) -> f32 {
        // A part of a hidden instance is not in its leaf.
        if count == 0 {
            return self.collect.limit();
        }
        let Part { instance: number, node } = self.tree.instances.parts[part as usize];
        let entry = &self.tree.instances.entries[number as usize];
        if self.skip == Some(number) || entry.mask & self.mask == 0 {
            return self.collect.limit();
        }
        let mesh = &self.tree.meshes[entry.mesh as usize];
        let placed;
        let local = match &self.modelled {
            Some(modelled) if entry.is_identity => modelled,
            _ => {
                let ray = self.scaled.ray;
                let ray = if entry.is_identity { ray } else { ray.transformed(&entry.to_object) };
                placed = Local::new(self.token, ray, &mesh.bounds);
                &placed
            }
        };
        let mut triangles = Triangles::<L, S, _> {
            mesh,
            blocks: &local.blocks,
            source: self.source,
            number,
            ray: &local.ray,
            from: self.scaled.from,
            sides: self.asked.sides,
            through_holes: self.asked.through_holes,
            collect: &mut *self.collect,
        };
        if entry.is_sphere {
            triangles.sphere();
        } else {
            let range = Range { from: self.scaled.from, limit: triangles.collect.limit() };
            traverse(&mesh.tree, node, None, &local.nodes, range, &mut triangles);
        }
        self.collect.limit()
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
