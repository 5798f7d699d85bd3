//! The steps of a packet, which need no other packet. Those that trace or shade run outlined, so that they are compiled once
//! for each instruction set, and are spread over files, each of which can be a unit of compilation
//! (`Outline` in `wide/simd.rs`).

mod ambient;
mod light;
mod record;
mod shade;
mod shadow;
mod surface;
mod trace;

use crate::block::RAYS;
use crate::clock::Clock;
use crate::context::FrameContext;
use crate::instant::Instant;
use crate::records::Records;
use crate::shadows::Shadows;
use crate::wide::Wide;
use alloc::vec::Vec;
use rtrt_core::grid::{BLOCK_RAYS, RayIndex};
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::lane::{Bits, Lane, Mask, Select, V3, groups};
use rtrt_core::layout::{Frame, Hit, NONE};
use rtrt_core::schedule::{Pass, Step};
use rtrt_core::stage::ambient::Record;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::light::IncomingLight;
use rtrt_core::stage::peel::is_covered;
use rtrt_core::stage::share;
use rtrt_core::stage::surface::Surfaces;
use rtrt_core::stage::visibility::directions;

/// Words of a hit.
pub const HIT: usize = 5;

/// Planes of what rays have found: [`HIT`] of hits, then three of directions.
pub type Found = [[u32; RAYS]; HIT + 3];

/// What the rays of a block leave for later steps, ray after ray or, of words, plane after plane: the first
/// word of all rays, then the second.
pub struct Rays<'a> {
    /// [`Frame::RECORDS`] planes.
    pub colors: &'a mut [[f32; 4]],
    /// Where they are not bits.
    pub shadows: &'a mut Shadows,
    /// [`HIT`] planes, where blocks wait for one another.
    pub hits: &'a mut [u32],
    /// [`PLACES`](crate::block::PLACES) planes, where penumbras are filtered.
    pub places: &'a mut [u32],
    /// In frames that ask for light from all around.
    pub ambient: &'a mut [Record],
    /// The ray whose color each takes, in frames where [`Frame::is_shared`] is 1.
    pub shaded: &'a mut [u8],
}

impl<'a> Rays<'a> {
    /// For steps that leave nothing but shadows.
    pub fn nothing(shadows: &'a mut Shadows) -> Self {
        let (colors, ambient) = (&mut [][..], &mut [][..]);
        Self { colors, shadows, hits: &mut [], places: &mut [], ambient, shaded: &mut [] }
    }
}

/// A packet, and the results of its last steps.
pub struct PacketState<'a, L: Wide, const G: usize> {
    token: L::Token,
    context: &'a FrameContext<'a>,
    /// Its first ray, and the number of that ray in the block.
    ray: RayIndex,
    first: usize,
    directions: [V3<L>; G],
    closest: [ClosestHit<L>; G],
    surfaces: [Surfaces<L>; G],
    incoming: [IncomingLight<L>; G],
    /// The first word of the shadow masks, where shadows are bits; and those of scenes with more lights.
    mask: [L::Bits; G],
    more_masks: Vec<[L::Bits; G]>,
    /// The groups that have rays.
    groups: usize,
    /// Whether the layers so far cover everything behind them.
    pub is_done: bool,
}

impl<'a, L: Wide, const G: usize> PacketState<'a, L, G> {
    /// The packet from the ray numbered `first` of a block on, which has not looked for anything yet.
    #[inline(always)]
    pub fn new(token: L::Token, context: &'a FrameContext<'a>, block: u32, first: usize) -> Self {
        let ray = RayIndex(block * BLOCK_RAYS + first as u32);
        let directions = directions(token, context.trace.frame, context.trace.camera(), ray);
        Self::at(token, context, ray, first, directions)
    }

    /// Rays in these directions.
    #[inline(always)]
    fn at(
        token: L::Token,
        context: &'a FrameContext<'a>,
        ray: RayIndex,
        first: usize,
        directions: [V3<L>; G],
    ) -> Self {
        let zero = L::splat(token, 0.0);
        let none = zero.broadcast_bits(0);
        let unfound = ClosestHit { t: zero, instance: none, triangle: none, u: zero, v: zero };
        Self {
            token,
            context,
            ray,
            first,
            directions,
            closest: [unfound; G],
            surfaces: [no_surface(token); G],
            incoming: [IncomingLight::dark(token); G],
            mask: [none; G],
            more_masks: Vec::new(),
            groups: G,
            is_done: false,
        }
    }

