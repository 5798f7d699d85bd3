//! Instances that move and turn, as functions of time.

use glam::{DMat3, DMat4, DQuat, DVec3, Mat4, Vec3};

/// The motion of an instance: along a line, and around an axis through its own origin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// World units a second.
    pub velocity: Vec3,
    /// The axis of rotation, world space, any length; 0 for no rotation.
    pub axis: Vec3,
    /// Radians a second, counterclockwise where the axis points to the viewer.
    pub rate: f32,
}

impl Motion {
    /// The transform after `time` seconds of an instance that began at `start`; see
    /// [`Scene::set_transforms`](crate::scene::Scene::set_transforms).
    ///
    /// It is computed from the start, in `f64`: errors do not add up from frame to frame, and a frame does
    /// not depend on earlier ones.
    ///
    /// ```
    /// use glam::{Mat4, Vec3};
    /// use rtrt_core::scene::Motion;
    ///
    /// let motion = Motion { velocity: Vec3::X, axis: Vec3::Y, rate: core::f32::consts::PI };
    /// let half_turn = motion.at(Mat4::from_scale(Vec3::splat(2.0)), 1.0);
    /// let corner = half_turn.transform_point3(Vec3::new(1.0, 1.0, 0.0));
    /// assert!(corner.distance(Vec3::new(-1.0, 2.0, 0.0)) < 1e-6);
    /// ```
    pub fn at(&self, start: Mat4, time: f64) -> Mat4 {
        let start = start.as_dmat4();
        let axis = self.axis.as_dvec3();
        let length = libm::sqrt(axis.length_squared());
        let half = f64::from(self.rate) * time * 0.5;
        let turn = if length > 0.0 {
            let [x, y, z] = (axis * (libm::sin(half) / length)).to_array();
            DQuat::from_xyzw(x, y, z, libm::cos(half))
        } else {
            DQuat::IDENTITY
        };
        let turned = DMat3::from_quat(turn) * DMat3::from_mat4(start);
        let place: DVec3 = start.w_axis.truncate() + self.velocity.as_dvec3() * time;
        let [x, y, z] = [turned.x_axis, turned.y_axis, turned.z_axis].map(|axis| axis.extend(0.0));
        DMat4::from_cols(x, y, z, place.extend(1.0)).as_mat4()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_moved_at_first() {
        let start = Mat4::from_rotation_x(0.3) * Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0));
        let motion = Motion { velocity: Vec3::splat(9.0), axis: Vec3::ONE, rate: 2.0 };
        assert_eq!(motion.at(start, 0.0), start);
        assert_eq!(Motion::default().at(start, 1e3), start);
    }
}
