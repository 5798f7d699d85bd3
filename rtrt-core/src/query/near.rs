//! The nearest point to a point.

use super::block::Block;
use super::ray::{QueryError, check_distance, check_point};
use super::seek::{Placed, Seeker, rounding};
use super::shape::{nearest_on_ellipsoid, nearest_on_triangle};
use super::source::Source;
use super::world::{Hit, World};
use crate::kernel::environment::octahedral;
use crate::lane::V3;
use crate::scene::InstanceIndex;
use glam::DVec3;

impl<S: Source> World<'_, S> {
    /// The point of all surfaces that is nearest to `point`, if one is no farther away than `within`, as a hit whose `t` is
    /// the distance; [`World::surface`] has its position. Of a sphere the triangle is 0 outside and 1 inside.
    ///
    /// # Errors
    /// The point or the distance is out of range: see [`QueryError`].
    pub fn nearest(&self, point: impl Into<[f32; 3]>, within: f32) -> Result<Option<Hit>, QueryError> {
        self.nearest_where(point, within, |_| true)
    }

    /// [`World::nearest`] of what `accept` accepts: it is called with instances, in no particular order, with some perhaps often.
    ///
    /// # Errors
    /// As for [`World::nearest`].
    pub fn nearest_where(
        &self,
        point: impl Into<[f32; 3]>,
        within: f32,
        accept: impl FnMut(InstanceIndex) -> bool,
    ) -> Result<Option<Hit>, QueryError> {
        let point = point.into();
        check_point(point)?;
        check_distance(within)?;
        let magnitude = self.magnitude_from(point);
        let mut nearest = Nearest {
            p: DVec3::from(point.map(f64::from)),
            rounding: rounding(magnitude),
            squared: f64::from(within) * f64::from(within),
            found: None,
            accept,
        };
        self.seek(magnitude, &mut nearest);
        Ok(nearest.found.map(|(instance, triangle, [u, v])| Hit {
            t: libm::sqrt(nearest.squared) as f32,
            instance,
            triangle,
            u,
            v,
        }))
    }
}

/// The nearest so far, or the farthest that counts.
struct Nearest<F> {
    p: DVec3,
    rounding: f64,
    squared: f64,
    /// The instance, the triangle, and where on it.
    found: Option<(InstanceIndex, u32, [f32; 2])>,
    accept: F,
}

impl<F> Nearest<F> {
    fn take(&mut self, squared: f64, instance: InstanceIndex, triangle: u32, place: [f32; 2]) {
        let is_earlier = self.found.is_none_or(|(i, t, _)| (instance.number, triangle) < (i.number, t));
        if squared < self.squared || (squared == self.squared && is_earlier) {
            (self.squared, self.found) = (squared, Some((instance, triangle, place)));
        }
    }
}

impl<F: FnMut(InstanceIndex) -> bool> Seeker for Nearest<F> {
    fn distance(&self, low: DVec3, high: DVec3) -> f64 {
        libm::sqrt((low - self.p).max(self.p - high).max(DVec3::ZERO).length_squared())
    }

    fn reach(&self) -> f64 {
        libm::sqrt(self.squared) + self.rounding
    }

    fn accepts(&mut self, instance: InstanceIndex) -> bool {
        (self.accept)(instance)
    }

    fn sphere(&mut self, instance: InstanceIndex, placed: &Placed) {
        let n = nearest_on_ellipsoid(self.p - placed.moved, &placed.to_world);
        let squared = (placed.to_world * n + placed.moved - self.p).length_squared();
        let is_inside = (placed.to_ball * self.p + placed.ball_moved).length_squared() < 1.0;
        let place = octahedral(V3::<f32>::splat((), n.to_array().map(|c| c as f32)));
        self.take(squared, instance, u32::from(is_inside), place);
    }