    /// A packet of rays of any blocks, which have found what they look for: the first `count` of these.
    #[inline(always)]
    pub fn of(token: L::Token, context: &'a FrameContext<'a>, found: &Found, count: usize) -> Self {
        let [.., xs, ys, zs] = found;
        let directions = groups(
            #[inline(always)]
            |g| V3 {
                x: L::from_bits(L::load(token, &xs[g * L::WIDTH..])),
                y: L::from_bits(L::load(token, &ys[g * L::WIDTH..])),
                z: L::from_bits(L::load(token, &zs[g * L::WIDTH..])),
            },
        );
        let mut packet = Self::at(token, context, RayIndex(0), 0, directions);
        packet.groups = count.div_ceil(L::WIDTH);
        packet.load(found.as_flattened());
        packet
    }

    /// Runs steps that follow one another.
    #[inline(always)]
    pub fn run_all(
        &mut self,
        steps: &[Step],
        rays: &mut Rays<'_>,
        records: Option<&mut Records<'_>>,
        clock: &mut Clock,
        start: &mut Instant,
    ) {
        let frame = self.context.trace.frame;
        let Step { pass, layer } = steps[0];
        let follows_barrier = !matches!(pass, Pass::Visibility | Pass::Peel);
        if follows_barrier {
            self.load(rays.hits);
        }
        // Surfaces are found again: they have far more words than hits.
        let again = [Pass::Surface, Pass::Detail].map(|pass| Step { pass, layer });
        let count = if follows_barrier { 1 + frame.details as usize } else { 0 };
        let steps = again.into_iter().take(count).chain(steps.iter().copied());
        self.run_steps(steps, rays, records, clock, start);
        if !rays.hits.is_empty() {
            self.store(rays.hits);
        }
    }

    /// Runs steps on what the last ones have left in the packet.
    #[inline(always)]
    pub fn run_steps(
        &mut self,
        steps: impl Iterator<Item = Step>,
        rays: &mut Rays<'_>,
        mut records: Option<&mut Records<'_>>,
        clock: &mut Clock,
        start: &mut Instant,
    ) {
        let frame = self.context.trace.frame;
        for step in steps {
            if !self.is_done {
                self.run(step, &frame.of_layer(step.layer), rays, records.as_deref_mut());
                clock.lap(step.stage(), start);
            } else if step.pass == Pass::BlockerSearch {
                // Neighbors read what a search finds, though it be nothing.
                rays.shadows.clear_all(self.range());
            }
        }
    }

    /// Takes over the hits of earlier steps.
    #[inline(always)]
    fn load(&mut self, hits: &[u32]) {
        let plane = |number: usize, g: usize| &hits[number * RAYS + self.first + g * L::WIDTH..];
        for g in 0..G {
            self.closest[g] = ClosestHit {
                t: L::from_bits(L::load(self.token, plane(0, g))),
                instance: L::load(self.token, plane(1, g)),
                triangle: L::load(self.token, plane(2, g)),
                u: L::from_bits(L::load(self.token, plane(3, g))),
                v: L::from_bits(L::load(self.token, plane(4, g))),
            };
        }
    }

    /// Leaves the hits to later steps.
    #[inline(always)]
    fn store(&self, hits: &mut [u32]) {
        for g in 0..G {
            let ClosestHit { t, instance, triangle, u, v } = self.closest[g];
            let at = self.first + g * L::WIDTH;
            L::store(t.to_bits(), &mut hits[at..]);
            L::store(instance, &mut hits[RAYS + at..]);
            L::store(triangle, &mut hits[2 * RAYS + at..]);
            L::store(u.to_bits(), &mut hits[3 * RAYS + at..]);
            L::store(v.to_bits(), &mut hits[4 * RAYS + at..]);
        }
    }

