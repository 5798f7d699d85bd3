//! Whether a picture is right, and not only the same everywhere: camera, triangle test,
//! shadows and fading of light once more in `f64`, from corners in world space.
//!
//! It computes nothing with code of the renderer. It reads the scene as it was given: positions, indices,
//! the matrices that instances were placed with, materials and lights, and which mesh an instance with
//! levels of detail has ([`Setup`] chose it). Matrices from world to object space and bounds on errors are
//! its own, and it checks the renderer's bound ([`Instance::slack`]) against them.
//!
//! `f32` and `f64` may honestly disagree where a ray passes an edge, where two surfaces are
//! at the same depth, or where a transform magnifies roundings. So each triangle has a
//! margin, at least 10⁻³ of a barycentric weight, and more by a bound on the error of `f32`;
//! a ray that comes within the margin of anything that matters is not judged. Callers assert
//! how many are.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, dvec2};
use rtrt_core::backend::{Picture, Request, Shadows};
use rtrt_core::grid::{Grid, RayIndex};
use rtrt_core::layout::{Hit, Instance, Kind, Lit, MaterialRecord, NONE, Surface};
use rtrt_core::scene::{Light, LightKind, Occluders, Projection, Scene, Setup};
use rtrt_core::stage::share::shaded;
use std::f64::consts::PI;

/// How many rays and shadow rays could be judged, of how many. All of them were right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Judged {
    /// Camera rays.
    pub rays: usize,
    /// Of them judged.
    pub judged: usize,
    /// Of the others those that pass an edge between two triangles, and must not go through.
    pub edges: usize,
    /// Shadow rays of the judged.
    pub shadow_rays: usize,
    /// Of them judged.
    pub judged_shadow_rays: usize,
}

/// The smallest margin of a barycentric weight, and of a depth relative to it.
const MARGIN: f64 = 1e-3;
/// How far the depth of a judged hit may be off, relative to it.
const DEPTH: f64 = 1e-4;
/// Error of a few roundings of `f32`, relative.
const ROUNDINGS: f64 = 8.0 / 16_777_216.0;

/// A triangle, or one side of a sphere.
struct Triangle {
    instance: u32,
    id: u32,
    corner: DVec3,
    ab: DVec3,
    ac: DVec3,
    /// How far the instance's transform may put a point away from where it should be, per
    /// unit of the point's size; 0 for none.
    transform: f64,
    /// The largest coordinate.
    size: f64,
    /// The light that it shows, if any.
    shows: Option<u32>,
    /// Of a sphere: its matrix from world space, three rows.
    sphere: Option<[[f64; 4]; 3]>,
    /// Of an instance that is not double-sided: the sign of its matrix's determinant.
    one_sided: Option<f64>,
}

struct Ray {
    origin: DVec3,
    direction: DVec3,
    /// How far the origin may be off.
    doubt: f64,
}

/// A triangle that the ray may meet.
struct Candidate<'a> {
    triangle: &'a Triangle,
    t: f64,
    /// How far `t` may be off.
    doubt: f64,
    /// Whether the ray certainly meets it.
    is_safe: bool,
    /// The barycentric weights of the corners, and how far they may be off; NaN where nothing is known of them.
    weights: [f64; 3],
    margin: f64,
}

/// An edge of a triangle.
struct Edge {
    ends: [DVec3; 2],
    /// The corner across from it.
    third: DVec3,
}

impl Candidate<'_> {
    /// The edge that the ray passes, if it is one edge alone and not nearly everything.
    fn edge(&self) -> Option<Edge> {
        let is_near = |i: usize| self.weights[i].abs() <= self.margin;
        let near = (0..3).find(|&i| is_near(i))?;
        let &Triangle { corner, ab, ac, .. } = self.triangle;
        let corners = [corner, corner + ab, corner + ac];
        let (one, other) = ((near + 1) % 3, (near + 2) % 3);
        let is_alone = self.margin < 0.05 && self.weights[one].min(self.weights[other]) > self.margin;
        is_alone.then(|| Edge { ends: [corners[one], corners[other]], third: corners[near] })
    }
}

