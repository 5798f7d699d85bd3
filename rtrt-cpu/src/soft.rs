//! Frames with soft shadows. Penumbras reach from block to block, so all blocks find their
//! shadows before the first one blurs them, layer after layer.

use crate::block::{resolved, store};
use crate::clock::{Clock, LAYERS};
use crate::context::FrameContext;
use crate::instruction_set::{InstructionSet, LaneTask};
use crate::planes::{OF_SURFACE, Planes, Rows, count};
use crate::records::{Found, RawShadows, Records};
use crate::shadows::Shadows;
use crate::wide::Wide;
use rayon::iter::repeat_n;
use rayon::prelude::*;
use rtrt_core::grid::{BLOCK, BLOCK_RAYS, RayIndex, number};
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::lane::{Bits, Mask, Row, Select, groups};
use rtrt_core::layout::{Frame, NONE};
use rtrt_core::stage::context::Context;
use rtrt_core::stage::occlusion::{Arrival, potentially_lit, transmittance};
use rtrt_core::stage::peel::is_covered;
use rtrt_core::stage::penumbra_blocks::{PenumbraSummary, are_soft, common, edges_at, span};
use rtrt_core::stage::penumbra_filter::filter_penumbra;
use rtrt_core::stage::visibility::directions;
use std::time::Instant;

/// Rays in a block.
const RAYS: usize = BLOCK_RAYS as usize;
/// Words of a hit.
const HIT: usize = 5;

/// What a frame leaves from one pass over its blocks to the next, block after block. Words of a
/// block's rays are word after word, so that groups of rays find theirs side by side.
#[derive(Debug, Default)]
pub struct Soft {
    /// The hits; 0 where nothing has been looked for yet.
    hits: Vec<u32>,
    /// Whether no ray of a block looks for more.
    is_done: Vec<bool>,
    /// What the blur looks at: see [`count`].
    cells: Vec<u32>,
    planes: Planes,
    /// Of each block and light: see [`edges_at`].
    edges: Vec<PenumbraSummary>,
    /// Whether its shadows are blurred.
    is_soft: Vec<u32>,
    /// Whether a block is seen by one whose shadows are.
    is_seen: Vec<bool>,
    /// What is left of each light.
    transmittance: Vec<u32>,
    colors: Vec<[f32; 4]>,
}

impl Soft {
    /// Fills the tiles, the records (of all blocks, or none), and what is known of shadows before
    /// they are blurred.
    pub fn frame<'a>(
        &mut self,
        level: InstructionSet,
        context: &FrameContext<'_>,
        tiles: impl IndexedParallelIterator<Item = &'a mut [u32]>,
        records: &mut [Option<Records<'_>>],
        mut kept: Option<RawShadows<'_>>,
    ) -> Clock {
        self.reset(context.trace.frame);
        let blocks = context.trace.frame.grid().blocks() as usize;
        let mut clock = Clock::default();
        for number in 0..context.trace.frame.layers.max(1) {
            let frame =
                Frame { layers: context.trace.frame.layers.saturating_sub(number), ..*context.trace.frame };
            let shared = Shared { context, frame: &frame, number: number as usize };
            clock = clock.plus(self.find(level, shared));
            if let Some(kept) = kept.take() {
                keep(&frame, &self.cells, kept);
            }
            clock = clock.plus(self.choose(shared));
            clock = clock.plus(if records.is_empty() {
                self.lighten(level, shared, repeat_n((), blocks).map(|()| None))
            } else {
                self.lighten(level, shared, records.par_iter_mut().map(Option::as_mut))
            });
            if self.is_done.iter().all(|&is_done| is_done) {
                break;
            }
        }
        let encode = |(index, (tile, colors)): (usize, (&mut [u32], &[[f32; 4]]))| {
            level.run(Encode { context, index: index as u32, colors, tile })
        };
        let encoded = tiles.zip(self.colors.par_chunks(RAYS)).enumerate().map(encode);
        for (records, colors) in records.iter_mut().flatten().zip(self.colors.chunks(RAYS)) {
            records.colors.copy_from_slice(colors);
        }
        clock.plus(encoded.reduce(Clock::default, Clock::plus))
    }

    /// Makes room for a frame in which nothing has been seen.
    fn reset(&mut self, frame: &Frame) {
        let (all, blocks) = (frame.rays as usize, frame.grid().blocks() as usize);
        let lights = frame.lights as usize;
        self.hits.clear();
        self.hits.resize(all * HIT, 0);
        self.is_done.clear();
        self.is_done.resize(blocks, false);
        self.cells.resize(all * count(frame), 0);
        self.edges.resize(blocks * lights, PenumbraSummary::NONE);
        self.is_soft.resize(blocks * lights, 0);
        self.is_seen.resize(blocks, false);
        self.transmittance.resize(all * lights, 0);
        self.colors.clear();
        self.colors.resize(all, [0.0; 4]);
    }

