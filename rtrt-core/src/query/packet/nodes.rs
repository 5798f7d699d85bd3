//! How a packet asks nodes: first with bounds of all rays, then with those rays that came so far.

use super::rays::Rays;
use super::{FEW, GROUPS, PACKET, Set, each};
use crate::kernel::tiles::{Sign, separate_origins};
use crate::kernel::traverse::STACK;
use crate::lane::{Lane, Mask, Select, V3};
use crate::query::ray::Span;
use crate::query::rows::{cross, enter, load, splat, store};
use crate::query::search::Collect;
use crate::query::wide::{Child, SHALLOW, WIDTH, WideNode, WideTree};

/// How rays side by side ask nodes.
#[derive(Clone, Copy)]
pub(super) struct Group {
    /// The starts, moved by as much as boxes are wider: what lower planes are measured from, and upper ones.
    origins: [[[f32; WIDTH]; 3]; 2],
    from: [f32; WIDTH],
    /// How far each ray is still traced; −1 for one that is not.
    pub limit: [f32; WIDTH],
}

impl Group {
    /// Rays that are not traced.
    const NOBODY: Self = Self { origins: [[[0.0; WIDTH]; 3]; 2], from: [0.0; WIDTH], limit: [-1.0; WIDTH] };
}

/// The rays of a packet in one space, ready to ask nodes.
pub(super) struct Asked<'a, L> {
    pub rays: &'a Rays,
    pub groups: [Group; GROUPS],
    /// The rays that are still traced.
    active: Set,
    /// The largest limit.
    limit: f32,
    /// The largest start for lower planes, the least one for upper ones.
    origins: [[L; 3]; 2],
    /// The least reciprocal direction, the largest one.
    inverse: [[L; 3]; 2],
    signs: [Sign; 3],
    magnitude: f32,
}

impl<'a, L: Lane> Asked<'a, L> {
    /// The rays of a set. `magnitude` and `widening` are those of [`super::wide::Asked::new`]; `spans` have the starts
    /// of their ranges.
    #[inline(always)]
    pub fn new<C: Collect>(
        token: L::Token,
        rays: &'a Rays,
        set: Set,
        magnitude: f32,
        widening: f32,
        spans: &[Span; PACKET],
        collect: &[C; PACKET],
    ) -> Self {
        let mut groups = [Group::NOBODY; GROUPS];
        let (mut least, mut most) = ([L::splat(token, f32::MAX); 6], [L::splat(token, -f32::MAX); 6]);
        let by = L::splat(token, widening);
        let mut g = 0;
        while g < GROUPS {
            let group = &mut groups[g];
            let mut first = 0;
            while first < WIDTH {
                let V3 { x, y, z } = rays.origins::<L>(token, g * WIDTH + first);
                let origin = [x, y, z];
                let mut axis = 0;
                while axis < 3 {
                    let (lower, upper) = (origin[axis] + by, origin[axis] - by);
                    store(lower, &mut group.origins[0][axis], first);
                    store(upper, &mut group.origins[1][axis], first);
                    let inverse = rays.inverse(token, g * WIDTH + first, axis);
                    least[axis] = least[axis].min(upper);
                    most[axis] = most[axis].max(lower);
                    least[3 + axis] = least[3 + axis].min(inverse);
                    most[3 + axis] = most[3 + axis].max(inverse);
                    axis += 1;
                }
                first += L::WIDTH;
            }
            let mut lane = 0;
            while lane < WIDTH {
                group.from[lane] = spans[g * WIDTH + lane].from;
                lane += 1;
            }
            g += 1;
        }
        let smallest = [0, 1, 2].map(
            #[inline(always)]
            |axis| least[axis].smallest(),
        );
        let largest = [0, 1, 2].map(
            #[inline(always)]
            |axis| most[axis].largest(),
        );
        let inverse = [3, 4, 5].map(
            #[inline(always)]
            |row| [least[row].smallest(), most[row].largest()],
        );
        let [x, y, z] = inverse;
        let mut asked = Self {
            rays,
            groups,
            active: set,
            limit: -1.0,
            origins: [splat(token, largest), splat(token, smallest)],
            inverse: [splat(token, [x[0], y[0], z[0]]), splat(token, [x[1], y[1], z[1]])],
            signs: [Sign::of(x[0], x[1]), Sign::of(y[0], y[1]), Sign::of(z[0], z[1])],
            magnitude,
        };
        asked.limit(token, set, collect);
        asked
    }

