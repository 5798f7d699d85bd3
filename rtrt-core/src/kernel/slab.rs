//! Slab test: the interval of a ray inside a box.

use crate::kernel::ray::Ray;
use crate::lane::{Lane, V3};
use core::ops::Mul;

/// How much the far end of an interval is stretched before it is compared: 1 + 2⁻¹⁹.
///
/// Each end is a rounded subtraction, reciprocal and multiplication, off by at most
/// 4 · 2⁻²⁴ of itself; a box without thickness would otherwise be missed by chance.
/// Stretching is monotone, so it keeps the order of nested intervals.
pub const STRETCH: f32 = 1.0 + 1.0 / 524_288.0;

/// A box relative to the origin of rays.
#[derive(Clone, Copy)]
pub struct RelativeBox<O> {
    /// From the start to the lower corner.
    pub low: V3<O>,
    /// From the start to the upper corner.
    pub high: V3<O>,
}

impl<O: Lane> RelativeBox<O> {
    /// The box between `low` and `high`, relative to `origin`.
    #[inline(always)]
    pub fn new(origin: V3<O>, low: &[f32; 3], high: &[f32; 3]) -> Self {
        let token = origin.x.token();
        Self { low: V3::splat(token, *low) - origin, high: V3::splat(token, *high) - origin }
    }

    /// The box around points, relative to the origin of rays.
    #[inline(always)]
    pub(crate) fn around([a, b, c]: &[V3<O>; 3]) -> Self {
        Self { low: a.min(*b).min(*c), high: a.max(*b).max(*c) }
    }

    /// The largest coordinate of its corners, in magnitude.
    #[inline(always)]
    pub(crate) fn reach(&self) -> O {
        let (low, high) = (&self.low, &self.high);
        let most = low.x.abs().max(low.y.abs()).max(low.z.abs());
        most.max(high.x.abs()).max(high.y.abs()).max(high.z.abs())
    }

    /// The box, wider by so much on each side.
    #[inline(always)]
    pub fn widened(&self, by: O) -> Self {
        let by = V3 { x: by, y: by, z: by };
        Self { low: self.low - by, high: self.high + by }
    }
}

/// The interval of `t` for which the ray is between the box's planes: `(near, far)`,
/// with `far` stretched by [`STRETCH`]. Empty where `far < near`.
///
/// ```text
/// near = max over axes of min((low − o) / d, (high − o) / d)
/// far  = min over axes of max((low − o) / d, (high − o) / d) · STRETCH
/// ```
///
/// The slab method of Kay and Kajiya, 1986. Bits: rounded subtraction, multiplication,
/// minimum and maximum are monotone, so the interval of a box contains, exactly, the
/// interval of every box inside it. No term is NaN: coordinates are finite and the
/// reciprocal of 0 is finite.
#[inline(always)]
pub fn slab<L: Lane + Mul<O, Output = L>, O: Lane>(ray: &Ray<L, O>, relative: &RelativeBox<O>) -> (L, L) {
    let (i, low, high) = (&ray.inverse, &relative.low, &relative.high);
    let (x0, x1) = (i.x * low.x, i.x * high.x);
    let (y0, y1) = (i.y * low.y, i.y * high.y);
    let (z0, z1) = (i.z * low.z, i.z * high.z);
    let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1));
    let far = x0.max(x1).min(y0.max(y1)).min(z0.max(z1));
    (near, far * STRETCH)
}

/// Where the ray meets the box at some `0 ≤ t ≤ limit`. A negative limit meets nothing.
#[inline(always)]
pub fn intersects<L: Lane + Mul<O, Output = L>, O: Lane>(
    ray: &Ray<L, O>,
    relative: &RelativeBox<O>,
    limit: L,
) -> L::Mask {
    let (near, far) = slab(ray, relative);
    near.max(near.broadcast(0.0)).le(far.min(limit))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(origin: [f32; 3], direction: [f32; 3], low: [f32; 3], high: [f32; 3]) -> (f32, f32) {
        let ray = Ray::<f32>::new(V3::splat((), origin), V3::splat((), direction));
        slab(&ray, &RelativeBox::new(ray.origin, &low, &high))
    }

    fn is_met(direction: [f32; 3], low: [f32; 3], high: [f32; 3], limit: f32) -> bool {
        let ray = Ray::<f32>::new(V3::splat((), [0.0; 3]), V3::splat((), direction));
        intersects(&ray, &RelativeBox::new(ray.origin, &low, &high), limit)
    }

    /// Numbers within −1 .. 1 that look random.
    fn random(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    #[test]
    fn a_ray_is_inside_from_plane_to_plane() {
        let (near, far) = interval([0.5, 0.5, -3.0], [0.0, 0.0, 2.0], [0.0; 3], [1.0; 3]);
        assert!((near - 1.5).abs() < 1e-6 && (far - 2.0).abs() < 1e-5);
        // Backward, and with two axes in the way: the later entry, the earlier exit.
        let (near, far) = interval([3.0, 4.0, 0.5], [-1.0, -1.0, 0.0], [0.0; 3], [1.0, 2.0, 1.0]);
        assert!((near - 2.0).abs() < 1e-6 && (far - 3.0).abs() < 1e-5);
        let (near, far) = interval([3.0, 5.0, 0.5], [-1.0, -1.0, 0.0], [0.0; 3], [1.0; 3]);
        assert!(far < near);
    }

    #[test]
    fn a_box_is_met_up_to_the_limit_and_not_behind() {
        let (low, high) = ([-1.0, -1.0, 2.0], [1.0, 1.0, 3.0]);
        let along = |z: f32, limit: f32| is_met([0.0, 0.0, z], low, high, limit);
        assert!(along(1.0, 2.001) && !along(1.0, 1.999) && !along(-1.0, 9.0) && !along(1.0, -1.0));
        // From within, and a box without thickness.
        assert!(is_met([0.6, 0.8, 0.0], [-1.0; 3], [1.0; 3], 1e-3));
        assert!(is_met([0.1, 0.2, 0.3], [-9.0, -9.0, 0.7], [9.0, 9.0, 0.7], 9.0));
    }

    #[test]
    fn the_interval_of_a_box_contains_exactly_those_of_boxes_inside_it() {
        let mut seed = 1;
        for _ in 0..20_000 {
            let mut number = || random(&mut seed);
            let [origin, direction, a, b] = [0; 4].map(|_| [number(), number(), number()]);
            let (low, high) = ([0, 1, 2].map(|i| a[i].min(b[i])), [0, 1, 2].map(|i| a[i].max(b[i])));
            let out = [number().abs() * 1e-3, number().abs(), 0.0];
            let (wide_low, wide_high) =
                ([0, 1, 2].map(|i| low[i] - out[i]), [0, 1, 2].map(|i| high[i] + out[i]));
            let (near, far) = interval(origin, direction, low, high);
            let (wide_near, wide_far) = interval(origin, direction, wide_low, wide_high);
            assert!(wide_near <= near && (far <= wide_far || far < 0.0));
        }
    }
}
