//! Crates that trace rays: all triangles, world space, in one tree.

use crate::{Answer, Library, MISS, OneByOne, Single};
use glam::Vec3;
use rtrt_core::query::Ray;
use std::error::Error;
use std::time::{Duration, Instant};

/// The libraries, each with the milliseconds of its build on one thread.
pub fn libraries(triangles: &[[Vec3; 3]]) -> Result<Vec<(Box<dyn Library>, f64)>, Box<dyn Error>> {
    let mut libraries: Vec<(Box<dyn Library>, f64)> = vec![];
    let start = Instant::now();
    let obvhs = Box::new(OneByOne(Obvhs::new(triangles)));
    libraries.push((obvhs, start.elapsed().as_secs_f64() * 1e3));
    let start = Instant::now();
    let parry = Box::new(OneByOne(Parry::new(triangles)?));
    libraries.push((parry, start.elapsed().as_secs_f64() * 1e3));
    let start = Instant::now();
    let crate_bvh = Box::new(OneByOne(CrateBvh::new(triangles)));
    libraries.push((crate_bvh, start.elapsed().as_secs_f64() * 1e3));
    Ok(libraries)
}

/// `obvhs`: its compressed tree of eight children a node, built slowly for fast rays.
struct Obvhs {
    tree: obvhs::cwbvh::CwBvh,
    /// In the order of the tree.
    triangles: Vec<obvhs::triangle::Triangle>,
}

impl Obvhs {
    fn new(triangles: &[[Vec3; 3]]) -> Self {
        let all: Vec<_> = triangles
            .iter()
            .map(|corners| {
                let [v0, v1, v2] = corners.map(|c| obvhs_vector(c.to_array()));
                obvhs::triangle::Triangle { v0, v1, v2 }
            })
            .collect();
        let tree = obvhs::cwbvh::builder::build_cwbvh_from_tris(
            &all,
            obvhs::BvhBuildParams::slow_build(),
            &mut Duration::default(),
        );
        let triangles = tree.primitive_indices.iter().map(|&index| all[index as usize]).collect();
        Self { tree, triangles }
    }

    fn hit(&self, ray: &Ray, is_any: bool) -> Answer {
        let asked = obvhs::ray::Ray::new(
            obvhs_vector(ray.origin),
            obvhs_vector(ray.direction),
            0.0,
            ray.to.min(f32::MAX),
        );
        let mut hit = obvhs::ray::RayHit::none();
        let is_hit = if is_any {
            !self.tree.ray_traverse_miss(asked, |ray, id| self.triangles[id].intersect(ray))
        } else {
            self.tree.ray_traverse(asked, &mut hit, |ray, id| self.triangles[id].intersect(ray))
        };
        if is_hit { (hit.t, 0, 0) } else { MISS }
    }
}

fn obvhs_vector([x, y, z]: [f32; 3]) -> glam::Vec3A {
    glam::Vec3A::new(x, y, z)
}

impl Single for Obvhs {
    const NAME: &'static str = "obvhs";
    fn closest(&self, ray: &Ray) -> Answer {
        self.hit(ray, false)
    }
    fn occluded(&self, ray: &Ray) -> Answer {
        self.hit(ray, true)
    }
}

/// `parry3d`: its mesh.
struct Parry {
    mesh: parry3d::shape::TriMesh,
}

impl Parry {
    fn new(triangles: &[[Vec3; 3]]) -> Result<Self, Box<dyn Error>> {
        let corners = triangles.iter().flatten().map(|c| parry_vector(c.to_array())).collect();
        let indices = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Ok(Self { mesh: parry3d::shape::TriMesh::new(corners, indices)? })
    }

    fn hit(&self, ray: &Ray, is_any: bool) -> Answer {
        use parry3d::query::RayCast;
        let asked = parry3d::query::Ray::new(parry_vector(ray.origin), parry_vector(ray.direction));
        let limit = ray.to.min(f32::MAX);
        if is_any {
            return if self.mesh.intersects_local_ray(&asked, limit) { (0.0, 0, 0) } else { MISS };
        }
        self.mesh.cast_local_ray(&asked, limit, true).map_or(MISS, |t| (t, 0, 0))
    }
}

fn parry_vector([x, y, z]: [f32; 3]) -> parry3d::math::Vector {
    parry3d::math::Vector::new(x, y, z)
}

impl Single for Parry {
    const NAME: &'static str = "parry3d";
    fn closest(&self, ray: &Ray) -> Answer {
        self.hit(ray, false)
    }
    fn occluded(&self, ray: &Ray) -> Answer {
        self.hit(ray, true)
    }
}

/// `bvh`: leaves in the order of their boxes along the ray. Its test of a triangle sees fronts only, so the triangle
/// is tested here.
struct CrateBvh {
    tree: bvh::bvh::Bvh<f32, 3>,
    triangles: Vec<BvhTriangle>,
}

struct BvhTriangle {
    corners: [Vec3; 3],
    node: usize,
}

impl bvh::aabb::Bounded<f32, 3> for BvhTriangle {
    fn aabb(&self) -> bvh::aabb::Aabb<f32, 3> {
        let [a, b, c] = self.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        bvh::aabb::Aabb::with_bounds(low.to_array().into(), high.to_array().into())
    }
}

impl bvh::bounding_hierarchy::BHShape<f32, 3> for BvhTriangle {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl CrateBvh {
    fn new(triangles: &[[Vec3; 3]]) -> Self {
        let mut triangles: Vec<_> =
            triangles.iter().map(|&corners| BvhTriangle { corners, node: 0 }).collect();
        let tree = bvh::bvh::Bvh::build(&mut triangles);
        Self { tree, triangles }
    }

    fn hit(&self, ray: &Ray, is_any: bool) -> Answer {
        use bvh::aabb::Bounded;
        // It makes directions a unit long.
        let length = Vec3::from(ray.direction).length();
        let asked = bvh::ray::Ray::new(ray.origin.into(), ray.direction.into());
        let mut limit = ray.to.min(f32::MAX);
        let mut answer = MISS;
        for triangle in self.tree.nearest_traverse_iterator(&asked, &self.triangles) {
            let entered = asked.intersection_slice_for_aabb(&triangle.aabb());
            if entered.is_some_and(|(near, _)| near / length > limit) {
                break;
            }
            if let Some(t) = distance(ray, &triangle.corners).filter(|&t| t <= limit) {
                (limit, answer) = (t, (t, 0, 0));
                if is_any {
                    break;
                }
            }
        }
        answer
    }
}

/// Möller and Trumbore's test of both sides.
fn distance(ray: &Ray, &[a, b, c]: &[Vec3; 3]) -> Option<f32> {
    let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
    let (ab, ac, from) = (b - a, c - a, origin - a);
    let across = direction.cross(ac);
    let inverse = ab.dot(across).recip();
    let u = from.dot(across) * inverse;
    let turned = from.cross(ab);
    let v = direction.dot(turned) * inverse;
    let t = ac.dot(turned) * inverse;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

impl Single for CrateBvh {
    const NAME: &'static str = "bvh";
    fn closest(&self, ray: &Ray) -> Answer {
        self.hit(ray, false)
    }
    fn occluded(&self, ray: &Ray) -> Answer {
        self.hit(ray, true)
    }
}
