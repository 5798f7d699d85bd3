//! Surface: the geometry of a hit that lights and materials need.

use crate::kernel::closest_hit::{ClosestHit, ClosestHitRows};
use crate::kernel::geometry::Geometry;
use crate::kernel::interpolate::Weights;
use crate::kernel::mip::footprint;
use crate::kernel::offset::{ErrorBound, offset};
use crate::kernel::ray::{normal, point, vector};
use crate::kernel::sphere::{self, ENTRY};
use crate::kernel::terminator::lift;
use crate::kernel::texture::TexCoords;
use crate::kernel::unique_gather::UniqueGather;
use crate::kernel::variance::{self, Curve};
use crate::kernel::vertex_color::mixed;
use crate::lane::{Bits, Lane, Mask, Row, Select, V3};
use crate::layout::{Attribute, Instance, NONE, Surface, View};
use crate::num::{TINY, clamp, flush, flush3, normalize, recip, sqrt};

/// The surfaces that one group of rays has found; see [`Surface`].
#[derive(Clone, Copy)]
pub struct Surfaces<L: Lane> {
    /// Where rays that leave the surface start.
    pub origin: V3<L>,
    /// Unit normal on the viewer's side.
    pub normal: V3<L>,
    /// 1 + the material, or 0.
    pub material: L::Bits,
    /// Vertex color: red and green, blue and alpha.
    pub color: [L::Bits; 2],
    /// Texture coordinates.
    pub uv: [L; 2],
    /// Side of the ray's footprint, in texture coordinates.
    pub footprint: L,
    /// Second texture coordinates, where `detail` has found them.
    pub second_uv: [L; 2],
    /// Side of the ray's footprint, in them.
    pub second_footprint: L,
    /// How much the normals within the footprint vary; see `kernel::variance`.
    pub variance: L,
    /// The normal of a clear coat, packed, where `detail` has found it.
    pub coat_normal: L::Bits,
    /// The direction along which a brushed surface is steeper, packed, where `detail` has found it.
    pub tangent: L::Bits,
}

/// [`Surfaces`] whose lanes are in memory, one after another.
#[derive(Clone, Copy)]
pub struct SurfaceRows<L: Lane> {
    origin: V3<L::Row>,
    normal: V3<L::Row>,
    material: <L::Bits as Bits>::Row,
    color: [<L::Bits as Bits>::Row; 2],
    uv: [L::Row; 2],
    footprint: L::Row,
    second_uv: [L::Row; 2],
    second_footprint: L::Row,
    variance: L::Row,
    coat_normal: <L::Bits as Bits>::Row,
    tangent: <L::Bits as Bits>::Row,
}

impl<L: Lane> Surfaces<L> {
    /// Where they are in their textures.
    #[inline(always)]
    pub(crate) fn tex_coords(&self) -> TexCoords<L> {
        TexCoords { uv: [self.uv, self.second_uv], footprint: [self.footprint, self.second_footprint] }
    }
    /// The record of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Surface {
        self.rows().lane(lane)
    }
    /// The lanes one by one. Take them out once, before a loop over lanes.
    #[inline(always)]
    pub fn rows(&self) -> SurfaceRows<L> {
        SurfaceRows {
            origin: self.origin.row(),
            normal: self.normal.row(),
            material: self.material.row(),
            color: [self.color[0].row(), self.color[1].row()],
            uv: [self.uv[0].row(), self.uv[1].row()],
            footprint: self.footprint.row(),
            second_uv: [self.second_uv[0].row(), self.second_uv[1].row()],
            second_footprint: self.second_footprint.row(),
            variance: self.variance.row(),
            coat_normal: self.coat_normal.row(),
            tangent: self.tangent.row(),
        }
    }
}

impl<L: Lane> SurfaceRows<L> {
    /// The record of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Surface {
        Surface {
            origin: self.origin.at(lane),
            material: self.material.at(lane),
            normal: self.normal.at(lane),
            color: [self.color[0].at(lane), self.color[1].at(lane)],
            uv: [self.uv[0].at(lane), self.uv[1].at(lane)],
            footprint: self.footprint.at(lane),
            second_uv: [self.second_uv[0].at(lane), self.second_uv[1].at(lane)],
            second_footprint: self.second_footprint.at(lane),
            variance: self.variance.at(lane),
            coat_normal: self.coat_normal.at(lane),
            tangent: self.tangent.at(lane),
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
            color: [crate::lane::Word(record.color[0]), crate::lane::Word(record.color[1])],
            uv: record.uv,
            footprint: record.footprint,
            second_uv: record.second_uv,
            second_footprint: record.second_footprint,
            variance: record.variance,
            coat_normal: crate::lane::Word(record.coat_normal),
            tangent: crate::lane::Word(record.tangent),
        }
    }
}

