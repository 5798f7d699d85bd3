//! Triangles and ellipsoids in world space, in `f64`: the nearest point of one, and whether a box meets it.
//!
//! Queries run on hosts, where `f64` has the same bits everywhere.

use glam::{DMat3, DVec3};

/// The nearest point of a shape: squared distance, and where it is on the shape.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    pub squared: f64,
    /// Barycentric weights of the second and third corner; of an ellipsoid, nothing.
    pub weights: [f64; 2],
}

/// The point of a triangle that is nearest to `p`: that of its plane if it is inside, or of an edge.
pub(super) fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> Nearest {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    let (u, v) = (ap.cross(ac).dot(normal), ab.cross(ap).dot(normal));
    let at = |u: f64, v: f64| Nearest { squared: (ap - ab * u - ac * v).length_squared(), weights: [u, v] };
    if area > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= area {
        return at(u / area, v / area);
    }
    let share = |along: DVec3, to: DVec3| {
        let length = along.length_squared();
        if length > 0.0 { (to.dot(along) / length).clamp(0.0, 1.0) } else { 0.0 }
    };
    let across = share(c - b, p - b);
    let edges = [at(share(ab, ap), 0.0), at(0.0, share(ac, ap)), at(1.0 - across, across)];
    edges.into_iter().fold(edges[0], |best, edge| if edge.squared < best.squared { edge } else { best })
}

/// The unit vector `n` for which `m · n` is nearest to `p`: the nearest point of an ellipsoid around the origin.
///
/// With `S = mᵀ m` and `b = mᵀ p`, it is `(S + λ)⁻¹ b` for the one `λ`, at least the negative of the least
/// eigenvalue of `S`, for which it has length 1; that length falls as `λ` grows, so `λ` is found by bisection.
/// Where several points are as near, as in the center, it is one of them.
pub(super) fn nearest_on_ellipsoid(p: DVec3, m: &DMat3) -> DVec3 {
    let (values, vectors) = eigen(m.transpose() * *m);
    let b = (vectors.transpose() * (m.transpose() * p)).to_array();
    let least = (0..3).fold(0, |best, i| if values[i] < values[best] { i } else { best });
    // Without the least value, so that λ counts from there.
    let above = values.map(|value| value - values[least]);
    let at =
        |shift: f64| [0, 1, 2].map(|i| if above[i] + shift > 0.0 { b[i] / (above[i] + shift) } else { 0.0 });
    let squared = |n: [f64; 3]| n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    let (mut low, mut high) = (0.0, libm::sqrt(squared(b)));
    for _ in 0..100 {
        let middle = (low + high) * 0.5;
        if squared(at(middle)) > 1.0 { low = middle } else { high = middle }
    }
    let mut n = at(high);
    let missing = 1.0 - squared(n);
    if missing > 1e-12 {
        // On a plane of symmetry, inside: the rest goes along the shortest axis.
        n[least] = if b[least] < 0.0 { -1.0 } else { 1.0 } * libm::sqrt(missing + n[least] * n[least]);
    }
    let n = vectors * DVec3::from(n);
    n / libm::sqrt(n.length_squared())
}

/// Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations.
fn eigen(mut s: DMat3) -> ([f64; 3], DMat3) {
    let mut vectors = DMat3::IDENTITY;
    for step in 0..24 {
        let (p, q) = [(0, 1), (0, 2), (1, 2)][step % 3];
        let off = s.col(q)[p];
        if off == 0.0 {
            continue;
        }
        let half = (s.col(q)[q] - s.col(p)[p]) / (2.0 * off);
        let sign = if half < 0.0 { -1.0 } else { 1.0 };
        let tangent = sign / (half.abs() + libm::sqrt(half * half + 1.0));
        let cosine = 1.0 / libm::sqrt(tangent * tangent + 1.0);
        let sine = tangent * cosine;
        let mut turn = DMat3::IDENTITY;
        turn.col_mut(p)[p] = cosine;
        turn.col_mut(q)[q] = cosine;
        turn.col_mut(q)[p] = sine;
        turn.col_mut(p)[q] = -sine;
        s = turn.transpose() * s * turn;
        vectors *= turn;
    }
    ([s.col(0)[0], s.col(1)[1], s.col(2)[2]], vectors)
}