impl Edge {
    /// Whether the other is the same edge, of a triangle on its other side as the ray sees them.
    fn meets(&self, other: &Self, ray: &Ray) -> bool {
        let [a, b] = self.ends;
        let size = a.abs().max(b.abs()).max_element();
        let is_at = |p: DVec3, q: DVec3| (p - q).length() <= 1e-12 * size;
        let [c, d] = other.ends;
        let side = |corner: DVec3| ray.direction.dot((b - a).cross(corner - a));
        (is_at(a, c) && is_at(b, d) || is_at(a, d) && is_at(b, c))
            && side(self.third) * side(other.third) < 0.0
    }
}

/// Checks hits, shadow masks and arriving light of every `step`-th ray of a picture. A scene in
/// which not every instance is opaque, or shadows are not hard, is not judged at all.
///
/// # Errors
/// The first judged ray that is wrong.
///
/// # Panics
/// The picture has no deferred buffers.
pub fn check(scene: &Scene, request: &Request<'_>, picture: &Picture, step: usize) -> Result<Judged, String> {
    let mut setup = Setup::default();
    setup.prepare(scene, request).expect("a frame that has been rendered");
    let instances = &setup.instances(scene)[..scene.instances().len()];
    let is_wide = !matches!(request.shadows, Shadows::Off | Shadows::Hard)
        && scene.lights().iter().any(|light| light.radius > 0.0);
    let is_short = matches!(scene.occluders, Occluders::Near(_));
    if is_wide || is_short || instances.iter().any(|instance| instance.transparency != 0) {
        return Ok(Judged::default());
    }
    let side = f64::from(request.samples).sqrt() as u32;
    let grid = Grid { width: request.size[0], height: request.size[1], side };
    let deferred = picture.deferred.as_ref().expect("deferred buffers");
    for (index, instance) in instances.iter().enumerate() {
        check_slack(instance).map_err(|why| format!("instance {index}: {why}"))?;
    }
    let triangles = triangles(scene, instances);
    let mut judged = Judged::default();
    for index in (0..grid.rays()).step_by(step) {
        let at = grid.ray(RayIndex(index));
        if !grid.contains(at) {
            continue;
        }
        judged.rays += 1;
        let hit = &deferred.hits[index as usize];
        let ray =
            camera_ray(request, dvec2(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5) / f64::from(side));
        let nearest = nearest(&triangles, &ray, request.clip.map(f64::from));
        let taken = shaded(index, hit);
        if taken != index {
            let other = &deferred.hits[taken as usize];
            if nearest.is_some_and(|nearest| met(nearest.as_ref()) != [other.instance, other.triangle]) {
                return Err(format!(
                    "ray {index} at {at:?} has not met what it has its color from: {other:?}"
                ));
            }
            continue;
        }
        let Some(nearest) = nearest else {
            if let Some(end) = sealed_until(&triangles, &ray, request.clip.map(f64::from)) {
                judged.edges += 1;
                if hit.instance == NONE || f64::from(hit.t) > end {
                    return Err(format!("ray {index} at {at:?}: {hit:?} is behind an edge at {end}"));
                }
            }
            continue;
        };
        judged.judged += 1;
        judge(hit, nearest.as_ref()).map_err(|why| format!("ray {index} at {at:?}: {why}"))?;
        let Some(nearest) = nearest else { continue };
        let surface = &deferred.surfaces[index as usize];
        let point = ray.origin + ray.direction * nearest.t;
        let place = Place {
            camera: &ray,
            at: point,
            doubt: (DVec3::from(surface.origin.map(f64::from)) - point).length(),
            normal: DVec3::from(surface.normal.map(f64::from)),
            own: nearest.triangle,
        };
        let masks = &deferred.masks[(index * deferred.mask_words) as usize..][..deferred.mask_words as usize];
        for (light, which) in scene.lights().iter().zip(0_u32..) {
            judged.shadow_rays += 1;
            let Some(lit) = is_lit(&triangles, light, which, request.shadows, &place) else { continue };
            judged.judged_shadow_rays += 1;
            if reaches(masks, which) != lit {
                return Err(format!("ray {index} at {at:?}: light {which} is lit: {}, not {lit}", !lit));
            }
        }
        judge_light(scene, surface, -ray.direction, masks, &deferred.lit[index as usize])
            .map_err(|why| format!("ray {index} at {at:?}: {why}"))?;
    }
    Ok(judged)
}