/// All that is known of a scene's vertices but their positions. (One value to capture: rust-gpu keeps a closure
/// of more than two words in memory, pointers and all, which no device takes.)
#[derive(Clone, Copy)]
pub struct Vertices<'a> {
    /// The scene's instances.
    pub instances: &'a [Instance],
    /// The scene's words.
    pub mesh_data: &'a [u32],
    /// The scene's attributes.
    pub attributes: &'a [Attribute],
}

/// A word of an instance.
pub(super) trait OfInstance {
    /// What it is where nothing was hit.
    const NONE: u32;
    /// The word.
    fn of(instance: &Instance) -> u32;
}

impl Vertices<'_> {
    /// A word of the instance in each lane. Neighboring rays mostly hit the same one, which is
    /// then looked at once.
    #[inline(always)]
    pub(super) fn of_instances<L: Lane, W: OfInstance>(
        &self,
        token: L::Token,
        instances: L::Bits,
        found: &ClosestHitRows<L>,
    ) -> L::Bits {
        let first = found.instance(0);
        if L::WIDTH > 1 && !(!instances.eq(instances.broadcast(first))).any() {
            return instances.broadcast(self.of_object::<W>(first));
        }
        L::bits_from_fn(
            token,
            #[inline(always)]
            |lane| self.of_object::<W>(found.instance(lane)),
        )
    }

    /// A word of one instance.
    #[inline(always)]
    fn of_object<W: OfInstance>(&self, index: u32) -> u32 {
        if index == NONE { W::NONE } else { W::of(&self.instances[index as usize]) }
    }
}

/// Whether object and world space are the same.
pub(super) struct Identity;

impl OfInstance for Identity {
    const NONE: u32 = 1;
    #[inline(always)]
    fn of(instance: &Instance) -> u32 {
        instance.is_identity
    }
}

/// 1 + the material.
struct OneMaterial;

impl OfInstance for OneMaterial {
    const NONE: u32 = 0;
    #[inline(always)]
    fn of(instance: &Instance) -> u32 {
        instance.material + 1
    }
}

/// 1 for a sphere.
struct Round;

impl OfInstance for Round {
    const NONE: u32 = 0;
    #[inline(always)]
    fn of(instance: &Instance) -> u32 {
        instance.is_sphere() as u32
    }
}

