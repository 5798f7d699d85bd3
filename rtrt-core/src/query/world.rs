//! The world: what rays are asked of.

use super::collect::{Any, Closest, Filtered, Sorted};
use super::packet::{PACKET, Packet, Searched, start_nearby};
use super::ray::{QueryError, Ray, ScaledRay, Span};
use super::search::{Collect, Found, Limits, search};
use super::source::Source;
use super::surface::{self, Surface};
use super::tree::Tree;
use crate::lane::Lane;
use crate::lane::plain::Plain;
use crate::num::FLOOR;
use crate::scene::{InstanceIndex, Places, Scene};

/// Where a ray hits a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The parameter of the hit on the ray, in lengths of its direction. `f32::MAX` if it is too large for a
    /// number.
    pub t: f32,
    /// The instance.
    pub instance: InstanceIndex,
    /// The triangle of the instance's mesh, in the order of its tree ([`World::source_triangle`] has its number
    /// in the source). Of a sphere, 0 where the ray enters and 1 where it leaves.
    pub triangle: u32,
    /// Barycentric weight of the second corner; of a sphere, an octahedral coordinate.
    pub u: f32,
    /// Barycentric weight of the third corner; of a sphere, the other one.
    pub v: f32,
}

impl Hit {
    /// A hit that is no hit: what slices can be filled with before [`World::all`].
    pub const NONE: Self = Self {
        t: f32::MAX,
        instance: InstanceIndex { number: u32::MAX, generation: u32::MAX, scene: u32::MAX },
        triangle: u32::MAX,
        u: 0.0,
        v: 0.0,
    };
}

/// What rays, points and boxes are asked of: a source as it was when [`Tree::world`] was called.
///
/// No call allocates, and none panics. Results are functions of the set of surfaces: of hits that are as
/// near, the one with the least instance counts, and of those the one with the least triangle. A closest hit with
/// [`Sides::Drawn`](super::Sides::Drawn) has the bits of a picture's.
///
/// Instances with [levels of detail](crate::scene::Scene::set_levels) are asked with their own mesh.
#[derive(Debug)]
pub struct World<'a, S: Source = Scene> {
    pub(super) tree: &'a Tree,
    pub(super) source: &'a S,
    /// The largest coordinate of all.
    pub(super) magnitude: f32,
    /// The groups of instances that count.
    pub(super) mask: u32,
}

/// The largest coordinate of all that is not hidden, and at least [`FLOOR`].
pub(super) fn magnitude(places: &Places) -> f32 {
    let all = places.all();
    let corners = all.low.into_iter().chain(all.high).filter(|c| c.is_finite());
    corners.fold(FLOOR, |most, c| most.max(c.abs()))
}

impl<S: Source> Clone for World<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Source> Copy for World<'_, S> {}

impl<'a, S: Source> World<'a, S> {
    pub(super) fn new(tree: &'a Tree, source: &'a S) -> Self {
        Self { tree, source, magnitude: magnitude(source.places()), mask: u32::MAX }
    }

    /// The world of those of its instances whose [mask](Scene::set_ray_mask) has a bit in common with `mask`: no
    /// call sees the others.
    #[must_use]
    pub fn masked(self, mask: u32) -> Self {
        Self { mask: self.mask & mask, ..self }
    }

    /// The closest hit on a ray.
    ///
    /// # Errors
    /// The ray has no start, direction or range: see [`QueryError`].
    pub fn closest(&self, ray: &Ray) -> Result<Option<Hit>, QueryError> {
        self.closest_with::<Plain<4>>((), ray)
    }

    /// [`World::closest`] with wider lanes: as many boxes are tested at a time, up to eight. The hit is the same.
    ///
    /// # Errors
    /// As for [`World::closest`].
    #[inline(always)]
    pub fn closest_with<L: Lane>(&self, token: L::Token, ray: &Ray) -> Result<Option<Hit>, QueryError> {
        let scaled = ray.scaled()?;
        let mut closest = Closest::new(scaled.span.to);
        self.search::<L>(token, ray, &scaled, &mut closest);
        Ok(closest.found().map(|found| self.hit(&scaled.span, &found)))
    }

    /// Whether a ray hits anything.
    ///
    /// # Errors
    /// As for [`World::closest`].
    pub fn occluded(&self, ray: &Ray) -> Result<bool, QueryError> {
        self.occluded_with::<Plain<4>>((), ray)
    }

    /// [`World::occluded`] with wider lanes, as [`World::closest_with`].
    ///
    /// # Errors
    /// As for [`World::closest`].
    #[inline(always)]
    pub fn occluded_with<L: Lane>(&self, token: L::Token, ray: &Ray) -> Result<bool, QueryError> {
        let scaled = ray.scaled()?;
        let mut any = Any::new(scaled.span.to);
        self.search::<L>(token, ray, &scaled, &mut any);
        Ok(any.is_hit)
    }

