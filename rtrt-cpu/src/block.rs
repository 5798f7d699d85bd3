//! All stages of one block, on one thread: what a stage leaves for the next stays in the
//! first-level cache.

use crate::clock::{Clock, LAYERS};
use crate::instruction_set::LaneTask;
use crate::records::Records;
use crate::wide::Wide;
use rayon::prelude::*;
use rtrt_core::grid::{BLOCK_RAYS, BlockIndex, Grid, RayIndex};
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::kernel::traverse::{ClosestHit, Geometry};
use rtrt_core::lane::{Bits, Lane, Mask, Row, Select, V3, groups};
use rtrt_core::layout::{Attribute, Frame, MaterialRecord, NONE, View};
use rtrt_core::stage::detail::detail;
use rtrt_core::stage::light::{IncomingLight, light};
use rtrt_core::stage::peel::{blend, is_covered, peel};
use rtrt_core::stage::surface::{Surfaces, Vertices, surface};
use rtrt_core::stage::visibility::{directions, visibility};
use rtrt_core::stage::{occlusion, resolve::resolve, shade::shade};
use std::time::Instant;

/// What every block of a frame shares.
pub struct FrameContext<'a> {
    pub frame: &'a Frame,
    pub views: &'a [View],
    pub lists: BlockLists<'a>,
    pub geometry: Geometry<'a>,
    pub attributes: &'a [Attribute],
    pub materials: &'a [MaterialRecord],
    pub texels: &'a [u32],
}

/// A block to be rendered, packet after packet, into its pixels and, if wanted, its records.
pub struct Block<'a> {
    pub context: &'a FrameContext<'a>,
    pub index: u32,
    pub tile: &'a mut [u32],
    /// See [`transmittance_words`].
    pub transmittance: &'a mut [u32],
    pub records: Option<Records<'a>>,
}

impl LaneTask for Block<'_> {
    type Output = Clock;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Clock {
        let Self { context, index, tile, transmittance, mut records } = self;
        let mut clock = Clock::default();
        let mut colors = [[0.0; 4]; BLOCK_RAYS as usize];
        let packet = L::WIDTH * G;
        for first in (0..BLOCK_RAYS as usize).step_by(packet) {
            let ray = RayIndex(index * BLOCK_RAYS + first as u32);
            // Where none are kept, a block has one word.
            let kept = first.min(transmittance.len());
            let transmittance = &mut transmittance[kept..];
            packet_colors::<L, G>(
                token,
                context,
                ray,
                first,
                &mut colors,
                transmittance,
                records.as_mut(),
                &mut clock,
            );
        }
        let mut start = Instant::now();
        resolved::<L>(token, context, index, &colors, tile);
        clock.lap(9, &mut start);
        clock
    }
}

/// The pixels of a block of these colors.
#[inline(always)]
pub fn resolved<L: Wide>(
    token: L::Token,
    context: &FrameContext<'_>,
    index: u32,
    colors: &[[f32; 4]],
    tile: &mut [u32],
) {
    let grid = context.frame.grid();
    // A power of two.
    let side = grid.block_pixels();
    let (across, down) = (side - 1, side.trailing_zeros());
    let [left, top] = grid.ray(RayIndex(index * BLOCK_RAYS)).map(|ray| ray / grid.side);
    for (first, pixels) in (0..).step_by(L::WIDTH).zip(tile.chunks_mut(L::WIDTH)) {
        let bits = resolve::<L>(
            token,
            grid,
            #[inline(always)]
            |lane| [left + ((first + lane as u32) & across), top + ((first + lane as u32) >> down)],
            #[inline(always)]
            |ray| colors[(ray.0 % BLOCK_RAYS) as usize],
        );
        let bits = bits.row();
        for (lane, pixel) in pixels.iter_mut().enumerate() {
            *pixel = bits.at(lane);
        }
    }
}