/// The surfaces at the best hits of a group of rays with these directions; all zero in a lane
/// without a hit.
///
/// The point is interpolated between the triangle's corners rather than followed along the ray, so its error is that of
/// the triangle's size (see `kernel::offset`), and lifted to the curved surface that the corners' normals mean (see
/// `kernel::terminator`). The normal faces the viewer; one that interpolates to nothing is replaced by the
/// triangle's own. A sphere is smooth by itself; its texture coordinates are longitude and
/// latitude.
#[inline(always)]
pub fn surface<L: Lane>(
    camera: &View,
    geometry: &Geometry<'_>,
    attributes: &[Attribute],
    direction: V3<L>,
    best: &ClosestHit<L>,
) -> Surfaces<L> {
    let token = best.t.token();
    let zero = best.t.broadcast(0.0);
    let none = best.instance.broadcast(0);
    let nothing = V3 { x: zero, y: zero, z: zero };
    let missed = best.instance.eq(best.instance.broadcast(NONE));
    if !(!missed).any() {
        return Surfaces {
            origin: nothing,
            normal: nothing,
            material: none,
            color: [none; 2],
            uv: [zero; 2],
            footprint: zero,
            second_uv: [zero; 2],
            second_footprint: zero,
            variance: zero,
            coat_normal: none,
            tangent: none,
        };
    }
    let vertices = Vertices { instances: geometry.instances, mesh_data: geometry.mesh_data, attributes };
    let found = best.rows();
    let triangles = triangles(best, &found, !missed);
    let [
        [ax, ay, az, ta],
        [bx, by, bz, tb],
        [cx, cy, cz, tc],
        [nax, nay, naz, sa],
        [nbx, nby, nbz, sb],
        [ncx, ncy, ncz, sc],
    ] = triangles.gather(
        #[inline(always)]
        |lane| corners(geometry, attributes, &found, lane),
    );
    let red_green = triangles.bits(
        #[inline(always)]
        |lane| colors(&vertices, &found, lane)[0],
    );
    let blue_alpha = triangles.bits(
        #[inline(always)]
        |lane| colors(&vertices, &found, lane)[1],
    );
    let space = Space::of(&vertices, best.t, best.instance, &found);
    let own = [V3 { x: ax, y: ay, z: az }, V3 { x: bx, y: by, z: bz }, V3 { x: cx, y: cy, z: cz }];
    let normals =
        [V3 { x: nax, y: nay, z: naz }, V3 { x: nbx, y: nby, z: nbz }, V3 { x: ncx, y: ncy, z: ncz }];
    let own_edges = [own[1] - own[0], own[2] - own[0]];
    let edges = [space.vector(own_edges[0]), space.vector(own_edges[1])];
    let weights = Weights::new(best.u, best.v);
    let own_normal = weights.mix3(normals[0], normals[1], normals[2]);
    let mut smooth = space.normal(own_normal);
    let mut uv_area = (sb - sa) * (tc - ta) - (sc - sa) * (tb - ta);
    let mut uv = [weights.mix(sa, sb, sc), weights.mix(ta, tb, tc)];
    // From a corner, so that its rounding is that of the triangle's size and not of how far away it is.
    let mut point = own[0] + (own_edges[0].scale(best.u) + own_edges[1].scale(best.v));
    let mut across = edges[0].cross(edges[1]);
    let mut flat = facing(normalize(across), -direction);

    let round = vertices.of_instances::<L, Round>(token, best.instance, &found);
    let round = round.gt(none);
    if round.any() {
        let enters = best.triangle.eq(none.broadcast(ENTRY));
        let n = sphere::point(best.u, best.v);
        let [s, t] = sphere::tangents(n);
        let [longitude, latitude] = sphere::longitude_and_latitude(n);
        let out = space.vector(s).cross(space.vector(t));
        let toward = V3::select(enters, n, -n);
        across = V3::select(round, out, across);
        flat = V3::select(round, normalize(space.normal(toward)), flat);
        smooth = V3::select(round, space.normal(toward), smooth);
        point = V3::select(round, sphere::start(n, enters), point);
        uv = [round.select(longitude, uv[0]), round.select(latitude, uv[1])];
        uv_area = round.select(sphere::density(n), uv_area);
    }
    let area = sqrt(across.dot(across));
    let length = smooth.dot(smooth);
    let has_normal = length.gt(length.broadcast(TINY));
    let smooth = flush3(V3::select(has_normal, facing(normalize(smooth), flat), flat));

    let mut pixel = best.t * camera.pixel_t + camera.pixel;
    if camera.by_angle == 1 {
        pixel = pixel * grazing(flat, direction);
    }
    let own_across = own_edges[0].cross(own_edges[1]);
    let own_area = space.own_area(own_across, area);
    let turns = [normals[1] - normals[0], normals[2] - normals[0]];
    let mut variance = zero;
    let curved = is_curved(&turns) & !round;
    if curved.any() {
        let curve = Curve { edges: own_edges, turns, normal: own_normal, area: own_area };
        variance = curved.select(variance::of_curve(pixel, area, &curve), zero);
        // The side of the viewer, which a mirroring transform changes.
        let front = space.normal(own_across).dot(direction).lt(zero);
        let side = |v: V3<L>| V3::select(front, v, -v);
        let normals = [side(normals[0]), side(normals[1]), side(normals[2])];
        let lifted = point + lift(&weights, point, &own, &normals, side(own_across));
        point = V3::select(curved, lifted, point);
    }
    if round.any() {
        variance = round.select(variance::of_sphere(pixel, area), variance);
    }
    let mut bound = ErrorBound::of_triangle(own[0], own_edges, own_area);
    let one = zero.broadcast(1.0);
    bound.reach = V3::select(round, V3 { x: one, y: one, z: one }, bound.reach);
    bound.test = round.select(zero, bound.test);
    let start = offset(flush3(space.point(point)), flat, space.distance(&bound, flat));
    Surfaces {
        origin: V3::select(missed, nothing, start),
        normal: V3::select(missed, nothing, smooth),
        material: vertices.of_instances::<L, OneMaterial>(token, best.instance, &found),
        color: [
            missed.select(none, mixed(&weights, red_green)),
            missed.select(none, mixed(&weights, blue_alpha)),
        ],
        uv: [missed.select(zero, flush(uv[0])), missed.select(zero, flush(uv[1]))],
        footprint: missed.select(zero, flush(footprint(pixel, uv_area, area))),
        second_uv: [zero; 2],
        second_footprint: zero,
        variance: missed.select(zero, variance),
        coat_normal: none,
        tangent: none,
    }
}

