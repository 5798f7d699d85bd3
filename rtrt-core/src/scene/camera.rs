//! The view of the camera.

use crate::grid::{BLOCK, Grid};
use crate::layout::{View, ViewKind};
use crate::num::flush;
use crate::request::{Camera, Projection};
use crate::scene::SetupError;
use crate::scene::floor::floored;
use bytemuck::Zeroable;
use glam::DVec3;

impl Camera {
    /// The camera's view for a frame of this size, computed in `f64`. Its rays
    /// ([`camera_ray`](crate::kernel::view::camera_ray)) are those of the frame.
    ///
    /// # Errors
    /// [`SetupError::Camera`] where eye and target coincide, `up` is along the view, or a
    /// number is out of range.
    pub fn view(&self, grid: Grid) -> Result<View, SetupError> {
        let error = |why| SetupError::Camera { why };
        let eye = self.eye.map(floored).as_dvec3();
        if !(eye.is_finite() && self.look_at.is_finite() && self.up.is_finite()) {
            return Err(error("eye, target and up must be finite"));
        }
        let forward = unit(self.look_at.as_dvec3() - eye).ok_or(error("eye and target coincide"))?;
        let up = unit(self.up.as_dvec3()).ok_or(error("up is zero"))?;
        let right = forward.cross(up);
        if right.length_squared() < 1e-12 {
            return Err(error("up is along the view"));
        }
        let right = unit(right).ok_or(error("up is along the view"))?;
        let up = right.cross(forward);

        let Edges { left, right: right_edge, bottom, top } = self.edges(grid).map_err(error)?;
        let (across, down) = (right_edge - left, top - bottom);
        let block = f64::from(BLOCK);
        // Blocks in the picture, not whole numbers.
        let columns = f64::from(grid.width * grid.side) / block;
        let rows = f64::from(grid.height * grid.side) / block;
        let step_x = right * (across / columns);
        let step_y = up * (-down / rows);
        let corner = up * top + right * left;
        let x = right * (columns / across);
        let y = up * (-rows / down);
        let radius = (0.5 * libm::sqrt(step_x.length_squared() + step_y.length_squared())) as f32;
        let pixel = (down / (rows * block)) as f32;
        let view = View {
            kind: ViewKind::Camera as u32,
            depth: single(forward),
            width: grid.blocks_x(),
            height: grid.blocks_y(),
            reach_squared: f32::MAX,
            ..View::zeroed()
        };
        Ok(match self.projection {
            Projection::Perspective { .. } | Projection::OffCenter { .. } => View {
                center: single(eye),
                x: single(x + forward * (columns * (-left / across))),
                y: single(y + forward * (rows * (top / down))),
                w: single(forward),
                spread_w: radius,
                along: single(forward + corner),
                along_x: single(step_x),
                along_y: single(step_y),
                pixel_t: pixel,
                ..view
            },
            Projection::Orthographic { .. } => View {
                center: single(eye + corner),
                x: single(x),
                y: single(y),
                w_offset: 1.0,
                spread: radius,
                along: single(forward),
                start_x: single(step_x),
                start_y: single(step_y),
                pixel,
                ..view
            },
        })
    }
}

/// Where the edges of the picture are, at distance 1 in front of the camera or, for parallel rays, in its plane.
struct Edges {
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
}

impl Camera {
    /// The edges of a picture of this size.
    fn edges(&self, grid: Grid) -> Result<Edges, &'static str> {
        let half_height = match self.projection {
            Projection::Perspective { fov_y } if fov_y > 0.0 && fov_y < core::f32::consts::PI => {
                libm::tan(f64::from(fov_y) * 0.5)
            }
            Projection::Orthographic { height } if height > 0.0 && height.is_finite() => {
                f64::from(height) * 0.5
            }
            Projection::OffCenter { left, right, bottom, top } => {
                const LIMIT: f64 = 1048576.0;
                let [left, right, bottom, top] = [left, right, bottom, top].map(f64::from);
                let are_near = [left, right, bottom, top].iter().all(|edge| edge.abs() <= LIMIT);
                let are_apart = right - left >= 1.0 / LIMIT && top - bottom >= 1.0 / LIMIT;
                return if are_near && are_apart {
                    Ok(Edges { left, right, bottom, top })
                } else {
                    Err("the edges of the picture must be in order, apart by 2^-20, and within ±2^20")
                };
            }
            Projection::Perspective { .. } => {
                return Err("the field of view must be within 0 and 180 degrees");
            }
            Projection::Orthographic { .. } => return Err("the height must be positive"),
        };
        let half_width = half_height * f64::from(grid.width) / f64::from(grid.height);
        Ok(Edges { left: -half_width, right: half_width, bottom: -half_height, top: half_height })
    }
}

