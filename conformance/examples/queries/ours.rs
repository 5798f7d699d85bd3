//! The ways of this project.

use crate::{Answer, Library, MISS, Single};
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::hit_filter::{Any, Closest, Faces, HitFilter};
use rtrt_core::kernel::packet::{Packet, PacketHits, ray_hit_mask};
use rtrt_core::kernel::ray::Ray as KernelRay;
use rtrt_core::kernel::tiles::Tiles;
use rtrt_core::kernel::traverse::traverse;
use rtrt_core::lane::V3;
use rtrt_core::query::{Hit, QueryError, Ray, Tree, World};
use rtrt_core::scene::{Bvh, Mesh, Scene, Sequential};
use rtrt_cpu::{Caster, Cpu};
use std::collections::BTreeMap;
use std::error::Error;
use std::time::Instant;

/// One after the other, with the processor's vectors.
pub struct Cast<'a>(pub World<'a>, pub Caster);
/// One after the other, with the vectors that every processor of its kind has.
pub struct Core<'a>(pub World<'a>);
/// All at once, on one thread.
pub struct Slices<'a>(pub World<'a>, pub Cpu);
/// Each instance's tree, one after the other.
pub struct Each<'a> {
    geometry: Geometry<'a>,
}

fn nearest(hit: Result<Option<Hit>, QueryError>) -> Answer {
    hit.ok().flatten().map_or(MISS, |hit| (hit.t, hit.instance.number(), hit.triangle))
}

fn any(met: Result<bool, QueryError>) -> Answer {
    if met == Ok(true) { (0.0, 0, 0) } else { MISS }
}

impl Single for Cast<'_> {
    const NAME: &'static str = "rtrt";
    const IS_OURS: bool = true;
    fn closest(&self, ray: &Ray) -> Answer {
        nearest(self.1.closest(&self.0, ray))
    }
    fn occluded(&self, ray: &Ray) -> Answer {
        any(self.1.occluded(&self.0, ray))
    }
}

impl Single for Core<'_> {
    const NAME: &'static str = "rtrt-core";
    const IS_OURS: bool = true;
    fn closest(&self, ray: &Ray) -> Answer {
        nearest(self.0.closest(ray))
    }
    fn occluded(&self, ray: &Ray) -> Answer {
        any(self.0.occluded(ray))
    }
}

impl Library for Slices<'_> {
    fn name(&self) -> &'static str {
        "rtrt slices"
    }
    fn is_ours(&self) -> bool {
        true
    }
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        let mut hits = vec![Ok(None); rays.len()];
        self.1.closest(&self.0, rays, &mut hits);
        for (answer, hit) in answers.iter_mut().zip(hits) {
            *answer = nearest(hit);
        }
    }
    fn occluded(&self, rays: &[Ray], answers: &mut [Answer]) {
        let mut met = vec![Ok(false); rays.len()];
        self.1.occluded(&self.0, rays, &mut met);
        for (answer, met) in answers.iter_mut().zip(met) {
            *answer = any(met);
        }
    }
}

impl Single for Each<'_> {
    const NAME: &'static str = "loop";
    const IS_OURS: bool = true;
    fn closest(&self, ray: &Ray) -> Answer {
        self.ask(ray, Closest)
    }
    fn occluded(&self, ray: &Ray) -> Answer {
        self.ask(ray, Any)
    }
}

/// The time that one thread takes for the trees of all meshes and of the instances.
pub fn build_ms(scene: &Scene) -> Result<f64, Box<dyn Error>> {
    let mut meshes = BTreeMap::new();
    for instance in scene.instances().iter().filter(|instance| instance.triangles > 0) {
        meshes.entry(instance.root).or_insert(instance);
    }
    let mut built = 0.0;
    for instance in meshes.values() {
        let indices = &scene.mesh_data()[instance.first_index as usize..][..3 * instance.triangles as usize];
        let vertices = indices.iter().max().map_or(0, |most| *most as usize + 1);
        let first = instance.first_vertex as usize;
        let positions = scene.positions()[first..first + vertices].to_vec();
        let attributes = scene.attributes()[first..first + vertices].to_vec();
        let mesh = Mesh::new(positions, attributes, indices.to_vec())?;
        let start = Instant::now();
        std::hint::black_box(Bvh::build(&mesh, &Sequential));
        built += start.elapsed().as_secs_f64();
    }
    let start = Instant::now();
    std::hint::black_box(Tree::new(scene, &Sequential));
    Ok((built + start.elapsed().as_secs_f64()) * 1e3)
}

impl<'a> Each<'a> {
    pub fn new(scene: &'a Scene, low: glam::Vec3, high: glam::Vec3) -> Self {
        let geometry = Geometry {
            instances: scene.instances(),
            nodes: scene.nodes(),
            mesh_data: scene.mesh_data(),
            positions: scene.positions(),
            texels: scene.texels(),
            magnitude: low.abs().max(high.abs()).max_element(),
        };
        Self { geometry }
    }

    fn ask(&self, ray: &Ray, filter: impl HitFilter<f32>) -> Answer {
        let asked = KernelRay::<f32>::new(V3::splat((), ray.origin), V3::splat((), ray.direction));
        let magnitude = ray.origin.iter().fold(self.geometry.magnitude, |most, c| most.max(c.abs()));
        let (mut hits, mut filters) =
            (PacketHits::new([ClosestHit::none(ray.to.min(f32::MAX))]), [Twice { filter }]);
        for (number, instance) in (0..).zip(self.geometry.instances) {
            let (low, high) = instance.padded_aabb(magnitude);
            if ray_hit_mask(&[asked], &low, &high, 1, &hits.closest) == 0 {
                continue;
            }
            let rays = [if instance.is_identity == 1 { asked } else { asked.to_object(instance) }];
            let packet = Packet { rays: &rays, tiles: &Tiles::of(&rays, &hits.closest, 1) };
            traverse(&self.geometry, number, &packet, 1, &mut hits, &mut filters);
            if hits.closest[0].t < 0.0 {
                return (0.0, 0, 0);
            }
        }
        let hit = hits.closest[0].rows().hit(0);
        (hit.t, hit.instance, hit.triangle)
    }
}

/// A filter that sees both sides.
#[derive(Clone, Copy)]
struct Twice<F> {
    filter: F,
}

impl<F: HitFilter<f32>> HitFilter<f32> for Twice<F> {
    const TERMINATES: bool = F::TERMINATES;
    const FACES: Faces = Faces::Both;

    #[inline(always)]
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &rtrt_core::kernel::triangle::Intersection<f32>,
        closest: &mut ClosestHit<f32>,
    ) -> bool {
        self.filter.accept(geometry, instance, triangle, intersection, closest)
    }
}
