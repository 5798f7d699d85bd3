//! Cameras as matrices and lenses in pixels, which programs exchange.
//!
//! ```
//! use glam::DVec3;
//! use rtrt::pose::{Pinhole, pixel, placed, to_world};
//!
//! let lens = Pinhole { fx: 500.0, fy: 500.0, cx: 320.0, cy: 200.0 };
//! let size = [640, 480];
//! let matrix = glam::DMat4::from_translation(DVec3::new(0.0, 1.0, 5.0));
//! let camera = placed(&matrix, lens.projection(size))?;
//! assert_eq!(to_world(&camera), Some(matrix));
//! // Half a unit to the right, five in front: 320 + 500 · 0.5 / 5.
//! let [x, y] = pixel(&camera, size, DVec3::new(0.5, 1.0, 0.0)).ok_or("behind")?;
//! assert!((x - 370.0).abs() < 1e-4 && (y - 200.0).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use glam::{DMat4, DVec3};
use rtrt_core::scene::{Camera, Projection};

/// A lens without distortion, in pixels.
///
/// A point at `(x, y)` right of and above the view, and `z` in front of the eye, is at column `cx + fx · x / z` and
/// row `cy − fy · y / z`, counted from the upper left corner of the picture: the middle of the first pixel is at
/// (0.5, 0.5), as in COLMAP and NeRF. OpenCV counts from that middle; add 0.5 to its principal points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    /// Horizontal focal length.
    pub fx: f64,
    /// Vertical focal length.
    pub fy: f64,
    /// Column of the principal point, from the left edge.
    pub cx: f64,
    /// Its row, from the upper edge.
    pub cy: f64,
}

impl Pinhole {
    /// The lens of a camera for a picture of this size; none for parallel rays.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Option<Self> {
        let [width, height] = size.map(f64::from);
        match camera.projection {
            Projection::Perspective { fov_y } => {
                let focal = 0.5 * height / libm::tan(0.5 * f64::from(fov_y));
                Some(Self { fx: focal, fy: focal, cx: 0.5 * width, cy: 0.5 * height })
            }
            Projection::OffCenter { left, right, bottom, top } => {
                let [left, right, bottom, top] = [left, right, bottom, top].map(f64::from);
                let (fx, fy) = (width / (right - left), height / (top - bottom));
                Some(Self { fx, fy, cx: -left * fx, cy: top * fy })
            }
            Projection::Orthographic { .. } => None,
        }
    }

    /// The lens with a horizontal angle of view, radians, and the principal point in the middle.
    pub fn of_angle_x(angle: f64, size: [u32; 2]) -> Self {
        let [width, height] = size.map(f64::from);
        let focal = 0.5 * width / libm::tan(0.5 * angle);
        Self { fx: focal, fy: focal, cx: 0.5 * width, cy: 0.5 * height }
    }

    /// The projection for a picture of this size.
    pub fn projection(&self, size: [u32; 2]) -> Projection {
        let [width, height] = size.map(f64::from);
        let Self { fx, fy, cx, cy } = *self;
        Projection::OffCenter {
            left: (-cx / fx) as f32,
            right: ((width - cx) / fx) as f32,
            bottom: ((cy - height) / fy) as f32,
            top: (cy / fy) as f32,
        }
    }
}

/// The matrix from the camera's axes (x to the right, y up, z backward) to world space; none for a camera that looks
/// nowhere.
pub fn to_world(camera: &Camera) -> Option<DMat4> {
    let eye = camera.eye.as_dvec3();
    let forward = unit(camera.look_at.as_dvec3() - eye)?;
    let right = unit(forward.cross(unit(camera.up.as_dvec3())?))?;
    let up = right.cross(forward);
    Some(DMat4::from_cols(right.extend(0.0), up.extend(0.0), (-forward).extend(0.0), eye.extend(1.0)))
}