/// The matrix that an instance was placed with.
fn to_world(instance: &Instance) -> DMat4 {
    let [x, y, z] = instance.to_world.map(|row| DVec4::from(row.map(f64::from)));
    DMat4::from_cols(x, y, z, DVec4::W).transpose()
}

/// How much a rounding error may grow on the way to object space and back, at least 1: the largest, over
/// the axes, of what an error of 1 in each coordinate becomes if nothing cancels.
fn growth(to_world: DMat4) -> f64 {
    let there = DMat3::from_mat4(to_world.inverse());
    let back = DMat3::from_mat4(to_world);
    let sizes = |m: DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    (sizes(back) * (sizes(there) * DVec3::ONE)).max_element().max(1.0)
}

/// Whether the bound that the renderer widens an instance's bounds by is one, and not far above: hits
/// would be lost, or lists would hold instances that are nowhere near.
fn check_slack(instance: &Instance) -> Result<(), String> {
    let (slack, growth) = (f64::from(instance.slack), growth(to_world(instance)));
    // A rounding of the start, of each product and sum there and of each back, all one way.
    let (least, most) = (4.0 * ROUNDINGS * growth, 256.0 * ROUNDINGS * growth);
    if (least..=most).contains(&slack) {
        return Ok(());
    }
    Err(format!("its bounds are widened by {slack:e}, which is not within {least:e} ..= {most:e}"))
}

/// The triangles in world space.
fn triangles(scene: &Scene, instances: &[Instance]) -> Vec<Triangle> {
    let mut all = Vec::new();
    for (instance, o) in (0..).zip(instances) {
        let matrix = to_world(o);
        let is_one_sided = scene.materials()[o.material as usize].double_sided == 0;
        let one_sided = is_one_sided.then(|| matrix.determinant().signum());
        let sphere = o.is_sphere().then(|| {
            let rows = matrix.inverse().transpose();
            [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.to_array())
        });
        let transform = if matrix == DMat4::IDENTITY { 0.0 } else { growth(matrix) * ROUNDINGS };
        let shows = o.kind.checked_sub(Kind::Light as u32);
        let indices = &scene.mesh_data()[o.first_index as usize..][..3 * o.triangles as usize];
        for (id, corners) in (0..).zip(indices.chunks_exact(3)) {
            let [a, b, c] = [0, 1, 2].map(|i| {
                let p = scene.positions()[(o.first_vertex + corners[i]) as usize].map(f64::from);
                matrix.transform_point3(DVec3::from(p))
            });
            let size = [a, b, c].iter().fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
            all.push(Triangle {
                instance,
                id,
                corner: a,
                ab: b - a,
                ac: c - a,
                transform,
                size,
                shows,
                sphere,
                one_sided,
            });
        }
    }
    all
}

/// The ray through a point of the picture, in pixels.
fn camera_ray(request: &Request<'_>, at: DVec2) -> Ray {
    let camera = request.camera;
    let eye = camera.eye.as_dvec3();
    let forward = (camera.look_at.as_dvec3() - eye).normalize();
    let right = forward.cross(camera.up.as_dvec3()).normalize();
    let up = right.cross(forward);
    let size = dvec2(f64::from(request.size[0]), f64::from(request.size[1]));
    // From the middle of the picture, whose height is 2.
    let [x, y] = ((at - size * 0.5) * 2.0 / size.y).to_array();
    match camera.projection {
        Projection::Perspective { fov_y } => {
            let half = (f64::from(fov_y) * 0.5).tan();
            Ray { origin: eye, direction: forward + (right * x - up * y) * half, doubt: 0.0 }
        }
        Projection::OffCenter { left, right: right_edge, bottom, top } => {
            let [left, right_edge, bottom, top] = [left, right_edge, bottom, top].map(f64::from);
            let [x, y] = (at / size).to_array();
            let (x, y) = (left + (right_edge - left) * x, top + (bottom - top) * y);
            Ray { origin: eye, direction: forward + right * x + up * y, doubt: 0.0 }
        }
        Projection::Orthographic { height } => {
            let half = f64::from(height) * 0.5;
            let origin = eye + (right * x - up * y) * half;
            Ray { origin, direction: forward, doubt: ROUNDINGS * (eye.abs().max_element() + half) }
        }
    }
}

