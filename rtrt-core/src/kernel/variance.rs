//! How much normals vary within a ray's footprint, which a highlight is wider by.
//!
//! A lobe narrower than the normals under one ray vary flickers from pixel to pixel. The sum of many such lobes
//! is close to one wider lobe (Olano and Baker, "LEAN Mapping", 2010): of slopes with the variance `v`, summed
//! over both axes,
//!
//! ```text
//! α'² = α² + v
//! ```
//!
//! as a lobe of width `α` has slopes of variance α²/2 along each axis. The variance of a curved surface is what
//! its normals change by over the footprint (Tokuyoshi and Kaplanyan, "Improved Geometric Specular
//! Antialiasing", 2019), here from the triangle itself in place of differences between pixels: no ray depends on
//! its neighbors. The variance of a normal map is in its mip levels (see
//! [`Content::Normals`](crate::scene::Content)), where Toksvig's estimate ("Mipmapping normal maps", 2005) is
//! taken from normals before they are rounded to bytes.

use crate::lane::{Lane, Select, V3};
use crate::num::{FLOOR, flush, recip};

/// The variance, along an axis, of places in a footprint of side 1: that of a Gaussian filter whose standard
/// deviation is half a pixel, as in Tokuyoshi and Kaplanyan.
const FILTER: f32 = 0.25;

/// The most variance that curvature gives (Tokuyoshi and Kaplanyan's threshold): near silhouettes and on tiny
/// triangles the estimate has no bound.
const MOST_CURVATURE: f32 = 0.18;

/// Corners and normals of a triangle in its own space.
#[derive(Clone, Copy)]
pub struct Curve<L> {
    /// From the first corner to the second and to the third.
    pub edges: [V3<L>; 2],
    /// What the normals of the second and the third corner have beyond that of the first.
    pub turns: [V3<L>; 2],
    /// The normal between those of the corners, not normalized.
    pub normal: V3<L>,
    /// Twice the area.
    pub area: L,
}

/// The variance of the interpolated normals of triangles within a footprint of this side in the world, 0 ..=
/// 0.18.
///
/// ```text
/// v = ¼ · footprint² · Σ |∂n/∂s|²        over two directions s at right angles on the triangle
/// ```
///
/// With the edges' metric G and the turns' D, the sum is the trace of G⁻¹ D; of the turns only what is at right
/// angles to the normal counts, relative to its length. `area` is twice the area in the world: its ratio to that in
/// the triangle's own space is the scale between them, which is taken to be the same along all directions. 0
/// where there is no area, and where a normal interpolates to nothing.
#[inline(always)]
pub fn of_curve<L: Lane>(footprint: L, area: L, curve: &Curve<L>) -> L {
    let &Curve { edges: [e, f], turns: [d, t], normal, area: own_area } = curve;
    let length = normal.dot(normal);
    let (along_d, along_t) = (normal.dot(d), normal.dot(t));
    let dd = d.dot(d) * length - along_d * along_d;
    let dt = d.dot(t) * length - along_d * along_t;
    let tt = t.dot(t) * length - along_t * along_t;
    let trace = f.dot(f) * dd - e.dot(f) * dt * 2.0 + e.dot(e) * tt;
    let divisor = area * own_area * (length * length);
    let variance = footprint * footprint * trace * recip(divisor) * FILTER;
    let zero = variance.broadcast(0.0);
    capped(zero.broadcast(FLOOR).lt(divisor).select(variance, zero))
}

/// The variance of the normals of a sphere, or an ellipsoid: `area` is how much larger the surface is there
/// than that of a sphere of radius 1. Exact for a sphere, whose normals turn by the distance over the radius.
#[inline(always)]
pub fn of_sphere<L: Lane>(footprint: L, area: L) -> L {
    capped(footprint * footprint * recip(area) * (2.0 * FILTER))
}

/// The variance that the alpha of a normal map's texel stands for, where the map is scaled.
///
/// ```text
/// v = (alpha · scale)²
/// ```
#[inline(always)]
pub fn of_map<L: Lane>(alpha: L, scale: L) -> L {
    let deviation = alpha * scale;
    flush((deviation * deviation).min(deviation.broadcast(1.0)))
}

/// Within 0 ..= [`MOST_CURVATURE`]; NaN as that.
#[inline(always)]
fn capped<L: Lane>(variance: L) -> L {
    flush(crate::num::clamp(variance, 0.0, MOST_CURVATURE))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(v: [f32; 3]) -> V3<f32> {
        V3::splat((), v)
    }

    /// A small triangle on a sphere of this radius, around +z, whose normals have this length.
    fn on_sphere(radius: f32, length: f32) -> Curve<f32> {
        let normals = [[0.01, 0.002, 1.0], [-0.01, 0.004, 1.0], [0.003, -0.01, 1.0]]
            .map(|n| crate::num::normalize(v(n)));
        let [a, b, c] = normals.map(|n| n.scale(radius));
        let [na, nb, nc] = normals.map(|n| n.scale(length));
        let edges = [b - a, c - a];
        let across = edges[0].cross(edges[1]);
        let normal = (na + nb + nc).scale(1.0 / 3.0);
        Curve { edges, turns: [nb - na, nc - na], normal, area: crate::num::sqrt(across.dot(across)) }
    }

    #[test]
    fn a_sphere_of_triangles_varies_as_a_sphere_does() {
        for (radius, length) in [(1.0, 1.0), (4.0, 1.0), (0.25, 3.0)] {
            let curve = on_sphere(radius, length);
            let footprint = 0.1 * radius;
            let expected = 0.25 * 2.0 * 0.01;
            assert!((of_curve(footprint, curve.area, &curve) - expected).abs() < 1e-2 * expected);
            assert!((of_sphere(footprint, radius * radius) - expected).abs() < 1e-6);
            // Twice as large in the world.
            let twice = of_curve(footprint, 4.0 * curve.area, &curve);
            assert!((twice - expected / 4.0).abs() < 1e-2 * expected);
        }
    }

    #[test]
    fn a_cylinder_varies_half_as_much() {
        let (e, f) = (v([0.01, 0.0, 0.0]), v([0.0, 0.01, 0.0]));
        let curve = Curve {
            edges: [e, f],
            turns: [v([0.01, 0.0, 0.0]), v([0.0; 3])],
            normal: v([0.0, 0.0, 1.0]),
            area: 1e-4,
        };
        assert!((of_curve(0.2, 1e-4, &curve) - 0.25 * 0.04).abs() < 1e-5);
    }

    #[test]
    fn flat_triangles_and_broken_ones_do_not_vary_and_the_rest_is_capped() {
        let flat = Curve { turns: [v([0.0; 3]); 2], ..on_sphere(1.0, 1.0) };
        assert_eq!(of_curve(10.0, flat.area, &flat), 0.0);
        let longer = Curve { turns: [flat.normal, flat.normal.scale(0.5)], ..flat };
        assert!(of_curve(1.0, flat.area, &longer) < 1e-5);
        let none = Curve { area: 0.0, ..on_sphere(1.0, 1.0) };
        assert_eq!(of_curve(1.0, 0.0, &none), 0.0);
        assert_eq!(of_curve(1e9, 1e-4, &on_sphere(1.0, 1.0)), MOST_CURVATURE);
        assert_eq!(of_sphere(1e9_f32, 1.0), MOST_CURVATURE);
        assert_eq!([of_map(0.5_f32, 1.0), of_map(0.5, -2.0), of_map(0.5, 1e9)], [0.25, 1.0, 1.0]);
    }
}
