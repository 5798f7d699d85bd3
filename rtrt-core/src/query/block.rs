//! The triangles of a leaf, side by side: a ray asks eight at once which of them it may hit.

use super::rows::load_v3;
use super::wide::WIDTH;
use crate::kernel::ray::Ray;
use crate::kernel::triangle::{RelativeTriangle, may_meet_ahead};
use crate::lane::{Lane, Mask, V3};

/// Up to eight triangles.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    /// The coordinates of the first corners, of the second ones and of the third ones.
    corners: [[[f32; WIDTH]; 3]; 3],
    /// The number of the first triangle. The others follow.
    pub first: u32,
    /// How many there are.
    pub count: u32,
    /// A bit for each.
    there: u32,
}

impl Block {
    /// The block of the triangles with these corners.
    pub fn new(first: u32, count: u32, corners: impl Fn(u32) -> [[f32; 3]; 3]) -> Self {
        let mut block = Self { corners: [[[0.0; WIDTH]; 3]; 3], first, count, there: (1 << count) - 1 };
        for lane in 0..count {
            for (rows, corner) in block.corners.iter_mut().zip(corners(first + lane)) {
                for (row, coordinate) in rows.iter_mut().zip(corner) {
                    row[lane as usize] = coordinate;
                }
            }
        }
        block
    }

    /// The corners of one triangle.
    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> [[f32; 3]; 3] {
        let lane = lane & (WIDTH - 1);
        let [a, b, c] = &self.corners;
        let corner = |[x, y, z]: &[[f32; WIDTH]; 3]| [x[lane], y[lane], z[lane]];
        [corner(a), corner(b), corner(c)]
    }

    /// The numbers and corners of its triangles.
    pub fn triangles(&self) -> impl Iterator<Item = (u32, [[f32; 3]; 3])> {
        (0..self.count).map(|lane| (self.first + lane, self.triangle(lane as usize)))
    }

    /// A corner of the triangles from `first` on.
    #[inline(always)]
    fn corner<L: Lane>(&self, token: L::Token, corner: usize, first: usize) -> V3<L> {
        load_v3(token, &self.corners[corner], first)
    }
}

/// A ray, ready to ask the triangles of blocks, as many at a time as there are lanes.
pub(crate) struct AskedBlock<L> {
    ray: Ray<L>,
    /// The direction's coordinate along the axis that it follows most.
    along: L,
}

impl<L: Lane> AskedBlock<L> {
    #[inline(always)]
    pub fn new(token: L::Token, ray: &Ray<f32>) -> Self {
        let ray = ray.splat(token);
        Self { ray, along: ray.shear.along(ray.direction) }
    }

    /// The triangles that pass two tests of [`intersect`](crate::kernel::triangle::intersect), the first one and that they
    /// are not behind the ray: all that the ray hits, and few more.
    #[inline(always)]
    pub fn may_hit(&self, block: &Block) -> u32 {
        let ray = &self.ray;
        let token = ray.origin.x.token();
        let mut hit = 0;
        let mut first = 0;
        while first < WIDTH {
            let corners =
                [block.corner(token, 0, first), block.corner(token, 1, first), block.corner(token, 2, first)];
            let seen = RelativeTriangle::of(corners, ray.origin);
            hit |= may_meet_ahead(ray, self.along, &seen).bits() << first;
            first += L::WIDTH;
        }
        hit & block.there
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::triangle::{Triangle, intersect};
    use crate::lane::plain::Plain;

    /// Numbers within −1 .. 1 that look random.
    fn random(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    #[test]
    fn triangles_too_small_to_tell_their_winding_may_be_hit() {
        let s = f32::from_bits((127 - 33) << 23);
        let [a, b, c] = [[-s, -s, 0.0], [2.0 * s, -s, 0.0], [-s, 2.0 * s, 0.0]];
        for (corners, z) in [([a, b, c], 1.0), ([a, c, b], 1.0), ([a, b, c], -1.0), ([a, c, b], -1.0)] {
            let ray = Ray::<f32>::new(V3::splat((), [0.0, 0.0, z]), V3::splat((), [0.0, 0.0, -z]));
            let triangle = Triangle::new(corners[0], corners[1], corners[2]);
            assert!(intersect(&ray, &triangle.relative_to(ray.origin), f32::MAX).mask);
            let block = Block::new(0, 1, |_| corners);
            assert_eq!(AskedBlock::<Plain<8>>::new((), &ray).may_hit(&block), 1);
        }
    }

    #[test]
    fn what_is_hit_may_be_hit_and_little_else() {
        let (mut seed, mut hits, mut candidates) = (1, 0, 0);
        for round in 0..20_000 {
            // From flat and small to far beyond what meshes have; where they are tiny, all may be hit.
            let size = f32::from_bits(((127 + round % 50 - 20) as u32) << 23);
            let flat = if round % 3 == 0 { 1e-6 } else { 1.0 };
            let mut point =
                |by: f32| [random(&mut seed) * by, random(&mut seed) * by, random(&mut seed) * by * flat];
            let corners: [[[f32; 3]; 3]; 5] = [0; 5].map(|_| [0; 3].map(|_| point(size)));
            let (origin, to) = (point(size * 2.0), point(size * 0.5));
            let direction = [0, 1, 2].map(|axis| to[axis] - origin[axis]);
            let ray = Ray::<f32>::new(V3::splat((), origin), V3::splat((), direction));
            let block = Block::new(100, 5, |id| corners[id as usize - 100]);
            let may = AskedBlock::<Plain<8>>::new((), &ray).may_hit(&block);
            assert_eq!(AskedBlock::<f32>::new((), &ray).may_hit(&block), may);
            assert_eq!(may >> 5, 0);
            for (lane, [a, b, c]) in corners.into_iter().enumerate() {
                let triangle = Triangle::new(a, b, c);
                let hit = intersect(&ray, &triangle.relative_to(ray.origin), f32::MAX).mask;
                assert!(!hit || may >> lane & 1 == 1);
                assert_eq!(block.triangle(lane), [a, b, c]);
                hits += u32::from(hit);
            }
            candidates += may.count_ones();
        }
        assert!(hits > 5000 && candidates < 3 * hits, "{hits} of {candidates}");
    }
}
