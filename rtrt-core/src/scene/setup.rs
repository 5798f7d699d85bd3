//! The numbers of one frame: views, grids, sizes.

use crate::grid::{BLOCK_RAYS, Grid};
use crate::kernel::geometry::Geometry;
use crate::layout::{AlphaKind, Backdrop, Frame, Instance, View};
use crate::num::exp2;
use crate::request::{Request, Shading, Shadows};
use crate::scene::cut::BvhCut;
use crate::scene::floor::floored;
use crate::scene::levels::LodSelection;
use crate::scene::light::is_color;
use crate::scene::setup_error::{MAX_LAYERS, MAX_STOPS, SetupError};
use crate::scene::views::{Asked, Lights, light_views, mark};
use crate::scene::{Mip, Occluders, Scene, Structure};
use crate::stage::occlusion::LIGHTS_PER_WORD;
use alloc::vec::Vec;
use bytemuck::Zeroable;
use glam::Vec3;

/// A frame, ready for the stages: its numbers and its views. Reuses its memory from frame to frame.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The numbers.
    pub frame: Frame,
    /// The camera, then six views a light.
    pub views: Vec<View>,
    /// The key of the views of lights.
    lights: Option<Lights>,
    /// The instances with the levels of detail of this frame, where there are any.
    lods: LodSelection,
    cut: BvhCut,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            frame: Frame::zeroed(),
            views: Vec::new(),
            lights: None,
            lods: LodSelection::default(),
            cut: BvhCut::default(),
        }
    }
}

impl Setup {
    /// The most pixels in a row, and the most rows.
    pub const MAX_SIDE: u32 = 16_384;
    /// The most lights in a scene.
    pub const MAX_LIGHTS: usize = 1024;
    /// The most layers of surfaces that a ray looks at.
    pub const MAX_LAYERS: u32 = MAX_LAYERS;
    /// The most stops by which light is raised or lowered.
    pub const MAX_STOPS: f32 = MAX_STOPS;

    /// The instances of the frame: the scene's, with the levels of detail that the camera sees; then
    /// their parts, where the camera's lists hold those.
    pub fn instances<'a>(&'a self, scene: &'a Scene) -> &'a [Instance] {
        if self.cut.triangles.is_some() { self.cut.instances() } else { self.lods.instances(scene) }
    }

    /// What rays of the frame meet.
    pub fn geometry<'a>(&'a self, scene: &'a Scene) -> Geometry<'a> {
        Geometry {
            instances: self.instances(scene),
            nodes: scene.nodes(),
            mesh_data: scene.mesh_data(),
            positions: scene.positions(),
            texels: scene.texels(),
            magnitude: self.frame.magnitude,
        }
    }

    /// Whether lists hold whole instances, whatever [`Structure`] says.
    pub fn keep_instances_closed(&mut self, are_whole: bool) {
        self.cut.are_refused = are_whole;
    }

    /// The largest number of triangles of a part of an instance; `None` where lists hold whole instances.
    pub fn cut_triangles(&self) -> Option<u32> {
        self.cut.triangles
    }

    /// A number that changes with the chosen levels of detail; 0 for a scene without any.
    /// [`Setup::instances`] depend on this, on [`Setup::cut_triangles`] and on the scene alone.
    pub fn lod_revision(&self) -> u32 {
        if self.lods.is_needed { self.lods.changes } else { 0 }
    }

