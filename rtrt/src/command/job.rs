//! A scene with a camera and settings, ready to render.

use super::Error;
use super::console::Console;
use super::options::{BackendOptions, CameraOptions, Common};
#[cfg(feature = "viewer")]
use super::parse::Environment;
use super::parse::{AmbientOcclusion, Exposure};
use super::repaint::{self, Repaint};
use super::report::{Machine, counted};
use super::stream;
use super::surroundings::{Surrounded, surrounded};
use super::views::{View, Viewpoint};
use glam::{DVec3, Mat4};
use rtrt::cache::Cache;
use rtrt::choose::{self, ChooseError, Chosen, choose};
use rtrt::debug::{DebugImage, DebugView, show};
use rtrt::demo;
use rtrt::import::{self, Animation, ImportError, Label, Loaded, NamedCamera, Pose};
use rtrt::layers::MOST_RAYS;
use rtrt_core::backend::{Backend, Picture, Request, Shading, Shadows, ToneMap};
use rtrt_core::layout::Kind;
use rtrt_core::scene::{Camera, InstanceIndex, LightKind, Projection, Scene, Setup};
use rtrt_cpu::{Cpu, Parallel};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Deref, DerefMut};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// The limit of rays of a frame. They have 32-bit numbers, and blocks may reach outside of the frame.
const MAX_RAYS: u64 = 1 << 31;

/// A scene that pictures in progress may share. A change while they do makes a copy.
#[derive(Debug)]
pub struct Shared(Arc<Scene>);

impl Deref for Shared {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        &self.0
    }
}

impl DerefMut for Shared {
    fn deref_mut(&mut self) -> &mut Scene {
        Arc::make_mut(&mut self.0)
    }
}

/// A scene with a camera and settings.
pub struct RenderJob {
    pub scene: Shared,
    /// What the scene's coordinates are relative to, in those of the file.
    pub origin: DVec3,
    pub camera: Camera,
    pub size: [u32; 2],
    pub samples: u32,
    pub shadows: Shadows,
    /// The most surfaces along a ray.
    pub layers: u32,
    /// The exposure, stops.
    pub exposure: f32,
    pub tone_map: ToneMap,
    /// The depths of the near and the far plane.
    pub clip: [f32; 2],
    /// From how far away surfaces hide ambient light; 0 for not at all.
    pub ambient_reach: f32,
    /// The number of rays from the camera.
    pub rays: u64,
    /// Milliseconds, of [`Self::load_ms`].
    pub bvh_build_ms: f64,
    /// The time in which the scene became ready to render, milliseconds.
    pub load_ms: f64,
    /// Whether the lights come from the file.
    own_lights: bool,
    /// What surrounds the scene.
    pub surrounded: Surrounded,
    animation: Option<Animation>,
    cameras: Vec<NamedCamera>,
    /// Which of the cameras is used; none for one that is none of them.
    camera_number: Option<usize>,
    /// What the file calls its instances.
    pub labels: Vec<Label>,
    /// The files of the scene and its environment.
    files: Vec<PathBuf>,
    /// The objects that are not drawn, with their transforms.
    pub hidden: BTreeMap<u32, Mat4>,
    common: Common,
}