/// Whether normals differ between the corners of a triangle.
#[inline(always)]
fn is_curved<L: Lane>(turns: &[V3<L>; 2]) -> L::Mask {
    let [d, t] = turns;
    let zero = d.x.broadcast(0.0);
    zero.lt(d.x.abs() + d.y.abs() + d.z.abs() + t.x.abs() + t.y.abs() + t.z.abs())
}

/// The different triangles that the lanes in `wanted` have hit.
#[inline(always)]
pub(super) fn triangles<L: Lane>(
    best: &ClosestHit<L>,
    found: &ClosestHitRows<L>,
    wanted: L::Mask,
) -> UniqueGather<L> {
    UniqueGather::of(
        best.t.token(),
        wanted,
        #[inline(always)]
        |lane| {
            best.instance.eq(best.instance.broadcast(found.instance(lane)))
                & best.triangle.eq(best.triangle.broadcast(found.triangle(lane)))
        },
    )
}

/// How much longer a footprint is where a surface with this normal, of length 1, is seen along a
/// direction: 1 / cosine, at most 1024.
#[inline(always)]
fn grazing<L: Lane>(normal: V3<L>, direction: V3<L>) -> L {
    const LEAST: f32 = 1.0 / 1024.0;
    let cosine = normal.dot(normalize(direction)).abs();
    recip(clamp(cosine, LEAST, 1.0))
}

/// `v`, turned to the side that `toward` is on.
#[inline(always)]
fn facing<L: Lane>(v: V3<L>, toward: V3<L>) -> V3<L> {
    let away = v.dot(toward).lt(v.x.broadcast(0.0));
    V3::select(away, -v, v)
}

/// The way from instance to world space, of each lane's own instance.
#[derive(Clone, Copy)]
pub(super) struct Space<L: Lane> {
    /// The lanes whose object and world space are the same.
    same: L::Mask,
    /// Whether that is all of them.
    all_same: bool,
    to_world: [[L; 4]; 3],
    to_object: [[L; 4]; 3],
}

impl<L: Lane> Space<L> {
    /// The spaces of the hit instances. Matrices are read lane by lane only where the lanes
    /// have hit different instances.
    #[inline(always)]
    pub(super) fn of(
        vertices: &Vertices<'_>,
        like: L,
        instances: L::Bits,
        found: &ClosestHitRows<L>,
    ) -> Self {
        let token = like.token();
        let identity = vertices.of_instances::<L, Identity>(token, instances, found);
        let same = identity.eq(identity.broadcast(1));
        let zero = [[like.broadcast(0.0); 4]; 3];
        let mut space = Self { same, all_same: !(!same).any(), to_world: zero, to_object: zero };
        if space.all_same {
            return space;
        }
        let different = UniqueGather::of(
            token,
            !same,
            #[inline(always)]
            |lane| instances.eq(instances.broadcast(found.instance(lane))),
        );
        // Whole matrices at once: a closure made in a loop is beyond rust-gpu.
        space.to_world = different.gather(
            #[inline(always)]
            |lane| {
                let index = found.instance(lane);
                if index == NONE { [[0.0; 4]; 3] } else { vertices.instances[index as usize].to_world }
            },
        );
        space.to_object = different.gather(
            #[inline(always)]
            |lane| {
                let index = found.instance(lane);
                if index == NONE { [[0.0; 4]; 3] } else { vertices.instances[index as usize].to_object }
            },
        );
        space
    }

    /// A point in world space.
    #[inline(always)]
    fn point(&self, p: V3<L>) -> V3<L> {
        if self.all_same { p } else { V3::select(self.same, p, point(&self.to_world, p)) }
    }

    /// The length of the cross product of a triangle's edges in its own space; `area` is that in the world.
    #[inline(always)]
    fn own_area(&self, across: V3<L>, area: L) -> L {
        if self.all_same { area } else { sqrt(across.dot(across)) }
    }

    /// How far from surfaces with these bounds and normals, in the world, rays start.
    #[inline(always)]
    fn distance(&self, bound: &ErrorBound<L>, normal: V3<L>) -> L {
        let distance = bound.distance(normal);
        if self.all_same {
            return distance;
        }
        self.same.select(distance, bound.placed_distance(normal, &self.to_world, &self.to_object))
    }

    /// A direction in world space.
    #[inline(always)]
    pub(super) fn vector(&self, v: V3<L>) -> V3<L> {
        if self.all_same { v } else { V3::select(self.same, v, vector(&self.to_world, v)) }
    }

