//! The rays of a view, and the block of a light in which a point lies.

use crate::grid::BLOCK;
use crate::kernel::ray::Ray;
use crate::lane::{Bits, Lane, Select, V3};
use crate::layout::{View, ViewKind};
use crate::num::{clamp, floor, recip, to_integer};

/// Side of a ray's cell, in blocks.
const BLOCKS_PER_RAY: f32 = 1.0 / BLOCK as f32;

/// The ray through column `a` and row `b` of the view's blocks (not whole numbers).
#[inline(always)]
pub fn ray<L: Lane>(view: &View, a: L, b: L) -> Ray<L> {
    let start = affine(&view.start, &view.start_x, &view.start_y, a, b);
    Ray::new(V3::splat(a.token(), view.center) + start, direction(view, a, b))
}

/// The direction of [`ray`].
#[inline(always)]
fn direction<L: Lane>(view: &View, a: L, b: L) -> V3<L> {
    affine(&view.along, &view.along_x, &view.along_y, a, b)
}

/// [`camera_ray`] of a camera all of whose rays start at its center.
#[inline(always)]
pub(crate) fn central_ray<L: Lane>(view: &View, x: L, y: L) -> Ray<L, f32> {
    Ray::new(V3::splat((), view.center), camera_direction(view, x, y))
}

/// The direction of [`camera_ray`].
#[inline(always)]
pub(crate) fn camera_direction<L: Lane>(view: &View, x: L, y: L) -> V3<L> {
    direction(view, (x + 0.5) * BLOCKS_PER_RAY, (y + 0.5) * BLOCKS_PER_RAY)
}

/// `a · by_a + b · by_b + base`.
#[inline(always)]
fn affine<L: Lane>(base: &[f32; 3], by_a: &[f32; 3], by_b: &[f32; 3], a: L, b: L) -> V3<L> {
    V3 {
        x: a * by_a[0] + b * by_b[0] + base[0],
        y: a * by_a[1] + b * by_b[1] + base[1],
        z: a * by_a[2] + b * by_b[2] + base[2],
    }
}

/// The camera ray with these column and row, counted in rays: it goes through the
/// middle of its cell of the grid.
#[inline(always)]
pub fn camera_ray<L: Lane>(view: &View, x: L, y: L) -> Ray<L> {
    ray(view, (x + 0.5) * BLOCKS_PER_RAY, (y + 0.5) * BLOCKS_PER_RAY)
}

/// The block of `light` (numbered as in the lists) whose list holds everything that can
/// stand between the light and the point, where a shadow ray starts.
///
/// For a point light: the face of the offset's longest axis (`+x −x +y −y +z −z`, the
/// first of equals), in which the other two coordinates, divided by it, give column and
/// row. The offset is taken first, so that column and row are off by a few rounding errors
/// of themselves only; binning widens every instance by more.
#[inline(always)]
pub(crate) fn light_block<L: Lane>(light: &View, point: V3<L>) -> L::Bits {
    let token = point.x.token();
    let offset = point - V3::splat(token, light.center);
    // Not `== Point`: the first face of a spot light's cube may be off.
    let (column, row, face) = if light.kind != ViewKind::Sun as u32 {
        let (x, y, z) = (offset.x, offset.y, offset.z);
        let in_x = x.abs().ge(y.abs()) & x.abs().ge(z.abs());
        let in_y = y.abs().ge(z.abs());
        let major = in_x.select(x, in_y.select(y, z));
        let inverse = recip(major.abs());
        let half = light.width as f32 * 0.5;
        let column = in_x.select(y, x) * inverse * half + half;
        let row = (in_x | in_y).select(z, y) * inverse * half + half;
        let axis = in_x.select(x.broadcast_bits(0), in_y.select(x.broadcast_bits(2), x.broadcast_bits(4)));
        (column, row, axis + (major.to_bits() >> 31))
    } else {
        let column = offset.dot(V3::splat(token, light.x));
        let row = offset.dot(V3::splat(token, light.y));
        (column, row, column.broadcast_bits(0))
    };
    let size = light.width * light.height;
    let block = times(cell(row, light.height), light.width) + cell(column, light.width);
    block + times(face, size) + block.broadcast(light.first_block)
}