    /// The closest hit of each ray, as [`World::closest`] finds it. 64 rays that follow one another in the slices are
    /// traced together where they start near to each other. That takes less time, least where they also run in almost the
    /// same direction, as those of a picture's row do. A ray that is refused has an error of its own. What is beyond the
    /// shorter slice is left alone.
    pub fn closest_each(&self, rays: &[Ray], hits: &mut [Result<Option<Hit>, QueryError>]) {
        self.closest_each_with::<Plain<4>>((), rays, hits);
    }

    /// [`World::closest_each`] with wider lanes, as [`World::closest_with`].
    #[inline(always)]
    pub fn closest_each_with<L: Lane>(
        &self,
        token: L::Token,
        rays: &[Ray],
        hits: &mut [Result<Option<Hit>, QueryError>],
    ) {
        let bounds = self.source.places().all();
        for (rays, hits) in rays.chunks(PACKET).zip(hits.chunks_mut(PACKET)) {
            let is_nearby = start_nearby(rays, &bounds);
            let packet = if is_nearby { Packet::new::<L>(token, self.source, rays) } else { None };
            if let Some(packet) = &packet {
                let mut all = packet.collectors(Closest::new);
                self.search_packet::<L, _>(token, packet, &mut all);
                for ((number, closest), hit) in all.iter().enumerate().zip(hits).take(rays.len()) {
                    *hit = packet.answer(number, |span| closest.found().map(|found| self.hit(span, &found)));
                }
            } else {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.closest_with::<L>(token, ray);
                }
            }
        }
    }

    /// Whether each ray hits anything, as [`World::occluded`] finds it. 64 rays that follow one another in the slices are
    /// traced together, wherever they start. Errors and lengths are those of [`World::closest_each`].
    pub fn occluded_each(&self, rays: &[Ray], occluded: &mut [Result<bool, QueryError>]) {
        self.occluded_each_with::<Plain<4>>((), rays, occluded);
    }

    /// [`World::occluded_each`] with wider lanes, as [`World::closest_with`].
    #[inline(always)]
    pub fn occluded_each_with<L: Lane>(
        &self,
        token: L::Token,
        rays: &[Ray],
        occluded: &mut [Result<bool, QueryError>],
    ) {
        for (rays, occluded) in rays.chunks(PACKET).zip(occluded.chunks_mut(PACKET)) {
            let packet = Packet::new::<L>(token, self.source, rays);
            if let Some(packet) = &packet {
                let mut all = packet.collectors(Any::new);
                self.search_packet::<L, _>(token, packet, &mut all);
                for ((number, any), occluded) in all.iter().enumerate().zip(occluded).take(rays.len()) {
                    *occluded = packet.answer(number, |_| any.is_hit);
                }
            } else {
                for (ray, occluded) in rays.iter().zip(occluded) {
                    *occluded = self.occluded_with::<L>(token, ray);
                }
            }
        }
    }

    /// The closest hit of those that `accept` accepts. It is called in no particular order, and not for
    /// hits that are behind one that it has accepted.
    ///
    /// # Errors
    /// As for [`World::closest`].
    pub fn closest_where(
        &self,
        ray: &Ray,
        accept: impl FnMut(&Hit) -> bool,
    ) -> Result<Option<Hit>, QueryError> {
        let scaled = ray.scaled()?;
        let mut closest = self.filtered(&scaled.span, Closest::new(scaled.span.to), accept);
        self.search::<Plain<4>>((), ray, &scaled, &mut closest);
        Ok(closest.inner.found().map(|found| self.hit(&scaled.span, &found)))
    }

    /// Whether there is a hit that `accept` accepts. It is called in no particular order, until then.
    ///
    /// # Errors
    /// As for [`World::closest`].
    pub fn occluded_where(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Result<bool, QueryError> {
        let scaled = ray.scaled()?;
        let mut any = self.filtered(&scaled.span, Any::new(scaled.span.to), accept);
        self.search::<Plain<4>>((), ray, &scaled, &mut any);
        Ok(any.inner.is_hit)
    }

    /// Fills `hits` with the nearest hits on a ray, nearest first, and returns how many they are; if it fills
    /// all of them, there may be more. A ray through an edge hits both triangles.
    ///
    /// # Errors
    /// As for [`World::closest`].
    pub fn all(&self, ray: &Ray, hits: &mut [Hit]) -> Result<usize, QueryError> {
        self.all_where(ray, hits, |_| true)
    }

    /// [`World::all`] of the hits that `accept` accepts, called in no particular order.
    ///
    /// # Errors
    /// As for [`World::closest`].
    pub fn all_where(
        &self,
        ray: &Ray,
        hits: &mut [Hit],
        accept: impl FnMut(&Hit) -> bool,
    ) -> Result<usize, QueryError> {
        let scaled = ray.scaled()?;
        let sorted = Sorted::new(hits, scaled.span.to, self.source);
        let mut sorted = self.filtered(&scaled.span, sorted, accept);
        self.search::<Plain<4>>((), ray, &scaled, &mut sorted);
        let count = sorted.inner.count;
        for hit in &mut hits[..count] {
            hit.t = scaled.span.t(hit.t);
        }
        Ok(count)
    }

    /// What is known of the surface at a hit; `None` if the hit is not one of this world.
    pub fn surface(&self, hit: &Hit) -> Option<Surface> {
        let index = self.index(hit.instance)?;
        let instance = &self.source.instances()[index];
        let triangles = if instance.is_sphere() { 2 } else { instance.triangles };
        (hit.triangle < triangles).then(|| surface::surface(self.source, index, hit))
    }

    /// The number that a triangle had in the mesh that was added; `None` if there is no such triangle. Of a
    /// sphere it is the same as in the hit.
    pub fn source_triangle(&self, hit: &Hit) -> Option<u32> {
        let index = self.index(hit.instance)?;
        let is_there = hit.triangle < self.source.instances()[index].triangles;
        is_there.then(|| self.source.source_triangle(index, hit.triangle))
    }

    /// The number that the caller gave to an instance ([`Scene::set_user_data`]); `None` if there is no such
    /// instance.
    pub fn user_data(&self, instance: InstanceIndex) -> Option<u32> {
        self.index(instance).map(|index| self.source.tags()[index].user)
    }

    /// The place of an instance in the arrays.
    pub(super) fn index(&self, instance: InstanceIndex) -> Option<usize> {
        self.source.place_of(instance)
    }

    #[inline(always)]
    fn search<L: Lane>(&self, token: L::Token, ray: &Ray, scaled: &ScaledRay, collect: &mut impl Collect) {
        const { assert!(L::WIDTH <= 8) };
        let magnitude = self.magnitude_from(ray.origin);
        let mask = ray.mask & self.mask;
        search::<L, S>(token, self.tree, self.source, ray, scaled, Limits { magnitude, mask }, collect);
    }

    #[inline(always)]
    fn search_packet<L: Lane, C: Collect>(
        &self,
        token: L::Token,
        packet: &Packet<'_>,
        collect: &mut [C; PACKET],
    ) {
        const { assert!(L::WIDTH <= 8) };
        let Self { tree, source, mask, magnitude } = *self;
        let limits = Limits { magnitude: magnitude.max(packet.reach::<L>(token)), mask };
        packet.search::<L, S, C>(token, Searched { tree, source, limits }, collect);
    }

    /// The largest coordinate of the world and a point.
    pub(super) fn magnitude_from(&self, point: [f32; 3]) -> f32 {
        point.iter().fold(self.magnitude, |most, c| most.max(c.abs()))
    }

    /// A hit, with the caller's `t`.
    #[inline(always)]
    fn hit(&self, span: &Span, found: &Found) -> Hit {
        let &Found { t, instance, triangle, u, v } = found;
        Hit { t: span.t(t), instance: self.source.numbered(instance), triangle, u, v }
    }

    fn filtered<'f, C: Collect>(
        &'f self,
        span: &'f Span,
        inner: C,
        mut accept: impl FnMut(&Hit) -> bool + 'f,
    ) -> Filtered<C, impl FnMut(&Found) -> bool + 'f> {
        Filtered { inner, accept: move |found: &Found| accept(&self.hit(span, found)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::RayIndex;
    use crate::query::{Sides, Tree};
    use crate::scene::Material;
    use crate::stage::fixture::{Prepared, add_square, closest, square_at};
    use crate::stage::visibility::{hit, rays};
    use glam::{Mat4, Vec3};

    #[test]
    fn a_camera_ray_has_the_bits_of_the_picture() {
        let mut scene = Scene::new();
        for i in 0..60 {
            let place = [(i % 7) as f32 * 2.0 - 6.0, (i % 5) as f32 * 2.5 - 5.0, -(i as f32) * 0.3];
            let turn = Mat4::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), i as f32 * 0.7);
            let material = Material::default().double_sided(i % 3 == 0);
            add_square(&mut scene, material, square_at(1.5, place) * turn);
        }
        let white = scene.add_material(Material::default()).unwrap();
        scene.add_sphere(white, square_at(3.0, [2.0, 1.0, 0.0])).unwrap();
        let prepared = Prepared::new(scene, |request| request);
        let mut tree = Tree::default();
        let world = tree.world(&prepared.scene);
        let mut hits = 0;
        for first in (0..prepared.frame().rays).map(RayIndex) {
            let seen = hit(&closest::<f32, 1>(&prepared, first)[0], 0);
            let [ray] = rays::<f32, 1>((), prepared.frame(), prepared.context().camera(), first);
            let ray = Ray::new(ray.origin.lane(0), ray.direction.lane(0)).sides(Sides::Drawn);
            match world.closest(&ray).unwrap() {
                None => assert_eq!(seen, crate::layout::Hit::MISS),
                Some(Hit { t, instance, triangle, u, v }) => {
                    let number = instance.number();
                    assert_eq!(seen, crate::layout::Hit { t, instance: number, triangle, u, v });
                    hits += 1;
                }
            }
        }
        assert!(hits > 100, "{hits}");
    }
}
