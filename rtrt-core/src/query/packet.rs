//! Rays that are traced together: a node is read once for 64 of them, a triangle once for eight. Each has the hits
//! that it has alone.
//!
//! Rays that have gone different ways go on one by one (after Benthin et al., "Combining Single and Packet-Ray Tracing for
//! Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 2012).

mod nodes;
mod rays;
mod visitors;

use super::instances::{Entry, Start};
use super::merged::Space;
use super::ray::{QueryError, Ray, ScaledRay, Span};
use super::search::{Collect, Limits, Seen, skipped};
use super::source::Parts;
use super::tree::Tree;
use super::wide::WIDTH;
use crate::lane::Lane;
use crate::scene::{Bounds, COORDINATE_LIMIT};
use nodes::{Asked, traverse};
use rays::Rays;
use visitors::{InstanceVisitor, MergedVisitor};

/// The most rays of a packet.
pub(super) const PACKET: usize = 64;
/// Groups of [`WIDTH`] rays.
const GROUPS: usize = PACKET / WIDTH;
/// So many rays or fewer go on one by one.
const FEW: u32 = 16;
/// So many rays of a group or fewer are tested one by one against the triangles of a leaf.
const FEW_LANES: u32 = 4;
/// Starts that follow one another lie apart by no more than this share of the world, on average.
const NEARBY: f32 = 1.0 / 16.0;

/// Some rays of a packet: bit `i` stands for ray `i`.
type Set = u64;

/// The numbers of the rays of a set.
#[inline(always)]
fn each(set: Set, mut visit: impl FnMut(usize)) {
    let mut remaining = set;
    while remaining != 0 {
        visit(remaining.trailing_zeros() as usize);
        remaining &= remaining - 1;
    }
}

/// Whether rays start near to each other in a world with these bounds. Only then closest hits are found sooner
/// together: the order in which a packet visits nodes is good for a ray if it is good for its neighbors.
#[inline(always)]
pub(super) fn start_nearby(rays: &[Ray], world: &Bounds) -> bool {
    let mut apart = 0.0;
    for pair in rays.windows(2) {
        let (a, b) = (&pair[0].origin, &pair[1].origin);
        let (x, y) = (Lane::abs(b[0] - a[0]), Lane::abs(b[1] - a[1]));
        let most = Lane::max(Lane::max(x, y), Lane::abs(b[2] - a[2]));
        // The start of a refused ray may be anywhere, or nowhere.
        apart += if most <= 2.0 * COORDINATE_LIMIT { most } else { 0.0 };
    }
    apart <= NEARBY * rays.len() as f32 * world.side()
}

/// Rays that are traced together. A refused ray is in no set; in its place is a copy of another one.
pub(super) struct Packet<'a> {
    asked: &'a [Ray],
    traced: Set,
    rays: Rays,
    spans: [Span; PACKET],
    skip: [Option<u32>; PACKET],
}

impl<'a> Packet<'a> {
    /// `None` if the rays are too few or too many, or all are refused.
    #[inline(always)]
    pub fn new<L: Lane>(token: L::Token, source: &impl Parts, asked: &'a [Ray]) -> Option<Self> {
        if asked.len() <= FEW as usize || asked.len() > PACKET {
            return None;
        }
        let mut packet = Self {
            asked,
            traced: 0,
            rays: Rays::NONE,
            spans: [Span::new(0.0, 0.0); PACKET],
            skip: [None; PACKET],
        };
        let (mut there, mut with_range) = (0, 0);
        for (number, ray) in asked.iter().enumerate() {
            there |= 1 << number;
            with_range |= Set::from(!(ray.from.is_nan() || ray.to.is_nan())) << number;
            packet.rays.set(number, ray.origin, ray.direction);
            packet.spans[number] = Span::new(ray.from, ray.to);
            packet.skip[number] = skipped(source, ray);
        }
        packet.traced = packet.rays.usual::<L>(token) & with_range;
        each(there & !packet.traced, |number| packet.scale(number));
        if packet.traced == 0 {
            return None;
        }
        packet.rays.fill(packet.traced);
        packet.rays.prepare::<L>(token);
        Some(packet)
    }

    /// Takes over a ray with an unusual length, if it is not refused.
    #[inline(never)]
    fn scale(&mut self, number: usize) {
        if let Ok(ScaledRay { ray, span }) = self.asked[number].scaled() {
            self.rays.set(number, ray.origin.lane(0), ray.direction.lane(0));
            self.spans[number] = span;
            self.traced |= 1 << number;
        }
    }

    /// The largest coordinate of a start.
    #[inline(always)]
    pub fn reach<L: Lane>(&self, token: L::Token) -> f32 {
        self.rays.reach::<L>(token)
    }

