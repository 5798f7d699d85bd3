//! Rays that are asked together: a node is read once for all of them, and a triangle for eight. Each ray's hits are
//! those that it has alone.
//!
//! Rays that have come apart go on one by one (after Benthin et al., "Combining Single and Packet-Ray Tracing for
//! Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 2012).

mod nodes;

use super::block::Block;
use super::instances::Entry;
use super::merged::{MergedLeaf, Space};
use super::ray::{QueryError, Ray, Scale, ScaledRay};
use super::search::{Collect, Instances, Limits, Local, MergedLeaves, Seen, skipped};
use super::source::Parts;
use super::tree::Tree;
use super::wide::{Visitor, WIDTH};
use crate::kernel::ray::Ray as WorldRay;
use crate::kernel::slab::RelativeBox;
use crate::kernel::triangle::{Intersection, Triangle, intersect, passing};
use crate::lane::{Lane, Mask, Row};
use crate::scene::Bounds;
use nodes::{Asked, Group, PacketVisitor, load, traverse};

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

/// Rays that are asked together. What is not traced is in no set, and a copy of one that is.
pub(super) struct Packet<'a> {
    asked: &'a [Ray],
    traced: Set,
    rays: [WorldRay<f32>; PACKET],
    scales: [Scale; PACKET],
    skip: [Option<u32>; PACKET],
}

impl<'a> Packet<'a> {
    /// `None` if the rays are too few or too many, or all are refused.
    #[inline(always)]
    pub fn new(source: &impl Parts, asked: &'a [Ray]) -> Option<Self> {
        if asked.len() <= FEW as usize || asked.len() > PACKET {
            return None;
        }
        let first = asked.iter().find_map(|ray| ray.scaled().ok())?;
        let mut packet = Self {
            asked,
            traced: 0,
            rays: [first.ray; PACKET],
            scales: [first.scale; PACKET],
            skip: [None; PACKET],
        };
        for (number, ray) in asked.iter().enumerate() {
            let Ok(ScaledRay { ray: traced, scale }) = ray.scaled() else { continue };
            packet.traced |= 1 << number;
            (packet.rays[number], packet.scales[number]) = (traced, scale);
            packet.skip[number] = skipped(source, ray);
        }
        Some(packet)
    }

    /// Whether the rays start near to each other in a world with these bounds. Only then closest hits are found sooner
    /// together: the order in which nodes are visited is best for one of them.
    #[inline(always)]
    pub fn start_nearby(&self, world: &Bounds) -> bool {
        let mut apart = 0.0;
        for pair in self.rays.windows(2) {
            let (a, b) = (pair[0].origin.lane(0), pair[1].origin.lane(0));
            apart += (0..3).fold(0.0, |most, axis| Lane::max(most, Lane::abs(b[axis] - a[axis])));
        }
        apart <= NEARBY * self.asked.len() as f32 * world.side()
    }

    /// The largest coordinate of a start.
    #[inline(always)]
    pub fn reach(&self) -> f32 {
        let mut most = 0.0;
        for ray in &self.rays {
            most = ray.origin.lane(0).into_iter().fold(most, |most, c| Lane::max(most, Lane::abs(c)));
        }
        most
    }

    /// What a ray has met, or why it is no ray.
    #[inline(always)]
    pub fn answer<T>(&self, number: usize, answer: impl FnOnce(&Scale) -> T) -> Result<T, QueryError> {
        if self.traced >> number & 1 == 1 {
            return Ok(answer(&self.scales[number]));
        }
        self.asked[number].scaled().map(|ScaledRay { scale, .. }| answer(&scale))
    }

    /// What collects the hits of each ray.
    #[inline(always)]
    pub fn collectors<C>(&self, collect: impl Fn(f32) -> C) -> [C; PACKET] {
        self.scales.map(
            #[inline(always)]
            |scale| collect(scale.to),
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
            let rays = placed(&self.rays, self.traced, *is_identity, to_object, &mut local);
            let widening = widening(rays, &top.merged.bounds);
            let mut asked = Asked::<L>::new(token, rays, self.traced, 0.0, widening, &self.scales, collect);
            let mut merged = MergedVisitor { rays, packet: self, world, collect };
            traverse(token, &top.merged.tree, None, &mut asked, &mut merged);
        }
        let magnitude = world.limits.magnitude;
        let mut asked =
            Asked::<L>::new(token, &self.rays, self.traced, magnitude, 0.0, &self.scales, collect);
        let mut instances = InstanceVisitor { packet: self, world, collect };
        traverse(token, &top.tree, Some(&top.slacks), &mut asked, &mut instances);
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
        let (asked, from, skip) = (&self.asked[number], self.scales[number].from, self.skip[number]);
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

/// The rays of a set in the space of an object, perhaps in `local`; the others are copies of the first.
#[inline(always)]
fn placed<'a>(
    rays: &'a [WorldRay<f32>; PACKET],
    set: Set,
    is_identity: bool,
    to_object: &[[f32; 4]; 3],
    local: &'a mut Option<[WorldRay<f32>; PACKET]>,
) -> &'a [WorldRay<f32>; PACKET] {
    if is_identity {
        return rays;
    }
    let first = rays[set.trailing_zeros() as usize & (PACKET - 1)].transformed(to_object);
    let local = local.insert([first; PACKET]);
    each(
        set,
        #[inline(always)]
        |number| local[number] = rays[number].transformed(to_object),
    );
    local
}