    /// Sets up the frame that a request asks for.
    ///
    /// # Errors
    /// Camera, lights or sizes are not usable; see [`SetupError`].
    pub fn prepare(&mut self, scene: &Scene, request: &Request<'_>) -> Result<(), SetupError> {
        let Request {
            camera,
            size: [width, height],
            samples,
            shading,
            shadows,
            layers,
            exposure,
            tone_map,
            clip: [near, far],
            ambient_occlusion,
            deferred: _,
            stop: _,
        } = *request;
        let side = match samples {
            1 => 1,
            4 => 2,
            16 => 4,
            _ => return Err(SetupError::Samples { samples }),
        };
        if !(1..=Self::MAX_SIDE).contains(&width) || !(1..=Self::MAX_SIDE).contains(&height) {
            return Err(SetupError::Size { width, height });
        }
        if !(1..=Self::MAX_LAYERS).contains(&layers) {
            return Err(SetupError::Layers { layers });
        }
        for (what, value) in [("ambient light", scene.ambient), ("background", scene.background)] {
            if !is_color(value) {
                return Err(SetupError::Color { what, value });
            }
        }
        for (what, value, low, high) in [
            ("rotation", scene.environment_rotation, -1024.0, 1024.0),
            ("intensity", scene.environment_intensity, 0.0, 4_294_967_296.0),
            ("blur", scene.environment_blur, 0.0, 1.0),
            ("strength in the background", scene.backdrop_strength, 0.0, 65_536.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(SetupError::Environment { what, value, low, high });
            }
        }
        let [sky_cosine, sky_sine] = turn(scene.environment_rotation);
        if let Occluders::Near(value) = scene.occluders
            && value.is_nan()
        {
            return Err(SetupError::Distance { value });
        }
        if exposure.is_nan() || exposure.abs() > Self::MAX_STOPS {
            return Err(SetupError::Exposure { stops: exposure });
        }
        if !(near >= 0.0 && near < far) {
            return Err(SetupError::Clip { near, far });
        }
        if ambient_occlusion != 0.0 && !(LEAST_REACH..=MOST_REACH).contains(&ambient_occlusion) {
            return Err(SetupError::AmbientReach { reach: ambient_occlusion });
        }
        let is_lit_around = scene.sky().first != 0 || scene.ambient.map(floored) != Vec3::ZERO;
        let has_ambient_rays = ambient_occlusion > 0.0 && is_lit_around && !scene.instances().is_empty();
        let lights = scene.lights();
        if lights.len() > Self::MAX_LIGHTS {
            return Err(SetupError::Lights { lights: lights.len(), limit: Self::MAX_LIGHTS });
        }
        let grid = Grid { width, height, side };
        let rays = u64::from(grid.blocks()) * u64::from(BLOCK_RAYS);
        if rays > 1 << 31 {
            return Err(SetupError::Rays { rays });
        }
        self.lods.choose(scene, camera.eye);
        let has_bounds = self.lods.is_needed && !self.lods.bounds.is_empty();
        let bounds = if has_bounds { self.lods.bounds } else { scene.bounds() };
        let chosen = self.lod_revision();
        let [first_seen, seen] = self.cut.prepare(scene, self.lods.instances(scene), chosen)?;
        let is_one_list = scene.structure == Structure::None;
        let by_angle = u32::from(scene.mip == Mip::Angle);
        let eye = View { by_angle, ..camera.view(grid)? };
        let light_blocks = {
            let asked = Asked { shadows, has_ambient_rays };
            light_views(&mut self.views, &mut self.lights, scene, &bounds, asked, eye)?
        };
        let camera = &mut self.views[Frame::CAMERA as usize];
        if is_one_list {
            [camera.width, camera.height] = [1, 1];
        }
        camera.first_block = light_blocks;
        mark(scene, camera);
        let blocks = light_blocks + camera.width * camera.height;
        let centers = self.views.iter().flat_map(|view| view.center.map(|c| c.abs() + view.disc));
        let corners = bounds.low.into_iter().chain(bounds.high);
        let magnitude = centers.chain(corners).fold(0.0_f32, |most, c| most.max(c.abs()));
        let has_radius = lights.iter().any(|light| light.radius > 0.0);
        let is_soft = shadows == Shadows::Soft && has_radius;
        let background = if scene.backdrop == Backdrop::Nothing { Vec3::ZERO } else { scene.background };
        let ([ambient_r, ambient_g, ambient_b], [background_r, background_g, background_b]) =
            (scene.ambient.map(floored).to_array(), background.map(floored).to_array());
        let frame = Frame {
            width,
            height,
            side,
            views: self.views.len() as u32,
            instances: scene.instances().len() as u32,
            lights: lights.len() as u32,
            blocks,
            mask_words: (lights.len() as u32).div_ceil(LIGHTS_PER_WORD).max(1),
            shadows: u32::from(shadows != Shadows::Off),
            rays: grid.rays(),
            ambient_r,
            ambient_g,
            ambient_b,
            background_r,
            background_g,
            background_b,
            magnitude,
            first_seen,
            seen,
            details: u32::from(scene.has_details()),
            extensions: scene.extensions(),
            sky_first: scene.sky().first,
            sky_side: scene.sky().side,
            sky_levels: scene.sky().levels,
            // A masked surface is opaque where it has no hole.
            layers: match scene.see_through() {
                AlphaKind::Opaque => 0,
                AlphaKind::Mask => 1,
                AlphaKind::Blend => layers,
            },
            backdrop: scene.backdrop as u32,
            penumbra_window: if is_soft { Frame::PENUMBRA_WINDOW * side } else { 0 },
            sky_cosine,
            sky_sine,
            sky_intensity: floored(scene.environment_intensity),
            backdrop_blur: floored(scene.environment_blur),
            backdrop_strength: floored(scene.backdrop_strength),
            exposure: exp2(exposure),
            tone_map: tone_map as u32,
            near: floored(near),
            far: floored(far.min(f32::MAX)),
            ambient_view: if has_ambient_rays { 1 + lights.len() as u32 * Frame::VIEWS_PER_LIGHT } else { 0 },
            ambient_reach: ambient_occlusion,
            ..Frame::zeroed()
        };
        let is_hard = !has_radius || matches!(shadows, Shadows::Off | Shadows::Hard);
        let is_one_layer = frame.layers_behind() == 0 && frame.records() == 1;
        let can_share = side > 1 && is_hard && is_one_layer && !has_ambient_rays;
        let is_shared = can_share && shading == Shading::Pixel;
        if is_shared {
            // A color stands for a pixel, not for a sub-ray.
            let camera = &mut self.views[Frame::CAMERA as usize];
            camera.pixel *= side as f32;
            camera.pixel_t *= side as f32;
        }
        self.frame = Frame { is_shared: u32::from(is_shared), ..frame };
        Ok(())
    }
}