/// The camera with this matrix to world space, as [`to_world`] gives it. Its axes may have any length.
///
/// # Errors
/// The matrix is no placement: it is not finite, skewed, or mirrored.
pub fn placed(matrix: &DMat4, projection: Projection) -> Result<Camera, &'static str> {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| unit(axis.truncate()));
    let (Some(x), Some(y), Some(z)) = (x, y, z) else {
        return Err("an axis of its matrix has no length");
    };
    let eye = matrix.w_axis.truncate();
    let last = [matrix.x_axis.w, matrix.y_axis.w, matrix.z_axis.w, matrix.w_axis.w];
    if !eye.is_finite() || last != [0.0, 0.0, 0.0, 1.0] {
        return Err("the last row of its matrix is not 0, 0, 0, 1");
    }
    if [x.dot(y), y.dot(z), z.dot(x)].iter().any(|cosine| cosine.abs() > 1e-3) {
        return Err("the axes of its matrix are not at right angles");
    }
    if x.cross(y).dot(z) < 0.0 {
        return Err("its matrix is mirrored");
    }
    // So far that rounding keeps the direction.
    let look_at = eye - z * eye.abs().max_element().max(1.0);
    Ok(Camera { eye: eye.as_vec3(), look_at: look_at.as_vec3(), up: y.as_vec3(), projection })
}

/// Where a point of the world is in a picture of this size: column and row, from the upper left corner. None for a
/// point that is not in front of the eye.
pub fn pixel(camera: &Camera, size: [u32; 2], point: DVec3) -> Option<[f64; 2]> {
    let axes = to_world(camera)?;
    let offset = point - axes.w_axis.truncate();
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.truncate().dot(offset));
    if let Projection::Orthographic { height } = camera.projection {
        let [columns, rows] = size.map(f64::from);
        let scale = rows / f64::from(height);
        return Some([0.5 * columns + x * scale, 0.5 * rows - y * scale]);
    }
    let Pinhole { fx, fy, cx, cy } = Pinhole::new(camera, size)?;
    (z < 0.0).then(|| [cx - fx * x / z, cy + fy * y / z])
}

/// `v` at length 1; none for a vector without a length.
fn unit(v: DVec3) -> Option<DVec3> {
    let length = v.length_squared().sqrt();
    (length > 1e-30 && length.is_finite()).then(|| v / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, Vec3};

    const SIZE: [u32; 2] = [640, 480];

    #[test]
    fn a_lens_is_a_projection_and_back() {
        let lens = Pinhole { fx: 512.0, fy: 400.0, cx: 100.0, cy: 300.0 };
        let camera =
            Camera { eye: Vec3::ZERO, look_at: -Vec3::Z, up: Vec3::Y, projection: lens.projection(SIZE) };
        let back = Pinhole::new(&camera, SIZE).unwrap();
        for (a, b) in [(back.fx, 512.0), (back.fy, 400.0), (back.cx, 100.0), (back.cy, 300.0)] {
            assert!((a - b).abs() < 1e-3, "{back:?}");
        }
        // tan 45° = 1: half of the width is the focal length.
        let right_angle = Pinhole::of_angle_x(std::f64::consts::FRAC_PI_2, SIZE);
        assert!((right_angle.fx - 320.0).abs() < 1e-9 && right_angle.cy == 240.0);
    }

    #[test]
    fn a_matrix_is_a_camera_and_back() {
        let turn = DQuat::from_euler(glam::EulerRot::YXZ, 2.1, -0.4, 0.3);
        let matrix = DMat4::from_scale_rotation_translation(DVec3::ONE, turn, DVec3::new(300.0, -2.0, 7.0));
        let projection = Projection::Perspective { fov_y: 1.0 };
        let camera = placed(&matrix, projection).unwrap();
        let back = to_world(&camera).unwrap();
        assert!(back.abs_diff_eq(matrix, 1e-5), "{back} {matrix}");
        let larger = placed(&(matrix * DMat4::from_scale(DVec3::splat(3.0))), projection).unwrap();
        assert!(to_world(&larger).unwrap().abs_diff_eq(matrix, 1e-5));
        let mirrored = matrix * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert_eq!(placed(&mirrored, projection), Err("its matrix is mirrored"));
        assert!(placed(&DMat4::ZERO, projection).is_err());
        let mut skewed = matrix;
        skewed.x_axis += skewed.y_axis * 0.5;
        assert_eq!(placed(&skewed, projection), Err("the axes of its matrix are not at right angles"));
    }

    #[test]
    fn parallel_rays_show_a_point_at_the_same_place_at_any_depth() {
        let projection = Projection::Orthographic { height: 4.8 };
        let camera = Camera { eye: Vec3::ZERO, look_at: -Vec3::Z, up: Vec3::Y, projection };
        for depth in [1.0, 9.0] {
            let [x, y] = pixel(&camera, SIZE, DVec3::new(1.0, -1.0, -depth)).unwrap();
            assert!((x - 420.0).abs() < 1e-4 && (y - 340.0).abs() < 1e-4, "{x} {y}");
        }
    }
}