    /// Finds the next surfaces, and their shadows before they are blurred.
    fn find(&mut self, level: InstructionSet, shared: Shared<'_>) -> Clock {
        let frame = shared.frame;
        let hits = self.hits.par_chunks_mut(RAYS * HIT).zip(&self.is_done);
        let cells = self.cells.par_chunks_mut(RAYS * count(frame));
        let edges = self.edges.par_chunks_mut(frame.lights as usize);
        hits.zip(cells)
            .zip(edges)
            .enumerate()
            .filter(|(_, (((_, is_done), _), _))| !**is_done)
            .map(|(index, (((hits, _), cells), edges))| {
                level.run(Find { shared, index: index as u32, hits, cells, edges })
            })
            .reduce(Clock::default, Clock::plus)
    }

    /// Finds the blocks whose shadows are to be blurred, and lays out what is seen from there.
    fn choose(&mut self, shared: Shared<'_>) -> Clock {
        let (start, frame) = (Instant::now(), shared.frame);
        let (lights, columns) = (frame.lights, frame.grid().blocks_x());
        let (edges, rows) = (&self.edges[..], frame.grid().blocks_y());
        self.is_soft.par_iter_mut().with_min_len(256).enumerate().for_each(|(at, is_soft)| {
            *is_soft = are_soft(frame, edges, at as u32 / lights, at as u32 % lights);
        });
        self.is_seen.fill(false);
        for block in 0..columns * rows {
            let first = edges_at(frame, block, 0);
            if self.is_soft[first..first + lights as usize].contains(&1) {
                let [left, right] = span(frame, block % columns, columns);
                let [top, bottom] = span(frame, block / columns, rows);
                for y in top..bottom {
                    self.is_seen[(y * columns + left) as usize..(y * columns + right) as usize].fill(true);
                }
            }
        }
        self.planes.fill(frame, &self.cells, &self.is_seen);
        let mut clock = Clock::default();
        clock.add(shared.stage(5), start);
        clock
    }

    /// Blurs the shadows, lights and shades.
    fn lighten<'a, 'b: 'a>(
        &mut self,
        level: InstructionSet,
        shared: Shared<'_>,
        records: impl IndexedParallelIterator<Item = Option<&'a mut Records<'b>>>,
    ) -> Clock {
        let lights = shared.frame.lights as usize;
        let (planes, is_soft) = (&self.planes, self.is_soft.par_chunks(lights));
        let cells = self.cells.par_chunks_mut(RAYS * count(shared.frame));
        let shadows = cells.zip(self.edges.par_chunks_mut(lights)).zip(is_soft);
        let transmittance =
            self.transmittance.par_chunks_mut(RAYS * lights).zip(self.colors.par_chunks_mut(RAYS));
        let hits = self.hits.par_chunks_mut(RAYS * HIT).zip(&mut self.is_done);
        shadows
            .zip(transmittance.zip(records))
            .zip(hits)
            .enumerate()
            .filter(|(_, (_, (_, is_done)))| !**is_done)
            .map(
                |(
                    index,
                    ((((cells, edges), is_soft), ((transmittance, colors), records)), (hits, is_done)),
                )| {
                    let index = index as u32;
                    let blur = level.run(Blur { shared, index, planes, is_soft, cells, transmittance });
                    let lighten = Lighten { shared, index, hits, is_done, transmittance, colors, records };
                    let lit = level.run(lighten);
                    if *is_done {
                        clear(cells, edges);
                    }
                    blur.plus(lit)
                },
            )
            .reduce(Clock::default, Clock::plus)
    }
}

/// Keeps what is left of lights and the sizes of penumbras, ray after ray.
fn keep(frame: &Frame, cells: &[u32], RawShadows { left, penumbras }: RawShadows<'_>) {
    for block in cells.chunks(RAYS * count(frame)) {
        for ray in 0..RAYS {
            for lights in block[OF_SURFACE * RAYS..].chunks(2 * RAYS) {
                left.push(lights[ray]);
                penumbras.push(f32::from_bits(lights[RAYS + ray]));
            }
        }
    }
}

/// Makes a block, of which nothing is left to be seen, one whose rays ask for no light.
fn clear(cells: &mut [u32], edges: &mut [PenumbraSummary]) {
    for (lights, edges) in cells[OF_SURFACE * RAYS..].chunks_mut(2 * RAYS).zip(edges) {
        let (left, sizes) = lights.split_at_mut(RAYS);
        left.fill(0);
        sizes.fill((-1.0_f32).to_bits());
        *edges = PenumbraSummary::of(0, -1.0);
    }
}

