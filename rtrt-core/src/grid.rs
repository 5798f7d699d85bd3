//! The numbering of pixels, rays and blocks, which every stage uses.
//!
//! A frame of `width × height` pixels with `n × n` sub-rays a pixel is a grid of
//! `width·n × height·n` rays. [`BLOCK`] × [`BLOCK`] rays are a block. Rays are numbered
//! block after block; inside a block, tile after tile of 4 × 4, so that 8 or 16
//! neighbors in number are neighbors in the picture. Blocks at the right and lower edge
//! may reach outside the frame; their outer rays exist and hit nothing.

use bytemuck::{Pod, Zeroable};

/// Side of a block, in rays.
pub const BLOCK: u32 = 16;
/// Rays in a block.
pub const BLOCK_RAYS: u32 = BLOCK * BLOCK;

/// The number of a ray: `block · BLOCK_RAYS + place in the block`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct RayIndex(pub u32);

/// The number of a block of the camera's grid, row by row.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BlockIndex(pub u32);

/// The size of a frame.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Debug, Pod, Zeroable)]
pub struct Grid {
    /// Pixels in a row.
    pub width: u32,
    /// Rows of pixels.
    pub height: u32,
    /// Sub-rays along one side of a pixel: 1, 2 or 4.
    pub side: u32,
}

impl Grid {
    /// Blocks in a row.
    #[inline(always)]
    pub fn blocks_x(self) -> u32 {
        (self.width * self.side).div_ceil(BLOCK)
    }
    /// Rows of blocks.
    #[inline(always)]
    pub fn blocks_y(self) -> u32 {
        (self.height * self.side).div_ceil(BLOCK)
    }
    /// Blocks in the frame.
    #[inline(always)]
    pub fn blocks(self) -> u32 {
        self.blocks_x() * self.blocks_y()
    }
    /// Rays in all blocks, those outside the frame included.
    #[inline(always)]
    pub fn rays(self) -> u32 {
        self.blocks() * BLOCK_RAYS
    }
    /// Pixels along one side of a block.
    #[inline(always)]
    pub fn block_pixels(self) -> u32 {
        BLOCK / self.side
    }
    /// Column and row of the ray, counted in rays from the upper left.
    #[inline(always)]
    pub fn ray(self, index: RayIndex) -> [u32; 2] {
        let block = index.0 / BLOCK_RAYS;
        let blocks_x = self.blocks_x();
        let [x, y] = place(index.0 % BLOCK_RAYS);
        [block % blocks_x * BLOCK + x, block / blocks_x * BLOCK + y]
    }
    /// Column and row of the first ray of the block that the ray lies in, and the ray's number
    /// inside it.
    #[inline(always)]
    pub fn corner(self, index: RayIndex) -> ([u32; 2], u32) {
        let inside = index.0 % BLOCK_RAYS;
        (self.ray(RayIndex(index.0 - inside)), inside)
    }
    /// Columns and rows of rays that belong to the frame.
    #[inline(always)]
    pub(crate) fn rays_across(self) -> [u32; 2] {
        [self.width * self.side, self.height * self.side]
    }
    /// Whether the ray at `[x, y]` belongs to the frame.
    #[inline(always)]
    pub fn contains(self, ray: [u32; 2]) -> bool {
        let [width, height] = self.rays_across();
        ray[0] < width && ray[1] < height
    }
    /// The ray at column `x` and row `y`.
    #[inline(always)]
    pub fn index(self, [x, y]: [u32; 2]) -> RayIndex {
        let block = y / BLOCK * self.blocks_x() + x / BLOCK;
        RayIndex(block * BLOCK_RAYS + number([x % BLOCK, y % BLOCK]))
    }
    /// The first sub-ray of the pixel with this number. That at column `a` and row `b` inside of the pixel has the
    /// [`number`] of `[a, b]` more.
    #[inline(always)]
    pub fn first_ray(self, pixel: u32) -> RayIndex {
        let [x, y] = self.pixel(pixel);
        self.index([x * self.side, y * self.side])
    }
    /// Column and row of the pixel with this number; pixels are numbered row by row.
    #[inline(always)]
    pub fn pixel(self, number: u32) -> [u32; 2] {
        [number % self.width, number / self.width]
    }
    /// The pixels of `rays` rays from `first` on, whole rows of blocks: the first pixel's number, and the
    /// number of pixels.
    #[inline(always)]
    pub fn pixels(self, first: RayIndex, rays: u32) -> [u32; 2] {
        let row = |ray: u32| {
            let row = ray / (self.blocks_x() * BLOCK_RAYS) * self.block_pixels();
            if row < self.height { row } else { self.height }
        };
        let (first, last) = (row(first.0), row(first.0 + rays));
        [first * self.width, (last - first) * self.width]
    }
    /// The block that the ray lies in.
    #[inline(always)]
    pub fn block(self, index: RayIndex) -> BlockIndex {
        BlockIndex(index.0 / BLOCK_RAYS)
    }
}

