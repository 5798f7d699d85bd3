//! Reflection of a light: Lambert's cosine and the Blinn-Phong lobe.

use crate::lane::{Lane, V3};
use crate::num::{clamp, flush, normalize, pow, recip};

/// Lambert's cosine between unit vectors; 0 for a light behind the surface, and where it is
/// too small to count on every device (see [`flush`]).
#[inline(always)]
pub fn lambert<L: Lane>(normal: V3<L>, to_light: V3<L>) -> L {
    let cosine = normal.dot(to_light);
    flush(cosine.max(cosine.broadcast(0.0)))
}

/// The Blinn-Phong lobe (Blinn 1977), normalized so that a sharper highlight is brighter
/// and not only smaller:
///
/// ```text
/// (shininess + 8) / 8π · (n · h)^shininess,   h = (l + v) / |l + v|
/// ```
///
/// The factor is that of Real-Time Rendering, third edition, equation 7.49, without 1/π
/// of the diffuse term, which this renderer leaves out everywhere: `(shininess + 8) / 8`.
#[inline(always)]
pub fn blinn_phong<L: Lane>(normal: V3<L>, to_light: V3<L>, to_viewer: V3<L>, shininess: L) -> L {
    let half = normalize(to_light + to_viewer);
    pow(lambert(normal, half), shininess) * ((shininess + 8.0) * 0.125)
}

/// The exponent of the lobe of a surface with this roughness, 0 ..= 1; `scene::Material` says
/// where it comes from.
///
/// ```text
/// 2 / roughness⁴ − 2, within 1 ..= 8192
/// ```
#[inline(always)]
pub fn shininess<L: Lane>(roughness: L) -> L {
    let width = roughness * roughness;
    clamp(recip(width * width) * 2.0 - 2.0, 1.0, 8192.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(v: [f32; 3]) -> V3<f32> {
        normalize(V3::splat((), v))
    }

    #[test]
    fn the_lobe_peaks_at_the_mirror_direction() {
        let (n, l) = (unit([0.0, 1.0, 0.0]), unit([1.0, 1.0, 0.0]));
        let at = |v| blinn_phong(n, l, unit(v), 32.0);
        assert!(at([-1.0, 1.0, 0.0]) > at([-1.0, 1.5, 0.0]) && at([-1.0, 1.0, 0.0]) > at([-1.0, 0.7, 0.0]));
        assert!((at([-1.0, 1.0, 0.0]) - 5.0).abs() < 1e-4);
    }

    #[test]
    fn the_rougher_the_duller() {
        assert_eq!([shininess(0.0_f32), shininess(1.0)], [8192.0, 1.0]);
        assert!((shininess(0.5_f32) - 30.0).abs() < 1e-4);
    }

    #[test]
    fn light_from_behind_is_dark() {
        assert_eq!(lambert(unit([0.0, 1.0, 0.0]), unit([0.0, -1.0, 0.1])), 0.0);
    }
}
