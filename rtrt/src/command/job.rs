//! What is rendered: a scene, loaded, and the camera chosen for it.

use super::Error;
use super::console::Console;
use super::options::{BackendOptions, CameraOptions, Common};
use super::report::Machine;
use rtrt::cache::Cache;
use rtrt::choose::{self, ChooseError, Chosen, choose};
use rtrt::debug::{DebugImage, DebugView, show};
use rtrt::demo;
use rtrt::import::{self, Animation, ImportError, Loaded, NamedCamera};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Camera, LightKind, Projection, Scene};
use rtrt_cpu::{Cpu, Parallel};
#[cfg(feature = "viewer")]
use std::path::PathBuf;

/// The most rays of a frame: they are numbered with 32 bits, those of blocks that reach
/// outside the frame included.
const MAX_RAYS: u64 = 1 << 31;
/// The most rays whose deferred buffers are kept: at about 110 bytes each, 7 GB.
const MAX_DEFERRED: u64 = 1 << 26;

/// What is rendered.
pub struct RenderJob {
    pub scene: Scene,
    pub camera: Camera,
    pub size: [u32; 2],
    pub samples: u32,
    pub shadows: Shadows,
    /// The most layers of surfaces that a ray looks at.
    pub layers: u32,
    /// Rays from the camera.
    pub rays: u64,
    /// Milliseconds.
    pub bvh_build_ms: f64,
    /// Whether the lights are those of the file.
    own_lights: bool,
    /// Whether the lights are [`import::light_by_default`]'s.
    #[cfg(feature = "viewer")]
    default_lights: bool,
    animation: Option<Animation>,
    cameras: Vec<NamedCamera>,
    /// What the scene and its environment were read from.
    #[cfg(feature = "viewer")]
    files: Vec<PathBuf>,
    common: Common,
}

impl RenderJob {
    /// Loads the scene that `common` names, and changes it as `common` says. `samples` is
    /// for where it says nothing; `deferred` is whether deferred buffers will be asked for; `time` is
    /// when, of the animation.
    pub fn load(
        common: &Common,
        samples: u32,
        deferred: bool,
        time: Option<f64>,
        console: &Console,
    ) -> Result<Self, Error> {
        let samples = common.samples.unwrap_or(samples);
        let rays = rays(common.size, samples, deferred)?;
        console.step(format_args!("loading {}", common.scene.display()));
        let mut loaded = load(common, console)?;
        for warning in &loaded.warnings {
            console.warn(3, warning)?;
        }
        console.detail(format_args!(
            "scene: {} objects, {} triangles stored, {} drawn; trees took {:.1} ms",
            loaded.scene.instances().len(),
            loaded.scene.triangles(),
            loaded.scene.drawn_triangles(),
            loaded.bvh_build_ms
        ));
        choose_animation(common, &mut loaded, time.is_some(), console)?;
        let camera = camera(common, &mut loaded, time.is_some())?;
        let Loaded { mut scene, cameras, lit_by_default, animation, files, bvh_build_ms, .. } = loaded;
        let default_lights = lit_by_default && common.lights.is_empty() && common.environment.is_none();
        if !common.lights.is_empty() {
            scene.lights_mut().clone_from(&common.lights);
        } else if default_lights {
            import::light_by_default(&mut scene, &camera);
        } else if lit_by_default {
            scene.lights_mut().clear();
        }
        if let Some(size) = common.light_radius {
            for light in scene.lights_mut() {
                if light.kind != LightKind::Sun {
                    light.radius = size;
                }
            }
        }
        let around =
            common.environment.as_ref().map(|path| import::surround(&mut scene, path)).transpose()?;
        let files: Vec<_> = files.into_iter().chain(around.into_iter().flatten()).collect();
        console.detail(format_args!("read from {} files", files.len()));
        if let Some(ambient) = common.ambient {
            scene.ambient = ambient;
        }
        if animation.is_none() && time.is_some() {
            console.warn(3, "nothing in the scene is animated")?;
        }
        scene.mip = common.mip;
        scene.occluders = common.sun_shadows;
        scene.structure = common.structure;
        show_lights(&mut scene, common)?;
        let mut job = Self {
            scene,
            camera,
            size: common.size,
            samples,
            rays,
            shadows: common.shadows(),
            layers: common.transparency_depth,
            bvh_build_ms,
            own_lights: common.lights.is_empty() && !lit_by_default,
            #[cfg(feature = "viewer")]
            default_lights,
            animation,
            cameras,
            #[cfg(feature = "viewer")]
            files,
            common: common.clone(),
        };
        if let Some(time) = time {
            job.play(time)?;
        }
        Ok(job)
    }

    /// Moves what moves to where it is at a time, seconds. The camera of a scene without cameras
    /// stays where it is.
    pub fn play(&mut self, time: f64) -> Result<(), Error> {
        let Some(animation) = &self.animation else { return Ok(()) };
        let pose = animation.at(time)?;
        pose.apply(&mut self.scene)?;
        if self.own_lights {
            pose.aim(self.scene.lights_mut());
            show_lights(&mut self.scene, &self.common)?;
        }
        for (index, camera) in pose.cameras {
            self.cameras[index].camera = camera;
        }
        if let Some(named) = self.cameras.get(self.common.camera.camera.unwrap_or(0)) {
            self.camera = changed(named.camera, &self.common.camera, &self.scene);
        }
        Ok(())
    }

