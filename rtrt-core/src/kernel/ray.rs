//! A ray, and its transform into object space.

use crate::kernel::shear::Shear;
use crate::lane::{Lane, V3};
use crate::layout::Instance;
use crate::num::recip;
use core::ops::{Add, Mul};

/// The points `origin + t · direction`, `t > 0`.
///
/// `O` is `L` if each lane's ray has its own origin, and `f32` if all rays of a packet share one: terms of
/// the origin alone are then computed once.
#[derive(Clone, Copy)]
pub struct Ray<L, O = L> {
    /// The start of the ray.
    pub origin: V3<O>,
    /// The direction; any length.
    pub direction: V3<L>,
    /// The reciprocals of the direction, finite even where it is 0.
    pub inverse: V3<L>,
    /// How it leans.
    pub shear: Shear<L>,
}

impl<L: Lane, O: Lane> Ray<L, O> {
    /// The ray from `origin` along `direction`.
    #[inline(always)]
    pub fn new(origin: V3<O>, direction: V3<L>) -> Self {
        let inverse = V3 { x: recip(direction.x), y: recip(direction.y), z: recip(direction.z) };
        Self { origin, direction, inverse, shear: Shear::new(direction, inverse) }
    }

    /// The same points, `t` for `t`, in the space of an object with this
    /// [`Instance::to_object`](crate::layout::Instance::to_object).
    ///
    /// Relative to the object's place the origin is exact where it is near (Sterbenz), however far both are from the
    /// world's origin.
    #[inline(always)]
    pub(crate) fn transformed(&self, m: &[[f32; 4]; 3]) -> Self {
        let place = V3::splat(self.origin.x.token(), [m[0][3], m[1][3], m[2][3]]);
        Self::new(vector(m, self.origin - place), vector(m, self.direction))
    }

    /// The same points, `t` for `t`, in the object's space.
    #[inline(always)]
    pub fn to_object(&self, instance: &Instance) -> Self {
        self.transformed(&instance.to_object)
    }
}

impl<L: Lane> Ray<L> {
    /// Rays that are not traced.
    #[inline(always)]
    pub(crate) fn idle(token: L::Token) -> Self {
        let zero = V3::splat(token, [0.0; 3]);
        Self { origin: zero, direction: zero, inverse: zero, shear: Shear::idle(token) }
    }
}

#[cfg(feature = "alloc")]
impl Ray<f32> {
    /// The same ray in all lanes.
    #[inline(always)]
    pub(crate) fn splat<L: Lane>(&self, token: L::Token) -> Ray<L> {
        Ray {
            origin: V3::splat(token, self.origin.lane(0)),
            direction: V3::splat(token, self.direction.lane(0)),
            inverse: V3::splat(token, self.inverse.lane(0)),
            shear: self.shear.splat(token),
        }
    }
}

/// `m · (p, 1)`, each row summed from left to right; the matrix is one for all lanes, or
/// each lane's own.
#[inline(always)]
pub fn point<L: Lane + Mul<M, Output = L> + Add<M, Output = L>, M: Copy>(m: &[[M; 4]; 3], p: V3<L>) -> V3<L> {
    V3 {
        x: p.x * m[0][0] + p.y * m[0][1] + p.z * m[0][2] + m[0][3],
        y: p.x * m[1][0] + p.y * m[1][1] + p.z * m[1][2] + m[1][3],
        z: p.x * m[2][0] + p.y * m[2][1] + p.z * m[2][2] + m[2][3],
    }
}

/// `m · (v, 0)`, each row summed from left to right.
#[inline(always)]
pub fn vector<L: Lane + Mul<M, Output = L>, M: Copy>(m: &[[M; 4]; 3], v: V3<L>) -> V3<L> {
    V3 {
        x: v.x * m[0][0] + v.y * m[0][1] + v.z * m[0][2],
        y: v.x * m[1][0] + v.y * m[1][1] + v.z * m[1][2],
        z: v.x * m[2][0] + v.y * m[2][1] + v.z * m[2][2],
    }
}

/// `transpose(m) · n`: takes a normal from instance to world space when `m` takes points
/// from world to object space.
#[inline(always)]
pub fn normal<L: Lane + Mul<M, Output = L>, M: Copy>(m: &[[M; 4]; 3], n: V3<L>) -> V3<L> {
    V3 {
        x: n.x * m[0][0] + n.y * m[1][0] + n.z * m[2][0],
        y: n.x * m[0][1] + n.y * m[1][1] + n.z * m[2][1],
        z: n.x * m[0][2] + n.y * m[1][2] + n.z * m[2][2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn a_matrix_takes_points_vectors_and_normals() {
        let m = [[1.0_f32, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0]];
        let v = V3::<f32>::splat((), [1.0, -1.0, 2.0]);
        assert_eq!(point(&m, v).lane(0), [9.0, 21.0, 33.0]);
        assert_eq!(vector(&m, v).lane(0), [5.0, 13.0, 21.0]);
        // Columns in place of rows.
        assert_eq!(normal(&m, v).lane(0), [14.0, 16.0, 18.0]);
    }

    #[test]
    fn a_ray_keeps_its_t_on_the_way_into_an_object() {
        // Half the size, and moved.
        let to_object = [[0.5, 0.0, 0.0, -2.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 6.0]];
        let instance = Instance { to_object, ..Instance::zeroed() };
        let ray = Ray::<f32>::new(V3::splat((), [2.0, 4.0, 6.0]), V3::splat((), [0.0, -8.0, 2.0]));
        let local = ray.to_object(&instance);
        assert_eq!((local.origin.lane(0), local.direction.lane(0)), ([2.0, 2.0, 0.0], [0.0, -4.0, 1.0]));
        let ends = [ray.origin + ray.direction.scale(3.0), local.origin + local.direction.scale(3.0)];
        let as_point = [[0.5, 0.0, 0.0, 1.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, -3.0]];
        assert_eq!(point(&as_point, ends[0]).lane(0), ends[1].lane(0));
    }

    #[test]
    fn reciprocals_of_a_direction_are_finite() {
        let ray = Ray::<f32>::new(V3::splat((), [0.0; 3]), V3::splat((), [0.0, -0.0, 4.0]));
        let [x, y, z] = ray.inverse.lane(0);
        assert!(x > 1e27 && x.is_finite() && y < -1e27 && y.is_finite() && (z - 0.25).abs() < 1e-7);
    }
}
