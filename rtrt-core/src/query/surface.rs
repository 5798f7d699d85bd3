//! What is known of the surface at a hit.

use super::source::Parts;
use super::world::Hit;
use crate::kernel::offset::{ErrorBound, offset};
use crate::kernel::sphere::{longitude_and_latitude, point, start};
use crate::lane::V3;
use crate::num::sqrt;
use crate::scene::{MaterialIndex, from_rows};
use glam::{DMat3, DVec3};

/// The surface at a hit, world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// The point of the triangle or sphere at the hit's barycentrics. It does not depend on `t`.
    pub position: [f32; 3],
    /// How far each coordinate may be off the plane of the triangle, or off the sphere, by rounding.
    pub error: f32,
    /// The normal of the triangle or sphere on its front; length 1.
    pub normal: [f32; 3],
    /// The normal between those of the vertices, on the same side; `normal` where they have none.
    pub smooth_normal: [f32; 3],
    /// Texture coordinates, if the source has any.
    pub uv: Option<[f32; 2]>,
    /// The material, if the source has any.
    pub material: Option<MaterialIndex>,
    /// The number that the triangle had in the mesh that was added; of a sphere, the hit's.
    pub source_triangle: u32,
    /// The caller's number of the instance.
    pub user: u32,
    /// Where rays start that leave the front, and the back.
    starts: [[f32; 3]; 2],
}

impl Surface {
    /// Where a ray starts that leaves the surface along `direction` and must not hit it again.
    pub fn start(&self, direction: impl Into<[f32; 3]>) -> [f32; 3] {
        let (n, d) = (self.normal, direction.into());
        let cosine = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
        self.starts[usize::from(cosine < 0.0)]
    }
}

/// Half of the distance of numbers at 1, and a little more for the rounding of `f64`.
const HALF_ULP: f64 = 1.000_001 / 16_777_216.0;

/// The surface at a hit of an instance that is there, on a triangle that it has.
pub(super) fn surface(source: &impl Parts, index: usize, hit: &Hit) -> Surface {
    let instance = &source.instances()[index];
    let to_world = from_rows(&instance.to_world);
    let moved = to_world.w_axis.truncate();
    let to_world = DMat3::from_mat4(to_world);
    let to_normal = DMat3::from_mat4(from_rows(&instance.to_object)).transpose();
    let place = |p: DVec3| to_world * p + moved;
    let exact = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let unit = |v: DVec3| v / libm::sqrt(v.length_squared());
    let single = |v: DVec3| v.to_array().map(|c| c as f32);
    let (u, v) = (f64::from(hit.u), f64::from(hit.v));

    let one = V3::<f32>::splat((), [1.0; 3]);
    let (position, normal, smooth, uv, leaving);
    // Of the ball.
    let mut bound = ErrorBound { reach: one, test: 0.0 };
    if instance.is_sphere() {
        let on_sphere = point(hit.u, hit.v);
        let n = unit(exact(on_sphere.lane(0)));
        position = place(n);
        normal = unit(to_normal * n);
        smooth = normal;
        uv = Some(longitude_and_latitude(on_sphere));
        leaving = [true, false].map(|outside| place(exact(start(on_sphere, outside).lane(0))));
    } else {
        let vertices = source.corners(instance, hit.triangle);
        let corners = vertices.map(|vertex| V3::<f32>::splat((), source.position(instance, vertex)));
        let edges = [corners[1] - corners[0], corners[2] - corners[0]];
        let across = edges[0].cross(edges[1]);
        bound = ErrorBound::of_triangle(corners[0], edges, sqrt(across.dot(across)));
        let [a, b, c] = corners.map(|corner| exact(corner.lane(0)));
        position = place(a * (1.0 - u - v) + b * u + c * v);
        normal = unit(to_normal * (b - a).cross(c - a));
        let [p, q, r] = vertices.map(|vertex| source.attribute(vertex));
        uv = p.zip(q).zip(r).map(|((p, q), r)| {
            let mix = |k: usize| {
                f64::from(p.uv[k]) * (1.0 - u - v) + f64::from(q.uv[k]) * u + f64::from(r.uv[k]) * v
            };
            [mix(0) as f32, mix(1) as f32]
        });
        let between = p.zip(q).zip(r).map_or(DVec3::ZERO, |((p, q), r)| {
            exact(p.normal) * (1.0 - u - v) + exact(q.normal) * u + exact(r.normal) * v
        });
        let between = unit(to_normal * between);
        let turned = if between.dot(normal) < 0.0 { -between } else { between };
        smooth = if turned.is_finite() { turned } else { normal };
        leaving = [position; 2];
    }
    let rounded = single(position);
    let flat = V3::<f32>::splat((), single(normal));
    let starts = [flat, -flat];
    let distance = if instance.is_identity == 1 {
        bound.distance(flat)
    } else {
        bound.placed_distance(flat, &instance.to_world, &instance.to_object)
    };
    Surface {
        position: rounded,
        error: (rounded.iter().fold(0.0_f32, |most, c| most.max(c.abs())) as f64 * HALF_ULP) as f32,
        normal: single(normal),
        smooth_normal: single(smooth),
        uv,
        material: source.material(instance),
        source_triangle: source.source_triangle(index, hit.triangle),
        user: source.tags()[index].user,
        starts: [0, 1]
            .map(|side| offset(V3::<f32>::splat((), single(leaving[side])), starts[side], distance).lane(0)),
    }
}
