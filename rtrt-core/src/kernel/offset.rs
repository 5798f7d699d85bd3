//! The origin of a ray that leaves a surface.

use crate::lane::{Lane, Select, V3};

/// Coordinates below this magnitude move by a fixed step instead of by bits.
const NEAR_ZERO: f32 = 1.0 / 32.0;
/// The fixed step.
const STEP: f32 = 1.0 / 65_536.0;
/// The number of representable values that a coordinate moves along a normal of 1.
const NUMBERS: f32 = 256.0;

/// `point`, moved off its surface along `normal` (unit length, on the side where the ray
/// goes) far enough that the ray does not hit the surface again.
///
/// After Wächter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection",
/// Ray Tracing Gems, chapter 6: each coordinate moves by a number of representable
/// values in proportion to the normal, by an addition to its bits. The rule is made of
/// integer operations and comparisons, the same on every device.
#[inline(always)]
pub fn offset<L: Lane>(point: V3<L>, normal: V3<L>) -> V3<L> {
    V3 { x: moved(point.x, normal.x), y: moved(point.y, normal.y), z: moved(point.z, normal.z) }
}

/// One coordinate.
#[inline(always)]
fn moved<L: Lane>(p: L, n: L) -> L {
    let steps = crate::num::to_integer(n * NUMBERS);
    // Bits count away from 0, so a negative coordinate counts the other way.
    let negative = p.lt(p.broadcast(0.0));
    let counted = negative.select(p.to_bits() - steps, p.to_bits() + steps);
    let near_zero = p.abs().lt(p.broadcast(NEAR_ZERO));
    near_zero.select(p + n * STEP, L::from_bits(counted))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_each_coordinate_toward_its_normal() {
        for p in [-1e4_f32, -3.0, -0.01, 0.0, 0.02, 0.5, 77.0] {
            let at = |n: f32| moved(p, n);
            assert!(at(1.0) > p && at(-1.0) < p && at(0.0) == p);
            assert!(at(0.25) <= at(1.0));
        }
    }
}
