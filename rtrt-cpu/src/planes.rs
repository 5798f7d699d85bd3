//! What the penumbra filter reads, in planes of whole rows of the frame, so that rays side by side have
//! their neighbors side by side.

use crate::cells;
use crate::parallel;
use crate::wide::Wide;
use alloc::vec::Vec;
use rtrt_core::grid::{BLOCK, BLOCK_RAYS, Grid, place};
use rtrt_core::lane::{Lane, V3};
use rtrt_core::layout::Frame;
use rtrt_core::stage::penumbra_blocks::around;
use rtrt_core::stage::penumbra_filter::{MISSING, Neighborhood};

/// Along a side of a block.
const SIDE: usize = BLOCK as usize;
/// As many rays that follow one another lie in a row.
const TILE: usize = 4;

/// The numbers of all rays: row after row of the frame, in a row number after number, and around
/// the frame a margin as wide as the blur may look.
#[derive(Debug, Default)]
pub struct Planes {
    words: Vec<u32>,
    /// What the margin was made for.
    shape: Option<(Grid, u32)>,
    margin: usize,
    /// Rays in a row, and words.
    row: usize,
    pitch: usize,
}

impl Planes {
    /// Takes over the numbers of the blocks that are needed: `cells` gives those of a block, number after
    /// number.
    pub fn fill<'a>(&mut self, frame: &Frame, cells: impl Fn(usize) -> &'a [u32] + Sync, is_needed: &[bool]) {
        let grid = frame.grid();
        self.reshape(frame);
        let (margin, row, pitch) = (self.margin, self.row, self.pitch);
        let columns = grid.blocks_x() as usize;
        let above = &mut self.words[margin * pitch..];
        parallel::each_part(above, SIDE * pitch, 1, |y, rows| {
            // None below the frame.
            let is_needed = is_needed.chunks(columns).nth(y).unwrap_or_default();
            let below = (grid.height * grid.side) as usize - y * SIDE;
            for (x, _) in is_needed.iter().enumerate().filter(|(_, is_needed)| **is_needed) {
                let right = (grid.width * grid.side) as usize - x * SIDE;
                for (number, cells) in cells(y * columns + x).chunks(BLOCK_RAYS as usize).enumerate() {
                    let first = number * row + margin + x * SIDE;
                    for (part, cells) in cells.chunks(TILE).enumerate() {
                        let [x, y] = place((part * TILE) as u32).map(|at| at as usize);
                        if y < below && x < right {
                            let (at, width) = (first + y * pitch + x, (right - x).min(TILE));
                            rows[at..at + width].copy_from_slice(&cells[..width]);
                        }
                    }
                }
            }
        });
    }

    /// Makes room for a frame, and the margin.
    fn reshape(&mut self, frame: &Frame) {
        let (grid, lights) = (frame.grid(), frame.lights);
        if self.shape.replace((grid, lights)) == Some((grid, lights)) {
            return;
        }
        self.margin = (around(frame) * BLOCK) as usize;
        self.row = grid.blocks_x() as usize * SIDE + 2 * self.margin;
        self.pitch = self.row * cells::count(frame);
        let rows = grid.blocks_y() as usize * SIDE + 2 * self.margin;
        self.words.clear();
        self.words.resize(rows * self.pitch, 0);
        for row in self.words.chunks_mut(self.pitch) {
            for light in 0..lights as usize {
                row[cells::transmittance(light) * self.row..][..self.row].fill(MISSING);
                row[cells::radius(light) * self.row..][..self.row].fill((-1.0_f32).to_bits());
            }
        }
    }
}

/// Rays in a row of a frame, and those around them.
pub struct Rows<'a, L: Lane> {
    token: L::Token,
    planes: &'a Planes,
    /// Where the first of the rays is.
    first: usize,
    light: usize,
}

impl<'a, L: Lane> Rows<'a, L> {
    /// The rays from this column and row on.
    #[inline(always)]
    pub fn new(token: L::Token, planes: &'a Planes, [x, y]: [u32; 2], light: u32) -> Self {
        let first = (y as usize + planes.margin) * planes.pitch + x as usize + planes.margin;
        Self { token, planes, first, light: light as usize }
    }
}

impl<L: Wide> Rows<'_, L> {
    #[inline(always)]
    fn number(&self, place: usize, number: usize) -> L::Bits {
        L::load(self.token, &self.planes.words[place + number * self.planes.row..])
    }
    #[inline(always)]
    fn vector(&self, place: usize, first: usize) -> V3<L> {
        V3 {
            x: L::from_bits(self.number(place, first)),
            y: L::from_bits(self.number(place, first + 1)),
            z: L::from_bits(self.number(place, first + 2)),
        }
    }
}

impl<L: Wide> Neighborhood<L> for Rows<'_, L> {
    type Place = usize;

    #[inline(always)]
    fn place(&self, [x, y]: [u32; 2]) -> usize {
        let (x, y) = (x.cast_signed() as isize, y.cast_signed() as isize);
        self.first.wrapping_add_signed(y * self.planes.pitch as isize + x)
    }
    #[inline(always)]
    fn transmittance(&self, place: usize) -> L::Bits {
        self.number(place, cells::transmittance(self.light))
    }
    #[inline(always)]
    fn penumbra_radius(&self, place: usize) -> L {
        L::from_bits(self.number(place, cells::radius(self.light)))
    }
    #[inline(always)]
    fn origin(&self, place: usize) -> V3<L> {
        self.vector(place, cells::ORIGIN)
    }
    #[inline(always)]
    fn normal(&self, place: usize) -> V3<L> {
        self.vector(place, cells::NORMAL)
    }
}