    /// What a ray has met, or why it is no ray.
    #[inline(always)]
    pub fn answer<T>(&self, number: usize, answer: impl FnOnce(&Span) -> T) -> Result<T, QueryError> {
        if self.traced >> number & 1 == 1 {
            return Ok(answer(&self.spans[number]));
        }
        self.asked[number].scaled().map(|ScaledRay { span, .. }| answer(&span))
    }

    /// What collects the hits of each ray.
    #[inline(always)]
    pub fn collectors<C>(&self, collect: impl Fn(f32) -> C) -> [C; PACKET] {
        self.spans.map(
            #[inline(always)]
            |span| collect(span.to),
        )
    }

    /// Shows the collector of each ray every hit that can change its result.
    #[inline(always)]
    pub fn search<L: Lane, S: Parts, C: Collect>(
        &self,
        token: L::Token,
        world: Searched<'_, S>,
        collect: &mut [C; PACKET],
    ) {
        let top = &world.tree.instances;
        if !top.merged.leaves.is_empty() {
            let Space { is_identity, to_object, .. } = &top.merged.space;
            let mut local = None;
            let rays = self.rays.placed::<L>(token, self.traced, *is_identity, to_object, &mut local);
            let widening = rays.widening::<L>(token, &top.merged.bounds);
            let mut asked = Asked::<L>::new(token, rays, self.traced, 0.0, widening, &self.spans, collect);
            let mut merged = MergedVisitor { rays, packet: self, world, collect };
            traverse(token, &top.merged.tree, None, &mut asked, &mut merged);
        }
        let mut instances = InstanceVisitor { packet: self, world, collect };
        match top.start() {
            Start::Nowhere => {}
            Start::Leaf(number) => instances.instance::<L>(token, number, self.traced),
            Start::Root => {
                let (rays, magnitude) = (&self.rays, world.limits.magnitude);
                let mut asked =
                    Asked::<L>::new(token, rays, self.traced, magnitude, 0.0, &self.spans, instances.collect);
                traverse(token, &top.tree, Some(&top.slacks), &mut asked, &mut instances);
            }
        }
    }

    /// The rays of a set that see an instance.
    #[inline(always)]
    fn seeing<S>(&self, world: Searched<'_, S>, set: Set, instance: u32, entry: &Entry) -> Set {
        let mut seeing = set;
        each(
            set,
            #[inline(always)]
            |number| {
                let mask = self.asked[number].mask & world.limits.mask;
                let sees = self.skip[number] != Some(instance) && entry.mask & mask != 0;
                seeing &= !(u64::from(!sees) << number);
            },
        );
        seeing
    }

    #[inline(always)]
    fn seen<'b, S, C>(&'b self, world: Searched<'b, S>, number: usize, collect: &'b mut C) -> Seen<'b, S, C> {
        let (asked, from, skip) = (&self.asked[number], self.spans[number].from, self.skip[number]);
        let mask = asked.mask & world.limits.mask;
        let Searched { tree, source, .. } = world;
        Seen { tree, source, asked, mask, from, skip, collect }
    }
}

/// What is searched.
pub(super) struct Searched<'a, S> {
    pub tree: &'a Tree,
    pub source: &'a S,
    /// Those for all rays.
    pub limits: Limits,
}