/// How much wider boxes within these bounds have to be for all rays.
#[inline(always)]
fn widening(rays: &[WorldRay<f32>; PACKET], Bounds { low, high }: &Bounds) -> f32 {
    let mut reach = 0.0;
    let mut number = 0;
    while number < PACKET {
        reach = Lane::max(reach, RelativeBox::new(rays[number].origin, low, high).reach());
        number += 1;
    }
    passing(reach, low, high)
}

/// Looks at leaves of meshes that stand in one space.
struct MergedVisitor<'a, S, C> {
    /// In that space.
    rays: &'a [WorldRay<f32>; PACKET],
    packet: &'a Packet<'a>,
    world: Searched<'a, S>,
    collect: &'a mut [C; PACKET],
}

impl<L: Lane, S: Parts, C: Collect> PacketVisitor<L> for MergedVisitor<'_, S, C> {
    #[inline(always)]
    fn leaf(&mut self, token: L::Token, leaf: u32, _: u32, set: Set, asked: &mut Asked<L>) {
        let top = &self.world.tree.instances;
        let MergedLeaf { instance, block, triangles } = top.merged.leaves[leaf as usize];
        let entry = &top.entries[instance as usize];
        if entry.is_merged {
            let Self { rays, packet, world, .. } = *self;
            let set = packet.seeing(world, set, instance, entry);
            TriangleVisitor { rays, packet, world, number: instance, collect: &mut *self.collect }
                .leaf(token, block, triangles, set, asked);
        }
    }

    #[inline(always)]
    fn few(&mut self, token: L::Token, node: u32, set: Set, asked: &mut Asked<L>) {
        let Self { rays, packet, world, .. } = *self;
        each(
            set,
            #[inline(always)]
            |ray| {
                let local = Local::<L>::new(token, rays[ray]);
                let mut seen = packet.seen(world, ray, &mut self.collect[ray]);
                MergedLeaves::<L, S, _> { local: &local, seen: &mut seen }.search_outlined(token, node);
            },
        );
        asked.limit(token, set, self.collect);
    }
}

/// Looks at instances.
struct InstanceVisitor<'a, S, C> {
    packet: &'a Packet<'a>,
    world: Searched<'a, S>,
    collect: &'a mut [C; PACKET],
}

impl<L: Lane, S: Parts, C: Collect> PacketVisitor<L> for InstanceVisitor<'_, S, C> {
    #[inline(always)]
    fn leaf(&mut self, token: L::Token, number: u32, count: u32, set: Set, asked: &mut Asked<L>) {
        let Self { packet, world, .. } = *self;
        let entry = &world.tree.instances.entries[number as usize];
        if entry.is_sphere || set.count_ones() <= FEW {
            each(
                set,
                #[inline(always)]
                |ray| {
                    let seen = packet.seen(world, ray, &mut self.collect[ray]);
                    Instances::<L, S, _, true> { token, ray: packet.rays[ray], seen }.leaf(number, count);
                },
            );
        } else {
            let seeing = packet.seeing(world, set, number, entry);
            let mesh = &world.tree.meshes[entry.mesh as usize];
            let mut local = None;
            let rays = placed(&packet.rays, seeing, entry.is_identity, &entry.to_object, &mut local);
            let widening = widening(rays, &mesh.bounds);
            let mut asked = Asked::<L>::new(token, rays, seeing, 0.0, widening, &packet.scales, self.collect);
            let mut triangles = TriangleVisitor { rays, packet, world, number, collect: &mut *self.collect };
            traverse(token, &mesh.tree, None, &mut asked, &mut triangles);
        }
        asked.limit(token, set, self.collect);
    }

    #[inline(always)]
    fn few(&mut self, token: L::Token, node: u32, set: Set, asked: &mut Asked<L>) {
        let Self { packet, world, .. } = *self;
        each(
            set,
            #[inline(always)]
            |ray| {
                let (seen, ray) = (packet.seen(world, ray, &mut self.collect[ray]), packet.rays[ray]);
                Instances::<L, S, _, true> { token, ray, seen }.search_outlined(node, world.limits.magnitude);
            },
        );
        asked.limit(token, set, self.collect);
    }
}

/// Looks at the triangles of one instance.
struct TriangleVisitor<'a, S, C> {
    /// In its space.
    rays: &'a [WorldRay<f32>; PACKET],
    packet: &'a Packet<'a>,
    world: Searched<'a, S>,
    number: u32,
    collect: &'a mut [C; PACKET],
}

