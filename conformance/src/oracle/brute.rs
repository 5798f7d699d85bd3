//! Every ray with every triangle, and sphere, of every instance, by the core's definition of a hit: no
//! lists, no trees, no packets. What culling may never change, bit for bit.

use rtrt_core::backend::{Picture, Request};
use rtrt_core::compare::{Difference, compare};
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::hit_filter::HitFilter;
use rtrt_core::kernel::penumbra::penumbra_radius;
use rtrt_core::kernel::ray::Ray;
use rtrt_core::kernel::shadow_distance::is_near;
use rtrt_core::kernel::sphere::{Chord, ENTRY};
use rtrt_core::kernel::transmittance::{Transmittance, WHITE};
use rtrt_core::kernel::transparency::{alpha_mode, passes_mask, tint_and_alpha};
use rtrt_core::kernel::triangle::{Intersection, intersect};
use rtrt_core::kernel::view::camera_ray;
use rtrt_core::layout::{AlphaKind, Frame, Hit, NONE, ShadowKind, Surface, ViewKind};
use rtrt_core::scene::{Scene, Setup, SetupError};
use rtrt_core::stage::occlusion::{LIGHTS_PER_WORD, limit, to_light};
use rtrt_core::stage::share::share;
use rtrt_core::stage::surface::Surfaces;

