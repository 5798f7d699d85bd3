//! Positions in `f64`, for worlds that are larger than `f32` can tell places apart in.

use super::{COORDINATE_LIMIT, InstanceIndex};
use alloc::vec::Vec;
use glam::{DMat4, DVec3, Mat4, Vec3};

/// Instances with transforms in `f64`, and the point that a [`Scene`](super::Scene) or
/// [`Shapes`](crate::query::Shapes) has at zero.
///
/// `f32` has 24 bits: a million units away from zero, places are a sixteenth apart. A program whose world is larger
/// keeps its transforms here, and moves the origin to where it renders or asks:
///
/// ```
/// use glam::{DMat4, DVec3};
/// use rtrt_core::query::{Ray, Tree};
/// use rtrt_core::scene::{Material, Origin, Scene};
///
/// let mut scene = Scene::new();
/// let white = scene.add_material(Material::default())?;
/// let ball = scene.add_sphere(white, glam::Mat4::IDENTITY)?;
/// // On the equator of the earth, in meters.
/// let place = DVec3::new(6_378_137.25, 0.0, 0.0);
/// let mut origin = Origin::new(place);
/// scene.set_transforms([(ball, origin.place(ball, DMat4::from_translation(place)))])?;
/// // The program travels on by 100 km.
/// scene.set_transforms(origin.moved_to(place + DVec3::new(0.0, 100_000.0, 0.0)))?;
/// let eye = origin.near(place + DVec3::new(0.0, 0.0, 3.0));
/// let mut tree = Tree::default();
/// let hit = tree.world(&scene).closest(&Ray::new(eye, [0.0, 0.0, -1.0]))?;
/// assert!(hit.is_some_and(|hit| (hit.t - 2.0).abs() < 0.02));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// What is farther than 2²⁹ from the origin along an axis, half of [`COORDINATE_LIMIT`], is put at that distance.
#[derive(Debug, Clone, Default)]
pub struct Origin {
    at: DVec3,
    /// By number.
    placed: Vec<Option<(InstanceIndex, DMat4)>>,
}

impl Origin {
    /// No instances yet; zero of the scene is at this point of the world.
    pub fn new(at: impl Into<DVec3>) -> Self {
        Self { at: at.into(), placed: Vec::new() }
    }

    /// The point of the world that is zero in the scene.
    pub fn point(&self) -> DVec3 {
        self.at
    }

    /// Keeps where an instance is in the world, and returns its transform relative to the origin: that of
    /// [`Scene::set_transforms`](super::Scene::set_transforms).
    pub fn place(&mut self, instance: InstanceIndex, to_world: DMat4) -> Mat4 {
        let number = instance.number() as usize;
        if self.placed.len() <= number {
            self.placed.resize(number + 1, None);
        }
        self.placed[number] = Some((instance, to_world));
        relative(self.at, to_world)
    }

    /// Moves the origin, and returns the transform of each instance relative to it.
    pub fn moved_to(&mut self, at: impl Into<DVec3>) -> impl Iterator<Item = (InstanceIndex, Mat4)> + '_ {
        self.at = at.into();
        let at = self.at;
        self.placed.iter().flatten().map(move |&(instance, to_world)| (instance, relative(at, to_world)))
    }

    /// A point of the world, relative to the origin: such as the start of a ray, or the eye of a camera.
    pub fn near(&self, point: impl Into<DVec3>) -> Vec3 {
        within(point.into() - self.at)
    }

    /// A point of the scene, in the world.
    pub fn far(&self, point: impl Into<Vec3>) -> DVec3 {
        self.at + point.into().as_dvec3()
    }
}

/// A transform whose translation is subtracted before it is rounded.
fn relative(at: DVec3, to_world: DMat4) -> Mat4 {
    let moved = within(to_world.w_axis.truncate() - at);
    Mat4 { w_axis: moved.extend(1.0), ..to_world.as_mat4() }
}

/// The nearest point that coordinates reach.
fn within(point: DVec3) -> Vec3 {
    let limit = f64::from(COORDINATE_LIMIT) / 2.0;
    // (The lesser of NaN and a number would be the number; this keeps NaN.)
    Vec3::from(point.to_array().map(|c| c.clamp(-limit, limit) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::{Ray, Tree};
    use crate::scene::{Material, Scene};

    #[test]
    fn far_away_is_as_near() {
        let (mut near, mut far) = (Scene::new(), Scene::new());
        // Exact in f64, and beyond all that f32 tells apart.
        let there = DVec3::new(6_378_137.25, -1.5e9, 4.0e12);
        let mut origin = Origin::new(DVec3::ZERO);
        for number in 0..20 {
            let place = Mat4::from_scale_rotation_translation(
                Vec3::new(0.25, 0.5, 1.5),
                glam::Quat::from_rotation_x(number as f32),
                Vec3::new(number as f32 * 0.5 - 5.0, 0.25, -3.0),
            );
            for (scene, is_far) in [(&mut near, false), (&mut far, true)] {
                let white = scene.add_material(Material::default()).unwrap();
                let ball = scene.add_sphere(white, place).unwrap();
                if is_far {
                    origin.place(ball, DMat4::from_translation(there) * place.as_dmat4());
                }
            }
        }
        far.set_transforms(origin.moved_to(there)).unwrap();
        let (mut near_tree, mut far_tree) = (Tree::default(), Tree::default());
        let (near, far) = (near_tree.world(&near), far_tree.world(&far));
        let mut hits = 0;
        for number in 0..200 {
            let eye = Vec3::new(number as f32 * 0.0625 - 6.0, 0.125, 4.0);
            let direction = Vec3::new(0.0, 0.0, -1.0);
            let [one, other] = [(near, eye), (far, origin.near(origin.far(eye)))]
                .map(|(world, eye)| world.closest(&Ray::new(eye, direction)).unwrap());
            let bits = |hit: crate::query::Hit| (hit.t.to_bits(), hit.instance.number(), hit.u.to_bits());
            assert_eq!(one.map(bits), other.map(bits));
            hits += usize::from(one.is_some());
        }
        assert!(hits > 100, "{hits}");
    }

    #[test]
    fn what_is_too_far_is_put_at_the_limit() {
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let ball = scene.add_sphere(white, Mat4::IDENTITY).unwrap();
        let mut origin = Origin::default();
        for place in [1e12, -1e300, f64::INFINITY] {
            let moved = origin.place(ball, DMat4::from_translation(DVec3::new(0.0, place, 1.0)));
            scene.set_transform(ball, moved).unwrap();
            assert_eq!(moved.w_axis.y, 536_870_912.0 * place.signum() as f32);
        }
        // What is no number is refused as anywhere else.
        let moved = origin.place(ball, DMat4::from_translation(DVec3::NAN));
        assert!(scene.set_transform(ball, moved).is_err());
    }
}