/// The stages of a packet that need nothing of others. (Each is one function for all that call
/// it, so that it is compiled once for each level.) `frame` is the context's, but for the layers that
/// are still looked at.
impl FrameContext<'_> {
    /// The closest surfaces; where not all is opaque, the closest behind the last.
    #[inline(always)]
    pub fn seen<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        frame: &Frame,
        ray: RayIndex,
        last: &[ClosestHit<L>; G],
    ) -> [ClosestHit<L>; G] {
        let FrameContext { views, lists, geometry, .. } = self;
        if frame.layers == 0 {
            L::outlined(
                token,
                #[inline(always)]
                || visibility::<L, G>(token, frame, views, lists, geometry, ray),
            )
        } else {
            L::outlined(
                token,
                #[inline(always)]
                || peel::<L, G>(token, frame, views, lists, geometry, ray, last),
            )
        }
    }

    /// What is known about them.
    #[inline(always)]
    pub fn surfaces<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        directions: &[V3<L>; G],
        best: &[ClosestHit<L>; G],
    ) -> [Surfaces<L>; G] {
        let FrameContext { views, geometry, attributes, .. } = self;
        let camera = &views[Frame::CAMERA as usize];
        L::outlined(
            token,
            #[inline(always)]
            || {
                groups(
                    #[inline(always)]
                    |g| surface(camera, geometry, attributes, directions[g], &best[g]),
                )
            },
        )
    }

    /// What normal maps and second texture coordinates tell of them.
    #[inline(always)]
    pub fn detail<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        best: &[ClosestHit<L>; G],
        surfaces: &mut [Surfaces<L>; G],
    ) {
        let FrameContext { geometry, attributes, materials, texels, .. } = self;
        if self.frame.details != 0 {
            let maps = Maps { materials, texels };
            let vertices =
                Vertices { instances: geometry.instances, mesh_data: geometry.mesh_data, attributes };
            L::outlined(
                token,
                #[inline(always)]
                || {
                    for g in 0..G {
                        surfaces[g] = detail(&maps, &vertices, &best[g], &surfaces[g]);
                    }
                },
            );
        }
    }

    /// The light that arrives there.
    #[inline(always)]
    pub fn arriving<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        frame: &Frame,
        first: RayIndex,
        directions: &[V3<L>; G],
        surfaces: &[Surfaces<L>; G],
        shadows: &Shadows<'_, L, G>,
    ) -> [IncomingLight<L>; G] {
        let FrameContext { views, materials, texels, .. } = self;
        let none = surfaces[0].material.broadcast(0);
        let maps = Maps { materials, texels };
        L::outlined(
            token,
            #[inline(always)]
            || {
                groups(
                    #[inline(always)]
                    |g| {
                        light(
                            frame,
                            views,
                            &maps,
                            #[inline(always)]
                            |word| shadows.word(frame, word, none, g),
                            #[inline(always)]
                            |light| shadows.transmittance(light, none, g),
                            RayIndex(first.0 + (g * L::WIDTH) as u32),
                            directions[g],
                            &surfaces[g],
                        )
                    },
                )
            },
        )
    }

    /// Adds the colors of a layer to those before it.
    #[inline(always)]
    pub fn shade<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        frame: &Frame,
        directions: &[V3<L>; G],
        surfaces: &[Surfaces<L>; G],
        arriving: &[IncomingLight<L>; G],
        sums: &mut [[L; 4]; G],
    ) {
        let maps = Maps { materials: self.materials, texels: self.texels };
        L::outlined(
            token,
            #[inline(always)]
            || {
                for g in 0..G {
                    let shaded = shade(frame, &maps, directions[g], &surfaces[g], &arriving[g]);
                    sums[g] = if frame.layers == 0 { shaded } else { blend(frame, sums[g], shaded) };
                }
            },
        );
    }
}

/// The colors of one packet: the first layer of surfaces, and those behind it that can be seen.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "each is a number of its own")]
fn packet_colors<L: Wide, const G: usize>(
    token: L::Token,
    context: &FrameContext<'_>,
    ray: RayIndex,
    first: usize,
    colors: &mut [[f32; 4]],
    transmittance: &mut [u32],
    mut records: Option<&mut Records<'_>>,
    clock: &mut Clock,
) {
    let mut frame = *context.frame;
    let camera = &context.views[Frame::CAMERA as usize];
    let mut start = Instant::now();
    let zero = L::splat(token, 0.0);
    let none = zero.broadcast_bits(0);
    let mut best: [ClosestHit<L>; G] = groups(
        #[inline(always)]
        |_| ClosestHit { t: zero, instance: none, triangle: none, u: zero, v: zero },
    );
    let mut sums = [[zero; 4]; G];
    for number in 0.. {
        // The stages of a layer have the names of the first one's, the time does not.
        let stage = |stage: usize| if number == 0 { stage } else { LAYERS };
        best = context.seen(token, &frame, ray, &best);
        clock.lap(stage(2), &mut start);
        let directions = directions::<L, G>(token, &frame, camera, ray);
        let mut surfaces = context.surfaces(token, &directions, &best);
        clock.lap(stage(3), &mut start);
        context.detail(token, &best, &mut surfaces);
        clock.lap(stage(4), &mut start);
        let shadows = Shadows::<L, G>::new(token, &frame, context, ray, &surfaces, transmittance);
        clock.lap(stage(5), &mut start);
        let arriving = context.arriving(token, &frame, ray, &directions, &surfaces, &shadows);
        clock.lap(stage(6), &mut start);
        context.shade(token, &frame, &directions, &surfaces, &arriving, &mut sums);
        clock.lap(stage(7), &mut start);
        if let Some(records) = &mut records {
            records.keep(context.frame, number, first, &best, &surfaces, &shadows, &arriving);
        }
        if frame.layers <= 1 {
            break;
        }
        frame.layers -= 1;
        // What nothing shines through looks for nothing more.
        let mut is_done = true;
        for g in 0..G {
            let missing = none.broadcast(NONE);
            best[g].instance = is_covered(sums[g][3]).select(missing, best[g].instance);
            is_done &= !(!best[g].instance.eq(missing)).any();
        }
        if is_done {
            break;
        }
    }
    store(&sums, &mut colors[first..]);
    if let Some(records) = &mut records {
        let range = first..first + G * L::WIDTH;
        records.colors[range.clone()].copy_from_slice(&colors[range]);
    }
    clock.lap(7, &mut start);
}