/// A frame whose rays are traced one by one.
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
        setup.prepare(scene, request)?;
        Ok(Self { scene, setup })
    }

    /// Calls `visit(instance, triangle, meeting)` for everything that the ray meets at
    /// `t ≤ limit`: of what is not double-sided only the fronts, toward the origin or, `from_end`, the end.
    fn each(
        &self,
        ray: &Ray<f32>,
        limit: f32,
        from_end: bool,
        mut visit: impl FnMut(u32, u32, &Intersection<f32>),
    ) {
        let geometry = self.geometry();
        for (index, instance) in (0..).zip(geometry.instances) {
            let local = if instance.is_identity == 1 { *ray } else { ray.to_object(instance) };
            for id in 0..instance.triangles {
                let (found, is_front) = if instance.is_sphere() {
                    (Chord::new(&local).side(local.direction, id, limit), id == ENTRY)
                } else {
                    let triangle = geometry.triangle(instance, id);
                    let seen = triangle.relative_to(local.origin);
                    (intersect(&local, &seen, limit), seen.front(limit))
                };
                if found.mask && (is_front != from_end || instance.double_sided == 1) {
                    visit(index, id, &found);
                }
            }
        }
    }

    /// The same for a ray to a light, which passes through what shows that light, and what is
    /// beyond the distance at which shadows of suns end.
    fn between(
        &self,
        ray: &Ray<f32>,
        limit: f32,
        light: u32,
        mut visit: impl FnMut(u32, u32, &Intersection<f32>),
    ) {
        if !self.scene.lights()[light as usize].casts_shadows {
            return;
        }
        let instances = self.geometry().instances;
        let views = &self.setup.views;
        let (camera, view) =
            (&views[Frame::CAMERA as usize], &views[self.setup.frame.light_view(light) as usize]);
        self.each(ray, limit, true, |instance, triangle, found| {
            let near =
                view.kind != ViewKind::Sun as u32 || is_near(camera, view, &instances[instance as usize]);
            if near && !instances[instance as usize].shows(light) {
                visit(instance, triangle, found);
            }
        });
    }

    /// The geometry of the scene.
    fn geometry(&self) -> Geometry<'_> {
        Geometry {
            instances: &self.setup.instances(self.scene)[..self.scene.instances().len()],
            ..self.setup.geometry(self.scene)
        }
    }

    /// The [`AlphaKind`] of an instance.
    fn alpha_mode(&self, instance: u32) -> u32 {
        let geometry = self.geometry();
        alpha_mode(&geometry.instances[instance as usize], geometry.mesh_data)
    }

    /// Whether anything is there where a ray has met an instance: what a mask leaves.
    fn is_there(&self, instance: u32, triangle: u32, found: &Intersection<f32>) -> bool {
        let geometry = self.geometry();
        if self.alpha_mode(instance) != AlphaKind::Mask as u32 {
            return true;
        }
        let [_, _, _, alpha] = tint_and_alpha(&geometry, instance, triangle, found);
        passes_mask(&geometry, instance, alpha)
    }

    /// The surfaces along a camera ray up to `count` of them, nearest first: of all hits in
    /// order, those that are not of the same instance and at the same place as the one before.
    pub fn layers(&self, ray: RayIndex, count: usize) -> Vec<Hit> {
        let mut all = Vec::new();
        let grid = self.setup.frame.grid();
        let at = grid.ray(ray);
        if grid.contains(at) {
            let ray = camera_ray(&self.setup.views[Frame::CAMERA as usize], at[0] as f32, at[1] as f32);
            let Frame { near, far, .. } = self.setup.frame;
            self.each(&ray, far, false, |instance, triangle, found| {
                if found.t > near && self.is_there(instance, triangle, found) {
                    all.push(Hit { t: found.t, instance, triangle, u: found.u, v: found.v });
                }
            });
        }
        all.sort_by(|a, b| a.t.total_cmp(&b.t).then((a.instance, a.triangle).cmp(&(b.instance, b.triangle))));
        let mut layers: Vec<Hit> = Vec::new();
        for hit in all {
            let is_same = layers.last().is_some_and(|last| {
                last.instance == hit.instance && hit.t <= last.t * (1.0 + 1.0 / 1_048_576.0)
            });
            if !is_same && layers.len() < count {
                layers.push(hit);
            }
        }
        layers
    }

    /// What is left of the light at the surface, as a word (see [`rtrt_core::kernel::transmittance`]):
    /// everything between them, in the order of the instances from last to first.
    pub fn transmittance(&self, ray: RayIndex, surface: &Surface, light: u32) -> u32 {
        let frame = &self.setup.frame;
        let view = &self.setup.views[frame.light_view(light) as usize];
        let surface = Surfaces::new(surface);
        let limit = limit(frame, view, ray, &surface);
        if limit <= 0.0 {
            return 0;
        }
        if frame.shadows == 0 {
            return WHITE;
        }
        let ray = Ray::new(surface.origin, to_light(frame, view, ray, surface.origin).0);
        let mut met = Vec::new();
        self.between(&ray, limit, light, |instance, triangle, found| met.push((instance, triangle, *found)));
        let geometry = self.geometry();
        let mut crossing = Transmittance::<f32, false>::new(0.0);
        for (instance, triangle, found) in met.iter().rev() {
            let mut best = ClosestHit::new(&Hit::MISS);
            crossing.accept(&geometry, *instance, *triangle, found, &mut best);
            if best.t < 0.0 {
                return 0;
            }
        }
        crossing.word().0
    }

    /// What is left of the light at the surface, and the radius of the penumbra there, before
    /// shadows are blurred.
    pub fn near(&self, ray: RayIndex, surface: &Surface, light: u32) -> (u32, f32) {
        let transmittance = self.transmittance(ray, surface, light);
        let frame = &self.setup.frame;
        let view = &self.setup.views[frame.light_view(light) as usize];
        let surface = Surfaces::new(surface);
        let limit = limit(frame, view, ray, &surface);
        let cast = Ray::new(surface.origin, to_light(frame, view, ray, surface.origin).0);
        let geometry = self.geometry();
        let mut nearest: Option<f32> = None;
        if limit > 0.0 {
            self.between(&cast, limit, light, |instance, triangle, found| {
                let is_nearer = nearest.is_none_or(|nearest| found.t < nearest);
                let is_seen = self.alpha_mode(instance) != AlphaKind::Blend as u32
                    || tint_and_alpha(&geometry, instance, triangle, found)[3] > 0.0;
                if is_nearer && is_seen && self.is_there(instance, triangle, found) {
                    nearest = Some(found.t);
                }
            });
        }
        (transmittance, nearest.map_or(-1.0, |t| penumbra_radius(view, t)))
    }

    /// The closest hit of a camera ray: the least `(t, instance, triangle)`.
    pub fn hit(&self, ray: RayIndex) -> Hit {
        if self.setup.frame.layers > 0 {
            return self.layers(ray, 1).first().copied().unwrap_or(Hit::MISS);
        }
        let mut best = Hit::MISS;
        let grid = self.setup.frame.grid();
        let at = grid.ray(ray);
        if !grid.contains(at) {
            return best;
        }
        let ray = camera_ray(&self.setup.views[Frame::CAMERA as usize], at[0] as f32, at[1] as f32);
        let Frame { near, far, .. } = self.setup.frame;
        self.each(&ray, far, false, |instance, triangle, &Intersection { t, u, v, .. }| {
            if t <= near {
                return;
            }
            if t < best.t || (t == best.t && (instance, triangle) < (best.instance, best.triangle)) {
                best = Hit { t, instance, triangle, u, v };
            }
        });
        best
    }

    /// Whether the light reaches the surface.
    pub fn is_lit(&self, ray: RayIndex, surface: &Surface, light: u32) -> bool {
        let frame = &self.setup.frame;
        let view = &self.setup.views[frame.light_view(light) as usize];
        let surface = Surfaces::new(surface);
        let limit = limit(frame, view, ray, &surface);
        let ray = Ray::new(surface.origin, to_light(frame, view, ray, surface.origin).0);
        let mut lit = limit > 0.0;
        if lit && frame.shadows == 1 {
            self.between(&ray, limit, light, |_, _, _| lit = false);
        }
        lit
    }
}

