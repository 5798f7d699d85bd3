//! Frames with soft shadows. Penumbras reach from block to block, so all blocks find their
//! shadows before the first one blurs them, layer after layer.

use crate::block::{Clock, Job, LAYERS, Records, Shadows, resolved, store};
use crate::level::{Level, Work};
use crate::wide::Wide;
use bytemuck::Zeroable;
use rayon::prelude::*;
use rtrt_core::grid::{BLOCK, BLOCK_RAYS, BlockIndex, RayIndex};
use rtrt_core::kernel::traverse::Best;
use rtrt_core::lane::{Bits, Lane, Row, groups};
use rtrt_core::layout::{Frame, Hit, Surface};
use rtrt_core::stage::layers::is_covered;
use rtrt_core::stage::occlusion::ask;
use rtrt_core::stage::penumbra::{near, reach, size_at, soften};
use rtrt_core::stage::visibility::rays;
use std::time::Instant;

/// Rays in a block.
const RAYS: usize = BLOCK_RAYS as usize;

/// What a frame leaves from one pass over its blocks to the next, one record a ray.
#[derive(Debug, Default)]
pub struct Soft {
    hits: Vec<Hit>,
    surfaces: Vec<Surface>,
    /// See [`rtrt_core::stage::penumbra::left_at`].
    shadows: Vec<u32>,
    tints: Vec<u32>,
    colors: Vec<[f32; 4]>,
}

/// Where to keep what the first layer's shadows are before they are blurred.
pub struct Kept<'a> {
    pub left: &'a mut Vec<u32>,
    pub penumbras: &'a mut Vec<f32>,
}

impl Soft {
    /// Fills the tiles, the records, and what is known of shadows before they are blurred.
    pub fn frame<'a>(
        &mut self,
        level: Level,
        job: &Job<'_>,
        tiles: impl IndexedParallelIterator<Item = &'a mut [u32]>,
        mut records: Vec<Option<Records<'_>>>,
        mut kept: Option<Kept<'_>>,
    ) -> Clock {
        let frame = job.frame;
        let (all, lights) = (frame.rays as usize, frame.lights as usize);
        self.hits.clear();
        self.hits.resize(all, Hit::zeroed());
        self.surfaces.resize(all, Surface::zeroed());
        self.shadows.resize(2 * all * lights, 0);
        self.tints.resize(all * lights, 0);
        self.colors.clear();
        self.colors.resize(all, [0.0; 4]);
        let mut clock = Clock::default();
        for number in 0..frame.layers.max(1) {
            let frame = Frame { layers: frame.layers.saturating_sub(number), ..*frame };
            let shared = Shared { job, frame: &frame, number: number as usize };
            let (left, sizes) = self.shadows.split_at_mut(all * lights);
            let found = self
                .hits
                .par_chunks_mut(RAYS)
                .zip(self.surfaces.par_chunks_mut(RAYS))
                .zip(left.par_chunks_mut(RAYS * lights).zip(sizes.par_chunks_mut(RAYS * lights)))
                .enumerate()
                .map(|(block, ((hits, surfaces), (left, sizes)))| {
                    level.run(Find { shared, index: block as u32, hits, surfaces, left, sizes })
                })
                .reduce(Clock::default, Clock::plus);
            if let Some(Kept { left, penumbras }) = kept.take() {
                left.extend_from_slice(&self.shadows[..all * lights]);
                penumbras.extend(self.shadows[all * lights..].iter().map(|&bits| f32::from_bits(bits)));
            }
            let edges = Edges::of(&frame, &self.shadows);
            let (surfaces, shadows) = (&self.surfaces[..], &self.shadows[..]);
            let (lit, is_done) = self
                .hits
                .par_chunks_mut(RAYS)
                .zip(self.tints.par_chunks_mut(RAYS * lights))
                .zip(self.colors.par_chunks_mut(RAYS).zip(&mut records))
                .enumerate()
                .map(|(block, ((hits, tints), (colors, records)))| {
                    let index = block as u32;
                    let start = Instant::now();
                    blur(&frame, job, surfaces, shadows, &edges, index, tints);
                    let mut clock = Clock::default();
                    clock.add(shared.stage(5), start);
                    let (lit, is_done) =
                        level.run(Lighten { shared, index, hits, tints, colors, records: records.as_mut() });
                    (clock.plus(lit), is_done)
                })
                .reduce(|| (Clock::default(), true), |(a, first), (b, second)| (a.plus(b), first & second));
            clock = clock.plus(found).plus(lit);
            if is_done {
                break;
            }
        }
        let encoded = tiles
            .zip(self.colors.par_chunks(RAYS))
            .zip(records)
            .enumerate()
            .map(|(block, ((tile, colors), records))| {
                if let Some(records) = records {
                    records.colors.copy_from_slice(colors);
                }
                level.run(Encode { job, index: block as u32, colors, tile })
            })
            .reduce(Clock::default, Clock::plus);
        clock.plus(encoded)
    }
}