/// The least distance up to which surfaces may hide ambient light, 2⁻⁶⁰: its reciprocal is finite, and products with it
/// are not denormal.
const LEAST_REACH: f32 = 1.0 / 1_152_921_504_606_846_976.0;
/// The largest, 2⁶⁰.
const MOST_REACH: f32 = 1_152_921_504_606_846_976.0;

/// Cosine and sine of an angle in radians; exact where it is a right angle as far as `f32` tells.
fn turn(angle: f32) -> [f32; 2] {
    let (sine, cosine) = libm::sincos(f64::from(angle));
    [cosine, sine].map(|c| if c.abs() < 1e-6 { 0.0 } else { c as f32 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Light, Material, Projection};

    /// The first denormal number: devices may flush it.
    fn denormal<'a>(numbers: impl IntoIterator<Item = &'a f32>) -> Option<&'a f32> {
        numbers.into_iter().find(|number| number.is_subnormal())
    }

    #[test]
    fn a_removed_environment_leaves_what_was_before() {
        let camera = Camera {
            eye: Vec3::Z,
            look_at: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::Perspective { fov_y: 1.0 },
        };
        let mut scene = Scene::new();
        let frame = |scene: &Scene| {
            let mut setup = Setup::default();
            setup.prepare(scene, &Request::new(&camera, [32, 16])).unwrap();
            setup.frame
        };
        let before = frame(&scene);
        scene.set_environment(&crate::scene::studio().0).unwrap();
        assert_ne!(frame(&scene).sky_first, before.sky_first);
        scene.remove_environment();
        assert_eq!(frame(&scene), before);
    }

    #[test]
    fn the_footprint_of_a_shared_color_is_a_pixel() {
        for projection in [Projection::Perspective { fov_y: 1.0 }, Projection::Orthographic { height: 3.0 }] {
            let camera = Camera { eye: Vec3::Z, look_at: Vec3::ZERO, up: Vec3::Y, projection };
            let footprint = |samples: u32, shading: Shading| {
                let mut setup = Setup::default();
                let request = Request::new(&camera, [32, 16]).samples(samples).shading(shading);
                setup.prepare(&Scene::new(), &request).unwrap();
                let View { pixel, pixel_t, .. } = setup.views[Frame::CAMERA as usize];
                [pixel, pixel_t]
            };
            let pixel = footprint(1, Shading::Sample);
            assert!(pixel != [0.0; 2]);
            for (samples, part) in [(1, 1.0), (4, 0.5), (16, 0.25)] {
                assert_eq!(footprint(samples, Shading::Pixel), pixel);
                assert_eq!(footprint(samples, Shading::Sample), pixel.map(|c| c * part));
            }
        }
    }

    #[test]
    fn nothing_that_kernels_read_is_denormal() {
        let small = Vec3::new(1e-40, 1e-30, -1e-39);
        let mut scene = Scene::new();
        (scene.ambient, scene.background) = (small, small);
        for reach in [None, Some(1e-40), Some(1e-30), Some(3e38)] {
            scene.add_light(Light::point(small).color(small).reach(reach).inverse_square(true).radius(1e-40));
        }
        scene.add_light(Light::sun(Vec3::Y + small).color(small).radius(1e-40));
        let mut material = Material::new([1e-40; 3]).roughness(0.5).emission(small.to_array());
        material.specular_strength = 1e-40;
        scene.add_material(material).unwrap();
        let camera = Camera {
            eye: small,
            look_at: small + Vec3::X,
            up: Vec3::Y + small,
            projection: Projection::Orthographic { height: 1.0 },
        };
        let mut setup = Setup::default();
        let request = Request::new(&camera, [32, 16]).shadows(Shadows::Area { jitter: Some(1) });
        setup.prepare(&scene, &request).unwrap();
        for view in &setup.views {
            let vectors = [
                view.center,
                view.x,
                view.y,
                view.w,
                view.depth,
                view.start,
                view.start_x,
                view.start_y,
                view.along,
                view.along_x,
                view.along_y,
                view.color,
            ];
            assert_eq!(denormal(vectors.as_flattened()), None, "{view:?}");
            let numbers =
                [view.inv_reach, view.reach_squared, view.pixel, view.radius, view.disc, view.margin];
            assert_eq!(denormal(&numbers), None, "{view:?}");
        }
        let Frame { ambient_r, ambient_g, ambient_b, .. } = setup.frame;
        let Frame { background_r, background_g, background_b, magnitude, .. } = setup.frame;
        assert_eq!([ambient_r, ambient_g, ambient_b], [0.0; 3]);
        assert_eq!([background_r, background_g, background_b], [0.0; 3]);
        assert_eq!(denormal(&[magnitude]), None);
        let material = &scene.materials()[0];
        let colors = [material.base, material.specular, material.emission];
        assert_eq!((denormal(colors.as_flattened()), material.strength), (None, 0.0));
    }

    #[test]
    fn refuses_what_is_no_number_or_would_overflow() {
        let camera = Camera {
            eye: Vec3::Z,
            look_at: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::Perspective { fov_y: 1.0 },
        };
        let prepare = |change: &dyn Fn(&mut Scene)| {
            let mut scene = Scene::new();
            scene.add_light(Light::sun(Vec3::Y));
            scene.add_light(Light::point(Vec3::ZERO).inverse_square(true));
            change(&mut scene);
            Setup::default().prepare(&scene, &Request::new(&camera, [8, 8]).shadows(Shadows::Hard))
        };
        assert_eq!(prepare(&|_| ()), Ok(()));
        let limit = crate::layout::LIGHT_LIMIT;
        for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e38, -3e38, limit * 2.0] {
            let bad = Vec3::new(0.0, bad, 0.0);
            let color = |number: usize, to: Vec3| prepare(&|scene| scene.lights_mut()[number].color = to);
            for refused in
                [color(0, bad), color(1, bad), prepare(&|scene| scene.lights_mut()[1].position = bad)]
            {
                assert!(matches!(refused, Err(SetupError::Light { .. })), "{bad} {refused:?}");
            }
            for refused in [prepare(&|scene| scene.ambient = bad), prepare(&|scene| scene.background = bad)] {
                assert!(matches!(refused, Err(SetupError::Color { .. })), "{bad} {refused:?}");
            }
            assert_eq!((color(0, Vec3::splat(limit)), color(1, Vec3::splat(-limit))), (Ok(()), Ok(())));
        }
        let near = prepare(&|scene| scene.occluders = Occluders::Near(f32::NAN));
        assert!(matches!(near, Err(SetupError::Distance { .. })));
    }

    #[test]
    fn refuses_more_rays_than_can_be_numbered() {
        let camera = Camera {
            eye: [0.0, 0.0, 1.0].into(),
            look_at: [0.0; 3].into(),
            up: [0.0, 1.0, 0.0].into(),
            projection: Projection::Perspective { fov_y: 1.0 },
        };
        let mut setup = Setup::default();
        for [near, far] in [[-1.0, 1.0], [f32::NAN, 1.0], [1.0, 1.0], [0.0, f32::NAN], [f32::INFINITY; 2]] {
            let refused = setup.prepare(&Scene::new(), &Request::new(&camera, [9, 9]).clip(near, far));
            assert!(matches!(refused, Err(SetupError::Clip { .. })), "{near} {far}");
        }
        setup.prepare(&Scene::new(), &Request::new(&camera, [9, 9]).clip(0.5, f32::INFINITY)).unwrap();
        assert_eq!((setup.frame.near, setup.frame.far), (0.5, f32::MAX));
        let none = setup.prepare(&Scene::new(), &Request::new(&camera, [9, 9]).layers(0));
        assert_eq!(none, Err(SetupError::Layers { layers: 0 }));
        let mut prepare =
            |size, samples| setup.prepare(&Scene::new(), &Request::new(&camera, size).samples(samples));
        assert!(matches!(prepare([16_384, 16_384], 16), Err(SetupError::Rays { .. })));
        assert!(matches!(prepare([0, 9], 1), Err(SetupError::Size { .. })));
        assert!(matches!(prepare([9, 9], 2), Err(SetupError::Samples { samples: 2 })));
        assert_eq!(prepare([16_384, 16_384], 4), Ok(()));
    }
}