/// What the ray may meet: Möller and Trumbore's test, with margins.
fn candidate<'a>(triangle: &'a Triangle, ray: &Ray) -> Option<Candidate<'a>> {
    if let Some(sphere) = &triangle.sphere {
        return side(triangle, sphere, ray);
    }
    let &Triangle { corner, ab, ac, transform, size, .. } = triangle;
    let p = ray.direction.cross(ac);
    let determinant = ab.dot(p);
    let lengths = ab.length() * ac.length() * ray.direction.length();
    if determinant.abs() <= lengths * 1e-7 || determinant.abs() < 1e-20 {
        return edge_on(triangle, ray);
    }
    let s = ray.origin - corner;
    let q = s.cross(ab);
    let (u, v, t) = (s.dot(p) / determinant, ray.direction.dot(q) / determinant, ac.dot(q) / determinant);
    // How far the ray may pass from where it should, in world units, and what that makes
    // of a weight and of a depth.
    let way = s.length() + ab.length() + ac.length();
    let moved = transform * (way + size + ray.origin.abs().max_element());
    let off = ray.doubt + ROUNDINGS * way + moved;
    let margin = MARGIN + off * ray.direction.length() * ab.length().max(ac.length()) / determinant.abs();
    let doubt = off * ab.length() * ac.length() / determinant.abs();
    let inside = u.min(v).min(1.0 - u - v);
    (inside > -margin && t > -doubt).then_some(Candidate {
        triangle,
        t,
        doubt,
        is_safe: inside > margin && t > doubt,
        weights: [1.0 - u - v, u, v],
        margin,
    })
}

/// What the ray may meet of a sphere: the lesser root of the quadratic equation for side 0, the
/// greater one for side 1.
fn side<'a>(triangle: &'a Triangle, to_object: &[[f64; 4]; 3], ray: &Ray) -> Option<Candidate<'a>> {
    let to = |v: DVec3, one: f64| {
        DVec3::from(to_object.map(|m| m[0] * v.x + m[1] * v.y + m[2] * v.z + m[3] * one))
    };
    let (o, d) = (to(ray.origin, 1.0), to(ray.direction, 0.0));
    let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - 1.0);
    // How far the ray may pass from where it should, in radii.
    let stretch = to_object.iter().map(|m| DVec3::new(m[0], m[1], m[2]).length()).fold(0.0, f64::max);
    let far = ray.origin.abs().max_element() + triangle.size;
    let off = ray.doubt * stretch + ROUNDINGS * (o.length() + 1.0 + stretch * far) + triangle.transform;
    // That of the nearest point from the center; 1 for a line that touches.
    let passes = (o - d * (b / a)).length();
    if passes > 1.0 + off + MARGIN {
        return None;
    }
    let half = (b * b - a * c).max(0.0).sqrt();
    let t = if triangle.id == 0 { -b - half } else { half - b } / a;
    let is_grazing = passes > 1.0 - off - MARGIN;
    let doubt =
        if is_grazing { 2.0 * (off + MARGIN).sqrt() } else { 2.0 * off / (1.0 - passes * passes).sqrt() };
    let doubt = doubt / a.sqrt();
    (t > -doubt).then_some(Candidate {
        triangle,
        t,
        doubt,
        is_safe: !is_grazing && t > doubt,
        weights: [f64::NAN; 3],
        margin: 0.0,
    })
}