    /// The request for a frame.
    pub fn request(&self, deferred: bool) -> Request<'_> {
        Request::new(&self.camera, self.size)
            .samples(self.samples)
            .shadows(self.shadows)
            .layers(self.layers)
            .deferred(deferred)
    }

    /// Renders a frame as `request` says.
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

    /// A view of a picture of the job whose deferred buffers were kept.
    pub fn show(&self, view: DebugView, picture: &Picture) -> Result<DebugImage, Error> {
        let shown = show(view, &self.scene, &self.request(true), picture);
        let shown = shown
            .map_err(|error| Error::Render { scene: self.common.scene.clone(), source: error.into() })?;
        shown.ok_or(Error::Usage("a view needs the deferred buffers"))
    }
}

/// How many rays a frame has, if not too many; fewer are allowed where their deferred buffers are kept.
pub fn rays(size: [u32; 2], samples: u32, deferred: bool) -> Result<u64, Error> {
    let rays = size.map(u64::from).iter().product::<u64>() * u64::from(samples);
    if rays > MAX_RAYS {
        return Err(Error::TooLarge { rays, limit: MAX_RAYS, may: "can be numbered" });
    }
    if deferred && rays > MAX_DEFERRED {
        return Err(Error::TooLarge { rays, limit: MAX_DEFERRED, may: "can be kept to be looked at" });
    }
    Ok(rays)
}

/// What changes while a scene is looked at.
#[cfg(feature = "viewer")]
impl RenderJob {
    /// Looks from elsewhere. Lights that the scene has only because it brings none are placed anew.
    pub fn look(&mut self, camera: Camera) {
        self.camera = camera;
        if self.default_lights {
            import::light_by_default(&mut self.scene, &camera);
        }
    }

    /// The lights are no longer those that the scene has only because it brings none.
    pub fn keep_lights(&mut self) -> Result<(), Error> {
        self.default_lights = false;
        show_lights(&mut self.scene, &self.common)
    }

    /// What the scene and its environment were read from.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Whether the scene brings cameras.
    pub fn has_cameras(&self) -> bool {
        !self.cameras.is_empty()
    }

    /// When the animation comes to rest, seconds, if there is one.
    pub fn end(&self) -> Option<f64> {
        self.animation.as_ref().map(Animation::end)
    }
}

/// Loads the scene that the options name, its trees built by as many threads as they say.
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
    match name.to_str().and_then(|name| name.strip_prefix("demo:")) {
        Some("matchbox") => Ok(pool.install(|| demo::matchbox(&Parallel))?),
        Some("glass") => Ok(pool.install(|| demo::glass(&Parallel))?),
        Some("spheres") => Ok(pool.install(|| demo::spheres(&Parallel))?),
        Some("levels") => Ok(pool.install(|| demo::levels(&Parallel))?),
        Some("moving") => Ok(pool.install(|| demo::moving(&Parallel))?),
        Some(unknown) => Err(Error::Demo { name: unknown.into() }),
        None => Ok(pool.install(|| import::load_cached(name, &Parallel, cache.as_ref()))?),
    }
}

/// Plays the animation that the options name: by its name, else by its number, else all.
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

/// Shows the lights that have a radius, where they are, if the options say so.
fn show_lights(scene: &mut Scene, common: &Common) -> Result<(), Error> {
    for light in (0..scene.lights().len()).filter(|_| common.show_lights) {
        scene
            .show_light(light)
            .map_err(|source| ImportError::Scene { path: common.scene.clone(), source })?;
    }
    Ok(())
}

/// The scene's camera, or the one chosen of its cameras, changed as the options say.
fn camera(common: &Common, loaded: &mut Loaded, plays: bool) -> Result<Camera, Error> {
    let options = &common.camera;
    let chosen = match options.camera {
        Some(asked) => loaded.cameras.get(asked).map(|named| named.camera).ok_or_else(|| {
            let have = loaded.cameras.len();
            Error::Camera { scene: common.scene.clone(), asked, have }
        })?,
        // The import frames for 16 to 9.
        None if loaded.cameras.is_empty() => {
            let aspect = common.size[0] as f32 / common.size[1] as f32;
            match loaded.animation.as_ref().filter(|_| plays) {
                Some(animation) => import::framing_played(&mut loaded.scene, animation, aspect)?,
                None => import::framing(&loaded.scene, aspect),
            }
        }
        None => loaded.camera,
    };
    Ok(changed(chosen, options, &loaded.scene))
}

/// `camera` with what the options give in place of its own.
fn changed(camera: Camera, options: &CameraOptions, scene: &Scene) -> Camera {
    let middle = || scene.extent().map_or(camera.look_at, |(low, high)| low * 0.5 + high * 0.5);
    Camera {
        eye: options.eye.unwrap_or(camera.eye),
        look_at: options
            .look_at
            .unwrap_or_else(|| if options.eye.is_some() { middle() } else { camera.look_at }),
        up: options.up.unwrap_or(camera.up),
        projection: match (options.fov_y, options.parallel) {
            (Some(fov_y), _) => Projection::Perspective { fov_y },
            (None, Some(height)) => Projection::Orthographic { height },
            (None, None) => camera.projection,
        },
    }
}

/// Opens the backend that the options ask for, and says which it is and why. With `hybrid`, it draws what the
/// camera sees.
pub fn open(
    options: &BackendOptions,
    hybrid: bool,
    console: &Console,
) -> Result<(Box<dyn Backend>, Machine), Error> {
    console.step("opening the backend");
    let Chosen { backend, why, is_software } =
        choose(&choose::Options { hybrid, ..options.choose(console.tells()) })?;
    let machine = Machine::from(backend.describe());
    console.say(format_args!("backend: {machine}: {why}"));
    if is_software {
        let why = "this adapter is software: it computes on the processor, as --backend cpu does faster";
        console.warn(4, why)?;
    }
    Ok((backend, machine))
}