impl<S> Clone for Searched<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for Searched<'_, S> {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::fixture::{Random, add, strewn};
    use crate::query::{Hit, Sides, World};
    use crate::scene::{Material, Scene, Sequential};
    use glam::{Mat4, Vec3};
    use std::vec::Vec;
    use std::{format, vec};

    /// Rays with options of all kinds. Starts differ by `spread`, directions by `angle`. Some rays are refused.
    fn rays(random: &mut Random, scene: &Scene, count: usize, spread: f32, angle: f32) -> Vec<Ray> {
        let from = random.vector(7.0);
        let along = (random.vector(3.0) - from).normalize();
        let mut ray = || {
            let direction = along * (1.0 - angle) + random.vector(angle);
            let scale = [1.0, 1e-20, 1e20][random.below(8).saturating_sub(5)];
            let ray = Ray::new(from + random.vector(spread), direction * scale);
            match random.below(12) {
                0 => ray.starting(2.0 / scale),
                1 => ray.until(5.0 / scale),
                2 => ray.mask(2),
                3 => ray.sides([Sides::Fronts, Sides::Backs, Sides::Drawn][random.below(3)]),
                4 => ray.skip(scene.instance_index(random.below(60) as u32).unwrap()),
                5 => ray.until(-1.0),
                7 if random.below(12) == 0 => ray.until(f32::NAN),
                7 if random.below(12) == 0 => ray.starting(f32::NAN),
                6 if random.below(3) == 0 => Ray::new([f32::MAX; 3], direction),
                6 if random.below(3) == 0 => Ray::new(from, [0.0; 3]),
                _ => ray,
            }
        };
        (0..count).map(|_| ray()).collect()
    }

    fn closest(world: &World<'_>, rays: &[Ray]) -> Vec<Result<Option<Hit>, QueryError>> {
        let mut hits = vec![Ok(Some(Hit::NONE)); rays.len()];
        world.closest_each(rays, &mut hits);
        hits
    }

    fn occluded(world: &World<'_>, rays: &[Ray]) -> Vec<Result<bool, QueryError>> {
        let mut occluded = vec![Ok(false); rays.len()];
        world.occluded_each(rays, &mut occluded);
        occluded
    }

    #[test]
    fn rays_meet_together_what_they_meet_alone() {
        let mut random = Random(7);
        let (mut hits, mut refused, mut together) = (0, 0, 0);
        for round in 0..60 {
            let (scene, mut tree) = strewn(&mut random);
            let world = tree.world(&scene);
            let count = [17, 64, 64, 150][round % 4];
            for (spread, angle) in [(0.0, 0.05), (0.3, 0.2), (0.01, 1.0), (7.0, 1.0)] {
                let rays = rays(&mut random, &scene, count, spread, angle);
                let alone: Vec<_> = rays.iter().map(|ray| world.closest(ray)).collect();
                // NaN in an error differs from itself.
                assert_eq!(format!("{:?}", closest(&world, &rays)), format!("{alone:?}"));
                hits += alone.iter().filter(|hit| matches!(hit, Ok(Some(_)))).count();
                refused += alone.iter().filter(|hit| hit.is_err()).count();
                let alone: Vec<_> = rays.iter().map(|ray| world.occluded(ray)).collect();
                assert_eq!(format!("{:?}", occluded(&world, &rays)), format!("{alone:?}"));
                together += usize::from(start_nearby(&rays[..count.min(64)], &scene.places().all()));
            }
        }
        assert!(hits > 5000 && refused > 200 && together == 180, "{hits} {refused} {together}");
    }

    #[test]
    fn many_rays_meet_one_large_mesh_together() {
        let mut random = Random(8);
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let mesh = add(&mut scene, &random.mesh(3000, 1.0));
        scene.add_instance(mesh, white, Mat4::from_rotation_x(0.3)).unwrap();
        let mut tree = Tree::new(&scene, &Sequential);
        let world = tree.world(&scene);
        let eye = Vec3::new(0.2, 0.1, 4.0);
        // Rows of a picture; the last one is short.
        let to = |i: usize| Vec3::new((i % 64) as f32 / 32.0 - 1.0, (i / 64) as f32 / 16.0 - 1.0, 0.0) - eye;
        let rays: Vec<_> = (0..64 * 32 + 20).map(|i| Ray::new(eye, to(i))).collect();
        let alone: Vec<_> = rays.iter().map(|ray| world.closest(ray)).collect();
        assert_eq!(closest(&world, &rays), alone);
        assert!(alone.iter().filter(|hit| matches!(hit, Ok(Some(_)))).count() > 1000);
        // What is beyond the shorter slice is left alone.
        let mut hits = vec![Ok(Some(Hit::NONE)); 100];
        world.closest_each(&rays[..70], &mut hits);
        assert_eq!(
            (&hits[..70], hits[70..].iter().all(|hit| *hit == Ok(Some(Hit::NONE)))),
            (&alone[..70], true)
        );
        let mut hits = vec![Ok(None); 40];
        world.closest_each(&rays, &mut hits);
        assert_eq!(hits, alone[..40]);
    }

    #[test]
    fn rays_that_are_few_or_none_make_no_packet() {
        let scene = Scene::new();
        let ray = Ray::new([0.0; 3], [1.0, 0.0, 0.0]);
        let none = Ray::new([0.0; 3], [0.0; 3]);
        let is_packet = |rays: &[Ray]| Packet::new::<f32>((), &scene, rays).is_some();
        assert!(is_packet(&[ray; 17]) && is_packet(&[ray; 64]));
        assert!(
            !is_packet(&[ray; 16]) && !is_packet(&[ray; 65]) && !is_packet(&[none; 17]) && !is_packet(&[])
        );
        let mut tree = Tree::default();
        let world = tree.world(&scene);
        assert_eq!(closest(&world, &[ray; 20]), [Ok(None); 20]);
        assert!(closest(&world, &[none; 20]).iter().all(Result::is_err));
    }
}