/// What a ray may meet: of an instance that is not double-sided, the side from which corners are counterclockwise, or
/// clockwise where it is mirrored, as seen from the ray's origin or, `from_end`, its end.
fn seen<'a>(triangle: &'a Triangle, ray: &Ray, from_end: bool) -> Option<Candidate<'a>> {
    let found = candidate(triangle, ray)?;
    let Some(sign) = triangle.one_sided else { return Some(found) };
    if triangle.sphere.is_some() {
        return (triangle.id == u32::from(from_end)).then_some(found);
    }
    let &Triangle { corner, ab, ac, .. } = triangle;
    let from = ray.origin - corner;
    let height = if from_end { -sign } else { sign } * from.dot(ab.cross(ac));
    let doubt = MARGIN * from.length() * ab.length() * ac.length();
    let is_safe = found.is_safe && height > doubt;
    (height > -doubt).then_some(Candidate { is_safe, ..found })
}

/// A triangle that the ray sees from its edge, or that has no area, may be met anywhere near
/// its bounds.
fn edge_on<'a>(triangle: &'a Triangle, ray: &Ray) -> Option<Candidate<'a>> {
    let &Triangle { corner, ab, ac, transform, size, .. } = triangle;
    let corners = [corner, corner + ab, corner + ac];
    let way = (ray.origin - corner).length() + ab.length() + ac.length();
    let moved = transform * (way + size + ray.origin.abs().max_element());
    let pad = 16.0 * (ROUNDINGS * way + moved) + ray.doubt;
    let low = corners[0].min(corners[1]).min(corners[2]) - pad;
    let high = corners[0].max(corners[1]).max(corners[2]) + pad;
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (o, d) = (ray.origin[axis], ray.direction[axis]);
        if d.abs() < 1e-12 {
            if o < low[axis] || o > high[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = ((low[axis] - o) / d, (high[axis] - o) / d);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    (far >= near.max(0.0)).then_some(Candidate {
        triangle,
        t: (near + far) * 0.5,
        doubt: (far - near) * 0.5,
        is_safe: false,
        weights: [f64::NAN; 3],
        margin: 0.0,
    })
}

/// The hit that is certainly the nearest between the planes, `Some(None)` where there is certainly none, and
/// `None` where that cannot be told.
fn nearest<'a>(triangles: &'a [Triangle], ray: &Ray, [near, far]: [f64; 2]) -> Option<Option<Candidate<'a>>> {
    let earliest = |c: &Candidate<'_>| c.t - c.doubt - MARGIN * c.t.abs();
    let latest = |c: &Candidate<'_>| c.t + c.doubt + MARGIN * c.t.abs();
    let between = |c: Candidate<'a>| {
        let (is_out, is_in) =
            (latest(&c) <= near || earliest(&c) > far, earliest(&c) > near && latest(&c) <= far);
        (!is_out).then_some(Candidate { is_safe: c.is_safe && is_in, ..c })
    };
    let mut candidates: Vec<_> =
        triangles.iter().filter_map(|t| seen(t, ray, false)).filter_map(between).collect();
    candidates.sort_by(|a, b| earliest(a).total_cmp(&earliest(b)));
    let mut candidates = candidates.into_iter();
    let Some(first) = candidates.next() else { return Some(None) };
    let latest = first.t + first.doubt + MARGIN * first.t;
    let is_alone = candidates.next().is_none_or(|second| earliest(&second) > latest);
    (is_alone && first.is_safe && first.doubt < DEPTH * first.t).then_some(Some(first))
}

