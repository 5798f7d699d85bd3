//! Penumbra filter: hard shadows become soft ones, on the screen.
//!
//! Each ray looks around itself for penumbras that reach it, and averages the transmittance of its
//! light over a disc of their mean radius. For an edge across the direction to the light, on a surface
//! that continues, that average is the visible share of the light: what the occluder covers of the
//! light, seen from the surface, is what its hard shadow covers of the disc.
//!
//! # Departures from the paper
//!
//! The paper filters like this (Analytical soft shadows). It does not say how a surface outside of a
//! hard shadow learns of the penumbra; hence the search. The disc lies across the direction to the light
//! in the world, not on the screen, so that a penumbra does not depend on the viewpoint.
//!
//! # Order of a frame
//!
//! Penumbras reach across blocks. A frame with soft shadows therefore has a barrier in each layer of
//! surfaces: the blocker search ([`transmittance`](super::occlusion::transmittance)) finishes in all blocks before the first block is
//! filtered. Frames without soft shadows have no barrier. A GPU filters bands of rows, and each band
//! also computes the rows around it from which penumbras reach into it.
//!
//! The blocker search keeps the minimum of the occluders' `t`, a function of the set. A ray ends at the
//! nearest opaque occluder: nothing behind it changes the distance or the transmittance.
//!
//! # Lanes
//!
//! Rays side by side in a row of the frame have their neighbors side by side too, as long as their
//! lattices have equal steps. So a group of 8 or 16 rays searches tap by tap, one contiguous load a tap,
//! and filters once for each different step among its rays. [`Neighborhood`] finds the neighbors: by a
//! ray's number in its band on a GPU, in planes of whole rows with a margin on the CPU. Sums run in the
//! order of the lattice, so one ray at a time gives the same bits as lanes.
//!
//! Transmittance is packed, 10 bits a channel, as colored shadows are: one path serves both.
//!
//! # The search
//!
//! Penumbras are 1 to [`Frame::PENUMBRA_WINDOW`] pixels wide. The search finds them with few taps: four
//! lattices of 21 taps, each twice as wide as the one before and turned against it, so that a shadow
//! thinner than the steps of one lattice, along its rows, is hit by another. Penumbras of thin things
//! that are much wider than their shadow still show a faint pattern.
//!
//! # What skips the filter
//!
//! - Blocks without a penumbra nearby, or with equal transmittance at all rays around them
//!   ([`penumbra_blocks`](super::penumbra_blocks)).
//! - Groups whose search meets only the transmittance of their own rays: the average of equal values is
//!   that value, exactly.
//! - On the CPU, blocks whose rays see nothing behind their first layers, and those that the light does not reach.

use crate::kernel::transmittance::{color, packed};
use crate::lane::{Bits, Lane, Mask, Row, Select, V3, Word};
use crate::layout::{Frame, ShadowBuffer, Surface, View};
use crate::num::{clamp, floor, flush, normalize, recip, sqrt, to_integer};
use crate::stage::occlusion::to_middle;

/// The transmittance where there is no ray.
pub const MISSING: u32 = u32::MAX;

/// A group of rays, side by side in a row of the frame, and their neighbors, as a backend stores them.
pub trait Neighborhood<L: Lane> {
    /// Where rays are stored.
    type Place: Copy;

    /// The place of the rays that many columns and rows aside. Negative numbers wrap.
    fn place(&self, aside: [u32; 2]) -> Self::Place;
    /// The transmittance there, as a word; [`MISSING`] where there is no ray.
    fn transmittance(&self, place: Self::Place) -> L::Bits;
    /// The radii of the penumbras there (see [`crate::kernel::penumbra`]); −1 where there is no ray.
    fn penumbra_radius(&self, place: Self::Place) -> L;
    /// Where the surfaces are that these rays hit; anything where there is no ray.
    fn origin(&self, place: Self::Place) -> V3<L>;
    /// Their normals.
    fn normal(&self, place: Self::Place) -> V3<L>;
}