    /// Leaves hits and directions.
    #[inline(always)]
    pub fn leave(&self, found: &mut Found) {
        self.store(found.as_flattened_mut());
        let [.., xs, ys, zs] = found;
        for g in 0..G {
            let V3 { x, y, z } = self.directions[g];
            let at = self.first + g * L::WIDTH;
            L::store(x.to_bits(), &mut xs[at..]);
            L::store(y.to_bits(), &mut ys[at..]);
            L::store(z.to_bits(), &mut zs[at..]);
        }
    }

    /// Runs a step on the frame as its layer sees it.
    #[inline(always)]
    fn run(&mut self, step: Step, frame: &Frame, rays: &mut Rays<'_>, records: Option<&mut Records<'_>>) {
        let context = Context { frame, ..self.context.trace };
        match step.pass {
            Pass::Visibility => self.visibility(&context),
            Pass::Peel => self.peel(&context),
            Pass::Share => self.share(rays.shaded),
            Pass::EndCovered => self.end_covered(rays.colors),
            Pass::Surface => self.surface(),
            Pass::Detail => self.detail(),
            Pass::Occlusion => self.occlusion(&context),
            Pass::Transmittance => self.transmittance(&context, rays.shadows),
            Pass::BlockerSearch => self.blocker_search(&context, rays),
            Pass::Ambient => self.ambient(&context, rays.ambient),
            Pass::Light => self.light(frame, rays.shadows),
            Pass::Shade | Pass::Blend => {
                self.shade(step, frame, rays.colors, rays.ambient);
                if let Some(records) = records {
                    self.record(step.layer, rays.shadows, records);
                }
            }
            // Records hold the mask: it is found when they are written.
            Pass::Mask => {}
            // These are not steps of a packet; and this backend draws nothing.
            Pass::Prepare
            | Pass::Bin
            | Pass::Pick
            | Pass::SummarizePenumbras
            | Pass::SelectFilterBlocks
            | Pass::FilterPenumbra
            | Pass::Resolve => {}
        }
    }

    /// Ends the rays whose colors let nothing through.
    #[inline(always)]
    fn end_covered(&mut self, colors: &[[f32; 4]]) {
        self.is_done = true;
        for g in 0..G {
            let at = self.first + g * L::WIDTH;
            let [alpha] = L::gather(
                self.token,
                #[inline(always)]
                |lane| [colors[at + lane][3]],
            );
            let instance = &mut self.closest[g].instance;
            let missing = instance.broadcast(NONE);
            *instance = is_covered(alpha).select(missing, *instance);
            self.is_done &= !(!instance.eq(missing)).any();
        }
    }

    /// Lets hits take the colors of others.
    #[inline(always)]
    fn share(&mut self, shaded: &mut [u8]) {
        let frame = self.context.trace.frame;
        let mut hits = [Hit::MISS; RAYS];
        for g in 0..G {
            let rows = self.closest[g].rows();
            for lane in 0..L::WIDTH {
                hits[g * L::WIDTH + lane] = rows.hit(lane);
            }
        }
        for ray in 0..(G * L::WIDTH) as u32 {
            let at = frame.grid().ray(RayIndex(self.ray.0 + ray));
            if frame.grid().contains(at) && at.iter().all(|at| at % frame.side == 0) {
                share::share(frame, &mut hits, ray);
            }
        }
        for (ray, hit) in hits[..G * L::WIDTH].iter().enumerate() {
            shaded[self.first + ray] = share::shaded((self.first + ray) as u32, hit) as u8;
        }
        for g in 0..G {
            self.closest[g] = ClosestHit::from_fn(
                self.token,
                #[inline(always)]
                |lane| hits[g * L::WIDTH + lane],
            );
        }
    }
}

/// What is known of surfaces before any is found.
#[inline(always)]
fn no_surface<L: Lane>(token: L::Token) -> Surfaces<L> {
    let zero = L::splat(token, 0.0);
    let (nothing, none) = (V3 { x: zero, y: zero, z: zero }, zero.broadcast_bits(0));
    Surfaces {
        origin: nothing,
        normal: nothing,
        material: none,
        color: [none; 2],
        uv: [zero; 2],
        footprint: zero,
        second_uv: [zero; 2],
        second_footprint: zero,
        variance: zero,
        coat_normal: none,
        tangent: none,
    }
}