/// `a · b`, as a sum: lanes have no integer multiplication.
#[inline(always)]
fn times<B: Bits>(a: B, b: u32) -> B {
    let mut sum = a.broadcast(0);
    let mut shift = 0;
    while b >> shift != 0 {
        if b >> shift & 1 == 1 {
            sum = sum + (a << shift);
        }
        shift += 1;
    }
    sum
}

/// The cell of `0 .. count` that a coordinate is in; the nearest one if it is outside, and
/// the first for NaN.
#[inline(always)]
pub fn cell<L: Lane>(coordinate: L, count: u32) -> L::Bits {
    let zero = coordinate.broadcast(0.0);
    let c = coordinate.gt(zero).select(coordinate, zero);
    to_integer(clamp(floor(clamp(c, 0.0, count as f32)), 0.0, (count - 1) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn at(v: [f32; 3]) -> V3<f32> {
        V3::splat((), v)
    }

    #[test]
    fn the_camera_ray_goes_through_the_middle_of_its_cell() {
        let view = View {
            center: [1.0, 2.0, 3.0],
            start_x: [8.0, 0.0, 0.0],
            along: [-1.0, 1.0, -1.0],
            along_x: [0.5, 0.0, 0.0],
            along_y: [0.0, -0.25, 0.0],
            ..View::zeroed()
        };
        // Half a cell is 1/32 of a block.
        let ray = camera_ray(&view, 15.5, 31.5);
        assert_eq!(ray.origin.lane(0), [1.0 + 8.0, 2.0, 3.0]);
        assert_eq!(ray.direction.lane(0), [-0.5, 0.5, -1.0]);
        assert_eq!(
            camera_ray(&view, 0.0, 0.0).direction.lane(0),
            [-1.0 + 0.5 / 32.0, 1.0 - 0.25 / 32.0, -1.0]
        );
        assert_eq!(central_ray(&view, 15.5, 31.5).origin.lane(0), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn a_point_lights_block_is_on_the_face_of_the_longest_axis() {
        let light = View {
            kind: ViewKind::Point as u32,
            center: [10.0, 0.0, 0.0],
            width: 4,
            height: 4,
            first_block: 100,
            ..View::zeroed()
        };
        let block = |x: f32, y: f32, z: f32| light_block(&light, at([10.0 + x, y, z])).0;
        // Column and row are the other coordinates in their order: −1 ..= 1 becomes 0 ..= 4.
        let in_face = |column: u32, row: u32| row * 4 + column;
        assert_eq!(block(1.0, 0.75, -0.25), 100 + in_face(3, 1));
        assert_eq!(block(-2.0, 1.5, -0.5), 100 + 16 + in_face(3, 1));
        assert_eq!(block(-0.25, 1.0, 0.75), 100 + 2 * 16 + in_face(1, 3));
        assert_eq!(block(0.25, -1.0, 0.75), 100 + 3 * 16 + in_face(2, 3));
        assert_eq!(block(-0.75, 0.25, 1.0), 100 + 4 * 16 + in_face(0, 2));
        assert_eq!(block(-0.75, 0.25, -1.0), 100 + 5 * 16 + in_face(0, 2));
        // The first of equals, its last cell.
        assert_eq!(block(1.0, 1.0, 1.0), 100 + in_face(3, 3));
    }

    #[test]
    fn a_suns_block_is_where_the_point_lies_across_its_light() {
        let light = View {
            kind: ViewKind::Sun as u32,
            center: [-4.0, 0.0, -4.0],
            x: [0.5, 0.0, 0.0],
            y: [0.0, 0.0, 0.5],
            width: 4,
            height: 2,
            first_block: 7,
            ..View::zeroed()
        };
        let block = |x: f32, y: f32, z: f32| light_block(&light, at([x, y, z])).0;
        assert_eq!([block(-4.0, 9.0, -4.0), block(1.0, -9.0, -1.0)], [7, 7 + 4 + 2]);
        // Beyond the edges, the nearest block.
        assert_eq!([block(99.0, 0.0, 99.0), block(-99.0, 0.0, -99.0)], [7 + 7, 7]);
    }

    #[test]
    fn cells_hold_what_is_outside_too() {
        let cells = [-5.0, f32::NAN, 0.0, 0.99, 3.0, 3.7, 4.0, 1e30].map(|c: f32| cell(c, 4).0);
        assert_eq!(cells, [0, 0, 0, 0, 3, 3, 3, 3]);
    }
}
