//! What the penumbra filter reads of a light, in planes of whole rows of the frame, so that rays side by
//! side have their neighbors side by side.

use crate::block::{Block, PLACES, RAYS};
use crate::parallel;
use crate::shadows::NO_PENUMBRA;
use crate::wide::Wide;
use alloc::vec::Vec;
use rtrt_core::grid::{BLOCK, Grid, place};
use rtrt_core::lane::{Lane, V3};
use rtrt_core::layout::Frame;
use rtrt_core::stage::penumbra_blocks::around;
use rtrt_core::stage::penumbra_filter::{MISSING, Neighborhood};

/// Along a side of a block.
const SIDE: usize = BLOCK as usize;
/// As many rays that follow one another lie in a row.
const TILE: usize = 4;

/// The first three planes: the origin of shadow rays.
const ORIGIN: usize = 0;
/// The next three: the normal there.
const NORMAL: usize = 3;
const TRANSMITTANCE: usize = PLACES;
const RADIUS: usize = PLACES + 1;
const COUNT: usize = PLACES + 2;

/// The numbers of all rays: row after row of the frame, in a row number after number, and around
/// the frame a margin as wide as the blur may look.
#[derive(Debug, Default)]
pub struct Planes {
    words: Vec<u32>,
    /// The blocks whose places in this layer are there.
    has_places: Vec<bool>,
    /// What the margin was made for.
    shape: Option<(Grid, u32)>,
    margin: usize,
    /// Rays in a row, and words.
    row: usize,
    pitch: usize,
}

impl Planes {
    /// Forgets all places; makes room and the margin where the size of the frame has changed. Called for each layer.
    pub fn begin(&mut self, frame: &Frame) {
        let grid = frame.grid();
        self.has_places.clear();
        self.has_places.resize(grid.blocks() as usize, false);
        let around = around(frame);
        if self.shape.replace((grid, around)) == Some((grid, around)) {
            return;
        }
        self.margin = (around * BLOCK) as usize;
        self.row = grid.blocks_x() as usize * SIDE + 2 * self.margin;
        self.pitch = self.row * COUNT;
        let rows = grid.blocks_y() as usize * SIDE + 2 * self.margin;
        self.words.clear();
        self.words.resize(rows * self.pitch, 0);
        for row in self.words.chunks_mut(self.pitch) {
            row[TRANSMITTANCE * self.row..][..self.row].fill(MISSING);
            row[RADIUS * self.row..][..self.row].fill(NO_PENUMBRA.to_bits());
        }
    }

    /// Takes over the numbers of a light, and the places of rays, from the blocks that are read.
    pub fn fill(&mut self, frame: &Frame, blocks: &[Block], light: u32, is_read: &[bool]) {
        let grid = frame.grid();
        let (margin, row, pitch) = (self.margin, self.row, self.pitch);
        let columns = grid.blocks_x() as usize;
        let has_places = &self.has_places[..];
        let above = &mut self.words[margin * pitch..];
        parallel::each_part(above, SIDE * pitch, 1, |y, rows| {
            let Some(is_read) = is_read.chunks(columns).nth(y) else {
                // Below the frame.
                return;
            };
            let below = (grid.height * grid.side) as usize - y * SIDE;
            for (x, _) in is_read.iter().enumerate().filter(|(_, is_read)| **is_read) {
                let right = (grid.width * grid.side) as usize - x * SIDE;
                let (block, has_places) = (&blocks[y * columns + x], has_places[y * columns + x]);
                let places = block.places.as_chunks::<RAYS>().0.iter().enumerate();
                let places = places.take(if has_places { 0 } else { PLACES });
                for (number, plane) in places.chain((TRANSMITTANCE..).zip(block.shadows.both(light))) {
                    let first = number * row + margin + x * SIDE;
                    for (part, plane) in plane.as_chunks::<TILE>().0.iter().enumerate() {
                        let [x, y] = place((part * TILE) as u32).map(|at| at as usize);
                        if y < below && x < right {
                            let row = &mut rows[first + y * pitch + x..];
                            match row.first_chunk_mut() {
                                // Of a length that is known: no call.
                                Some(row) if x + TILE <= right => *row = *plane,
                                _ => row[..right - x].copy_from_slice(&plane[..right - x]),
                            }
                        }
                    }
                }
            }
        });
        for (has_places, is_read) in self.has_places.iter_mut().zip(is_read) {
            *has_places |= is_read;
        }
    }
}

/// Rays in a row of a frame, and those around them.
pub struct Rows<'a, L: Lane> {
    token: L::Token,
    planes: &'a Planes,
    /// Where the first of the rays is.
    first: usize,
}

impl<'a, L: Lane> Rows<'a, L> {
    /// The rays from this column and row on.
    #[inline(always)]
    pub fn new(token: L::Token, planes: &'a Planes, [x, y]: [u32; 2]) -> Self {
        let first = (y as usize + planes.margin) * planes.pitch + x as usize + planes.margin;
        Self { token, planes, first }
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
        self.number(place, TRANSMITTANCE)
    }
    #[inline(always)]
    fn penumbra_radius(&self, place: usize) -> L {
        L::from_bits(self.number(place, RADIUS))
    }
    #[inline(always)]
    fn origin(&self, place: usize) -> V3<L> {
        self.vector(place, ORIGIN)
    }
    #[inline(always)]
    fn normal(&self, place: usize) -> V3<L> {
        self.vector(place, NORMAL)
    }
}