/// What all blocks share in a layer.
#[derive(Clone, Copy)]
struct Shared<'a> {
    job: &'a Job<'a>,
    /// The job's, with the layers that are still looked at.
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

/// The hits of a group of rays.
#[inline(always)]
fn load<L: Lane>(token: L::Token, hits: &[Hit]) -> Best<L> {
    let [t, u, v] = L::gather(
        token,
        #[inline(always)]
        |lane| [hits[lane].t, hits[lane].u, hits[lane].v],
    );
    let object = L::bits_from_fn(
        token,
        #[inline(always)]
        |lane| hits[lane].object,
    );
    let triangle = L::bits_from_fn(
        token,
        #[inline(always)]
        |lane| hits[lane].triangle,
    );
    Best { t, object, triangle, u, v }
}

/// Finds the next surfaces of a block, and their shadows before they are blurred.
struct Find<'a> {
    shared: Shared<'a>,
    index: u32,
    hits: &'a mut [Hit],
    surfaces: &'a mut [Surface],
    left: &'a mut [u32],
    sizes: &'a mut [u32],
}

impl Work for Find<'_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { shared, index, hits, surfaces: kept, left, sizes } = self;
        let Shared { job, frame, .. } = shared;
        let Job { views, lists, geometry, .. } = job;
        let camera = &views[Frame::CAMERA as usize];
        let lights = frame.lights as usize;
        let (mut clock, mut start) = (Clock::default(), Instant::now());
        for first in (0..RAYS).step_by(L::WIDTH * G) {
            let ray = RayIndex(index * BLOCK_RAYS + first as u32);
            let last: [Best<L>; G] = groups(
                #[inline(always)]
                |g| load(token, &hits[first + g * L::WIDTH..]),
            );
            let best = job.seen(token, frame, ray, &last);
            clock.lap(shared.stage(2), &mut start);
            let rays = rays::<L, G>(token, frame, camera, ray);
            let surfaces = job.surfaces(token, &rays, &best);
            clock.lap(shared.stage(3), &mut start);
            let surfaces = job.detailed(token, &best, surfaces);
            for g in 0..G {
                let at = first + g * L::WIDTH;
                let (found, rows) = (best[g].rows(), surfaces[g].rows());
                for lane in 0..L::WIDTH {
                    hits[at + lane] = found.hit(lane);
                    kept[at + lane] = rows.lane(lane);
                }
            }
            clock.lap(shared.stage(4), &mut start);
            let origins = groups(
                #[inline(always)]
                |g| surfaces[g].origin,
            );
            for light in 0..frame.lights {
                let asked = groups(
                    #[inline(always)]
                    |g| {
                        let ray = RayIndex(ray.0 + (g * L::WIDTH) as u32);
                        ask(frame, views, light, ray, &surfaces[g])
                    },
                );
                let found = L::apart(
                    token,
                    #[inline(always)]
                    || near::<L, G>(frame, views, lists, geometry, light, ray, &origins, &asked),
                );
                for (g, (word, size)) in found.into_iter().enumerate() {
                    let (word, size) = (word.row(), size.to_bits().row());
                    for lane in 0..L::WIDTH {
                        let at = (first + g * L::WIDTH + lane) * lights + light as usize;
                        (left[at], sizes[at]) = (word.at(lane), size.at(lane));
                    }
                }
            }
            clock.lap(shared.stage(5), &mut start);
        }
        clock
    }
}

/// Where shadows have edges that are to be blurred.
struct Edges {
    /// For each block and light, whether any of its rays has a penumbra, and whether anything of
    /// the light is left at any.
    has: Vec<[bool; 2]>,
}

impl Edges {
    fn of(frame: &Frame, shadows: &[u32]) -> Self {
        let lights = frame.lights as usize;
        let (left, sizes) = shadows.split_at(size_at(frame, 0, 0));
        let mut has = vec![[false; 2]; frame.grid().blocks() as usize * lights];
        has.par_chunks_mut(lights)
            .zip(left.par_chunks(RAYS * lights).zip(sizes.par_chunks(RAYS * lights)))
            .for_each(|(has, (left, sizes))| {
                for (at, (&left, &size)) in left.iter().zip(sizes).enumerate() {
                    has[at % lights][0] |= f32::from_bits(size) > 0.0;
                    has[at % lights][1] |= left != 0;
                }
            });
        Self { has }
    }

