//! How a light fades with distance.

use crate::lane::{Lane, Select};
use crate::layout::View;
use crate::num::recip;

/// The square of the distance below which an inverse-square light stays constant, 2⁻²⁰: sums of the
/// brightest lights stay finite (see [`LIGHT_LIMIT`](crate::layout::LIGHT_LIMIT)).
const NEAREST: f32 = 1.0 / 1_099_511_627_776.0;

/// The share of the light that arrives at `distance`.
///
/// ```text
/// linear            1 − distance / reach
/// inverse square    (1 − (distance / reach)⁴) / distance², at most 2⁴⁰
/// ```
///
/// Linear is the paper's; it is not inverse-square, whatever the prototype called it. The windowed inverse
/// square is the formula of KHR_lights_punctual for a light's `range`. Both are exactly 0 at the reach and beyond, so binning may drop the light there, and a
/// light without limit (`inv_reach` = 0) never fades by its window. A NaN distance is dark.
#[inline(always)]
pub fn falloff<L: Lane>(light: &View, distance: L) -> L {
    let spent = distance * light.inv_reach;
    let (zero, one) = (spent.broadcast(0.0), spent.broadcast(1.0));
    let left = if light.inverse_square == 1.0 {
        let square = spent * spent;
        (one - square * square) * recip((distance * distance).max(distance.broadcast(NEAREST)))
    } else {
        one - spent
    };
    spent.lt(one).select(left, zero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn is_zero_exactly_where_binning_drops_the_light() {
        for inverse_square in [0.0, 1.0] {
            let light = View { inv_reach: 1.0 / 8.0, inverse_square, ..View::zeroed() };
            assert_eq!([falloff(&light, 8.0_f32), falloff(&light, f32::NAN)], [0.0; 2]);
            assert!(falloff(&light, 7.9_f32) > 0.0);
        }
    }

    #[test]
    fn the_window_is_that_of_khr_lights_punctual() {
        let light = View { inv_reach: 1.0 / 10.0, inverse_square: 1.0, ..View::zeroed() };
        for distance in [0.5_f32, 2.0, 5.0, 9.0, 9.9] {
            let d = f64::from(distance);
            let expected = (1.0 - (d / 10.0).powi(4)).clamp(0.0, 1.0) / (d * d);
            assert!((f64::from(falloff(&light, distance)) - expected).abs() < 1e-6 * expected.max(0.1));
        }
    }

    #[test]
    fn without_reach_only_the_square_fades() {
        let light = View::zeroed();
        assert_eq!(falloff(&light, 1e6_f32), 1.0);
        let square = View { inverse_square: 1.0, ..light };
        assert!((falloff(&square, 4.0_f32) - 1.0 / 16.0).abs() < 1e-7);
    }
}
