//! Penumbra blocks: which blocks the penumbra filter can change, and which skip it.

use crate::grid::{BLOCK, BLOCK_RAYS, Grid, RayIndex, place};
use crate::layout::Frame;
use crate::stage::blocker_search::{penumbra_at, transmittance_at};
use crate::stage::penumbra_filter::reach;
use bytemuck::{Pod, Zeroable};

/// What the shadows of a light have in common, among some rays. A function of the set of rays.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PenumbraSummary {
    /// Those bits of what is left of the light that are 1 at all of the rays.
    pub all: u32,
    /// Those that are 1 at any; and [`PenumbraSummary::PENUMBRA`].
    pub any: u32,
}
const _: () = assert!(size_of::<PenumbraSummary>() == 8);

impl PenumbraSummary {
    /// Those of no rays.
    pub const NONE: Self = Self { all: u32::MAX, any: 0 };
    /// The bit that is 1 where any of the rays lies in a penumbra. What is left has 30 bits.
    pub const PENUMBRA: u32 = 1 << 31;

    /// Those of one ray, by what is left of the light and the size of the penumbra.
    #[inline(always)]
    pub fn of(left: u32, size: f32) -> Self {
        Self { all: left, any: left | if size > 0.0 { Self::PENUMBRA } else { 0 } }
    }
    /// Those of both sets of rays.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self { all: self.all & other.all, any: self.any | other.any }
    }
    /// Whether the blur may change anything, if it sees these rays and no others: without a
    /// penumbra, and where the same is left everywhere, it does not.
    #[inline(always)]
    pub fn are_soft(self) -> bool {
        self.any & Self::PENUMBRA != 0 && self.any != self.all | Self::PENUMBRA
    }
}

/// Where a block of a band has its edges of a light, and whether its shadows are blurred.
#[inline(always)]
pub fn edges_at(frame: &Frame, block: u32, light: u32) -> usize {
    (block * frame.lights + light) as usize
}

/// The edges of a light in a block of a band. `shadows` are the words that [`transmittance_at`] and
/// [`penumbra_at`] find their ways in.
#[inline(always)]
pub fn edges(frame: &Frame, shadows: &[u32], block: u32, light: u32) -> PenumbraSummary {
    let first = block * BLOCK_RAYS;
    common(
        frame.grid(),
        RayIndex(frame.first_ray + first),
        #[inline(always)]
        |ray| {
            let left = shadows[transmittance_at(frame, first + ray, light)];
            PenumbraSummary::of(left, f32::from_bits(shadows[penumbra_at(frame, first + ray, light)]))
        },
    )
}

/// What those rays of a block have in common that are in the frame: `first` is the block's first,
/// `of` the edges of each, by its number in the block.
#[inline(always)]
pub fn common(grid: Grid, first: RayIndex, of: impl Fn(u32) -> PenumbraSummary) -> PenumbraSummary {
    let [left, top] = grid.ray(first);
    let mut edges = PenumbraSummary::NONE;
    let mut ray = 0;
    while ray < BLOCK_RAYS {
        let [x, y] = place(ray);
        if grid.contains([left + x, top + y]) {
            edges = edges.and(of(ray));
        }
        ray += 1;
    }
    edges
}

/// Whether the shadows of a light in a block of a band are to be blurred: 1, or 0 where the blur
/// would leave all of them as they are. `edges` are those of all blocks of the band.
#[inline(always)]
pub fn are_soft(frame: &Frame, edges: &[PenumbraSummary], block: u32, light: u32) -> u32 {
    let columns = frame.grid().blocks_x();
    let [left, right] = span(frame, block % columns, columns);
    let [top, bottom] = span(frame, block / columns, frame.rays / BLOCK_RAYS / columns);
    let mut seen = PenumbraSummary::NONE;
    let mut y = top;
    while y < bottom {
        let mut x = left;
        while x < right {
            seen = seen.and(edges[edges_at(frame, y * columns + x, light)]);
            x += 1;
        }
        y += 1;
    }
    seen.are_soft() as u32
}

/// The blocks, along a side of a band, into which rays of one of them look.
#[inline(always)]
#[allow(clippy::implicit_saturating_sub, reason = "a comparison and a subtraction on every device")]
pub fn span(frame: &Frame, at: u32, count: u32) -> [u32; 2] {
    let around = around(frame);
    let first = if at < around { 0 } else { at - around };
    let end = at + around + 1;
    [first, if end < count { end } else { count }]
}

/// How many blocks aside the blur looks, at most.
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
                .fold(PenumbraSummary::NONE, |sum, &(left, size)| sum.and(PenumbraSummary::of(left, size)))
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
