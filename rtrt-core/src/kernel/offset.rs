//! The origin of a ray that leaves a surface.
//!
//! ```text
//! origin = point + distance · normal,  two representable values farther out
//! ```
//!
//! `distance` bounds how far the test of the surface's own triangle can be off: the rounding of the point, of the
//! ray's way into the object's space, and of the test itself (Higham's γₙ, as in Pharr, Jakob and Humphreys,
//! "Physically Based Rendering", section 6.8). Everything is computed relative to the instance's place, so the bound
//! is in proportion to the object, wherever it is; the last two values are for the rounding of the sum, which
//! depends on the distance from the world's origin. All terms scale with the scene.

use crate::lane::{Bits, Lane, Select, V3};
use crate::num::{FLOOR, clamp, flush, recip, sqrt};
use core::ops::{Add, Mul};

/// The unit roundoff of `f32`.
const ROUNDOFF: f32 = 1.0 / 16_777_216.0;
/// Roundings of a point, in units of the magnitudes of its terms: two edges, two products, two sums, and as many in
/// the rays' way to the triangle's corner and for larger triangles of the same plane beside it.
const POINT: f32 = 16.0 * ROUNDOFF;
/// Roundings of a matrix times a vector, and of the matrix.
const MATRIX: f32 = 5.0 * ROUNDOFF;
/// Roundings of the triple product of which the test takes the sign.
const TEST: f32 = 8.0 * ROUNDOFF;
/// Narrower triangles count as that narrow: their plane means little.
const NARROWEST: f32 = 1024.0;

/// `point`, moved off its surface along `normal` (unit length, on the side where the ray goes) by at least
/// `distance`.
#[inline(always)]
pub fn offset<L: Lane>(point: V3<L>, normal: V3<L>, distance: L) -> V3<L> {
    V3 {
        x: moved(point.x, normal.x, distance),
        y: moved(point.y, normal.y, distance),
        z: moved(point.z, normal.z, distance),
    }
}

/// One coordinate.
#[inline(always)]
fn moved<L: Lane>(p: L, n: L, distance: L) -> L {
    let zero = p.broadcast(0.0);
    let moved = flush(p + n * distance);
    // Bits count away from 0, so a negative coordinate counts the other way.
    let outward = moved.lt(zero).select(-n, n);
    let bits = moved.to_bits();
    let (far, near) = (bits + bits.broadcast(2), bits - bits.broadcast(2));
    let stepped = outward.gt(zero).select(far, outward.lt(zero).select(near, bits));
    // This close to 0 the steps would be denormal.
    moved.abs().lt(zero.broadcast(FLOOR)).select(moved, L::from_bits(stepped))
}

/// What bounds the rounding of points of a surface, in the space of its object.
#[derive(Clone, Copy)]
pub struct ErrorBound<L> {
    /// The magnitudes that points are sums of, each coordinate.
    pub reach: V3<L>,
    /// How far the test of the surface can be off.
    pub test: L,
}

impl<L: Lane> ErrorBound<L> {
    /// That of a triangle with a corner at `corner`, these edges from there, and `area` twice its area.
    ///
    /// ```text
    /// test = 8 ε · longest edge · (longest edge)² / area
    /// ```
    #[inline(always)]
    pub fn of_triangle(corner: V3<L>, edges: [V3<L>; 2], area: L) -> Self {
        let [d, t] = edges;
        let longest = d.dot(d).max(t.dot(t));
        let narrow = clamp(longest * recip(area), 1.0, NARROWEST);
        let reach = |corner: L, d: L, t: L| corner.abs() + d.abs() + t.abs();
        Self {
            reach: V3 {
                x: reach(corner.x, d.x, t.x),
                y: reach(corner.y, d.y, t.y),
                z: reach(corner.z, d.z, t.z),
            },
            test: sqrt(longest) * narrow * TEST,
        }
    }

    /// The distance, in the world, of an object whose space is the world: [`ErrorBound::placed_distance`] with matrices
    /// that change nothing.
    #[inline(always)]
    pub fn distance(&self, normal: V3<L>) -> L {
        self.along(self.reach, normal, self.reach, normal)
    }

