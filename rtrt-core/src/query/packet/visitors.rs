//! What a packet does with the leaves that it comes through: instances, and triangles.

use super::nodes::{Asked, Group, PacketVisitor, traverse};
use super::rays::Rays;
use super::{FEW, FEW_LANES, GROUPS, PACKET, Packet, Searched, Set, each};
use crate::kernel::triangle::{Intersection, Triangle, intersect};
use crate::lane::{Lane, Mask, Row};
use crate::query::block::Block;
use crate::query::instances::Entry;
use crate::query::merged::MergedLeaf;
use crate::query::rows::load;
use crate::query::search::{Collect, Instances, Local, MergedLeaves};
use crate::query::source::Parts;
use crate::query::wide::{Visitor, WIDTH};

/// Looks at leaves of meshes that stand in one space.
pub(super) struct MergedVisitor<'a, S, C> {
    /// In that space.
    pub rays: &'a Rays,
    pub packet: &'a Packet<'a>,
    pub world: Searched<'a, S>,
    pub collect: &'a mut [C; PACKET],
}

impl<L: Lane, S: Parts, C: Collect> PacketVisitor<L> for MergedVisitor<'_, S, C> {
    #[inline(always)]
    fn leaf(&mut self, token: L::Token, leaf: u32, _: u32, set: Set, asked: &mut Asked<'_, L>) {
        let top = &self.world.tree.instances;
        let MergedLeaf { instance, block, count } = top.merged.leaves[leaf as usize];
        let entry = &top.entries[instance as usize];
        if entry.is_merged {
            let Self { rays, packet, world, .. } = *self;
            let set = packet.seeing(world, set, instance, entry);
            TriangleVisitor { rays, packet, world, number: instance, collect: &mut *self.collect }
                .leaf(token, block, count, set, asked);
        }
    }

    #[inline(always)]
    fn few(&mut self, token: L::Token, node: u32, set: Set, asked: &mut Asked<'_, L>) {
        let Self { rays, packet, world, .. } = *self;
        each(
            set,
            #[inline(always)]
            |ray| {
                let local = Local::<L>::new(token, rays.ray(ray));
                let mut seen = packet.seen(world, ray, &mut self.collect[ray]);
                MergedLeaves::<L, S, _> { local: &local, seen: &mut seen }.search_outlined(token, node);
            },
        );
        asked.limit(token, set, self.collect);
    }
}

/// Looks at instances.
pub(super) struct InstanceVisitor<'a, S, C> {
    pub packet: &'a Packet<'a>,
    pub world: Searched<'a, S>,
    pub collect: &'a mut [C; PACKET],
}

impl<L: Lane, S: Parts, C: Collect> PacketVisitor<L> for InstanceVisitor<'_, S, C> {
    #[inline(always)]
    fn leaf(&mut self, token: L::Token, number: u32, _: u32, set: Set, asked: &mut Asked<'_, L>) {
        self.instance::<L>(token, number, set);
        asked.limit(token, set, self.collect);
    }

    #[inline(always)]
    fn few(&mut self, token: L::Token, node: u32, set: Set, asked: &mut Asked<'_, L>) {
        let Self { packet, world, .. } = *self;
        each(
            set,
            #[inline(always)]
            |ray| {
                let (seen, ray) = (packet.seen(world, ray, &mut self.collect[ray]), packet.rays.ray(ray));
                Instances::<L, S, _, true> { token, ray, seen }.search_outlined(node, world.limits.magnitude);
            },
        );
        asked.limit(token, set, self.collect);
    }
}

impl<S: Parts, C: Collect> InstanceVisitor<'_, S, C> {
    /// Shows an instance to the rays of a set.
    #[inline(always)]
    pub fn instance<L: Lane>(&mut self, token: L::Token, number: u32, set: Set) {
        let Self { packet, world, .. } = *self;
        let entry = &world.tree.instances.entries[number as usize];
        if entry.is_sphere || set.count_ones() <= FEW {
            each(
                set,
                #[inline(always)]
                |ray| {
                    let seen = packet.seen(world, ray, &mut self.collect[ray]);
                    Instances::<L, S, _, true> { token, ray: packet.rays.ray(ray), seen }.leaf(number, 1);
                },
            );
            return;
        }
        let seeing = packet.seeing(world, set, number, entry);
        if seeing != 0 {
            L::outlined(
                token,
                #[inline(always)]
                || self.mesh::<L>(token, number, entry, seeing),
            );
        }
    }

    /// Shows the mesh of an instance to the rays of a set, of which there must be some.
    #[inline(always)]
    fn mesh<L: Lane>(&mut self, token: L::Token, number: u32, entry: &Entry, set: Set) {
        let Self { packet, world, .. } = *self;
        let mesh = &world.tree.meshes[entry.mesh as usize];
        let mut local = None;
        let rays = packet.rays.placed::<L>(token, set, entry.is_identity, &entry.to_object, &mut local);
        let widening = rays.widening::<L>(token, &mesh.bounds);
        let mut asked = Asked::<L>::new(token, rays, set, 0.0, widening, &packet.spans, self.collect);
        let mut triangles = TriangleVisitor { rays, packet, world, number, collect: &mut *self.collect };
        traverse(token, &mesh.tree, None, &mut asked, &mut triangles);
    }
}

/// Looks at the triangles of one instance.
struct TriangleVisitor<'a, S, C> {
    /// In its space.
    rays: &'a Rays,
    packet: &'a Packet<'a>,
    world: Searched<'a, S>,
    number: u32,
    collect: &'a mut [C; PACKET],
}

impl<L: Lane, S: Parts, C: Collect> PacketVisitor<L> for TriangleVisitor<'_, S, C> {
    #[inline(always)]
    fn leaf(&mut self, token: L::Token, first: u32, count: u32, set: Set, asked: &mut Asked<'_, L>) {
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
                        let local = Local::<L>::new(token, self.rays.ray(ray));
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
    fn few(&mut self, token: L::Token, node: u32, set: Set, asked: &mut Asked<'_, L>) {
        let Self { packet, world, number, .. } = *self;
        let entry = &world.tree.instances.entries[number as usize];
        each(
            set,
            #[inline(always)]
            |ray| {
                let local = Local::<L>::new(token, self.rays.ray(ray));
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
            let rays = self.rays.lanes::<L>(token, start + lane);
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