    /// Whether a block sees both a penumbra of the light and something that is left of it.
    fn are_near(&self, frame: &Frame, block: BlockIndex, light: u32) -> bool {
        let (columns, rows) = (frame.grid().blocks_x(), frame.grid().blocks_y());
        let (x, y, around) = (block.0 % columns, block.0 / columns, reach(frame).div_ceil(BLOCK));
        let near = |at: u32, count: u32| at.saturating_sub(around)..(at + around + 1).min(count);
        let blocks = || near(y, rows).flat_map(|y| near(x, columns).map(move |x| y * columns + x));
        (0..2).all(|what| blocks().any(|block| self.has[(block * frame.lights + light) as usize][what]))
    }
}

/// Blurs the shadows of a block. Where no penumbra reaches, or all is dark, they stay as they are.
fn blur(
    frame: &Frame,
    job: &Job<'_>,
    surfaces: &[Surface],
    shadows: &[u32],
    edges: &Edges,
    block: u32,
    tints: &mut [u32],
) {
    let lights = frame.lights;
    let first = block * BLOCK_RAYS;
    tints.copy_from_slice(&shadows[(first * lights) as usize..][..tints.len()]);
    for light in (0..lights).filter(|&light| edges.are_near(frame, BlockIndex(block), light)) {
        for ray in 0..BLOCK_RAYS {
            tints[(ray * lights + light) as usize] =
                soften(frame, job.views, surfaces, shadows, first + ray, light);
        }
    }
}

/// Lights and shades a block, and makes the rays that nothing shines through look for nothing
/// more; whether those are all.
struct Lighten<'a, 'b> {
    shared: Shared<'a>,
    index: u32,
    hits: &'a mut [Hit],
    tints: &'a [u32],
    colors: &'a mut [[f32; 4]],
    records: Option<&'a mut Records<'b>>,
}

impl Work for Lighten<'_, '_> {
    type Output = (Clock, bool);

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> (Clock, bool) {
        let Self { shared, index, hits, tints, colors, mut records } = self;
        let Shared { job, frame, number } = shared;
        let camera = &job.views[Frame::CAMERA as usize];
        let lights = frame.lights as usize;
        let (mut clock, mut start) = (Clock::default(), Instant::now());
        let mut is_done = true;
        for first in (0..RAYS).step_by(L::WIDTH * G) {
            let ray = RayIndex(index * BLOCK_RAYS + first as u32);
            let best: [Best<L>; G] = groups(
                #[inline(always)]
                |g| load(token, &hits[first + g * L::WIDTH..]),
            );
            let rays = rays::<L, G>(token, frame, camera, ray);
            let surfaces = job.surfaces(token, &rays, &best);
            clock.lap(shared.stage(3), &mut start);
            let surfaces = job.detailed(token, &best, surfaces);
            clock.lap(shared.stage(4), &mut start);
            let mut colored = Vec::with_capacity(lights);
            for light in 0..lights {
                let group: [L::Bits; G] = groups(
                    #[inline(always)]
                    |g| {
                        L::bits_from_fn(
                            token,
                            #[inline(always)]
                            |lane| tints[(first + g * L::WIDTH + lane) * lights + light],
                        )
                    },
                );
                colored.push(group);
            }
            let shadows = Shadows::of(frame, surfaces[0].material.like(0), colored);
            let arriving = job.arriving(token, frame, ray, &rays, &surfaces, &shadows);
            clock.lap(shared.stage(6), &mut start);
            let mut sums: [[L; 4]; G] = groups(
                #[inline(always)]
                |g| {
                    L::gather(
                        token,
                        #[inline(always)]
                        |lane| colors[first + g * L::WIDTH + lane],
                    )
                },
            );
            job.shade(token, frame, &rays, &surfaces, &arriving, &mut sums);
            store(&sums, &mut colors[first..]);
            if let Some(records) = &mut records {
                records.keep(job.frame, number, first, &best, &surfaces, &shadows, &arriving);
            }
            for at in first..first + L::WIDTH * G {
                if frame.layers <= 1 || is_covered(colors[at][3]) {
                    hits[at] = Hit::MISS;
                }
                is_done &= hits[at] == Hit::MISS;
            }
            clock.lap(shared.stage(7), &mut start);
        }
        (clock, is_done)
    }
}

/// Makes the pixels of a block.
struct Encode<'a> {
    job: &'a Job<'a>,
    index: u32,
    colors: &'a [[f32; 4]],
    tile: &'a mut [u32],
}

impl Work for Encode<'_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { job, index, colors, tile } = self;
        let start = Instant::now();
        resolved::<L>(token, job, index, colors, tile);
        let mut clock = Clock::default();
        clock.add(9, start);
        clock
    }
}