/// A ray, and those around it in the buffers of a band: its [`ShadowBuffer`], and surfaces.
pub struct Band<'a> {
    /// The frame, with the rays of the band.
    pub frame: &'a Frame,
    /// The surface that each ray has hit.
    pub surfaces: &'a [Surface],
    /// The band's [`ShadowBuffer`].
    pub shadows: &'a [u32],
    /// The light.
    pub light: u32,
    /// Column and row of the ray.
    pub at: [u32; 2],
}

impl Neighborhood<f32> for Band<'_> {
    /// The ray's number in the band, or [`MISSING`].
    type Place = u32;

    #[inline(always)]
    fn place(&self, aside: [u32; 2]) -> u32 {
        let at = [self.at[0].wrapping_add(aside[0]), self.at[1].wrapping_add(aside[1])];
        // Left of the first column or above the first row, the place has wrapped.
        if !self.frame.grid().contains(at) {
            return MISSING;
        }
        let ray = self.frame.grid().index(at).0.wrapping_sub(self.frame.first_ray);
        if ray < self.frame.rays { ray } else { MISSING }
    }
    #[inline(always)]
    fn transmittance(&self, place: u32) -> Word {
        Word(if place == MISSING {
            MISSING
        } else {
            self.shadows[ShadowBuffer::new(self.frame).transmittance(place, self.light)]
        })
    }
    #[inline(always)]
    fn penumbra_radius(&self, place: u32) -> f32 {
        if place == MISSING {
            -1.0
        } else {
            f32::from_bits(self.shadows[ShadowBuffer::new(self.frame).penumbra_radius(place, self.light)])
        }
    }
    #[inline(always)]
    fn origin(&self, place: u32) -> V3<f32> {
        V3::splat((), self.surfaces[place as usize].origin)
    }
    #[inline(always)]
    fn normal(&self, place: u32) -> V3<f32> {
        V3::splat((), self.surfaces[place as usize].normal)
    }
}

/// Rows of the filter's lattice on either side of a ray.
const BLUR: u32 = 6;
/// One row's share of them.
const SHARE: f32 = 1.0 / BLUR as f32;
/// The longest steps of the filter's lattice, in pixels: they cover [`Frame::PENUMBRA_WINDOW`].
const LONGEST: u32 = Frame::PENUMBRA_WINDOW / BLUR;

/// Taps of each lattice of the search: 21.
const SEARCHED: Disc = Disc::within(5);
/// Taps of the filter, 137: all, in steps, at which a weight may be above 0 (see [`filter_penumbra`]).
const BLURRED: Disc = Disc::within(BLUR * BLUR + BLUR - 1);

/// The most rays aside that [`filter_penumbra`] reads.
#[inline(always)]
pub fn reach(frame: &Frame) -> u32 {
    BLUR * (LONGEST * frame.side + 1)
}

/// Rays that search for others on their surfaces.
#[derive(Clone, Copy)]
struct Here<L> {
    origin: V3<L>,
    normal: V3<L>,
    /// Unit vectors to the light's middle.
    toward: V3<L>,
}