/// How far a ray comes at most that passes an edge at which two triangles meet, one on each side; `None` if it passes
/// no such edge between the planes, or anything else of theirs than one edge.
fn sealed_until(triangles: &[Triangle], ray: &Ray, [near, far]: [f64; 2]) -> Option<f64> {
    let is_between =
        |c: &Candidate<'_>| c.t - c.doubt > near + MARGIN * c.t && c.t + c.doubt < far - MARGIN * c.t;
    let found: Vec<_> = triangles
        .iter()
        .filter(|triangle| triangle.sphere.is_none())
        .filter_map(|triangle| seen(triangle, ray, false))
        .filter(is_between)
        .collect();
    let ends = found.iter().filter_map(|one| {
        let edge = one.edge()?;
        let other = found.iter().find(|other| {
            let is_neighbor =
                other.triangle.instance == one.triangle.instance && other.triangle.id != one.triangle.id;
            is_neighbor && other.edge().is_some_and(|other| edge.meets(&other, ray))
        })?;
        Some((one.t + one.doubt).max(other.t + other.doubt) * (1.0 + MARGIN))
    });
    ends.min_by(f64::total_cmp)
}

/// The instance and the triangle that a ray meets.
fn met(nearest: Option<&Candidate<'_>>) -> [u32; 2] {
    nearest.map_or([NONE; 2], |nearest| [nearest.triangle.instance, nearest.triangle.id])
}

/// Whether a hit is the one that it must be.
fn judge(hit: &Hit, nearest: Option<&Candidate<'_>>) -> Result<(), String> {
    let Some(nearest) = nearest else {
        return if hit.instance == NONE { Ok(()) } else { Err(format!("{hit:?}, where there is nothing")) };
    };
    let (&Triangle { instance, id, .. }, t) = (nearest.triangle, nearest.t);
    let is_right =
        (hit.instance, hit.triangle) == (instance, id) && (f64::from(hit.t) - t).abs() <= DEPTH * t;
    if is_right { Ok(()) } else { Err(format!("{hit:?}, not instance {instance} triangle {id} at {t}")) }
}

/// Whether a light's bit is in the shadow mask.
fn reaches(masks: &[u32], light: u32) -> bool {
    masks[(light / 32) as usize] >> (light % 32) & 1 == 1
}

/// Whether the light that arrives at a surface is what the lights of its mask make of the cosine, the distance,
/// and, of materials without a map of roughness, the lobe.
fn judge_light(
    scene: &Scene,
    surface: &Surface,
    to_viewer: DVec3,
    masks: &[u32],
    lit: &Lit,
) -> Result<(), String> {
    let place = DVec3::from(surface.origin.map(f64::from));
    let normal = DVec3::from(surface.normal.map(f64::from));
    let material = &scene.materials()[surface.material as usize - 1];
    let alpha_squared =
        (f64::from(material.roughness).powi(4) + f64::from(surface.variance)).clamp(LEAST_ALPHA_SQUARED, 1.0);
    let (mut sums, mut doubts) = ([DVec3::ZERO; 3], [DVec3::splat(1e-9); 3]);
    for (light, _) in scene.lights().iter().zip(0..).filter(|(_, which)| reaches(masks, *which)) {
        let is_far = light.kind == LightKind::Sun;
        let way = if is_far { -light.direction.as_dvec3() } else { light.position.as_dvec3() - place };
        let distance = way.length();
        // Of a difference of two coordinates little is left where they are almost equal.
        if distance < 1e-3 * (place.abs().max_element() + distance) {
            return Ok(());
        }
        let spent = light.reach.map_or(0.0, |reach| distance / f64::from(reach));
        let (full, share) = match light.inverse_square {
            _ if is_far => (1.0, 1.0),
            true => (distance.powi(-2), 1.0 - spent.powi(4)),
            false => (1.0, 1.0 - spent),
        };
        let (cone, steepness) = cone(light, way);
        let color = light.color.as_dvec3() * full;
        let strength = f64::from(material.strength);
        let shares = responses(normal, way.normalize(), to_viewer.normalize(), alpha_squared, strength);
        // A narrow lobe magnifies the errors of directions.
        let widths = [1.0, alpha_squared.sqrt(), alpha_squared.sqrt()];
        for i in 0..3 {
            sums[i] += color * share * cone * shares[i];
            doubts[i] += color.abs() * 1e-5 * steepness * shares[i].max(1.0) / widths[i];
        }
    }
    let [has_roughness_map, has_strength_map] =
        [MaterialRecord::ROUGHNESS, MaterialRecord::SPECULAR].map(|map| material.textures[map].levels > 0);
    // The lobe of a brushed surface is another.
    let is_brushed = material.extensions & MaterialRecord::IS_BRUSHED != 0;
    let parts = usize::from(has_strength_map)..if has_roughness_map || is_brushed { 1 } else { 3 };
    let found = [lit.diffuse, lit.specular, lit.grazing].map(|color| DVec3::from(color.map(f64::from)));
    for part in parts {
        let (found, sum, doubt) = (found[part], sums[part], doubts[part]);
        if !(found - sum).abs().cmple(doubt + sum.abs() * 1e-4).all() {
            return Err(format!("{found} of light arrives, not {sum}"));
        }
    }
    Ok(())
}

