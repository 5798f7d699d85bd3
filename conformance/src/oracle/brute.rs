//! Every ray with every triangle of every object, by the core's definition of a hit: no
//! lists, no trees, no packets. What culling may never change, bit for bit.

use rtrt_core::backend::{Picture, Request};
use rtrt_core::compare::{Difference, compare};
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::ray::Ray;
use rtrt_core::kernel::traverse::Geometry;
use rtrt_core::kernel::triangle::{Meeting, meet};
use rtrt_core::kernel::view::camera_ray;
use rtrt_core::layout::{Frame, Hit, Surface};
use rtrt_core::scene::{Scene, Setup, SetupError};
use rtrt_core::stage::occlusion::{LIGHTS_PER_WORD, limit, to_light};
use rtrt_core::stage::surface::Surfaces;

/// A frame whose rays are asked one by one.
#[derive(Debug)]
pub struct Brute<'a> {
    scene: &'a Scene,
    setup: Setup,
}

impl<'a> Brute<'a> {
    /// The frame of this request.
    ///
    /// # Errors
    /// The request makes no picture.
    pub fn new(scene: &'a Scene, request: &Request<'_>) -> Result<Self, SetupError> {
        let mut setup = Setup::default();
        setup.prepare(scene, request.camera, request.size, request.samples, request.shadows)?;
        Ok(Self { scene, setup })
    }

    /// Calls `visit(object, triangle, meeting)` for everything that the ray meets at
    /// `t ≤ limit`.
    fn each(&self, ray: &Ray<f32>, limit: f32, mut visit: impl FnMut(u32, u32, &Meeting<f32>)) {
        let geometry = Geometry {
            objects: self.scene.objects(),
            nodes: self.scene.nodes(),
            words: self.scene.words(),
            positions: self.scene.positions(),
            magnitude: self.setup.frame.magnitude,
        };
        for (index, object) in (0..).zip(geometry.objects) {
            let local = if object.is_identity == 1 { *ray } else { ray.to_object(object) };
            for id in 0..object.triangles {
                let triangle = geometry.triangle(object, id);
                let found = meet(&local, &triangle, &triangle.seen_from(local.origin), limit);
                if found.mask {
                    visit(index, id, &found);
                }
            }
        }
    }

    /// The closest hit of a camera ray: the least `(t, object, triangle)`.
    pub fn hit(&self, ray: RayIndex) -> Hit {
        let mut best = Hit::MISS;
        let grid = self.setup.frame.grid();
        let at = grid.ray(ray);
        if !grid.contains(at) {
            return best;
        }
        let ray = camera_ray(&self.setup.views[Frame::CAMERA as usize], at[0] as f32, at[1] as f32);
        self.each(&ray, f32::MAX, |object, triangle, &Meeting { t, u, v, .. }| {
            if t < best.t || (t == best.t && (object, triangle) < (best.object, best.triangle)) {
                best = Hit { t, object, triangle, u, v };
            }
        });
        best
    }

    /// Whether the light reaches the surface.
    pub fn is_lit(&self, surface: &Surface, light: u32) -> bool {
        let frame = &self.setup.frame;
        let view = &self.setup.views[frame.light_view(light) as usize];
        let surface = Surfaces::new(surface);
        let limit = limit(view, &surface);
        let ray = Ray::new(surface.origin, to_light(view, surface.origin).0);
        let mut lit = limit > 0.0;
        if lit && frame.shadows == 1 {
            self.each(&ray, limit, |_, _, _| lit = false);
        }
        lit
    }
}

/// Compares hits and shadow masks of every `step`-th ray of a picture; shadow rays start at
/// the picture's own surfaces.
///
/// # Errors
/// The first difference; what the oracle found counts as expected.
///
/// # Panics
/// The request makes no picture, or the picture has no deferred buffers.
pub fn check(scene: &Scene, request: &Request<'_>, picture: &Picture, step: usize) -> Result<(), Difference> {
    let brute = Brute::new(scene, request).expect("a frame that has been rendered");
    let mut expected = picture.clone();
    let deferred = expected.deferred.as_mut().expect("deferred buffers");
    let words = deferred.mask_words as usize;
    for ray in (0..deferred.hits.len()).step_by(step) {
        deferred.hits[ray] = brute.hit(RayIndex(ray as u32));
        let mask = &mut deferred.masks[ray * words..][..words];
        mask.fill(0);
        for light in 0..brute.setup.frame.lights {
            let lit = brute.is_lit(&deferred.surfaces[ray], light);
            mask[(light / LIGHTS_PER_WORD) as usize] |= u32::from(lit) << (light % LIGHTS_PER_WORD);
        }
    }
    compare(request, &expected, picture)
}