/// Compares hits, layers, shadow masks and the colors of shadows of every `step`-th ray of a picture; shadow rays start at
/// the picture's own surfaces.
///
/// # Errors
/// The first difference; the oracle's result is the expected one.
///
/// # Panics
/// The request makes no picture, or the picture has no deferred buffers.
pub fn check(scene: &Scene, request: &Request<'_>, picture: &Picture, step: usize) -> Result<(), Difference> {
    let brute = Brute::new(scene, request).expect("a frame that has been rendered");
    let mut expected = picture.clone();
    let deferred = expected.deferred.as_mut().expect("deferred buffers");
    let words = deferred.mask_words as usize;
    let frame = &brute.setup.frame;
    let step = if frame.is_shared == 1 { 1 } else { step };
    for ray in (0..deferred.hits.len()).step_by(step) {
        deferred.hits[ray] = brute.hit(RayIndex(ray as u32));
    }
    if frame.is_shared == 1 {
        for pixel in 0..frame.width * frame.height {
            share(frame, &mut deferred.hits, frame.grid().first_ray(pixel).0);
        }
    }
    for ray in (0..deferred.hits.len()).step_by(step) {
        let mask = &mut deferred.masks[ray * words..][..words];
        mask.fill(0);
        let count = deferred.layer_count as usize;
        if count > 0 {
            // How many of them are looked at depends on how much they cover; that, the colors
            // tell. Here only those are compared that the picture has.
            let all = brute.layers(RayIndex(ray as u32), count + 1);
            let behind = &mut deferred.layers[ray * count..][..count];
            for (number, layer) in
                behind.iter_mut().enumerate().take_while(|(_, layer)| layer.instance != NONE)
            {
                *layer = all.get(number + 1).copied().unwrap_or(Hit::MISS);
            }
        }
        for light in 0..brute.setup.frame.lights {
            if brute.setup.frame.shadow_kind() == ShadowKind::Penumbra {
                let (left, size) = brute.near(RayIndex(ray as u32), &deferred.surfaces[ray], light);
                let at = ray * deferred.transmittance_words as usize + light as usize;
                (deferred.raw_transmittance[at], deferred.penumbra_radii[at]) = (left, size);
            }
            // Filtered shadows are not the result of one ray.
            let lit = if brute.setup.frame.shadow_kind() == ShadowKind::Penumbra {
                deferred.transmittance[ray * deferred.transmittance_words as usize + light as usize] != 0
            } else if brute.setup.frame.layers > 0 {
                let tint = brute.transmittance(RayIndex(ray as u32), &deferred.surfaces[ray], light);
                deferred.transmittance[ray * deferred.transmittance_words as usize + light as usize] = tint;
                tint != 0
            } else {
                brute.is_lit(RayIndex(ray as u32), &deferred.surfaces[ray], light)
            };
            mask[(light / LIGHTS_PER_WORD) as usize] |= u32::from(lit) << (light % LIGHTS_PER_WORD);
        }
    }
    compare(request, &expected, picture)
}