/// The transmittance of a light at a group of rays with soft shadows, packed.
///
/// ```text
/// radius        = mean of the radii of the penumbras that reach the ray
/// transmittance = Σ weight · transmittance there / Σ weight, weight = 1 within the radius, 0 beyond it
/// ```
///
/// The search reads neighbors on four lattices (see the [module](self)). A penumbra may reach the ray
/// from between the taps. So, where no penumbra that is found reaches it, the radius is the smallest of
/// those that would reach it if they were wider by half the diagonal of their lattice's cells. The
/// smallest, because penumbras are narrow where an occluder stands on the surface, and grow from there.
/// If the ray is beyond that penumbra after all, the filter averages equal values.
///
/// The steps of the filter's lattice grow with the radius; the weight falls from 1 to 0 over one step,
/// which hides the lattice. Lattices are turned against the pixels' rows, so that few of their rows run
/// along an edge. A penumbra ends [`Frame::penumbra_window`] rays aside.
///
/// A neighbor counts if it is on the same surface: within some 14° of the plane of the ray's surface, and
/// with a normal within 41° of its own. So shadows do not leak over edges.
#[inline(always)]
pub fn filter_penumbra<L: Lane, A: Neighborhood<L>>(
    frame: &Frame,
    views: &[View],
    around: &A,
    light: u32,
) -> L::Bits {
    let (camera, view) = (&views[Frame::CAMERA as usize], &views[frame.light_view(light) as usize]);
    let place = around.place([0, 0]);
    let own = around.transmittance(place);
    let missing = own.broadcast(MISSING);
    let lit = is_potentially_lit::<L>(own, around.penumbra_radius(place));
    let mut same = lit;
    let mut lattice = 0;
    while lattice < LATTICES && same.any() {
        let steps = searched(frame, lattice);
        let mut tap = SEARCHED.first();
        while SEARCHED.has(tap) && same.any() {
            let there = around.transmittance(around.place(aside(steps, tap)));
            same = same & (there.eq(own) | there.eq(missing));
            tap = SEARCHED.after(tap);
        }
        lattice += 1;
    }
    let differs = lit & !same;
    if !differs.any() {
        return lit.select(own, own.broadcast(0));
    }
    let origin = around.origin(place);
    let toward = normalize(to_middle(view, origin));
    let here = Here { origin, normal: around.normal(place), toward };

    // The distance of two rays on a surface that faces the eye.
    let none = origin.x.broadcast(0.0);
    let token = none.token();
    let depth = (origin - V3::splat(token, camera.center)).dot(V3::splat(token, camera.depth));
    let cell = depth * camera.pixel_t + camera.pixel;

    let (mut sum, mut count, mut least) = (none, none, none.broadcast(f32::MAX));
    let mut lattice = 0;
    while lattice < LATTICES {
        let steps = searched(frame, lattice);
        let half = cell * sqrt((steps[0] * steps[0] + steps[1] * steps[1]) as f32 * 0.5);
        let mut tap = SEARCHED.first();
        while SEARCHED.has(tap) {
            let place = around.place(aside(steps, tap));
            let radius = around.penumbra_radius(place);
            if (differs & radius.gt(none)).any() {
                let square = distance(&here, around.origin(place), around.normal(place));
                let is_penumbra = radius.gt(none) & square.ge(none);
                let reaches = is_penumbra & square.le(flush(radius * radius));
                sum = sum + reaches.select(radius, none);
                count = count + reaches.select(none.broadcast(1.0), none);
                let far = radius + half;
                let is_near = is_penumbra & square.le(flush(far * far));
                least = is_near.select(least.min(radius), least);
            }
            tap = SEARCHED.after(tap);
        }
        lattice += 1;
    }
    let blurred = differs & least.lt(least.broadcast(f32::MAX));
    if !blurred.any() {
        return lit.select(own, own.broadcast(0));
    }

    let slope = here.normal.dot(here.toward);
    let cell = cell * none.broadcast(LEAST_SLOPE).max(slope);
    let radius = count.gt(none).select(sum * recip(count), least);
    let radius = radius.min(cell * frame.penumbra_window as f32);
    let steps = steps(radius * recip(cell), frame.side);
    let edge = cell.max(radius * SHARE);
    let sharpness = recip(radius * edge) * 0.5;
    let square = radius * radius;

    let rows = steps.row();
    let (mut remaining, mut soft) = (blurred, own);
    let mut lane = 0;
    while lane < L::WIDTH {
        let step = rows.at(lane);
        let active = remaining & steps.eq(steps.broadcast(step));
        if active.any() {
            if differ(around, step, active, own) {
                let average = blur(around, &here, step, active, square, sharpness);
                soft = active.select(average, soft);
            }
            remaining = remaining & !active;
        }
        lane += 1;
    }
    lit.select(soft, own.broadcast(0))
}

/// Whether the transmittance around active rays, whose lattices have these steps, differs from their own.
#[inline(always)]
fn differ<L: Lane, A: Neighborhood<L>>(around: &A, steps: u32, active: L::Mask, own: L::Bits) -> bool {
    let mut differ = false;
    let mut tap = BLURRED.first();
    while BLURRED.has(tap) && !differ {
        let place = around.place(aside([steps, 1], tap));
        let there = around.transmittance(place);
        let other = active & !there.eq(own);
        differ = other.any() && (other & is_potentially_lit::<L>(there, around.penumbra_radius(place))).any();
        tap = BLURRED.after(tap);
    }
    differ
}