impl RenderJob {
    /// Loads the scene of the options, and applies the options to it. `samples` is the default of sub-rays,
    /// `deferred` says whether deferred buffers will be needed, and `time` is the time of the animation.
    pub fn load(
        common: &Common,
        samples: u32,
        deferred: bool,
        time: Option<f64>,
        console: &Console,
    ) -> Result<Self, Error> {
        let start = Instant::now();
        let samples = common.samples.unwrap_or(samples);
        let rays = rays(common.size, samples, deferred)?;
        console.step(format_args!("loading {}", common.scene.display()));
        let mut loaded = load(common, console)?;
        for warning in &loaded.warnings {
            console.warn(3, warning)?;
        }
        console.detail(format_args!(
            "scene: {}, {} stored, {} drawn; the BVHs took {:.1} ms",
            counted(loaded.scene.instances().len() as u64, "object"),
            counted(loaded.scene.triangles(), "triangle"),
            loaded.scene.drawn_triangles(),
            loaded.bvh_build_ms
        ));
        choose_animation(common, &mut loaded, time.is_some(), console)?;
        let camera_number = camera_number(common, &loaded.cameras)?;
        let camera = camera(common, &mut loaded, camera_number, time.is_some())?;
        let clip = file_clip(&common.camera, loaded.cameras.get(camera_number));
        let Loaded { mut scene, origin, cameras, mut labels, animation, files, bvh_build_ms, .. } = loaded;
        let own_lights = common.lights.is_empty() && !scene.lights().is_empty();
        if !common.lights.is_empty() {
            *scene.lights_mut() = common.lights.iter().map(|light| light.relative_to(origin)).collect();
        }
        if let Some(size) = common.light_radius {
            for light in scene.lights_mut() {
                if light.kind != LightKind::Sun {
                    light.radius = size;
                }
            }
        }
        let surrounded = surrounded(&mut scene, common)?;
        let files: Vec<_> = files.into_iter().chain(surrounded.surroundings.files.iter().cloned()).collect();
        console.detail(format_args!("read from {}", counted(files.len() as u64, "file")));
        if let Some(ambient) = common.ambient {
            scene.ambient = ambient;
        }
        let ambient_reach = ambient_reach(common, &scene);
        if animation.is_none() && time.is_some() {
            console.warn(3, "nothing in the scene is animated")?;
        }
        if common.surroundings.ground {
            let path = &common.scene;
            let ground = import::add_ground(&mut scene)
                .map_err(|source| ImportError::Scene { path: path.clone(), source })?;
            labels.extend(ground.map(|_| added("ground")));
        }
        scene.mip = common.mip;
        scene.occluders = common.sun_shadows;
        scene.structure = common.structure;
        show_lights(&mut scene, common)?;
        let mut job = Self {
            scene: Shared(Arc::new(scene)),
            origin,
            camera,
            size: common.size,
            samples,
            rays,
            shadows: common.shadows(),
            // A ground that counts as opaque would be black.
            layers: common.transparency_depth.max(1 + u32::from(common.surroundings.ground)),
            bvh_build_ms,
            load_ms: 0.0,
            own_lights,
            exposure: match common.exposure {
                Exposure::Stops(stops) => stops,
                Exposure::Auto => 0.0,
            },
            tone_map: common.tone_map,
            clip,
            ambient_reach,
            surrounded,
            animation,
            cameras,
            camera_number: Some(camera_number),
            labels,
            files,
            hidden: BTreeMap::new(),
            common: common.clone(),
        };
        for repaint in &common.materials {
            job.repaint(repaint)?;
        }
        if let Some(time) = time {
            job.play(time)?;
        }
        for number in &common.hide {
            job.hide(*number)?;
        }
        if job.common.shading == Shading::Pixel && job.samples > 1 && !job.shares() {
            console.warn(
                3,
                "--shading pixel is not possible with soft shadows, ambient occlusion or transparency: each sample is shaded",
            )?;
        }
        job.load_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(job)
    }

    /// Shows the animation at a time, seconds. The camera of a scene without cameras does not move.
    pub fn play(&mut self, time: f64) -> Result<(), Error> {
        match &self.animation {
            Some(animation) => self.pose(animation.at(time)?),
            None => Ok(()),
        }
    }

    /// Moves what an animation moves.
    fn pose(&mut self, pose: Pose) -> Result<(), Error> {
        pose.apply(&mut self.scene)?;
        if self.own_lights {
            pose.aim(self.scene.lights_mut());
            show_lights(&mut self.scene, &self.common)?;
        }
        for &number in self.hidden.keys() {
            hide(&mut self.scene, &self.common, number)?;
        }
        for (index, camera) in pose.cameras {
            self.cameras[index].camera = camera;
        }
        self.aim();
        Ok(())
    }

    /// Hides an object.
    pub fn hide(&mut self, number: u32) -> Result<(), Error> {
        let transform = self.scene.instances().get(number as usize).map(|instance| {
            let [x, y, z] = instance.to_world;
            Mat4::from_cols_array_2d(&[x, y, z, [0.0, 0.0, 0.0, 1.0]]).transpose()
        });
        hide(&mut self.scene, &self.common, number)?;
        // One that is hidden already has lost its transform.
        self.hidden.entry(number).or_insert(transform.unwrap_or_default());
        Ok(())
    }

    /// Changes a material.
    pub fn repaint(&mut self, repaint: &Repaint) -> Result<(), Error> {
        let path = &self.common.scene;
        let used = self.scene.instances().iter().map(|instance| instance.material);
        let unknown = || unknown(&self.common, "material", repaint.number, used.clone().collect());
        let index = repaint::material(&self.scene, repaint.number).ok_or_else(unknown)?;
        let material = repaint.applied(self.scene.material(index).ok_or_else(unknown)?);
        let changed = self.scene.set_material(index, material);
        Ok(changed.map_err(|source| ImportError::Scene { path: path.clone(), source })?)
    }

