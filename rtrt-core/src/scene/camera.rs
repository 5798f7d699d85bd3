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
    /// The camera's view for a frame of this size, computed in `f64`.
    ///
    /// # Errors
    /// [`SetupError::Camera`] where eye and target coincide, `up` is along the view, or a
    /// number is out of range.
    pub(crate) fn view(&self, grid: Grid) -> Result<View, SetupError> {
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

        // Half of the picture at distance 1, or in the plane.
        let half_height = match self.projection {
            Projection::Perspective { fov_y } if fov_y > 0.0 && fov_y < core::f32::consts::PI => {
                libm::tan(f64::from(fov_y) * 0.5)
            }
            Projection::Orthographic { height } if height > 0.0 && height.is_finite() => {
                f64::from(height) * 0.5
            }
            Projection::Perspective { .. } => {
                return Err(error("the field of view must be within 0 and 180 degrees"));
            }
            Projection::Orthographic { .. } => return Err(error("the height must be positive")),
        };
        let half_width = half_height * f64::from(grid.width) / f64::from(grid.height);
        let block = f64::from(BLOCK);
        // Blocks in the picture, not whole numbers.
        let columns = f64::from(grid.width * grid.side) / block;
        let rows = f64::from(grid.height * grid.side) / block;
        let step_x = right * (2.0 * half_width / columns);
        let step_y = up * (-2.0 * half_height / rows);
        let corner = up * half_height - right * half_width;
        let x = right * (columns / (2.0 * half_width));
        let y = up * (-rows / (2.0 * half_height));
        let radius = (0.5 * libm::sqrt(step_x.length_squared() + step_y.length_squared())) as f32;
        let pixel = (2.0 * half_height / (rows * block)) as f32;
        let view = View {
            kind: ViewKind::Camera as u32,
            depth: single(forward),
            width: grid.blocks_x(),
            height: grid.blocks_y(),
            reach_squared: f32::MAX,
            ..View::zeroed()
        };
        Ok(match self.projection {
            Projection::Perspective { .. } => View {
                center: single(eye),
                x: single(x + forward * (columns * 0.5)),
                y: single(y + forward * (rows * 0.5)),
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

/// `v` at length 1; none for a vector without length.
pub(super) fn unit(v: DVec3) -> Option<DVec3> {
    let length = libm::sqrt(v.length_squared());
    (length > 1e-30 && length.is_finite()).then(|| v / length)
}

/// Rounded to single precision, without denormals.
pub(super) fn single(v: DVec3) -> [f32; 3] {
    [v.x, v.y, v.z].map(|component| flush(component as f32))
}