/// Whether a triangle and a box have a point in common: none of the 13 axes separates them that can (Akenine-Möller,
/// "Fast 3D Triangle-Box Overlap Testing", 2001).
pub(super) fn box_meets_triangle(low: DVec3, high: DVec3, corners: [DVec3; 3]) -> bool {
    let (center, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let [a, b, c] = corners.map(|corner| corner - center);
    let edges = [b - a, c - b, a - c];
    let is_apart = |axis: DVec3| {
        let at = [a.dot(axis), b.dot(axis), c.dot(axis)];
        let reach = half.dot(axis.abs());
        at.iter().all(|&x| x > reach) || at.iter().all(|&x| x < -reach)
    };
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let crossed = |axis: &DVec3| edges.iter().any(|edge| is_apart(axis.cross(*edge)));
    !(axes.iter().any(|&axis| is_apart(axis))
        || is_apart(edges[0].cross(edges[1]))
        || axes.iter().any(crossed))
}

/// Whether the surface of an ellipsoid and a box have a point in common. `to_ball` and `moved` take the
/// ellipsoid to the ball of radius 1 around the origin.
///
/// That is so if the box has a point in the ball and one that is not inside it. The point nearest to the center has each
/// coordinate at one end of the box, at the other, or free, which makes 27 systems of linear equations.
pub(super) fn box_meets_ellipsoid(low: DVec3, high: DVec3, to_ball: &DMat3, moved: DVec3) -> bool {
    let squared = |x: DVec3| (*to_ball * x + moved).length_squared();
    let corner = |bits: usize| {
        DVec3::from([0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] }))
    };
    let farthest = (0..8).fold(0.0_f64, |most, bits| most.max(squared(corner(bits))));
    let square = to_ball.transpose() * *to_ball;
    let linear = to_ball.transpose() * moved;
    let mut nearest = (0..8).fold(f64::INFINITY, |least, bits| least.min(squared(corner(bits))));
    for code in 0..27 {
        let states = [code % 3, code / 3 % 3, code / 9];
        let mut rows = square.transpose();
        let mut right = -linear;
        for axis in 0..3 {
            if states[axis] < 2 {
                *rows.col_mut(axis) = [DVec3::X, DVec3::Y, DVec3::Z][axis];
                right[axis] = if states[axis] == 0 { low[axis] } else { high[axis] };
            }
        }
        let mut x = rows.transpose().inverse() * right;
        for axis in (0..3).filter(|&axis| states[axis] < 2) {
            // As exact as it was given.
            x[axis] = right[axis];
        }
        if x.is_finite() && x.cmpge(low).all() && x.cmple(high).all() {
            nearest = nearest.min(squared(x));
        }
    }
    nearest <= 1.0 && farthest >= 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers within −1 .. 1 that look random.
    struct Random(u32);

    impl Random {
        fn signed(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(self.0 >> 8) / f64::from(1 << 23) - 1.0
        }
        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.signed(), self.signed(), self.signed())
        }
    }

    #[test]
    fn the_nearest_point_of_a_triangle_is_known_where_it_is_simple() {
        let triangle = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 2.0];
        let at = |x: f64, y: f64, z: f64| {
            let Nearest { squared, weights } = nearest_on_triangle(DVec3::new(x, y, z), triangle);
            (squared, weights)
        };
        assert_eq!(at(1.0, 0.5, 3.0), (9.0, [0.25, 0.25]));
        assert_eq!(at(2.0, -1.0, 0.0), (1.0, [0.5, 0.0]));
        assert_eq!(at(-3.0, -4.0, 0.0), (25.0, [0.0, 0.0]));
        assert_eq!(at(6.0, 0.0, 0.0), (4.0, [1.0, 0.0]));
        // Across the long edge: its middle is (2, 1), and (1, 2) leaves it at a right angle.
        assert_eq!(at(3.0, 3.0, 0.0), (5.0, [0.5, 0.5]));
        // A line, and a point.
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 3.0];
        assert_eq!(nearest_on_triangle(DVec3::new(2.0, 1.0, 0.0), line).squared, 1.0);
        assert_eq!(nearest_on_triangle(DVec3::Y * 2.0, [DVec3::ZERO; 3]).squared, 4.0);
    }

    #[test]
    fn no_point_of_an_ellipsoid_is_nearer_than_the_nearest() {
        let mut random = Random(1);
        for round in 0..300 {
            let mut m = DMat3::from_cols(random.vector(), random.vector(), random.vector());
            if round % 4 == 0 {
                m = DMat3::from_diagonal(DVec3::new(3.0, 1.0, if round % 8 == 0 { 1.0 } else { 0.01 }));
            }
            let p = match round % 3 {
                0 => DVec3::new(random.signed() * 2.0, 0.0, 0.0),
                1 => random.vector() * 3.0,
                _ => random.vector() * 0.1,
            };
            let n = nearest_on_ellipsoid(p, &m);
            assert!((n.length() - 1.0).abs() < 1e-12);
            let found = (m * n - p).length();
            for _ in 0..2000 {
                let other = random.vector().normalize();
                assert!((m * other - p).length() > found - 1e-9, "{p} {m}");
            }
            // Close by, too.
            for _ in 0..200 {
                let other = (n + random.vector() * 1e-3).normalize();
                assert!((m * other - p).length() > found - 1e-9, "{p} {m}");
            }
        }
        let center = nearest_on_ellipsoid(DVec3::ZERO, &DMat3::from_diagonal(DVec3::new(3.0, 1.0, 2.0)));
        assert!((center.y.abs() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_box_meets_what_it_has_a_point_of() {
        let mut random = Random(2);
        let mut met = [0; 4];
        for _ in 0..2000 {
            let low = random.vector();
            let high = low + (random.vector() + 1.0) * 0.5;
            let inside = |p: DVec3| p.cmpge(low).all() && p.cmple(high).all();
            let corners = [random.vector(), random.vector(), random.vector()];
            let m = DMat3::from_cols(random.vector(), random.vector(), random.vector());
            let center = random.vector();
            let triangle = box_meets_triangle(low, high, corners);
            let ellipsoid = box_meets_ellipsoid(low, high, &m.inverse(), -(m.inverse() * center));
            // The nearest point of the box's middle is in it, or a sample is.
            let (mut samples, mut ball) = (false, false);
            for _ in 0..300 {
                let (u, v) = ((random.signed() + 1.0) * 0.5, (random.signed() + 1.0) * 0.5);
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let [a, b, c] = corners;
                samples |= inside(a + (b - a) * u + (c - a) * v);
                ball |= inside(m * random.vector().normalize() + center);
            }
            assert!(!samples || triangle);
            assert!(!ball || ellipsoid);
            for (count, is_met) in met.iter_mut().zip([samples, triangle, ball, ellipsoid]) {
                *count += usize::from(is_met);
            }
        }
        let [samples, triangle, ball, ellipsoid] = met;
        assert!(samples > 150 && triangle < samples * 3 / 2, "{met:?}");
        assert!(ball > 150 && ellipsoid < ball * 3 / 2, "{met:?}");
    }
}