    /// Takes the chosen camera of the file as it is now.
    fn aim(&mut self) {
        if let Some(named) = self.camera_number.and_then(|number| self.cameras.get(number)) {
            let options = &self.common.camera;
            self.clip = file_clip(options, Some(named));
            self.camera = changed(named.fitted(aspect(self.size)), options, &self.scene, self.origin);
        }
    }

    /// Looks from a view, in its size. The animation stays at its time.
    pub fn look(&mut self, view: &View, deferred: bool) -> Result<(), Error> {
        self.size = view.size.unwrap_or(self.common.size);
        self.rays = rays(self.size, self.samples, deferred)?;
        match view.from {
            Viewpoint::Options => {}
            Viewpoint::File(number) => {
                self.camera_number = Some(number);
                self.aim();
            }
            Viewpoint::Camera(camera, clip) => {
                (self.camera_number, self.camera) = (None, camera);
                self.clip = clipped(&self.common.camera, clip);
            }
        }
        Ok(())
    }

    /// What an object is called.
    pub fn label(&self, number: usize) -> Label {
        let kind = self.scene.instances().get(number).map_or(0, |instance| instance.kind);
        match kind.checked_sub(Kind::Light as u32) {
            Some(light) => added(&format!("light {light}")),
            None => self.labels.get(number).cloned().unwrap_or_default(),
        }
    }

    /// The names of the file's cameras.
    pub fn camera_names(&self) -> Vec<String> {
        self.cameras.iter().map(|camera| camera.name.clone()).collect()
    }

    /// The name of the camera in use, if the file has it.
    pub fn camera_name(&self) -> Option<&str> {
        self.camera_number.and_then(|number| self.cameras.get(number)).map(|camera| camera.name.as_str())
    }

    /// Whether nothing but the bounds of the scene decides where the camera is.
    pub fn is_framed(&self) -> bool {
        let CameraOptions { eye, look_at, .. } = self.common.camera;
        self.cameras.is_empty() && eye.is_none() && look_at.is_none()
    }

    /// Width / height of pictures.
    pub fn aspect(&self) -> f32 {
        aspect(self.size)
    }

    /// The files of the scene and its environment.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Whether sub-rays of a pixel are shaded as one.
    fn shares(&self) -> bool {
        let mut setup = Setup::default();
        setup.prepare(&self.scene, &self.request(false)).is_err() || setup.frame.is_shared == 1
    }

    /// The request for a frame.
    pub fn request(&self, deferred: bool) -> Request<'_> {
        Request::new(&self.camera, self.size)
            .samples(self.samples)
            .shading(self.common.shading)
            .shadows(self.shadows)
            .layers(self.layers)
            .exposure(self.exposure)
            .tone_map(self.tone_map)
            .clip(self.clip[0], self.clip[1])
            .ambient_occlusion(self.ambient_reach)
            .deferred(deferred)
    }

    /// Renders a frame for the request.
    pub fn render(
        &self,
        backend: &mut dyn Backend,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), Error> {
        backend
            .render(&self.scene, request, picture)
            .map_err(|source| Error::Render { scene: self.common.scene.clone(), source })
    }

    /// Meters the exposure if the options say `auto`.
    pub fn expose(&mut self, backend: &mut dyn Backend, console: &Console) -> Result<(), Error> {
        if self.common.exposure == Exposure::Auto {
            self.meter(backend)?;
            console.say(format_args!("exposure: {}", stops(self.exposure)));
        }
        Ok(())
    }

    /// Meters the exposure from the current camera.
    pub fn meter(&mut self, backend: &mut dyn Backend) -> Result<(), Error> {
        let metered = backend.meter(&self.scene, &self.request(false));
        self.exposure =
            metered.map_err(|source| Error::Render { scene: self.common.scene.clone(), source })?;
        Ok(())
    }

    /// A debug view of a picture with its deferred buffers.
    pub fn show(&self, view: DebugView, picture: &Picture) -> Result<DebugImage, Error> {
        let shown = show(view, &self.scene, &self.request(true), picture);
        let shown = shown
            .map_err(|error| Error::Render { scene: self.common.scene.clone(), source: error.into() })?;
        shown.ok_or(Error::Usage("a debug view needs the deferred buffers"))
    }
}

