//! What is right: a search in `f64` through all triangles.

use crate::Answer;
use glam::DVec3;
use rtrt_core::layout::NONE;
use rtrt_core::query::Ray;
use rtrt_core::scene::Scene;

/// All triangles, world space, in `f64`.
pub struct Brute {
    triangles: Vec<[DVec3; 3]>,
    /// The largest coordinate.
    size: f64,
}

/// A ray that passes an edge by less than this share of a triangle is not judged by that triangle alone.
const EDGE: f64 = 1e-4;

impl Brute {
    pub fn new(scene: &Scene) -> Self {
        let mut triangles = vec![];
        for instance in scene.instances() {
            for triangle in 0..instance.triangles {
                triangles.push(instance.corners(scene.mesh_data(), triangle).map(|vertex| {
                    let p = scene.positions()[vertex as usize].map(f64::from);
                    DVec3::from(instance.to_world.map(|row| {
                        let row = row.map(f64::from);
                        row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]
                    }))
                }));
            }
        }
        let size = triangles.iter().flatten().fold(0.0_f64, |most, p| most.max(p.abs().max_element()));
        Self { triangles, size }
    }

    /// The triangles, rounded.
    #[cfg(feature = "peers")]
    pub fn single(&self) -> Vec<[glam::Vec3; 3]> {
        self.triangles.iter().map(|corners| corners.map(|corner| corner.as_vec3())).collect()
    }

    /// Whether an answer is right; `None` where it is too close to call.
    pub fn agrees(&self, ray: &Ray, answer: Answer, is_any: bool) -> Option<bool> {
        let (o, d) = (DVec3::from(ray.origin.map(f64::from)), DVec3::from(ray.direction.map(f64::from)));
        let doubt = 1e-5 * self.size / d.length();
        let limit = f64::from(ray.to);
        // The nearest hit that is beyond doubt, and all that may be hits.
        let mut sure = f64::INFINITY;
        let mut possible = vec![];
        for [a, b, c] in &self.triangles {
            let (ab, ac, s) = (*b - *a, *c - *a, o - *a);
            let across = d.cross(ac);
            let determinant = ab.dot(across);
            if determinant == 0.0 {
                continue;
            }
            let u = s.dot(across) / determinant;
            let turned = s.cross(ab);
            let v = d.dot(turned) / determinant;
            let t = ac.dot(turned) / determinant;
            let inside = u.min(v).min(1.0 - u - v);
            if inside < -EDGE || t < -doubt || t > limit + doubt {
                continue;
            }
            possible.push(t);
            if inside > EDGE && t > doubt && t < limit - doubt {
                sure = sure.min(t);
            }
        }
        let is_hit = answer.1 != NONE;
        if is_any {
            return match (sure.is_finite(), possible.is_empty()) {
                (true, _) => Some(is_hit),
                (false, true) => Some(!is_hit),
                (false, false) => None,
            };
        }
        if !is_hit {
            return if sure.is_finite() { Some(false) } else { possible.is_empty().then_some(true) };
        }
        let t = f64::from(answer.0);
        let near = |other: &f64| (other - t).abs() <= doubt + 1e-5 * t;
        Some(possible.iter().any(near) && t <= sure + doubt + 1e-5 * t)
    }
}
