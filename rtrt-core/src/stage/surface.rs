//! Surface: what the lights and the material need to know about a hit.

use crate::kernel::interpolate::Weights;
use crate::kernel::mip::footprint;
use crate::kernel::offset::offset;
use crate::kernel::ray::{Ray, normal, point};
use crate::kernel::texture::BYTE;
use crate::kernel::traverse::{Best, Geometry};
use crate::lane::{Bits, Lane, Mask, Select, V3};
use crate::layout::{Attribute, NONE, Surface, View};
use crate::num::{TINY, floor, normalize, sqrt, to_integer};

/// The surfaces that one group of rays has found; see [`Surface`].
#[derive(Clone, Copy)]
pub struct Surfaces<L: Lane> {
    /// Where rays that leave the surface start.
    pub origin: V3<L>,
    /// Unit normal on the viewer's side.
    pub normal: V3<L>,
    /// 1 + the material, or 0.
    pub material: L::Bits,
    /// Vertex color.
    pub color: L::Bits,
    /// Texture coordinates.
    pub uv: [L; 2],
    /// Side of the ray's footprint, in texture coordinates.
    pub footprint: L,
}

impl<L: Lane> Surfaces<L> {
    /// The record of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Surface {
        Surface {
            origin: self.origin.lane(lane),
            material: self.material.lane(lane),
            normal: self.normal.lane(lane),
            color: self.color.lane(lane),
            uv: [self.uv[0].lane(lane), self.uv[1].lane(lane)],
            footprint: self.footprint.lane(lane),
        }
    }
}

impl Surfaces<f32> {
    /// A lane of width 1 from its record.
    #[inline(always)]
    pub fn new(record: &Surface) -> Self {
        Self {
            origin: V3::splat((), record.origin),
            normal: V3::splat((), record.normal),
            material: crate::lane::Word(record.material),
            color: crate::lane::Word(record.color),
            uv: record.uv,
            footprint: record.footprint,
        }
    }
}

/// All that is known of a scene's vertices. (One value to capture: rust-gpu keeps a closure
/// of more than two words in memory, pointers and all, which no device takes.)
struct Vertices<'a> {
    geometry: Geometry<'a>,
    attributes: &'a [Attribute],
}

/// The surfaces at the best hits of a group of rays; all zero in a lane without a hit.
///
/// The point is interpolated between the triangle's corners rather than followed along
/// the ray: its error is then that of the corners' coordinates, which the offset is made
/// for. The normal faces the viewer; one that interpolates to nothing is replaced by the
/// triangle's own.
#[inline(always)]
pub fn surface<L: Lane>(
    camera: &View,
    geometry: &Geometry<'_>,
    attributes: &[Attribute],
    ray: &Ray<L>,
    best: &Best<L>,
) -> Surfaces<L> {
    let token = best.t.token();
    let zero = best.t.like(0.0);
    let none = best.object.like(0);
    let nothing = V3 { x: zero, y: zero, z: zero };
    let missed = best.object.equal(best.object.like(NONE));
    if !(!missed).any() {
        return Surfaces {
            origin: nothing,
            normal: nothing,
            material: none,
            color: none,
            uv: [zero; 2],
            footprint: zero,
        };
    }
    let vertices = Vertices { geometry: *geometry, attributes };
    let [ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, s, t, uv_area] = L::gather(
        token,
        #[inline(always)]
        |lane| corners(geometry, attributes, best, lane),
    );
    let (a, b, c) = (V3 { x: ax, y: ay, z: az }, V3 { x: bx, y: by, z: bz }, V3 { x: cx, y: cy, z: cz });

    let across = (b - a).cross(c - a);
    let area = sqrt(across.dot(across));
    let flat = facing(normalize(across), -ray.direction);
    let smooth = V3 { x: nx, y: ny, z: nz };
    let length = smooth.dot(smooth);
    let has_normal = length.like(TINY).less_than(length);
    let smooth = V3::select(has_normal, facing(normalize(smooth), flat), flat);

    let place = Weights::new(best.u, best.v).mix3(a, b, c);
    let pixel = best.t * camera.pixel_t + camera.pixel;
    Surfaces {
        origin: V3::select(missed, nothing, offset(place, flat)),
        normal: V3::select(missed, nothing, smooth),
        material: missed.select(
            none,
            L::bits_from_fn(
                token,
                #[inline(always)]
                |lane| material(geometry, best, lane),
            ),
        ),
        color: missed.select(
            none,
            L::bits_from_fn(
                token,
                #[inline(always)]
                |lane| color(&vertices, best, lane),
            ),
        ),
        uv: [missed.select(zero, s), missed.select(zero, t)],
        footprint: missed.select(zero, footprint(pixel, uv_area, area)),
    }
}