/// The number of rays of a frame. An error if it exceeds the limit, which is lower with deferred buffers.
pub fn rays(size: [u32; 2], samples: u32, deferred: bool) -> Result<u64, Error> {
    let rays = size.map(u64::from).iter().product::<u64>() * u64::from(samples);
    if rays > MAX_RAYS {
        return Err(Error::TooLarge { rays, limit: MAX_RAYS, may: "can be numbered" });
    }
    if deferred && rays > MOST_RAYS {
        return Err(Error::TooLarge { rays, limit: MOST_RAYS, may: "can have deferred buffers" });
    }
    Ok(rays)
}

/// Changes by the viewer.
#[cfg(feature = "viewer")]
impl RenderJob {
    /// What a picture of the scene as it is needs. It cannot be changed.
    pub fn still(&self) -> Self {
        Self {
            scene: Shared(Arc::clone(&self.scene.0)),
            surrounded: Surrounded::default(),
            animation: None,
            cameras: Vec::new(),
            labels: Vec::new(),
            files: Vec::new(),
            hidden: BTreeMap::new(),
            common: self.common.clone(),
            ..*self
        }
    }

    /// Moves the spheres that show lights to their lights.
    pub fn lights_changed(&mut self) -> Result<(), Error> {
        show_lights(&mut self.scene, &self.common)
    }

    /// Turns and brightens the environment, its sun included.
    pub fn turn_environment(&mut self, rotation: f32, intensity: f32) {
        let scene = &mut self.scene;
        (scene.environment_rotation, scene.environment_intensity) = (rotation, intensity);
        let Surrounded { surroundings, sun, .. } = &self.surrounded;
        let placed = surroundings.placed_sun(scene);
        let light = sun.and_then(|sun| scene.lights_mut().get_mut(sun));
        if let (Some(light), Some(placed)) = (light, placed) {
            (light.direction, light.color) = (placed.direction, placed.color);
        }
    }

    /// Draws an object again.
    pub fn unhide(&mut self, number: u32) -> Result<(), Error> {
        let Some(transform) = self.hidden.remove(&number) else { return Ok(()) };
        let path = &self.common.scene;
        let object = object(&self.scene, &self.common, number)?;
        let shown = self.scene.set_transform(object, transform);
        Ok(shown.map_err(|source| ImportError::Scene { path: path.clone(), source })?)
    }

    /// Surrounds the scene with another environment, whose sun replaces that of the one before. It is turned, and as bright,
    /// as that was.
    pub fn surround_with(&mut self, environment: Environment) -> Result<(), Error> {
        let lights = self.scene.lights().to_vec();
        if let Some(sun) = self.surrounded.sun.filter(|sun| *sun < lights.len()) {
            self.scene.lights_mut().remove(sun);
        }
        let mut common = self.common.clone();
        common.surroundings.environment = Some(environment);
        common.surroundings.rotation = self.scene.environment_rotation;
        common.surroundings.intensity = self.scene.environment_intensity;
        match surrounded(&mut self.scene, &common) {
            Ok(surrounded) => (self.surrounded, self.common) = (surrounded, common),
            Err(error) => {
                *self.scene.lights_mut() = lights;
                return Err(error);
            }
        }
        Ok(())
    }

    /// The names of the animations.
    pub fn animation_names(&self) -> &[String] {
        self.animation.as_ref().map_or(&[], Animation::names)
    }

    /// The number of the animation that is played; none for all.
    pub fn played_animation(&self) -> Option<usize> {
        self.animation.as_ref().and_then(Animation::played_number)
    }

    /// Chooses an animation by its number, or all at once. What the one before has moved goes back.
    pub fn choose_animation(&mut self, number: Option<usize>) -> Result<(), Error> {
        if let Some(animation) = &mut self.animation {
            let pose = animation.unplayed()?;
            animation.play(number);
            self.pose(pose)?;
        }
        Ok(())
    }

    /// Looks from a camera of the file.
    pub fn choose_camera(&mut self, number: usize) {
        self.camera_number = Some(number);
        self.common.camera = CameraOptions::default();
        self.aim();
    }

    /// Whether the file has cameras.
    pub fn has_cameras(&self) -> bool {
        !self.cameras.is_empty()
    }

    /// The end of the animation, seconds, if there is one.
    pub fn end(&self) -> Option<f64> {
        self.animation.as_ref().map(Animation::end)
    }
}

