//! Single rays of other programs, one by one or in slices on all threads.

use crate::Cpu;
use crate::instruction_set::{EightTask, InstructionSet};
use rayon::prelude::*;
use rtrt_core::lane::Lane;
use rtrt_core::query::{Hit, QueryError, Ray, Source, World};

/// Asks rays with the widest instructions that are of use here: eight boxes or triangles at a time. The answers
/// are those of the [`World`].
///
/// ```
/// use rtrt_core::query::{Ray, Tree};
/// use rtrt_core::scene::{Material, Scene};
///
/// let mut scene = Scene::new();
/// let white = scene.add_material(Material::default())?;
/// scene.add_sphere(white, glam::Mat4::IDENTITY)?;
/// let mut tree = Tree::new(&scene, &rtrt_cpu::Parallel);
/// let (world, caster) = (tree.world(&scene), rtrt_cpu::Caster::new());
/// let ray = Ray::new([0.0, 0.0, 3.0], [0.0, 0.0, -1.0]);
/// assert_eq!(caster.closest(&world, &ray), world.closest(&ray));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Caster {
    level: InstructionSet,
}

impl Default for Caster {
    fn default() -> Self {
        Self::new()
    }
}

impl Caster {
    /// With what this processor has.
    pub fn new() -> Self {
        Self { level: InstructionSet::new(Some(8)).unwrap_or(InstructionSet::Scalar) }
    }

    /// [`World::closest`].
    ///
    /// # Errors
    /// As there.
    pub fn closest<S: Source>(&self, world: &World<'_, S>, ray: &Ray) -> Result<Option<Hit>, QueryError> {
        self.level.run_eight(Closest { world, ray })
    }

    /// [`World::occluded`].
    ///
    /// # Errors
    /// As there.
    pub fn occluded<S: Source>(&self, world: &World<'_, S>, ray: &Ray) -> Result<bool, QueryError> {
        self.level.run_eight(Occluded { world, ray })
    }
}

/// Rays that one task asks.
const RAYS: usize = 64;

impl Cpu {
    /// The closest hit of each ray, by [`World::closest`], on all threads; a ray that is refused has an error of
    /// its own. What is beyond the shorter slice is left alone.
    pub fn closest<S: Source + Sync>(
        &self,
        world: &World<'_, S>,
        rays: &[Ray],
        hits: &mut [Result<Option<Hit>, QueryError>],
    ) {
        let caster = Caster::new();
        self.each(rays, hits, |ray| caster.closest(world, ray));
    }

    /// Whether each ray hits anything, by [`World::occluded`], as [`Cpu::closest`].
    pub fn occluded<S: Source + Sync>(
        &self,
        world: &World<'_, S>,
        rays: &[Ray],
        occluded: &mut [Result<bool, QueryError>],
    ) {
        let caster = Caster::new();
        self.each(rays, occluded, |ray| caster.occluded(world, ray));
    }

    fn each<T: Send>(&self, rays: &[Ray], answers: &mut [T], ask: impl Fn(&Ray) -> T + Sync) {
        self.install(|| {
            rays.par_chunks(RAYS).zip(answers.par_chunks_mut(RAYS)).for_each(|(rays, answers)| {
                for (ray, answer) in rays.iter().zip(answers) {
                    *answer = ask(ray);
                }
            });
        });
    }
}

struct Closest<'a, S: Source> {
    world: &'a World<'a, S>,
    ray: &'a Ray,
}

impl<S: Source> EightTask for Closest<'_, S> {
    type Output = Result<Option<Hit>, QueryError>;

    #[inline(always)]
    fn run<L: Lane>(self, token: L::Token) -> Self::Output {
        self.world.closest_with::<L>(token, self.ray)
    }
}

struct Occluded<'a, S: Source> {
    world: &'a World<'a, S>,
    ray: &'a Ray,
}

impl<S: Source> EightTask for Occluded<'_, S> {
    type Output = Result<bool, QueryError>;

    #[inline(always)]
    fn run<L: Lane>(self, token: L::Token) -> Self::Output {
        self.world.occluded_with::<L>(token, self.ray)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, Parallel};
    use glam::{Mat4, Vec3};
    use rtrt_core::query::Tree;
    use rtrt_core::scene::{Attribute, Bvh, Material, Mesh, Scene};

    #[test]
    fn answers_are_those_of_the_world_one_by_one_and_in_slices() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut point = |size: f32| [random() * size, random() * size, random() * size];
        let positions: Vec<_> = (0..900).map(|_| point(1.0)).collect();
        let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: u32::MAX };
        let mesh = Mesh::new(positions, vec![attribute; 900], (0..900).collect()).unwrap();
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Parallel)).unwrap();
        for _ in 0..40 {
            let place = Mat4::from_translation(Vec3::from(point(4.0)));
            scene.add_instance(mesh, white, place).unwrap();
            scene.add_sphere(white, place).unwrap();
        }
        let mut tree = Tree::new(&scene, &Parallel);
        let world = tree.world(&scene);
        let mut rays: Vec<_> = (0..3000).map(|_| Ray::new(point(5.0), point(1.0)).until(20.0)).collect();
        rays[77].direction = [0.0; 3];
        let expected: Vec<_> = rays.iter().map(|ray| world.closest(ray)).collect();
        let occluded: Vec<_> = rays.iter().map(|ray| world.occluded(ray)).collect();
        assert!(expected.iter().filter(|hit| matches!(hit, Ok(Some(_)))).count() > 500);
        assert!(expected[77].is_err());
        let levels = InstructionSet::wide().into_iter().chain([InstructionSet::Scalar]);
        for caster in levels.map(|level| Caster { level }) {
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(caster.closest(&world, ray), *expected);
            }
            for (ray, occluded) in rays.iter().zip(&occluded) {
                assert_eq!(caster.occluded(&world, ray), *occluded);
            }
        }
        let cpu = Cpu::new(Options { threads: Some(3), ..Options::default() }).unwrap();
        let (mut hits, mut hidden) = (vec![Ok(None); 3000], vec![Ok(false); 3000]);
        cpu.closest(&world, &rays, &mut hits);
        cpu.occluded(&world, &rays, &mut hidden);
        assert_eq!((hits, hidden), (expected, occluded));
    }
}
