//! Penumbra blocks: which blocks the penumbra filter can change, and which skip it.

use crate::grid::{BLOCK, BLOCK_RAYS, Grid, RayIndex, place};
use crate::layout::{Frame, ShadowBuffer};
use crate::stage::penumbra_filter::reach;
use bytemuck::{Pod, Zeroable};

/// Which transmittances of a light, and which penumbras, a set of rays has.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PenumbraSummary {
    /// The bits of the transmittance that are 1 at all of the rays.
    pub all: u32,
    /// The bits that are 1 at any of them; and [`PenumbraSummary::PENUMBRA`].
    pub any: u32,
}
const _: () = assert!(size_of::<PenumbraSummary>() == 8);

impl PenumbraSummary {
    /// That of no rays.
    pub const NONE: Self = Self { all: u32::MAX, any: 0 };
    /// The bit that is 1 if any of the rays has a penumbra. A transmittance has 30 bits.
    pub const PENUMBRA: u32 = 1 << 31;

    /// That of one ray, by its transmittance and the radius of its penumbra.
    #[inline(always)]
    pub fn of(transmittance: u32, radius: f32) -> Self {
        let penumbra = if radius > 0.0 { Self::PENUMBRA } else { 0 };
        Self { all: transmittance, any: transmittance | penumbra }
    }
    /// That of both sets of rays.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self { all: self.all & other.all, any: self.any | other.any }
    }
    /// Whether the filter may change anything, if it reads these rays and no others: without a penumbra,
    /// and where all transmittances are equal, it does not.
    #[inline(always)]
    pub fn are_soft(self) -> bool {
        self.any & Self::PENUMBRA != 0 && self.any != self.all | Self::PENUMBRA
    }
}

/// Where the summary of a block of a band and a light is, and whether its shadows are filtered.
#[inline(always)]
pub fn edges_at(frame: &Frame, block: u32, light: u32) -> usize {
    (block * frame.lights + light) as usize
}

/// The summary of a light in a block of a band. `shadows` is its [`ShadowBuffer`].
#[inline(always)]
pub fn edges(frame: &Frame, shadows: &[u32], block: u32, light: u32) -> PenumbraSummary {
    let (buffer, first) = (ShadowBuffer::new(frame), block * BLOCK_RAYS);
    common(
        frame.grid(),
        RayIndex(frame.first_ray + first),
        #[inline(always)]
        |ray| {
            let transmittance = shadows[buffer.transmittance(first + ray, light)];
            let radius = f32::from_bits(shadows[buffer.penumbra_radius(first + ray, light)]);
            PenumbraSummary::of(transmittance, radius)
        },
    )
}

/// The summary of those rays of a block that are in the frame: `first` is the block's first, `of` gives
/// the summary of each, by its number in the block.
#[inline(always)]
pub fn common(grid: Grid, first: RayIndex, of: impl Fn(u32) -> PenumbraSummary) -> PenumbraSummary {
    let [left, top] = grid.ray(first);
    let mut summary = PenumbraSummary::NONE;
    let mut ray = 0;
    while ray < BLOCK_RAYS {
        let [x, y] = place(ray);
        if grid.contains([left + x, top + y]) {
            summary = summary.and(of(ray));
        }
        ray += 1;
    }
    summary
}

/// Whether the shadows of a light in a block of a band are filtered: 1, or 0 where the filter would change
/// none of them. `summaries` are those of all blocks of the band.
#[inline(always)]
pub fn are_soft(frame: &Frame, summaries: &[PenumbraSummary], block: u32, light: u32) -> u32 {
    let columns = frame.grid().blocks_x();
    let [left, right] = span(frame, block % columns, columns);
    let [top, bottom] = span(frame, block / columns, frame.rays / BLOCK_RAYS / columns);
    let mut seen = PenumbraSummary::NONE;
    let mut y = top;
    while y < bottom {
        let mut x = left;
        while x < right {
            seen = seen.and(summaries[edges_at(frame, y * columns + x, light)]);
            x += 1;
        }
        y += 1;
    }
    seen.are_soft() as u32
}

/// The blocks, along a side of a band, that the filter of one of them reads.
#[inline(always)]
#[allow(clippy::implicit_saturating_sub, reason = "a comparison and a subtraction on every device")]
pub fn span(frame: &Frame, at: u32, count: u32) -> [u32; 2] {
    let around = around(frame);
    let first = if at < around { 0 } else { at - around };
    let end = at + around + 1;
    [first, if end < count { end } else { count }]
}

/// How many blocks aside the filter reads, at most.
#[inline(always)]
pub fn around(frame: &Frame) -> u32 {
    reach(frame).div_ceil(BLOCK)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_soft_where_a_penumbra_is_and_not_all_is_the_same() {
        let of = |rays: &[(u32, f32)]| {
            rays.iter()
                .fold(PenumbraSummary::NONE, |sum, &(transmittance, radius)| {
                    sum.and(PenumbraSummary::of(transmittance, radius))
                })
                .are_soft()
        };
        assert!(!of(&[]) && !of(&[(0, -1.0)]) && !of(&[(7, 0.5)]) && !of(&[(0, 0.5), (0, -1.0)]));
        assert!(!of(&[(7, -1.0), (0, -1.0), (3, 0.0)]));
        assert!(of(&[(0, 0.5), (7, -1.0)]) && of(&[(7, -1.0), (0, 0.5)]) && of(&[(5, 0.1), (7, -1.0)]));
    }

    #[test]
    fn blocks_look_no_farther_than_the_frame() {
        let frame = Frame { side: 1, ..Frame::zeroed() };
        assert_eq!(around(&frame), 2);
        assert_eq!([span(&frame, 0, 9), span(&frame, 4, 9), span(&frame, 8, 9)], [[0, 3], [2, 7], [6, 9]]);
    }
}