    /// The distance, in the world, of an object that these matrices (see [`Instance`](crate::layout::Instance))
    /// place. `normal` is that of the surface in the world, of unit length.
    ///
    /// ```text
    /// world    = |to_world| · reach,  object = |to_object| · world
    /// turned   = to_worldᵀ · normal
    /// distance = 5 ε · |normal| · world + |turned| · (5 ε · object + 16 ε · reach + test)
    /// ```
    #[inline(always)]
    pub fn placed_distance<M: Copy>(
        &self,
        normal: V3<L>,
        to_world: &[[M; 4]; 3],
        to_object: &[[M; 4]; 3],
    ) -> L
    where
        L: Mul<M, Output = L> + Add<M, Output = L>,
    {
        let world = absolute(to_world, self.reach);
        let turned = crate::kernel::ray::normal(to_world, normal);
        self.along(world, normal, absolute(to_object, world), turned)
    }

    /// The distance along a normal of the world, and the same one in the object's space.
    #[inline(always)]
    fn along(&self, world: V3<L>, normal: V3<L>, object: V3<L>, turned: V3<L>) -> L {
        let error = |object: L, reach: L| object * MATRIX + reach * POINT + self.test;
        let errors = V3 {
            x: error(object.x, self.reach.x),
            y: error(object.y, self.reach.y),
            z: error(object.z, self.reach.z),
        };
        magnitude(world, normal) * MATRIX + magnitude(errors, turned)
    }
}

/// `|weights| · v`; `v` is not negative.
#[inline(always)]
fn magnitude<L: Lane>(v: V3<L>, weights: V3<L>) -> L {
    v.x * weights.x.abs() + v.y * weights.y.abs() + v.z * weights.z.abs()
}