    /// The children that any of the rays may enter.
    #[inline(always)]
    fn bounds(&self, token: L::Token, node: &WideNode, slack: Option<&[f32; WIDTH]>) -> u32 {
        let mut mask = 0;
        let mut first = 0;
        while first < WIDTH {
            let pad = slack.map(
                #[inline(always)]
                |slack| load::<L>(token, slack, first) * L::splat(token, self.magnitude),
            );
            let slabs = [
                self.cross(token, node, pad, first, 0),
                self.cross(token, node, pad, first, 1),
                self.cross(token, node, pad, first, 2),
            ];
            let (from, limit) = (L::splat(token, 0.0), L::splat(token, self.limit));
            mask |= enter(slabs, from, limit).1.bits() << first;
            first += L::WIDTH;
        }
        mask
    }

    /// Bounds on where the rays cross the planes of the children from `first` on along an axis.
    #[inline(always)]
    fn cross(&self, token: L::Token, node: &WideNode, pad: Option<L>, first: usize, axis: usize) -> (L, L) {
        let [low, high] = node.slab(token, pad, first, axis);
        let to = [low - self.origins[0][axis], high - self.origins[1][axis]];
        separate_origins(self.signs[axis], to, self.inverse[0][axis], self.inverse[1][axis])
    }

    /// The rays of a set that may enter a child within their limits, and where the first of them does.
    #[inline(always)]
    fn enter(
        &self,
        token: L::Token,
        node: &WideNode,
        slack: Option<&[f32; WIDTH]>,
        slot: usize,
        set: Set,
    ) -> (Set, f32) {
        let slot = slot & (WIDTH - 1);
        let pad = slack.map_or(0.0, |slack| slack[slot] * self.magnitude);
        let [x0, y0, z0, x1, y1, z1] = node.planes.map(|plane| plane[slot]);
        let low = splat::<L>(token, [x0 - pad, y0 - pad, z0 - pad]);
        let high = splat::<L>(token, [x1 + pad, y1 + pad, z1 + pad]);
        let (mut entered, mut first_near) = (0, L::splat(token, f32::MAX));
        let mut g = 0;
        while g < GROUPS {
            let shift = (g * WIDTH) as u32;
            if set >> shift & ((1 << WIDTH) - 1) != 0 {
                let group = &self.groups[g];
                let mut first = 0;
                while first < WIDTH {
                    let slabs = [
                        self.cross_group(token, [low[0], high[0]], g, first, 0),
                        self.cross_group(token, [low[1], high[1]], g, first, 1),
                        self.cross_group(token, [low[2], high[2]], g, first, 2),
                    ];
                    let (from, limit) = (load(token, &group.from, first), load(token, &group.limit, first));
                    let (near, is_entered) = enter(slabs, from, limit);
                    first_near = first_near.min(is_entered.select(near, first_near));
                    entered |= u64::from(is_entered.bits()) << (shift + first as u32);
                    first += L::WIDTH;
                }
            }
            g += 1;
        }
        (entered & set, first_near.smallest())
    }

    /// Where the rays of a group from `first` on enter and leave the slab between two planes across an axis.
    #[inline(always)]
    fn cross_group(&self, token: L::Token, planes: [L; 2], g: usize, first: usize, axis: usize) -> (L, L) {
        let [lower, upper] = &self.groups[g].origins;
        let origins = [load(token, &lower[axis], first), load(token, &upper[axis], first)];
        cross(planes, origins, self.rays.inverse(token, g * WIDTH + first, axis))
    }

