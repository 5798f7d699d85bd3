//! Clip coordinates for the rasterizer of hybrid frames.

use crate::lane::V3;
use crate::layout::View;
use crate::num::recip;
use bytemuck::{Pod, Zeroable};

/// A rectangle of a frame's blocks that is rasterized at once.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct ClipWindow {
    /// First column of blocks.
    pub column: u32,
    /// First row of blocks.
    pub row: u32,
    /// Number of columns; not 0.
    pub columns: u32,
    /// Number of rows; not 0.
    pub rows: u32,
}
const _: () = assert!(size_of::<ClipWindow>() == 16);

/// The near plane, as a share of the frame's magnitude: 2⁻⁴⁰.
pub const NEAR: f32 = f32::from_bits((127 - 40) << 23);

/// The far plane of parallel rays, in magnitudes: beyond the diagonal of the scene.
const FAR: f32 = 4.0;

/// A projected point: column `x / w` and row `y / w`, in blocks, and depth `depth`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projected {
    /// Column, times `w`.
    pub x: f32,
    /// Row, times `w`.
    pub y: f32,
    /// 1 for parallel rays, else the depth.
    pub w: f32,
    /// Its `t` on a ray of the camera.
    pub depth: f32,
}

impl Projected {
    /// A point of the world.
    #[inline(always)]
    pub fn point(view: &View, point: V3<f32>) -> Self {
        let offset = point - V3::splat((), view.center);
        let along = |row: &[f32; 3]| offset.dot(V3::splat((), *row));
        Self {
            x: along(&view.x),
            y: along(&view.y),
            w: along(&view.w) + view.w_offset,
            depth: along(&view.depth),
        }
    }

    /// The corner of a block at a depth, not in front of the near plane.
    #[inline(always)]
    pub fn corner(view: &View, magnitude: f32, [column, row]: [u32; 2], depth: f32) -> Self {
        let near = NEAR * magnitude;
        let depth = if near < depth { depth } else { near };
        let w = if view.w_offset == 0.0 { depth } else { view.w_offset };
        Self { x: column as f32 * w, y: row as f32 * w, w, depth }
    }

    /// Clip coordinates in the window: −w to w to the right and up, and depth from 0, farthest, to `w`,
    /// nearest.
    ///
    /// ```text
    /// z = near, so that z / w = near / depth       where rays leave one point
    /// z = 1 − depth / far                          where they are parallel
    /// ```
    ///
    /// Reversed depth with an infinite far plane: the precision of floats is highest far away.
    #[inline(always)]
    pub fn clip(&self, view: &View, window: &ClipWindow, magnitude: f32) -> [f32; 4] {
        let (column, row) = (window.column as f32, window.row as f32);
        let (columns, rows) = (2.0 * recip(window.columns as f32), 2.0 * recip(window.rows as f32));
        let z =
            if view.w_offset == 0.0 { NEAR * magnitude } else { 1.0 - self.depth * recip(FAR * magnitude) };
        [(self.x - column * self.w) * columns - self.w, self.w - (self.y - row * self.w) * rows, z, self.w]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{BLOCK, Grid};
    use crate::kernel::view::camera_ray;
    use crate::scene::{Camera, Projection};
    use glam::Vec3;

    #[test]
    fn a_point_on_a_ray_is_in_the_middle_of_its_pixel() {
        let grid = Grid { width: 100, height: 60, side: 2 };
        let projections = [Projection::Perspective { fov_y: 1.2 }, Projection::Orthographic { height: 5.0 }];
        for projection in projections {
            let (eye, look_at) = (Vec3::new(3.0, -4.0, 5.0), Vec3::new(-1.0, 2.0, 0.5));
            let view = Camera { eye, look_at, up: Vec3::Y, projection }.view(grid).unwrap();
            let window = ClipWindow { column: 3, row: 2, columns: 7, rows: 5 };
            let mut nearer = 1.0;
            for t in [0.5, 3.0, 11.0] {
                for [x, y] in [[50, 40], [111, 33], [159, 111]] {
                    let ray = camera_ray(&view, x as f32, y as f32);
                    let point = ray.origin + ray.direction.scale(t);
                    let [a, b, z, w] = Projected::point(&view, point).clip(&view, &window, 20.0);
                    let size = [window.columns, window.rows].map(|blocks| (blocks * BLOCK) as f32);
                    let pixel = [(a / w + 1.0) * 0.5 * size[0], (1.0 - b / w) * 0.5 * size[1]];
                    let first = [window.column, window.row].map(|block| (block * BLOCK) as f32);
                    let off = [pixel[0] + first[0] - x as f32 - 0.5, pixel[1] + first[1] - y as f32 - 0.5];
                    assert!(off[0].abs() < 1e-3 && off[1].abs() < 1e-3, "{projection:?} {t} {off:?}");
                    assert!(0.0 < z && z < w);
                    assert!(z / w <= nearer);
                    nearer = z / w + 1e-6;
                }
            }
        }
    }

    #[test]
    fn a_corner_of_a_block_is_where_it_is() {
        let grid = Grid { width: 64, height: 64, side: 1 };
        for projection in [Projection::Perspective { fov_y: 1.2 }, Projection::Orthographic { height: 5.0 }] {
            let view =
                Camera { eye: Vec3::ZERO, look_at: Vec3::X, up: Vec3::Y, projection }.view(grid).unwrap();
            let window = ClipWindow { column: 1, row: 1, columns: 2, rows: 2 };
            for depth in [0.0, 2.0] {
                let [x, y, z, w] = Projected::corner(&view, 4.0, [3, 2], depth).clip(&view, &window, 4.0);
                assert!((x / w - 1.0).abs() < 1e-6 && (y / w).abs() < 1e-6, "{projection:?} {x} {y} {w}");
                assert!(0.0 < z && z <= w);
            }
        }
    }
}
