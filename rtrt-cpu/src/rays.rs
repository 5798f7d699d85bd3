//! Single rays of other programs, one by one or in slices on all threads.

use crate::Cpu;
use crate::instruction_set::{EightTask, InstructionSet};
use crate::parallel;
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
        Self::with(InstructionSet::new(Some(8)).unwrap_or(InstructionSet::Scalar))
    }

    /// With these instructions.
    pub fn with(level: InstructionSet) -> Self {
        Self { level }
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

    /// [`World::closest_each`].
    pub fn closest_each<S: Source>(
        &self,
        world: &World<'_, S>,
        rays: &[Ray],
        hits: &mut [Result<Option<Hit>, QueryError>],
    ) {
        self.level.run_eight(ClosestEach { world, rays, hits });
    }

    /// [`World::occluded_each`].
    pub fn occluded_each<S: Source>(
        &self,
        world: &World<'_, S>,
        rays: &[Ray],
        occluded: &mut [Result<bool, QueryError>],
    ) {
        self.level.run_eight(OccludedEach { world, rays, occluded });
    }
}

/// Rays that one task asks: those that a [`World`] traces together.
const RAYS: usize = 64;

impl Cpu {
    /// [`World::closest_each`], on all threads.
    pub fn closest<S: Source + Sync>(
        &self,
        world: &World<'_, S>,
        rays: &[Ray],
        hits: &mut [Result<Option<Hit>, QueryError>],
    ) {
        let caster = Caster::new();
        self.each(rays, hits, |rays, hits| caster.closest_each(world, rays, hits));
    }

    /// [`World::occluded_each`], on all threads.
    pub fn occluded<S: Source + Sync>(
        &self,
        world: &World<'_, S>,
        rays: &[Ray],
        occluded: &mut [Result<bool, QueryError>],
    ) {
        let caster = Caster::new();
        self.each(rays, occluded, |rays, occluded| caster.occluded_each(world, rays, occluded));
    }

    fn each<T: Send>(&self, rays: &[Ray], answers: &mut [T], ask: impl Fn(&[Ray], &mut [T]) + Sync) {
        self.install(|| {
            parallel::each_part(answers, RAYS, 1, |part, answers| {
                ask(rays.chunks(RAYS).nth(part).unwrap_or_default(), answers);
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

struct ClosestEach<'a, S: Source> {
    world: &'a World<'a, S>,
    rays: &'a [Ray],
    hits: &'a mut [Result<Option<Hit>, QueryError>],
}

impl<S: Source> EightTask for ClosestEach<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self, token: L::Token) {
        self.world.closest_each_with::<L>(token, self.rays, self.hits);
    }
}

struct OccludedEach<'a, S: Source> {
    world: &'a World<'a, S>,
    rays: &'a [Ray],
    occluded: &'a mut [Result<bool, QueryError>],
}

impl<S: Source> EightTask for OccludedEach<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self, token: L::Token) {
        self.world.occluded_each_with::<L>(token, self.rays, self.occluded);
    }
}