/// Loads the scene of the options. Their number of threads builds its BVHs.
fn load(common: &Common, console: &Console) -> Result<Loaded, Error> {
    let threads = common.backend.threads();
    let pool = Cpu::new(rtrt_cpu::Options { lanes: None, threads }).map_err(ChooseError::Cpu)?;
    let cache = match common.cache.as_deref().map(|folder| (folder, Cache::new(folder))) {
        None => None,
        Some((_, Ok(cache))) => Some(cache),
        Some((folder, Err(error))) => {
            console.warn(1, format_args!("no cache at {}: {error}", folder.display()))?;
            None
        }
    };
    let name = &common.scene;
    let options = import::Options { cache: cache.as_ref(), point_size: common.point_size };
    let loaded = match name.to_str().and_then(|name| name.strip_prefix("demo:")) {
        Some("matchbox") => pool.install(|| demo::matchbox(&Parallel))?,
        Some("glass") => pool.install(|| demo::glass(&Parallel))?,
        Some("spheres") => pool.install(|| demo::spheres(&Parallel))?,
        Some("levels") => pool.install(|| demo::levels(&Parallel))?,
        Some("moving") => pool.install(|| demo::moving(&Parallel))?,
        Some(unknown) => return Err(Error::Demo { name: unknown.into() }),
        None if stream::is_stream(name) => {
            let bytes = stream::read(name);
            let bytes = bytes.map_err(|source| ImportError::Unreadable { path: name.clone(), source })?;
            pool.install(|| import::load_bytes(name, &bytes, &Parallel, &options))?
        }
        None => pool.install(|| import::load_with(name, &Parallel, &options))?,
    };
    if loaded.scene.drawn_triangles() > 0 {
        Ok(loaded)
    } else {
        Err(Error::Blank { scene: name.clone(), warnings: loaded.warnings })
    }
}

/// Chooses the animation of the options: by its name, else by its number, else all.
fn choose_animation(
    common: &Common,
    loaded: &mut Loaded,
    plays: bool,
    console: &Console,
) -> Result<(), Error> {
    let names = loaded.animation.as_ref().map_or(&[][..], Animation::names).to_vec();
    let Some(asked) = &common.animation else {
        if plays && names.len() > 1 {
            let count = names.len();
            console
                .warn(3, format_args!("of {count} animations, the first is played; --animation chooses"))?;
        }
        return Ok(());
    };
    let number = asked.parse().ok().filter(|number| *number < names.len());
    let number = names.iter().position(|name| name == asked).or(number);
    match &mut loaded.animation {
        Some(animation) if number.is_some() || asked == "all" => animation.play(number),
        _ => {
            let (scene, asked) = (common.scene.clone(), asked.clone());
            return Err(Error::Animation { scene, asked, names });
        }
    }
    Ok(())
}

/// The label of an object that is in no file.
fn added(name: &str) -> Label {
    Label { node: name.into(), mesh: name.into(), material: name.into(), path: String::new() }
}

/// The object with a number.
fn object(scene: &Scene, common: &Common, number: u32) -> Result<InstanceIndex, Error> {
    let all = 0..scene.instances().len() as u32;
    scene.instance_index(number).ok_or_else(|| unknown(common, "object", number, all.collect()))
}

/// The error for a number that is not among these.
fn unknown(common: &Common, what: &'static str, asked: u32, known: BTreeSet<u32>) -> Error {
    Error::Number { scene: common.scene.clone(), what, asked, known: known.into_iter().collect() }
}

/// Hides an object.
fn hide(scene: &mut Scene, common: &Common, number: u32) -> Result<(), Error> {
    let path = &common.scene;
    let object = object(scene, common, number)?;
    Ok(scene.hide(object).map_err(|source| ImportError::Scene { path: path.clone(), source })?)
}

/// Shows lights with a radius as spheres, with `--show-lights`.
fn show_lights(scene: &mut Scene, common: &Common) -> Result<(), Error> {
    for light in (0..scene.lights().len()).filter(|_| common.show_lights) {
        scene
            .show_light(light)
            .map_err(|source| ImportError::Scene { path: common.scene.clone(), source })?;
    }
    Ok(())
}

/// The number of the camera that the options choose: by its name, else by its number, else the first.
fn camera_number(common: &Common, cameras: &[NamedCamera]) -> Result<usize, Error> {
    let Some(asked) = &common.camera.camera else { return Ok(0) };
    let number = asked.parse().ok().filter(|number| *number < cameras.len());
    cameras.iter().position(|camera| camera.name == *asked).or(number).ok_or_else(|| Error::Camera {
        scene: common.scene.clone(),
        asked: asked.clone(),
        names: cameras.iter().map(|camera| camera.name.clone()).collect(),
    })
}