/// The least width of a lobe, squared.
const LEAST_ALPHA_SQUARED: f64 = 1.0 / 262_144.0;

/// What a surface makes of light of unit strength, as glTF's Appendix B has it: the share that its diffuse color
/// multiplies, that of the color mirrored head-on, and that of the one mirrored at grazing angles, of which a surface
/// that is no metal mirrors `strength`. Directions have unit length.
fn responses(
    normal: DVec3,
    to_light: DVec3,
    to_viewer: DVec3,
    alpha_squared: f64,
    strength: f64,
) -> [f64; 3] {
    let half = (to_light + to_viewer).normalize();
    let cosine = normal.dot(to_light).max(0.0);
    let viewed = normal.dot(to_viewer).clamp(0.0, 1.0);
    let spread = normal.dot(half).max(0.0).powi(2) * (alpha_squared - 1.0) + 1.0;
    let root = |cosine: f64| (cosine * cosine * (1.0 - alpha_squared) + alpha_squared).sqrt();
    let visibility = 0.5 / (cosine * root(viewed) + viewed * root(cosine)).max(1e-30);
    let lobe = (alpha_squared / (PI * spread * spread) * visibility * cosine).min(65_536.0);
    let grazing = (1.0 - to_viewer.dot(half)).powi(5);
    [cosine * (1.0 - strength * grazing) / PI, lobe * (1.0 - grazing), lobe * grazing]
}

/// The share of a light that its cone lets through on the way to it, and how much the cone
/// magnifies errors.
fn cone(light: &Light, way: DVec3) -> (f64, f64) {
    if light.kind != LightKind::Spot {
        return (1.0, 1.0);
    }
    let [inner, outer] = [light.inner, light.outer].map(|angle| f64::from(angle).cos());
    let steepness = 1.0 / (inner - outer).max(1e-3);
    let cosine = light.direction.as_dvec3().normalize().dot(-way.normalize());
    (((cosine - outer) * steepness).clamp(0.0, 1.0).powi(2), 1.0 + steepness)
}

/// A place that a ray of the camera hits.
struct Place<'a> {
    camera: &'a Ray,
    at: DVec3,
    /// How far from it a shadow ray starts.
    doubt: f64,
    normal: DVec3,
    /// The triangle that it is on.
    own: &'a Triangle,
}