/// `v`, turned to the side that `toward` is on.
#[inline(always)]
fn facing<L: Lane>(v: V3<L>, toward: V3<L>) -> V3<L> {
    let away = v.dot(toward).less_than(v.x.like(0.0));
    V3::select(away, -v, v)
}

/// What one lane reads of its triangle: the world positions of the corners, the world
/// normal (any length) and the texture coordinates at the hit, and the doubled area in
/// texture coordinates.
#[inline(always)]
fn corners<L: Lane>(
    geometry: &Geometry<'_>,
    attributes: &[Attribute],
    best: &Best<L>,
    lane: usize,
) -> [f32; 15] {
    let index = best.object.lane(lane);
    if index == NONE {
        return [0.0; 15];
    }
    let object = &geometry.objects[index as usize];
    let [a, b, c] = geometry.corners(object, best.triangle.lane(lane));
    let weights = Weights::new(best.u.lane(lane), best.v.lane(lane));
    let mut p = V3::<f32>::splat((), geometry.positions[a as usize]);
    let mut q = V3::<f32>::splat((), geometry.positions[b as usize]);
    let mut r = V3::<f32>::splat((), geometry.positions[c as usize]);
    let (a, b, c) = (&attributes[a as usize], &attributes[b as usize], &attributes[c as usize]);
    let mut n = weights.mix3(V3::splat((), a.normal), V3::splat((), b.normal), V3::splat((), c.normal));
    if object.is_identity == 0 {
        p = point(&object.to_world, p);
        q = point(&object.to_world, q);
        r = point(&object.to_world, r);
        n = normal(&object.to_object, n);
    }
    let area = (b.uv[0] - a.uv[0]) * (c.uv[1] - a.uv[1]) - (c.uv[0] - a.uv[0]) * (b.uv[1] - a.uv[1]);
    let s = weights.mix(a.uv[0], b.uv[0], c.uv[0]);
    let t = weights.mix(a.uv[1], b.uv[1], c.uv[1]);
    [p.x, p.y, p.z, q.x, q.y, q.z, r.x, r.y, r.z, n.x, n.y, n.z, s, t, area]
}

/// 1 + the material in one lane, or 0.
#[inline(always)]
fn material<L: Lane>(geometry: &Geometry<'_>, best: &Best<L>, lane: usize) -> u32 {
    let index = best.object.lane(lane);
    if index == NONE { 0 } else { geometry.objects[index as usize].material + 1 }
}

/// The vertex color at the hit in one lane.
#[inline(always)]
fn color<L: Lane>(vertices: &Vertices<'_>, best: &Best<L>, lane: usize) -> u32 {
    let Vertices { geometry, attributes } = vertices;
    let index = best.object.lane(lane);
    if index == NONE {
        return 0;
    }
    let object = &geometry.objects[index as usize];
    let [a, b, c] = geometry.corners(object, best.triangle.lane(lane));
    let (a, b, c) =
        (attributes[a as usize].color, attributes[b as usize].color, attributes[c as usize].color);
    if a == b && b == c {
        return a;
    }
    let weights = Weights::new(best.u.lane(lane), best.v.lane(lane));
    let channel = |shift: u32| {
        let part = |color: u32| (color >> shift & 255) as f32;
        let mixed = floor(weights.mix(part(a), part(b), part(c)) + 0.5);
        (to_integer(mixed).0 & 255) << shift
    };
    channel(0) | channel(8) | channel(16) | channel(24)
}

/// One channel (0 ..= 3) of a vertex color, 0 ..= 1.
#[inline(always)]
pub fn channel(color: u32, number: u32) -> f32 {
    (color >> (8 * number) & 255) as f32 * BYTE
}