    fn triangles(&mut self, instance: InstanceIndex, placed: &Placed, blocks: &[Block]) -> bool {
        for (triangle, corners) in blocks.iter().flat_map(Block::triangles) {
            let found = nearest_on_triangle(self.p, placed.triangle(corners));
            self.take(found.squared, instance, triangle, found.weights.map(|weight| weight as f32));
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::Tree;
    use crate::query::fixture::{Random, add, each, strewn};
    use crate::scene::{Material, Mesh, Scene};
    use glam::{Mat4, Vec3};

    #[test]
    fn nothing_is_nearer_than_the_nearest() {
        let mut random = Random(1);
        let (scene, mut tree) = strewn(&mut random);
        let all = tree.world(&scene);
        let mut hits = 0;
        for round in 0..400 {
            let point = random.vector(if round % 5 == 0 { 40.0 } else { 6.0 });
            let within = if round % 2 == 0 { 100.0 } else { 0.3 };
            let p = point.as_dvec3();
            let (world, mask) = if round % 4 == 0 { (all.masked(2), 2) } else { (all, u32::MAX) };
            let even = |instance: u32| round % 3 > 0 || instance.is_multiple_of(2);
            let counts = |instance: u32| even(instance) && scene.tags()[instance as usize].mask & mask != 0;
            let mut least = (f64::from(within) * f64::from(within), u32::MAX, u32::MAX);
            each(&scene, |instance, triangle, placed, corners| {
                let squared = match corners {
                    Some(corners) => nearest_on_triangle(p, corners).squared,
                    None => {
                        let n = nearest_on_ellipsoid(p - placed.moved, &placed.to_world);
                        (placed.to_world * n + placed.moved - p).length_squared()
                    }
                };
                if counts(instance) && (squared, instance, triangle) < least {
                    least = (squared, instance, triangle);
                }
            });
            let found = world.nearest_where(point, within, |instance| even(instance.number())).unwrap();
            let Some(hit) = found else {
                assert_eq!(least.1, u32::MAX);
                continue;
            };
            hits += 1;
            assert_eq!(
                (f64::from(hit.t), hit.instance.number),
                (f64::from(libm::sqrt(least.0) as f32), least.1)
            );
            let surface = world.surface(&hit).unwrap();
            let off = Vec3::from(surface.position).distance(point) - hit.t;
            assert!(off.abs() < 1e-4, "{off} {hit:?}");
            if !scene.instances()[least.1 as usize].is_sphere() {
                assert_eq!(hit.triangle, least.2);
            }
        }
        assert!(hits > 150, "{hits}");
    }

    #[test]
    fn of_what_is_as_near_the_least_number_counts() {
        let mut random = Random(4);
        let triangle = random.mesh(1, 1.0);
        let positions = triangle.positions().repeat(20);
        let attributes = [triangle.attributes()[0]].repeat(60);
        let mesh = Mesh::new(positions, attributes, (0..60).collect()).unwrap();
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let mesh = add(&mut scene, &mesh);
        for _ in 0..20 {
            scene.add_instance(mesh, white, Mat4::IDENTITY).unwrap();
        }
        let mut tree = Tree::default();
        let world = tree.world(&scene);
        for _ in 0..20 {
            let hit = world.nearest(random.vector(3.0), f32::INFINITY).unwrap().unwrap();
            assert_eq!((hit.instance.number, hit.triangle), (0, 0));
            let hit = world.nearest_where(random.vector(3.0), 99.0, |instance| instance.number > 6);
            assert_eq!(hit.unwrap().unwrap().instance.number, 7);
        }
    }

    #[test]
    fn what_is_no_point_or_distance_is_an_error() {
        let (scene, mut tree) = strewn(&mut Random(3));
        let world = tree.world(&scene);
        for bad in [f32::NAN, f32::INFINITY, -2e9] {
            assert!(matches!(world.nearest([0.0, bad, 0.0], 1.0), Err(QueryError::Point { .. })));
        }
        for bad in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            assert!(matches!(world.nearest([0.0; 3], bad), Err(QueryError::Distance { .. })));
        }
        assert!(world.nearest([0.0; 3], f32::INFINITY).unwrap().is_some());
    }
}
