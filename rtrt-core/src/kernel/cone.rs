//! How a spot light fades toward the edge of its cone.

use crate::lane::{Lane, V3};
use crate::layout::View;
use crate::num::clamp;

/// The share of a spot light that goes toward a surface; 1 for a light without a cone.
///
/// ```text
/// ((cos a − cos outer) / (cos inner − cos outer))², within 0 ..= 1
/// ```
///
/// `a` is the angle off the cone's axis; `toward` is the unit vector from the surface to
/// the light. The formula is the one that KHR_lights_punctual recommends, the division done
/// once on the host: `cone_scale` is 1 over the lower term (at least 0.001), `cone_offset`
/// is `−cos outer` times that. Exactly 0 outside of the outer cone, up to the rounding of
/// the cosine.
#[inline(always)]
pub fn cone<L: Lane>(light: &View, toward: V3<L>) -> L {
    if light.cone_scale == 0.0 {
        return toward.x.broadcast(1.0);
    }
    let cosine = -toward.dot(V3::splat(toward.x.token(), light.axis));
    let share = clamp(cosine * light.cone_scale + light.cone_offset, 0.0, 1.0);
    share * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn fades_from_the_inner_to_the_outer_angle() {
        let (inner, outer) = (libm::cos(0.2) as f32, libm::cos(0.6) as f32);
        let scale = 1.0 / (inner - outer);
        let light =
            View { axis: [0.0, -1.0, 0.0], cone_scale: scale, cone_offset: -outer * scale, ..View::zeroed() };
        let toward = |angle: f64| [libm::sin(angle) as f32, libm::cos(angle) as f32, 0.0];
        let at = |angle: f64| cone::<f32>(&light, V3::splat((), toward(angle)));
        assert_eq!([at(0.0), at(0.19), at(0.61), at(1.5), at(3.0)], [1.0, 1.0, 0.0, 0.0, 0.0]);
        assert!(at(0.3) > at(0.4) && at(0.59) > 0.0 && at(0.21) < 1.0);
        assert_eq!(cone::<f32>(&View::zeroed(), V3::splat((), [0.0, 1.0, 0.0])), 1.0);
    }
}