/// The average transmittance around active rays, whose lattices have these steps.
#[inline(always)]
fn blur<L: Lane, A: Neighborhood<L>>(
    around: &A,
    here: &Here<L>,
    steps: u32,
    active: L::Mask,
    square: L,
    sharpness: L,
) -> L::Bits {
    let none = square.broadcast(0.0);
    let (mut total, mut red, mut green, mut blue) = (none, none, none, none);
    let mut tap = BLURRED.first();
    while BLURRED.has(tap) {
        let place = around.place(aside([steps, 1], tap));
        let transmittance = around.transmittance(place);
        let lit = active & is_potentially_lit::<L>(transmittance, around.penumbra_radius(place));
        if lit.any() {
            let distance = distance(here, around.origin(place), around.normal(place));
            let weight = clamp((square - distance) * sharpness + 0.5, 0.0, 1.0);
            let weight = (lit & distance.ge(none)).select(weight, none);
            let light = color::<L>(transmittance);
            total = total + weight;
            red = red + light.x * weight;
            green = green + light.y * weight;
            blue = blue + light.z * weight;
        }
        tap = BLURRED.after(tap);
    }
    let inverse = recip(total);
    packed([red * inverse, green * inverse, blue * inverse])
}

/// Whether shadow rays were traced there: dark rays without a penumbra face away or are out of reach.
#[inline(always)]
fn is_potentially_lit<L: Lane>(transmittance: L::Bits, radius: L) -> L::Mask {
    let (missing, dark) = (transmittance.broadcast(MISSING), transmittance.broadcast(0));
    !transmittance.eq(missing) & (!transmittance.eq(dark) | radius.ge(radius.broadcast(0.0)))
}

/// The least cosine between a surface's normal and the way to the light that is reckoned with.
const LEAST_SLOPE: f32 = 1.0 / 16.0;

/// The steps of the blur's lattice, so that it covers a disc of this radius, in rays:
/// `√((radius / BLUR)² − 1)`, rounded up, at most [`LONGEST`]` · side`.
#[inline(always)]
fn steps<L: Lane>(radius: L, side: u32) -> L::Bits {
    let ratio = radius * SHARE;
    let steps = sqrt(ratio * ratio - 1.0);
    let none = steps.broadcast(0.0);
    let steps = steps.gt(none).select(floor(steps) + 1.0, none);
    to_integer(steps.min(steps.broadcast((LONGEST * side) as f32)))
}

/// Lattices of the search.
const LATTICES: u32 = 4;

/// The steps of a lattice of the search, the widest first: the taps of the last are pixels side by
/// side, those of the first go as far as the window.
#[inline(always)]
fn searched(frame: &Frame, lattice: u32) -> [u32; 2] {
    let [x, y] = match lattice {
        0 => [10, 5],
        1 => [5, 1],
        2 => [2, 2],
        _ => [1, 0],
    };
    [x * frame.side, y * frame.side]
}

/// Columns and rows aside of a tap of a lattice whose steps are `(x, y)` and `(−y, x)`.
#[inline(always)]
fn aside([x, y]: [u32; 2], [i, j]: [u32; 2]) -> [u32; 2] {
    [i.wrapping_mul(x).wrapping_sub(j.wrapping_mul(y)), i.wrapping_mul(y).wrapping_add(j.wrapping_mul(x))]
}

/// Taps of a lattice, within a disc around the ray: how many steps aside they are along both axes,
/// which wrap. They are walked row by row.
#[derive(Clone, Copy)]
struct Disc {
    /// How far each row goes, from the middle one on: four bits each.
    halves: u32,
    /// The last row.
    last: u32,
}

