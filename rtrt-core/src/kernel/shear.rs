//! The shear that makes a ray the third axis: corners of triangles become points of a plane, and the ray its
//! origin.

use crate::kernel::ray::Ray;
use crate::lane::{Lane, Mask, Select, V3};
use crate::num::flush;
use core::ops::Mul;

/// The lanes' rays have different axes.
const MIXED: u32 = 3;

/// How far a ray leans from the axis that it follows most.
///
/// ```text
/// k = the axis of the largest |d|, i and j the two that follow it
/// x = d_i / d_k,  y = d_j / d_k
/// ```
///
/// After Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013). A corner's place in the
/// plane depends on the corner and on the ray alone, so that all triangles at a corner agree on it.
#[derive(Clone, Copy)]
pub struct Shear<L> {
    x: L,
    y: L,
    /// `k`, or [`MIXED`].
    axis: u32,
}

impl<L: Lane> Shear<L> {
    /// That of rays that are not traced.
    #[inline(always)]
    pub(crate) fn idle(token: L::Token) -> Self {
        let zero = L::splat(token, 0.0);
        Self { x: zero, y: zero, axis: 0 }
    }

    /// That of rays in this direction, with these reciprocals.
    #[inline(always)]
    pub fn new(d: V3<L>, inverse: V3<L>) -> Self {
        let [is_x, is_y] = axes(d);
        let along = is_x.select(d.x, is_y.select(d.y, d.z));
        let inverse = is_x.select(inverse.x, is_y.select(inverse.y, inverse.z));
        let x = quotient(is_x.select(d.y, is_y.select(d.z, d.x)), along, inverse);
        let y = quotient(is_x.select(d.z, is_y.select(d.x, d.y)), along, inverse);
        let axis = if !(!is_x).any() {
            0
        } else if !(!is_y).any() {
            1
        } else if !(is_x | is_y).any() {
            2
        } else {
            MIXED
        };
        Self { x, y, axis }
    }

    /// The places of points relative to the origin of the ray, in the plane:
    /// `(p_i − x · p_k, p_j − y · p_k)`.
    #[inline(always)]
    pub fn flatten<O: Lane>(&self, ray: &Ray<L, O>, points: &[V3<O>; 3]) -> [[L; 2]; 3]
    where
        L: Mul<O, Output = L>,
    {
        if L::WIDTH > 1 && self.axis == MIXED {
            let [is_x, is_y] = axes(ray.direction);
            let [x, y, z] = [
                self.project(&turned(points, 0)),
                self.project(&turned(points, 1)),
                self.project(&turned(points, 2)),
            ];
            let mut places = z;
            let mut i = 0;
            while i < 3 {
                places[i] = [
                    is_x.select(x[i][0], is_y.select(y[i][0], z[i][0])),
                    is_x.select(x[i][1], is_y.select(y[i][1], z[i][1])),
                ];
                i += 1;
            }
            return places;
        }
        self.project(&turned(points, self.axis))
    }

    /// The places of points whose third coordinate is that along `k`.
    #[inline(always)]
    fn project<O: Lane>(&self, [a, b, c]: &[V3<O>; 3]) -> [[L; 2]; 3]
    where
        L: Mul<O, Output = L>,
    {
        [self.place(a), self.place(b), self.place(c)]
    }

    #[inline(always)]
    fn place<O: Lane>(&self, p: &V3<O>) -> [L; 2]
    where
        L: Mul<O, Output = L>,
    {
        let one = self.x.broadcast(1.0);
        [one * p.x - self.x * p.z, one * p.y - self.y * p.z]
    }

    /// The direction's coordinate along `k`.
    #[inline(always)]
    pub fn along(&self, d: V3<L>) -> L {
        let [is_x, is_y] = axes(d);
        is_x.select(d.x, is_y.select(d.y, d.z))
    }
}

#[cfg(feature = "alloc")]
impl Shear<f32> {
    /// The same in all lanes.
    #[inline(always)]
    pub(crate) fn splat<L: Lane>(&self, token: L::Token) -> Shear<L> {
        Shear { x: L::splat(token, self.x), y: L::splat(token, self.y), axis: self.axis }
    }
}

/// `a / b`, exact where it and `b` have few digits; `inverse` is the rounded reciprocal of `b`.
#[inline(always)]
fn quotient<L: Lane>(a: L, b: L, inverse: L) -> L {
    let first = a * inverse;
    flush(first + flush(a - first * b) * inverse)
}

/// Whether the largest coordinate is the first, and whether it is the second. The first of equal ones counts.
#[inline(always)]
fn axes<L: Lane>(d: V3<L>) -> [L::Mask; 2] {
    let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
    let is_x = x.ge(y) & x.ge(z);
    [is_x, !is_x & y.ge(z)]
}

/// The points with their coordinates turned, so that the one along this axis comes last.
#[inline(always)]
fn turned<O: Lane>([a, b, c]: &[V3<O>; 3], axis: u32) -> [V3<O>; 3] {
    if axis == 0 {
        [yzx(a), yzx(b), yzx(c)]
    } else if axis == 1 {
        [zxy(a), zxy(b), zxy(c)]
    } else {
        [*a, *b, *c]
    }
}

#[inline(always)]
fn yzx<O: Copy>(v: &V3<O>) -> V3<O> {
    V3 { x: v.y, y: v.z, z: v.x }
}

#[inline(always)]
fn zxy<O: Copy>(v: &V3<O>) -> V3<O> {
    V3 { x: v.z, y: v.x, z: v.y }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::plain::Plain;

    #[test]
    fn points_on_the_ray_are_the_origin_of_the_plane_whatever_its_axis() {
        let directions = [[4.0, 1.0, -2.0], [1.0, -4.0, 2.0], [-1.0, 2.0, 4.0], [0.0, 0.0, -1.0]];
        for d in directions {
            let ray = Ray::<f32>::new(V3::splat((), [0.0; 3]), V3::splat((), d));
            let on = V3::splat((), d.map(|c| c * 3.0));
            let aside = V3::splat((), [d[0] + 1.0, d[1], d[2]]);
            let [a, _, c] = ray.shear.flatten(&ray, &[on, on, aside]);
            assert_eq!(a, [0.0; 2]);
            assert_ne!(c, [0.0; 2]);
            let most = d.iter().fold(0.0_f32, |most, c| if c.abs() > most.abs() { *c } else { most });
            assert_eq!(ray.shear.along(ray.direction), most);
        }
    }

    #[test]
    fn lanes_with_different_axes_have_the_places_of_single_lanes() {
        let direction = |lane: usize| {
            let i = lane as f32;
            [i * 0.7 - 2.0, 3.0 - i, 1.0 + 0.1 * i]
        };
        let points = [[1.0, 2.0, 3.0], [-0.5, 0.25, 7.0], [0.1, -0.2, 0.3]];
        let many: Ray<Plain<8>, f32> = Ray::new(V3::splat((), [0.0; 3]), V3::from_fn((), direction));
        let shared = points.map(|p| V3::splat((), p));
        let wide = many.shear.flatten(&many, &shared);
        for lane in 0..8 {
            let one = Ray::<f32>::new(V3::splat((), [0.0; 3]), V3::splat((), direction(lane)));
            let places = one.shear.flatten(&one, &shared);
            for (wide, place) in wide.iter().zip(places) {
                assert_eq!([wide[0].0[lane], wide[1].0[lane]], place);
            }
        }
    }
}