    /// Takes over how far rays are still traced.
    #[inline(always)]
    pub fn limit<C: Collect>(&mut self, token: L::Token, set: Set, collect: &[C; PACKET]) {
        each(
            set,
            #[inline(always)]
            |number| {
                let (group, lane) = (&mut self.groups[number / WIDTH], number % WIDTH);
                let limit = collect[number].limit();
                group.limit[lane] = limit;
                self.active &= !(u64::from(limit < group.from[lane]) << number);
            },
        );
        let mut most = L::splat(token, -1.0);
        let mut g = 0;
        while g < GROUPS {
            let mut first = 0;
            while first < WIDTH {
                most = most.max(load(token, &self.groups[g].limit, first));
                first += L::WIDTH;
            }
            g += 1;
        }
        self.limit = most.largest();
    }
}

/// A child that waits.
#[derive(Clone, Copy)]
struct Waiting {
    /// No more than where the first of its rays enters it.
    near: f32,
    node: u32,
    slot: u32,
    set: Set,
}

/// Something that looks at what rays come through.
pub(super) trait PacketVisitor<L: Lane> {
    /// Looks at a leaf.
    fn leaf(&mut self, token: L::Token, first: u32, count: u32, set: Set, asked: &mut Asked<'_, L>);
    /// Follows few rays one by one from a node on.
    fn few(&mut self, token: L::Token, node: u32, set: Set, asked: &mut Asked<'_, L>);
}

/// Shows a visitor the leaves that rays may hit within their limits, roughly from near to far.
#[inline(always)]
pub(super) fn traverse<L: Lane>(
    token: L::Token,
    tree: &WideTree,
    slacks: Option<&[[f32; WIDTH]]>,
    asked: &mut Asked<'_, L>,
    visitor: &mut impl PacketVisitor<L>,
) {
    const NOTHING: Waiting = Waiting { near: 0.0, node: 0, slot: 0, set: 0 };
    // A stack is cleared for each search: most trees need a short one.
    let (mut short, mut long);
    let stack: &mut [Waiting] = if tree.depth <= SHALLOW {
        short = [NOTHING; WIDTH * SHALLOW];
        &mut short
    } else {
        long = [NOTHING; WIDTH * STACK];
        &mut long
    };
    let mut depth = 0;
    let (mut index, mut set) = (0, asked.active);
    loop {
        let node = &tree.nodes[index as usize];
        let slack = slacks.map(|slacks| &slacks[index as usize]);
        let mut remaining = asked.bounds(token, node, slack);
        let first = depth;
        while remaining != 0 {
            let slot = remaining.trailing_zeros();
            remaining &= remaining - 1;
            let (entered, near) = asked.enter(token, node, slack, slot as usize, set);
            if entered != 0 {
                let mut at = depth;
                while at > first && stack[at - 1].near < near {
                    stack[at] = stack[at - 1];
                    at -= 1;
                }
                stack[at] = Waiting { near, node: index, slot, set: entered };
                depth += 1;
            }
        }
        // The next node: leaves on the way are looked at.
        (index, set) = loop {
            if depth == 0 || asked.active == 0 {
                return;
            }
            depth -= 1;
            let Waiting { near, node: parent, slot, set } = stack[depth];
            let set = set & asked.active;
            if near > asked.limit || set == 0 {
                continue;
            }
            let node = &tree.nodes[parent as usize];
            match node.child(slot as usize) {
                Child::Node(child) if set.count_ones() > FEW => break (child, set),
                Child::Node(child) => visitor.few(token, child, set, asked),
                Child::Leaf(first, count) => {
                    let slack = slacks.map(|slacks| &slacks[parent as usize]);
                    let (set, _) = asked.enter(token, node, slack, slot as usize, set);
                    if set != 0 && count > 0 {
                        visitor.leaf(token, first, count, set, asked);
                    }
                }
            }
        };
    }
}