/// Whether a light reaches a place; `None` if rounding may decide it.
fn is_lit(
    triangles: &[Triangle],
    light: &Light,
    which: u32,
    shadows: Shadows,
    place: &Place<'_>,
) -> Option<bool> {
    let &Place { camera, at, doubt, normal, own } = place;
    let is_far = light.kind == LightKind::Sun;
    let way = if is_far { -light.direction.as_dvec3().normalize() } else { light.position.as_dvec3() - at };
    let cosine = |n: DVec3| n.dot(way) / (n.length() * way.length());
    let flat = if own.sphere.is_some() { normal } else { own.ab.cross(own.ac) };
    let flat = if flat.dot(camera.direction) > 0.0 { -flat } else { flat };
    let closeness = if is_far { 0.0 } else { doubt / way.length() };
    if let Some(reach) = light.reach.filter(|_| !is_far) {
        let share = way.length() / f64::from(reach);
        if share > 1.0 + MARGIN {
            return Some(false);
        }
        if share > 1.0 - MARGIN {
            return None;
        }
    }
    if light.kind == LightKind::Spot {
        let off = light.direction.as_dvec3().angle_between(-way) - f64::from(light.outer);
        if off > 1e-2 + closeness {
            return Some(false);
        }
        if off > -1e-2 - closeness {
            return None;
        }
    }
    if closeness > 1e-2 || cosine(normal).abs() < 2e-2 {
        return None;
    }
    if cosine(normal) < 0.0 {
        return Some(false);
    }
    if shadows == Shadows::Off || !light.casts_shadows {
        return Some(true);
    }
    if cosine(flat) < 2e-2 {
        return None;
    }
    let ray = Ray { origin: at, direction: way, doubt };
    let others =
        triangles.iter().filter(|t| (t.instance, t.id) != (own.instance, own.id) && t.shows != Some(which));
    let mut free = true;
    for Candidate { t, doubt, is_safe, .. } in others.filter_map(|t| seen(t, &ray, true)) {
        let pad = doubt + MARGIN;
        let end = if is_far { f64::INFINITY } else { 1.0 };
        if is_safe && t > doubt * 4.0 && t < end - pad {
            return Some(false);
        }
        free &= t > end + pad;
    }
    free.then_some(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use conformance_cases::cases;

    fn triangle(id: u32, [corner, b, c]: [DVec3; 3]) -> Triangle {
        let (ab, ac) = (b - corner, c - corner);
        Triangle {
            instance: 0,
            id,
            corner,
            ab,
            ac,
            transform: 0.0,
            size: 1.0,
            shows: None,
            sphere: None,
            one_sided: None,
        }
    }

    #[test]
    fn a_ray_at_an_edge_ends_there_if_there_is_a_triangle_on_each_side() {
        let [a, b, left, right] =
            [[0.0, -1.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 0.0]].map(|[x, y]| DVec3::new(x, y, -2.0));
        let pair = [triangle(0, [a, b, left]), triangle(1, [b, a, right])];
        // The second is folded over the first: beside the edge there is nothing.
        let folded = [triangle(0, [a, b, left]), triangle(1, [b, a, left + DVec3::new(0.0, 0.0, 0.5)])];
        let clip = [0.0, 100.0];
        let ray = |x: f64, y: f64| Ray { origin: DVec3::ZERO, direction: DVec3::new(x, y, -1.0), doubt: 0.0 };
        let end = sealed_until(&pair, &ray(1e-7, 0.1), clip).unwrap();
        assert!((end - 2.0).abs() < 0.01, "{end}");
        assert!(sealed_until(&pair, &ray(-1e-7, -0.2), clip).is_some());
        assert!(sealed_until(&folded, &ray(-1e-7, 0.1), clip).is_none());
        assert!(sealed_until(&pair[..1], &ray(-1e-7, 0.1), clip).is_none());
        // In the middle of one, and at a corner.
        assert!(sealed_until(&pair, &ray(0.2, 0.0), clip).is_none());
        assert!(sealed_until(&pair, &ray(0.0, 0.5), clip).is_none());
        assert!(sealed_until(&pair, &ray(1e-7, 0.1), [0.0, 1.0]).is_none());
    }

    /// Bounds that are too narrow lose hits; bounds that are far too wide cost time, which no picture shows.
    #[test]
    fn bounds_that_are_not_the_roundings_are_refused() {
        let case = cases::named("visibility/instances").unwrap();
        let scene = (case.scene)();
        let mut setup = Setup::default();
        setup.prepare(&scene, &case.request()).unwrap();
        for instance in &setup.instances(&scene)[..scene.instances().len()] {
            assert_eq!(check_slack(instance), Ok(()));
            for factor in [0.0, 0.001, 1000.0, f32::NAN] {
                let other = Instance { slack: instance.slack * factor, ..*instance };
                assert!(check_slack(&other).is_err(), "{factor}");
            }
        }
    }
}