/// Column and row of the ray with this number inside its block.
#[inline(always)]
pub fn place(number: u32) -> [u32; 2] {
    let tile = number >> 4;
    [(number & 3) | (tile & 3) << 2, (number >> 2 & 3) | (tile >> 2) << 2]
}

/// The number inside its block of the ray at column and row `[x, y]` of the block.
#[inline(always)]
pub const fn number([x, y]: [u32; 2]) -> u32 {
    (x & 3) | (y & 3) << 2 | (x >> 2) << 4 | (y >> 2) << 6
}

/// The numbers inside a block of the first rays of its pixels, which have `side` × `side` sub-rays, row by row; zeros behind
/// them.
pub const fn first_rays(side: u32) -> [u8; BLOCK_RAYS as usize] {
    let (mut rays, mut pixel) = ([0; BLOCK_RAYS as usize], 0);
    let across = BLOCK / side;
    while pixel < across * across {
        rays[pixel as usize] = number([pixel % across * side, pixel / across * side]) as u8;
        pixel += 1;
    }
    rays
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_places_are_inverse() {
        let grid = Grid { width: 37, height: 21, side: 2 };
        for i in 0..grid.rays() {
            assert_eq!(grid.index(grid.ray(RayIndex(i))), RayIndex(i));
        }
        assert_eq!(grid.blocks(), 5 * 3);
    }

    #[test]
    fn sub_rays_of_a_pixel_have_their_places_from_its_first() {
        for side in [1, 2, 4] {
            let grid = Grid { width: 37, height: 21, side };
            for [x, y] in [[0, 0], [5, 3], [36, 20], [17, 16]] {
                for inside in (0..side).flat_map(|b| (0..side).map(move |a| [a, b])) {
                    let ray = grid.index([x * side + inside[0], y * side + inside[1]]);
                    assert_eq!(ray.0, grid.first_ray(y * grid.width + x).0 + number(inside));
                }
            }
        }
    }

    #[test]
    fn first_rays_of_a_block_are_those_of_a_frame_of_one_block() {
        for side in [1, 2, 4] {
            let grid = Grid { width: BLOCK / side, height: BLOCK / side, side };
            let pixels = 0..grid.width * grid.height;
            assert!(pixels.clone().all(|p| grid.first_ray(p).0 == u32::from(first_rays(side)[p as usize])));
            assert_eq!(pixels.len() as u32 * side * side, BLOCK_RAYS);
        }
    }

    #[test]
    fn bands_of_block_rows_make_each_pixel_once() {
        let grid = Grid { width: 37, height: 21, side: 2 };
        let row = grid.blocks_x() * BLOCK_RAYS;
        assert_eq!(grid.pixels(RayIndex(0), grid.rays()), [0, 37 * 21]);
        assert_eq!(grid.pixels(RayIndex(0), row), [0, 37 * 8]);
        assert_eq!(grid.pixels(RayIndex(row), 2 * row), [37 * 8, 37 * 13]);
        assert_eq!(grid.pixel(37 * 8 + 5), [5, 8]);
    }

    #[test]
    fn sixteen_neighbors_in_number_are_one_tile() {
        for n in 0..BLOCK_RAYS {
            let ([x, y], [x0, y0]) = (place(n), place(n / 16 * 16));
            assert!(x - x0 < 4 && y - y0 < 4 && x0 % 4 == 0 && y0 % 4 == 0);
        }
    }
}