impl Disc {
    /// The taps whose squared distance, in steps, is at most this: less than 64.
    const fn within(square: u32) -> Self {
        let (mut halves, mut j) = (0, 0);
        while j * j <= square {
            let mut i = 0;
            while (i + 1) * (i + 1) + j * j <= square {
                i += 1;
            }
            halves |= i << (4 * j);
            j += 1;
        }
        Self { halves, last: j - 1 }
    }
    /// How far a row goes.
    #[inline(always)]
    fn half(self, j: u32) -> u32 {
        let row = if j > self.last { 0_u32.wrapping_sub(j) } else { j };
        if row > self.last { 0 } else { (self.halves >> (4 * row)) & 15 }
    }
    /// The first tap.
    #[inline(always)]
    fn first(self) -> [u32; 2] {
        let j = 0_u32.wrapping_sub(self.last);
        [0_u32.wrapping_sub(self.half(j)), j]
    }
    /// Whether it is one of the taps, and not what comes after the last.
    #[inline(always)]
    fn has(self, [_, j]: [u32; 2]) -> bool {
        j != self.last + 1
    }
    /// What comes after a tap.
    #[inline(always)]
    fn after(self, [i, j]: [u32; 2]) -> [u32; 2] {
        if i != self.half(j) {
            return [i.wrapping_add(1), j];
        }
        let j = j.wrapping_add(1);
        [0_u32.wrapping_sub(self.half(j)), j]
    }
}

/// How much of the squared distance to the plane of a surface counts: 1 / tan² 14°.
const FLATNESS: f32 = 16.0;
/// The least cosine of two normals of one surface.
const BEND: f32 = 0.75;

/// The squared distance of a surface from here, across the way to the light; −1 if it is another
/// surface.
#[inline(always)]
fn distance<L: Lane>(here: &Here<L>, origin: V3<L>, normal: V3<L>) -> L {
    let way = origin - here.origin;
    let (square, height) = (flush(way.dot(way)), here.normal.dot(way));
    let along = way.dot(here.toward);
    let is_flat = square.ge(flush(height * height) * FLATNESS);
    let is_same = is_flat & here.normal.dot(normal).ge(square.broadcast(BEND));
    let aside = flush(square - along * along);
    is_same.select(aside.max(aside.broadcast(0.0)), aside.broadcast(-1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use std::vec::Vec;

    fn taps(disc: Disc) -> Vec<[i32; 2]> {
        let mut taps = Vec::new();
        let mut tap = disc.first();
        while disc.has(tap) {
            taps.push(tap.map(u32::cast_signed));
            tap = disc.after(tap);
        }
        taps
    }

    #[test]
    fn discs_are_walked_tap_by_tap_and_are_round() {
        for (disc, square, count) in [(SEARCHED, 5, 21), (BLURRED, 41, 137), (Disc::within(0), 0, 1)] {
            let side = -8..=8_i32;
            let all = side.clone().flat_map(|j| side.clone().map(move |i| [i, j]));
            let expected: Vec<_> = all.filter(|[i, j]| i * i + j * j <= square).collect();
            assert_eq!((taps(disc), expected.len()), (expected, count));
        }
    }

    #[test]
    fn no_tap_is_farther_aside_than_the_margin() {
        for side in [1, 2, 4] {
            let frame = Frame { side, ..Frame::zeroed() };
            let searched = (0..LATTICES).map(|lattice| (searched(&frame, lattice), SEARCHED));
            let blurred = (0..=LONGEST * side).map(|steps| ([steps, 1], BLURRED));
            let mut farthest = 0;
            for (steps, disc) in searched.chain(blurred) {
                for tap in taps(disc) {
                    let aside = aside(steps, tap.map(i32::cast_unsigned)).map(u32::cast_signed);
                    farthest = aside.map(i32::unsigned_abs).into_iter().fold(farthest, u32::max);
                }
            }
            assert!(farthest <= reach(&frame) && farthest >= Frame::PENUMBRA_WINDOW * side, "{farthest}");
        }
    }

    #[test]
    fn the_blur_covers_the_window() {
        for side in [1, 2, 4] {
            for radius in 1..=Frame::PENUMBRA_WINDOW * side {
                let steps = steps::<f32>(radius as f32, side).0 as f32;
                assert!(BLUR as f32 * (steps * steps + 1.0).sqrt() >= radius as f32 * 0.9999, "{radius}");
            }
        }
    }
}