/// `v` at length 1; none for a vector without length.
pub(super) fn unit(v: DVec3) -> Option<DVec3> {
    let length = libm::sqrt(v.length_squared());
    (length > 1e-30 && length.is_finite()).then(|| v / length)
}

/// Rounded to single precision, without denormals.
pub(super) fn single(v: DVec3) -> [f32; 3] {
    [v.x, v.y, v.z].map(|component| flush(component as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::view::camera_ray;
    use glam::Vec3;

    /// A lens of 300 and 200 pixels focal length with its principal point at (20, 50) of 160 × 96 pixels.
    const LENS: Projection = Projection::OffCenter {
        left: -20.0 / 300.0,
        right: (160.0 - 20.0) / 300.0,
        bottom: (50.0 - 96.0) / 200.0,
        top: 50.0 / 200.0,
    };

    fn camera(projection: Projection) -> Camera {
        Camera { eye: Vec3::new(1.0, 2.0, 3.0), look_at: Vec3::new(1.0, 2.0, -5.0), up: Vec3::Y, projection }
    }

    #[test]
    fn a_point_is_where_its_lens_shows_it() {
        for side in [1, 2] {
            let view = camera(LENS).view(Grid { width: 160, height: 96, side }).unwrap();
            // Right, up and in front of the eye, and where that is: cx + fx · right / front, cy − fy · up / front.
            for (right, up, front) in [(0.5, 0.1, 2.0), (-0.1, -0.25, 4.0), (0.0, 0.0, 1.0)] {
                let pixel = [20.0 + 300.0 * right / front, 50.0 - 200.0 * up / front];
                let offset = DVec3::new(right, up, -front);
                let dot = |row: [f32; 3]| DVec3::from(row.map(f64::from)).dot(offset);
                let cells = f64::from(BLOCK) / f64::from(side);
                let found = [dot(view.x), dot(view.y)].map(|x| x / dot(view.w) * cells);
                assert!((0..2).all(|i| (found[i] - pixel[i]).abs() < 1e-4), "{found:?} {pixel:?}");
                // The ray through that place goes through the point.
                let [x, y] = pixel.map(|at| (at * f64::from(side) - 0.5) as f32);
                let ray = camera_ray::<f32>(&view, x, y);
                let along =
                    DVec3::new(ray.direction.x.into(), ray.direction.y.into(), ray.direction.z.into());
                assert!((along * front - offset).length() < 1e-5, "{along} {offset}");
            }
        }
    }

    #[test]
    fn a_lens_in_the_middle_is_a_field_of_view() {
        let grid = Grid { width: 64, height: 32, side: 2 };
        let middle = Projection::OffCenter { left: -2.0, right: 2.0, bottom: -1.0, top: 1.0 };
        let angle = Projection::Perspective { fov_y: core::f32::consts::FRAC_PI_2 };
        let [middle, angle] = [middle, angle].map(|projection| camera(projection).view(grid).unwrap());
        for (a, b) in [(middle.along, angle.along), (middle.x, angle.x), (middle.y, angle.y)] {
            assert!((Vec3::from(a) - Vec3::from(b)).abs().max_element() < 1e-6, "{a:?} {b:?}");
        }
    }

    #[test]
    fn edges_out_of_order_are_refused() {
        let grid = Grid { width: 8, height: 8, side: 1 };
        for [left, right, bottom, top] in [
            [1.0, -1.0, -1.0, 1.0],
            [-1.0, 1.0, 1.0, 1.0],
            [-1.0, f32::NAN, -1.0, 1.0],
            [f32::NEG_INFINITY, 1.0, -1.0, 1.0],
            [0.0, 1e-9, -1.0, 1.0],
        ] {
            assert!(camera(Projection::OffCenter { left, right, bottom, top }).view(grid).is_err());
        }
    }
}