/// A camera of the scene, with the changes of the options.
fn camera(common: &Common, loaded: &mut Loaded, number: usize, plays: bool) -> Result<Camera, Error> {
    let (options, aspect) = (&common.camera, aspect(common.size));
    let chosen = match loaded.cameras.get(number) {
        Some(named) => named.fitted(aspect),
        // The camera of the import is for 16 to 9.
        None => match loaded.animation.as_ref().filter(|_| plays) {
            Some(animation) => import::framing_played(&mut loaded.scene, animation, aspect)?,
            None => import::framing(&loaded.scene, aspect),
        },
    };
    Ok(changed(chosen, options, &loaded.scene, loaded.origin))
}

/// The depths of the planes before and beyond which nothing is drawn: those of the options, else those of the file's
/// camera where the options do not move it.
fn file_clip(options: &CameraOptions, named: Option<&NamedCamera>) -> [f32; 2] {
    let own = named.filter(|_| options.eye.is_none() && options.look_at.is_none());
    clipped(options, own.map_or([0.0, f32::INFINITY], |named| named.clip))
}

/// The depths of the options, else these.
fn clipped(options: &CameraOptions, [near, far]: [f32; 2]) -> [f32; 2] {
    [options.near.unwrap_or(near), options.far.unwrap_or(far)]
}

/// From how far away surfaces of the scene hide ambient light.
fn ambient_reach(common: &Common, scene: &Scene) -> f32 {
    match common.surroundings.ambient_occlusion {
        AmbientOcclusion::Off => 0.0,
        AmbientOcclusion::Reach(reach) => reach,
        AmbientOcclusion::Auto => {
            let diagonal = scene.extent().map_or(0.0, |(low, high)| low.distance(high));
            let reach = diagonal / 16.0;
            if (1e-18..=1e18).contains(&reach) { reach } else { 0.0 }
        }
    }
}

/// An exposure, in words.
fn stops(stops: f32) -> String {
    format!("{stops} stop{}", if stops.abs() == 1.0 { "" } else { "s" })
}

/// Width / height.
fn aspect(size: [u32; 2]) -> f32 {
    size[0] as f32 / size[1] as f32
}

/// The camera with the values of the options. The scene's coordinates are relative to this origin.
fn changed(camera: Camera, options: &CameraOptions, scene: &Scene, origin: DVec3) -> Camera {
    let [eye, look_at] =
        [options.eye, options.look_at].map(|point| point.map(|point| (point - origin).as_vec3()));
    let middle = || scene.extent().map_or(camera.look_at, |(low, high)| low * 0.5 + high * 0.5);
    Camera {
        eye: eye.unwrap_or(camera.eye),
        look_at: look_at.unwrap_or_else(|| if eye.is_some() { middle() } else { camera.look_at }),
        up: options.up.unwrap_or(camera.up),
        projection: match (options.fov_y, options.parallel) {
            (Some(fov_y), _) => Projection::Perspective { fov_y },
            (None, Some(height)) => Projection::Orthographic { height },
            (None, None) => camera.projection,
        },
    }
}

/// A backend.
pub struct Opened {
    pub backend: Box<dyn Backend>,
    pub machine: Machine,
    /// Whether it is a GPU that computes on the processor.
    #[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "the viewer avoids it"))]
    pub is_software: bool,
}

/// Opens the backend of the options, and prints its name and the reason for the choice. With `hybrid` it
/// rasterizes the first surfaces.
pub fn open(options: &BackendOptions, hybrid: bool, console: &Console) -> Result<Opened, Error> {
    console.step("opening the backend");
    let Chosen { backend, why, is_software } =
        choose(&choose::Options { hybrid, ..options.choose(console.on_gpu_failure()) })?;
    let machine = Machine::from(backend.describe());
    console.say(format_args!("backend: {machine}: {why}"));
    if is_software {
        let why = "this adapter is software: it computes on the processor, and --backend cpu is faster";
        console.warn(4, why)?;
    }
    Ok(Opened { backend, machine, is_software })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_stop_is_one() {
        let said = [1.0, -1.0, 0.5, 2.0].map(stops);
        assert_eq!(said, ["1 stop", "-1 stop", "0.5 stops", "2 stops"]);
    }
}