impl<L: Lane, S: Parts, C: Collect> PacketVisitor<L> for TriangleVisitor<'_, S, C> {
    #[inline(always)]
    fn leaf(&mut self, token: L::Token, first: u32, count: u32, set: Set, asked: &mut Asked<L>) {
        let tree = self.world.tree;
        let entry = &tree.instances.entries[self.number as usize];
        let blocks = tree.meshes[entry.mesh as usize].blocks(first, count);
        let mut g = 0;
        while g < GROUPS {
            let here = set >> (g * WIDTH) & ((1 << WIDTH) - 1);
            if here.count_ones() > FEW_LANES {
                self.side_by_side::<L>(token, blocks, g * WIDTH, here as u32, &mut asked.groups[g]);
            } else {
                each(
                    here << (g * WIDTH),
                    #[inline(always)]
                    |ray| {
                        let local = Local::<L>::new(token, self.rays[ray]);
                        let mut seen = self.packet.seen(self.world, ray, &mut self.collect[ray]);
                        seen.triangles(self.number, entry, &local).leaf(first, count);
                    },
                );
            }
            g += 1;
        }
        asked.limit(token, set, self.collect);
    }

    #[inline(always)]
    fn few(&mut self, token: L::Token, node: u32, set: Set, asked: &mut Asked<L>) {
        let Self { packet, world, number, .. } = *self;
        let entry = &world.tree.instances.entries[number as usize];
        each(
            set,
            #[inline(always)]
            |ray| {
                let local = Local::<L>::new(token, self.rays[ray]);
                let mut seen = packet.seen(world, ray, &mut self.collect[ray]);
                seen.triangles(number, entry, &local).search_outlined(token, node);
            },
        );
        asked.limit(token, set, self.collect);
    }
}

impl<S: Parts, C: Collect> TriangleVisitor<'_, S, C> {
    /// Tests each triangle of blocks against a group of rays, those of `set` among them. Its first ray is that with the
    /// number `start`.
    #[inline(always)]
    fn side_by_side<L: Lane>(
        &mut self,
        token: L::Token,
        blocks: &[Block],
        start: usize,
        set: u32,
        group: &mut Group,
    ) {
        let mut lane = 0;
        while lane < WIDTH {
            let rays: WorldRay<L> = group.rays(token, lane);
            for block in blocks {
                let mut number_in_block = 0;
                while number_in_block < block.count {
                    let [a, b, c] = block.triangle(number_in_block as usize);
                    let relative = Triangle::new(a, b, c).relative_to(rays.origin);
                    let found = intersect(&rays, &relative, load(token, &group.limit, lane));
                    let hit = found.mask.bits() & set >> lane;
                    if hit != 0 {
                        let (triangle, fronts) =
                            (block.first + number_in_block, relative.front(found.t).bits());
                        self.offer(triangle, start + lane, hit, &found, fronts, &mut group.limit[lane..]);
                    }
                    number_in_block += 1;
                }
            }
            lane += L::WIDTH;
        }
    }

    /// Offers a triangle to the rays of `hit`, a bit a lane, of which the first has the number `start`; takes over how
    /// far they are still traced.
    #[inline(always)]
    fn offer<L: Lane>(
        &mut self,
        triangle: u32,
        start: usize,
        hit: u32,
        found: &Intersection<L>,
        fronts: u32,
        limits: &mut [f32],
    ) {
        let (t, u, v) = (found.t.row(), found.u.row(), found.v.row());
        each(
            hit.into(),
            #[inline(always)]
            |lane| {
                let found = Intersection { mask: true, t: t.at(lane), u: u.at(lane), v: v.at(lane) };
                let ray = start + lane;
                let mut seen = self.packet.seen(self.world, ray, &mut self.collect[ray]);
                seen.offer(self.number, triangle, &found, fronts >> lane & 1 == 1);
                limits[lane] = seen.collect.limit();
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::fixture::{Random, add, strewn};
    use crate::query::{Hit, Sides, World};
    use crate::scene::{Material, Scene, Sequential};
    use glam::{Mat4, Vec3};
    use std::vec;
    use std::vec::Vec;

    /// Rays with all that can be asked, from near a point or from anywhere, in almost the same direction or in any. Some
    /// are none.
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
                assert_eq!(closest(&world, &rays), alone);
                hits += alone.iter().filter(|hit| matches!(hit, Ok(Some(_)))).count();
                refused += alone.iter().filter(|hit| hit.is_err()).count();
                let alone: Vec<_> = rays.iter().map(|ray| world.occluded(ray)).collect();
                assert_eq!(occluded(&world, &rays), alone);
                let packet = Packet::new(&scene, &rays[..count.min(64)]).unwrap();
                together += usize::from(packet.start_nearby(&scene.places().all()));
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
        let is_packet = |rays: &[Ray]| Packet::new(&scene, rays).is_some();
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