/// What all blocks share in a layer.
#[derive(Clone, Copy)]
struct Shared<'a> {
    context: &'a FrameContext<'a>,
    /// The context's, with the layers that are still looked at.
    frame: &'a Frame,
    /// How many layers there are before.
    number: usize,
}

impl Shared<'_> {
    /// The stages of a layer have the names of the first one's, the time does not.
    fn stage(&self, stage: usize) -> usize {
        if self.number == 0 { stage } else { LAYERS }
    }
}

/// The hits of a group of rays, from one of a block's on.
#[inline(always)]
fn load<L: Wide>(token: L::Token, hits: &[u32], first: usize) -> ClosestHit<L> {
    ClosestHit {
        t: L::from_bits(L::load(token, &hits[first..])),
        instance: L::load(token, &hits[RAYS + first..]),
        triangle: L::load(token, &hits[2 * RAYS + first..]),
        u: L::from_bits(L::load(token, &hits[3 * RAYS + first..])),
        v: L::from_bits(L::load(token, &hits[4 * RAYS + first..])),
    }
}

/// Finds the next surfaces of a block, and their shadows before they are blurred.
struct Find<'a> {
    shared: Shared<'a>,
    index: u32,
    hits: &'a mut [u32],
    cells: &'a mut [u32],
    edges: &'a mut [PenumbraSummary],
}

impl LaneTask for Find<'_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { shared, index, hits, cells, edges } = self;
        let Shared { context, frame, .. } = shared;
        let camera = context.trace.camera();
        let layer = Context { frame, ..context.trace };
        let (mut clock, mut start) = (Clock::default(), Instant::now());
        for first in (0..RAYS).step_by(L::WIDTH * G) {
            let ray = RayIndex(index * BLOCK_RAYS + first as u32);
            let last: [ClosestHit<L>; G] = groups(
                #[inline(always)]
                |g| load(token, hits, first + g * L::WIDTH),
            );
            let best = context.seen(token, frame, ray, &last);
            clock.lap(shared.stage(2), &mut start);
            let directions = directions::<L, G>(token, frame, camera, ray);
            let mut surfaces = context.surfaces(token, &directions, &best);
            clock.lap(shared.stage(3), &mut start);
            context.detail(token, &best, &mut surfaces);
            for g in 0..G {
                let at = first + g * L::WIDTH;
                let ClosestHit { t, instance, triangle, u, v } = best[g];
                let hit = [t.to_bits(), instance, triangle, u.to_bits(), v.to_bits()];
                for (plane, word) in hit.into_iter().enumerate() {
                    L::store(word, &mut hits[plane * RAYS + at..]);
                }
                let (origin, normal) = (surfaces[g].origin, surfaces[g].normal);
                let numbers = [origin.x, origin.y, origin.z, normal.x, normal.y, normal.z];
                for (plane, number) in numbers.into_iter().enumerate() {
                    L::store(number.to_bits(), &mut cells[plane * RAYS + at..]);
                }
            }
            clock.lap(shared.stage(4), &mut start);
            let origins = groups(
                #[inline(always)]
                |g| surfaces[g].origin,
            );
            for light in 0..frame.lights {
                let active = groups(
                    #[inline(always)]
                    |g| {
                        let ray = RayIndex(ray.0 + (g * L::WIDTH) as u32);
                        potentially_lit(frame, layer.views, light, ray, &surfaces[g])
                    },
                );
                let arrivals = L::outlined(
                    token,
                    #[inline(always)]
                    || transmittance::<L, true, G>(&layer, light, ray, &origins, &active),
                );
                let plane = (OF_SURFACE + 2 * light as usize) * RAYS;
                for (g, Arrival { transmittance, penumbra_radius }) in arrivals.into_iter().enumerate() {
                    let at = plane + first + g * L::WIDTH;
                    L::store(transmittance, &mut cells[at..]);
                    L::store(penumbra_radius.to_bits(), &mut cells[at + RAYS..]);
                }
            }
            clock.lap(shared.stage(5), &mut start);
        }
        let block = RayIndex(index * BLOCK_RAYS);
        for (lights, edges) in cells[OF_SURFACE * RAYS..].chunks(2 * RAYS).zip(edges) {
            let (left, sizes) = lights.split_at(RAYS);
            *edges = common(
                frame.grid(),
                block,
                #[inline(always)]
                |ray| PenumbraSummary::of(left[ray as usize], f32::from_bits(sizes[ray as usize])),
            );
        }
        clock.lap(shared.stage(5), &mut start);
        clock
    }
}