/// `|m| · (v, 0)`; `v` is not negative.
#[inline(always)]
fn absolute<L: Lane + Mul<M, Output = L>, M: Copy>(m: &[[M; 4]; 3], v: V3<L>) -> V3<L> {
    let row = |row: &[M; 4]| (v.x * row[0]).abs() + (v.y * row[1]).abs() + (v.z * row[2]).abs();
    V3 { x: row(&m[0]), y: row(&m[1]), z: row(&m[2]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::ray::{Ray, point};
    use crate::kernel::triangle::{Triangle, intersect};
    use crate::scene::{Bvh, Material, Mesh, Scene, Sequential};
    use glam::{Mat4, Quat, Vec3};
    use std::vec;

    #[test]
    fn moves_each_coordinate_toward_its_normal() {
        for p in [-1e4_f32, -3.0, -0.01, 0.0, 1e-30, 0.5, 77.0] {
            let at = |n: f32| moved(p, n, 1e-9);
            assert!(at(1.0) > p && at(-1.0) < p && (at(0.0) == p || p.abs() < FLOOR), "{p}");
            assert!(at(0.25) <= at(1.0), "{p}");
        }
        // Two values beyond the sum, also where a coordinate changes its sign.
        assert_eq!(moved(1.0_f32, 1.0, 0.0), 1.0 + 2.0 * f32::EPSILON);
        assert_eq!(moved(1.0_f32, -1.0, 2.0), -1.0 - 2.0 * f32::EPSILON);
    }

    #[test]
    fn a_bound_counts_the_roundings_of_its_terms() {
        // A right triangle with legs of 3 and 4 around the corner (8, 0, 0).
        let edges = [[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(|edge| V3::<f32>::splat((), edge));
        let bound = ErrorBound::of_triangle(V3::splat((), [8.0, 0.0, 0.0]), edges, 12.0);
        assert_eq!(bound.reach.lane(0), [11.0, 4.0, 0.0]);
        let test = 8.0 * 4.0 * (16.0 / 12.0);
        assert!((bound.test / ROUNDOFF - test).abs() < 1e-3);
        let diagonal = V3::splat((), [0.6, -0.8, 0.0]);
        // 5 and 16 roundings of the magnitudes, 5 of the way back, and the test's.
        let distance = (5.0 + 5.0 + 16.0) * (0.6 * 11.0 + 0.8 * 4.0) + 1.4 * test;
        assert!((bound.distance(diagonal) / ROUNDOFF - distance).abs() < 1e-2);
        let same = [[1.0, 0.0, 0.0, 9.0], [0.0, 1.0, 0.0, 9.0], [0.0, 0.0, 1.0, 9.0]];
        assert_eq!(bound.placed_distance(diagonal, &same, &same), bound.distance(diagonal));
        let doubled = |scale: f32| [[scale, 0.0, 0.0, 9.0], [0.0, scale, 0.0, 9.0], [0.0, 0.0, scale, 9.0]];
        let placed = bound.placed_distance(diagonal, &doubled(2.0), &doubled(0.5));
        assert!((placed / ROUNDOFF - 2.0 * distance).abs() < 1e-2, "{} {distance}", placed / ROUNDOFF);
    }

    /// Random triangles under random transforms, near and far, tiny and huge: rays that leave them, however flat, do
    /// not meet them, and start as near as their size and their coordinates allow.
    #[test]
    fn rays_leave_triangles_wherever_they_are() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut met_without = 0;
        for number in 0..20_000 {
            let mut vector = || Vec3::new(random(), random(), random());
            let [a, b, c, turn, place, way] = [(); 6].map(|()| vector());
            let size = libm::exp2f((number % 30 - 15) as f32);
            let far = [0.0, 1.0, 1e3, 1e6][number as usize % 4];
            let matrix = Mat4::from_scale_rotation_translation(
                Vec3::new(size, size * (1.0 + random().abs()), -size),
                Quat::from_scaled_axis(turn * 3.0),
                place * far * size.min(1.0),
            );
            let corners = [a, b, c].map(|corner| corner.to_array());
            let mut scene = Scene::new();
            let mesh =
                Mesh::new(corners.to_vec(), vec![bytemuck::Zeroable::zeroed(); 3], vec![0, 1, 2]).unwrap();
            let material = scene.add_material(Material::default()).unwrap();
            let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
            let Ok(_) = scene.add_instance(mesh, material, matrix) else { continue };
            let instance = scene.instances()[0];

            let [a, b, c] = corners.map(|corner| V3::<f32>::splat((), corner));
            let (u, v) = (random().abs() * 0.5, random().abs() * 0.5);
            let edges = [b - a, c - a];
            let start = point(&instance.to_world, a + (edges[0].scale(u) + edges[1].scale(v)));
            let world = edges.map(|edge| crate::kernel::ray::vector(&instance.to_world, edge));
            let across = world[0].cross(world[1]);
            let own = edges[0].cross(edges[1]);
            let normal = crate::num::normalize(across);
            let bound = ErrorBound::of_triangle(a, edges, sqrt(own.dot(own)));
            let distance = bound.placed_distance(normal, &instance.to_world, &instance.to_object);
            let origin = offset(start, normal, distance);

            // Steep, and flatter and flatter.
            let way = V3::splat((), way.to_array());
            let along = way - normal.scale(way.dot(normal));
            let direction = along + normal.scale(libm::exp2f(-random().abs() * 20.0));
            let meets = |origin: V3<f32>| {
                let ray = Ray::new(origin, direction.scale(size)).to_object(&instance);
                let triangle = Triangle::new(corners[0], corners[1], corners[2]);
                intersect(&ray, &triangle.relative_to(ray.origin), f32::MAX).mask
            };
            assert!(!meets(origin), "{number}: {instance:?} {corners:?} {u} {v}");
            met_without += u32::from(meets(start));

            let away = (origin - start).dot(normal).abs();
            let largest = origin.lane(0).iter().fold(0.0_f32, |most, c| most.max(c.abs()));
            let narrow = clamp(
                edges[0].dot(edges[0]).max(edges[1].dot(edges[1])) * recip(sqrt(own.dot(own))),
                1.0,
                NARROWEST,
            );
            let allowed = 6.0 * f32::EPSILON * largest + 256.0 * f32::EPSILON * size * narrow;
            assert!(away <= allowed, "{number}: {away} {allowed}");
        }
        assert!(
            met_without > 1000,
            "the rays would meet their triangles if they started on them: {met_without}"
        );
    }
}