/// Writes colors lane after lane.
#[inline(always)]
pub fn store<L: Lane, const G: usize>(sums: &[[L; 4]; G], colors: &mut [[f32; 4]]) {
    for (g, sum) in sums.iter().enumerate() {
        let [red, green, blue, alpha] = groups(
            #[inline(always)]
            |channel| sum[channel].row(),
        );
        for lane in 0..L::WIDTH {
            colors[g * L::WIDTH + lane] = [red.at(lane), green.at(lane), blue.at(lane), alpha.at(lane)];
        }
    }
}

/// Which lights reach a packet's surfaces.
pub enum Shadows<'a, L: Wide, const G: usize> {
    /// The words of the shadow mask; the usual scene has only the first.
    Bits { first: [L::Bits; G], more: Vec<[L::Bits; G]> },
    /// What is left of each light, where shadows are not bits: a block's words, light after light,
    /// from the packet's first on.
    Transmittance(L::Token, &'a [u32]),
}

impl<'a, L: Wide, const G: usize> Shadows<'a, L, G> {
    /// Hard ones; where not every instance is opaque, `transmittance` is what they are kept in.
    #[inline(always)]
    fn new(
        token: L::Token,
        frame: &Frame,
        context: &FrameContext<'_>,
        ray: RayIndex,
        surfaces: &[Surfaces<L>; G],
        transmittance: &'a mut [u32],
    ) -> Self {
        let FrameContext { views, lists, geometry, .. } = context;
        // Loops, not iterators: what is called back is not compiled for the instruction set.
        if frame.layers != 0 {
            let origins = groups(
                #[inline(always)]
                |g| surfaces[g].origin,
            );
            for light in 0..frame.lights {
                let asked = groups(
                    #[inline(always)]
                    |g| {
                        let ray = RayIndex(ray.0 + (g * L::WIDTH) as u32);
                        occlusion::potentially_lit(frame, views, light, ray, &surfaces[g])
                    },
                );
                let left = L::outlined(
                    token,
                    #[inline(always)]
                    || {
                        occlusion::transmittance::<L, G>(
                            frame, views, lists, geometry, light, ray, &origins, &asked,
                        )
                    },
                );
                for (g, words) in left.into_iter().enumerate() {
                    L::store(words, &mut transmittance[(light * BLOCK_RAYS) as usize + g * L::WIDTH..]);
                }
            }
            return Self::Transmittance(token, transmittance);
        }
        let none = surfaces[0].material.broadcast(0);
        let (mut first, mut more) = ([none; G], Vec::new());
        for word in 0..frame.mask_words {
            let mask = L::outlined(
                token,
                #[inline(always)]
                || occlusion::word::<L, G>(frame, views, lists, geometry, word, ray, surfaces),
            );
            if word == 0 {
                first = mask;
            } else {
                more.push(mask);
            }
        }
        Self::Bits { first, more }
    }

    /// A word of the shadow mask of a group; `none` is 0.
    #[inline(always)]
    pub fn word(&self, frame: &Frame, word: u32, none: L::Bits, g: usize) -> L::Bits {
        match self {
            Self::Bits { first, .. } if word == 0 => first[g],
            Self::Bits { more, .. } => more[word as usize - 1][g],
            Self::Transmittance(..) => occlusion::mask(
                frame,
                word,
                none,
                #[inline(always)]
                |light| self.transmittance(light, none, g),
            ),
        }
    }

    /// What is left of a light at a group, where shadows are not bits.
    #[inline(always)]
    pub fn transmittance(&self, light: u32, none: L::Bits, g: usize) -> L::Bits {
        match self {
            Self::Bits { .. } => none,
            Self::Transmittance(token, transmittance) => {
                L::load(*token, &transmittance[(light * BLOCK_RAYS) as usize + g * L::WIDTH..])
            }
        }
    }
}

/// How many words [`Shadows`] are kept in, a block; no fewer than one, so that every block has
/// some.
pub fn transmittance_words(frame: &Frame) -> usize {
    let is_kept = frame.layers != 0 && frame.penumbra_window == 0;
    if is_kept { (BLOCK_RAYS * frame.lights).max(1) as usize } else { 1 }
}

/// Copies tiles into rows.
pub fn untile(grid: Grid, tiles: &[u32], pixels: &mut Vec<u32>) {
    let side = grid.block_pixels() as usize;
    let width = grid.width as usize;
    pixels.resize(width * grid.height as usize, 0);
    pixels.par_chunks_mut(width).with_min_len(16).enumerate().for_each(|(y, row)| {
        for (column, part) in row.chunks_mut(side).enumerate() {
            let block = BlockIndex((y / side) as u32 * grid.blocks_x() + column as u32);
            let at = (block.0 as usize * side + y % side) * side;
            part.copy_from_slice(&tiles[at..at + part.len()]);
        }
    });
}