    /// A normal in world space, any length.
    #[inline(always)]
    pub(super) fn normal(&self, n: V3<L>) -> V3<L> {
        if self.all_same { n } else { V3::select(self.same, n, normal(&self.to_object, n)) }
    }
}

/// The positions of the corners of one lane's triangle, object space, each with the second texture
/// coordinate; then their normals, each with the first one, as they lie in memory.
#[inline(always)]
fn corners<L: Lane>(
    geometry: &Geometry<'_>,
    attributes: &[Attribute],
    found: &ClosestHitRows<L>,
    lane: usize,
) -> [[f32; 4]; 6] {
    let index = found.instance(lane);
    if index == NONE {
        return [[0.0; 4]; 6];
    }
    let [a, b, c] = geometry.corners(&geometry.instances[index as usize], found.triangle(lane));
    let (p, q, r) =
        (&geometry.positions[a as usize], &geometry.positions[b as usize], &geometry.positions[c as usize]);
    let (a, b, c) = (&attributes[a as usize], &attributes[b as usize], &attributes[c as usize]);
    let (n, m, o) = (&a.normal, &b.normal, &c.normal);
    [
        [p[0], p[1], p[2], a.uv[1]],
        [q[0], q[1], q[2], b.uv[1]],
        [r[0], r[1], r[2], c.uv[1]],
        [n[0], n[1], n[2], a.uv[0]],
        [m[0], m[1], m[2], b.uv[0]],
        [o[0], o[1], o[2], c.uv[0]],
    ]
}

/// The colors of the corners of one lane's triangle, a word each and one that means nothing: red and green, blue and
/// alpha.
#[inline(always)]
fn colors<L: Lane>(vertices: &Vertices<'_>, found: &ClosestHitRows<L>, lane: usize) -> [[u32; 4]; 2] {
    let index = found.instance(lane);
    if index == NONE {
        return [[0; 4]; 2];
    }
    let [a, b, c] = vertices.instances[index as usize].corners(vertices.mesh_data, found.triangle(lane));
    let color = |vertex: u32| vertices.attributes[vertex as usize].color;
    let (a, b, c) = (color(a), color(b), color(c));
    [[a[0], b[0], c[0], 0], [a[1], b[1], c[1], 0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::RayIndex;
    use crate::scene::{Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, square_at, surfaces};

    /// The surface in a column and row of the picture.
    fn seen(prepared: &Prepared, place: [u32; 2]) -> Surface {
        surfaces::<f32, 1>(prepared, prepared.frame().grid().index(place))[0].lane(0)
    }

    #[test]
    fn a_surface_is_interpolated_where_the_ray_hits() {
        let mut scene = Scene::new();
        scene.add_material(Material::default()).unwrap();
        add_square(&mut scene, Material::default(), square_at(4.0, [0.0, 0.0, 1.0]));
        let prepared = Prepared::new(scene, |request| request);
        // x = 2.5 and y = −1.5.
        let surface = seen(&prepared, [10, 9]);
        let [x, y, z] = surface.origin;
        assert!((x - 2.5).abs() < 1e-5 && (y + 1.5).abs() < 1e-5, "{x} {y}");
        // Off the surface, on the side of the camera.
        assert!(z > 1.0 && z < 1.0001, "{z}");
        assert!((surface.normal[2] - 1.0).abs() < 1e-6, "{:?}", surface.normal);
        assert_eq!((surface.material, surface.color), (2, Attribute::WHITE));
        let [u, v] = surface.uv;
        assert!((u - 6.5 / 8.0).abs() < 1e-6 && (v - 5.5 / 8.0).abs() < 1e-6, "{u} {v}");
        // A ray is a unit wide, the texture 8.
        assert!((surface.footprint - 0.125).abs() < 1e-4, "{}", surface.footprint);
    }

    #[test]
    fn what_is_seen_from_behind_has_the_viewers_normal_and_a_miss_has_nothing() {
        let mut scene = Scene::new();
        let turned = square_at(4.0, [0.0; 3]) * glam::Mat4::from_rotation_y(core::f32::consts::PI);
        add_square(&mut scene, Material::default(), turned);
        let prepared = Prepared::new(scene, |request| request);
        assert!((seen(&prepared, [8, 8]).normal[2] - 1.0).abs() < 1e-6);
        assert_eq!(seen(&prepared, [0, 0]), bytemuck::Zeroable::zeroed());
        assert_eq!(prepared.frame().grid().ray(RayIndex(0)), [0, 0]);
    }
}