/// Blurs the shadows of a block. Where no penumbra reaches, or the same is left everywhere, they
/// stay as they are.
struct Blur<'a> {
    shared: Shared<'a>,
    index: u32,
    planes: &'a Planes,
    is_soft: &'a [u32],
    cells: &'a [u32],
    transmittance: &'a mut [u32],
}

impl LaneTask for Blur<'_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { shared, index, planes, is_soft, cells, transmittance } = self;
        let (frame, start) = (shared.frame, Instant::now());
        let [left, top] = frame.grid().ray(RayIndex(index * BLOCK_RAYS));
        for (light, transmittance) in transmittance.chunks_mut(RAYS).enumerate() {
            if is_soft[light] == 0 {
                transmittance.copy_from_slice(&cells[(OF_SURFACE + 2 * light) * RAYS..][..RAYS]);
                continue;
            }
            for y in 0..BLOCK {
                for x in (0..BLOCK).step_by(L::WIDTH) {
                    let rows = Rows::new(token, planes, [left + x, top + y], light as u32);
                    let words = L::outlined(
                        token,
                        #[inline(always)]
                        || filter_penumbra::<L, _>(frame, shared.context.trace.views, &rows, light as u32),
                    );
                    let words = words.row();
                    for lane in 0..L::WIDTH {
                        transmittance[number([x + lane as u32, y]) as usize] = words.at(lane);
                    }
                }
            }
        }
        let mut clock = Clock::default();
        clock.add(shared.stage(5), start);
        clock
    }
}

/// Lights and shades a block, and makes the rays that nothing shines through look for nothing
/// more.
struct Lighten<'a, 'b> {
    shared: Shared<'a>,
    index: u32,
    hits: &'a mut [u32],
    is_done: &'a mut bool,
    transmittance: &'a [u32],
    colors: &'a mut [[f32; 4]],
    records: Option<&'a mut Records<'b>>,
}

impl LaneTask for Lighten<'_, '_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { shared, index, hits, is_done, transmittance, colors, mut records } = self;
        let Shared { context, frame, number } = shared;
        let camera = context.trace.camera();
        let (mut clock, mut start) = (Clock::default(), Instant::now());
        *is_done = true;
        for first in (0..RAYS).step_by(L::WIDTH * G) {
            let ray = RayIndex(index * BLOCK_RAYS + first as u32);
            let best: [ClosestHit<L>; G] = groups(
                #[inline(always)]
                |g| load(token, hits, first + g * L::WIDTH),
            );
            let directions = directions::<L, G>(token, frame, camera, ray);
            let mut surfaces = context.surfaces(token, &directions, &best);
            clock.lap(shared.stage(3), &mut start);
            context.detail(token, &best, &mut surfaces);
            clock.lap(shared.stage(4), &mut start);
            let shadows = Shadows::Transmittance(token, &transmittance[first..]);
            let arriving = context.arriving(token, frame, ray, &directions, &surfaces, &shadows);
            clock.lap(shared.stage(6), &mut start);
            let mut sums: [[L; 4]; G] = groups(
                #[inline(always)]
                |g| {
                    let [color] = L::gather_fours(
                        token,
                        #[inline(always)]
                        |lane| [colors[first + g * L::WIDTH + lane]],
                    );
                    color
                },
            );
            context.shade(token, frame, &directions, &surfaces, &arriving, &mut sums);
            store(&sums, &mut colors[first..]);
            if let Some(records) = &mut records {
                let found =
                    Found { closest: &best, surfaces: &surfaces, shadows: &shadows, light: &arriving };
                records.keep(context.trace.frame, number, first, &found);
            }
            for g in 0..G {
                let instance = best[g].instance;
                let missing = instance.broadcast(NONE);
                let covered = is_covered(sums[g][3]).select(missing, instance);
                let instance = if frame.layers <= 1 { missing } else { covered };
                L::store(instance, &mut hits[RAYS + first + g * L::WIDTH..]);
                *is_done &= !(!instance.eq(missing)).any();
            }
            clock.lap(shared.stage(7), &mut start);
        }
        clock
    }
}

/// Makes the pixels of a block.
struct Encode<'a> {
    context: &'a FrameContext<'a>,
    index: u32,
    colors: &'a [[f32; 4]],
    tile: &'a mut [u32],
}

impl LaneTask for Encode<'_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { context, index, colors, tile } = self;
        let start = Instant::now();
        resolved::<L>(token, context, index, colors, tile);
        let mut clock = Clock::default();
        clock.add(9, start);
        clock
    }
}
