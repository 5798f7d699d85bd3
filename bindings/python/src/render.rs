//! Pictures.

use crate::aov::{Aov, Memory, Part};
use crate::arrays::named;
use crate::backend::{Backend, machine};
use crate::camera::{self, Camera, SIZE, View};
use crate::parts::Parts;
use crate::scene::{Scene, failed};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rtrt::layers::MOST_RAYS;
use rtrt::motion::Before as Moment;
use rtrt_core::backend::{LAYERS, RenderError, Request, Shading, Shadows, ToneMap};
use std::sync::atomic::AtomicBool;

/// The rays of a call that take so long, some hundredths of a second, that signals do not wait for its end.
const LONG: u64 = 1 << 18;

// What the signature of `render` says.
const _: () = assert!(LAYERS == 8);

/// How well a picture is rendered.
struct Quality {
    samples: u32,
    shading: Shading,
    shadows: Shadows,
    layers: u32,
    exposure: f32,
    tone_map: ToneMap,
}

impl Quality {
    fn new(
        samples: i64,
        shading: &str,
        shadows: &str,
        layers: i64,
        exposure: f32,
        tone_map: &str,
    ) -> PyResult<Self> {
        let kinds = [
            ("off", Shadows::Off),
            ("hard", Shadows::Hard),
            ("soft", Shadows::Soft),
            ("area", Shadows::Area { jitter: Some(0) }),
        ];
        // What the core refuses, with its own words.
        let count = |number: i64| u32::try_from(number).unwrap_or(u32::MAX);
        Ok(Self {
            samples: count(samples),
            shading: named("shading", shading, &[("sample", Shading::Sample), ("pixel", Shading::Pixel)])?,
            shadows: named("shadows", shadows, &kinds)?,
            layers: count(layers),
            exposure,
            tone_map: named("tone_map", tone_map, &ToneMap::ALL)?,
        })
    }

    fn request<'a>(&self, view: &'a View, size: [u32; 2], deferred: bool) -> Request<'a> {
        Request::new(&view.camera, size)
            .clip(view.clip[0], view.clip[1])
            .samples(self.samples)
            .shading(self.shading)
            .shadows(self.shadows)
            .layers(self.layers)
            .exposure(self.exposure)
            .tone_map(self.tone_map)
            .deferred(deferred)
    }
}

/// What a picture raises: ValueError for what cannot be rendered, RuntimeError for a backend that fails.
fn raised(error: &RenderError, before: &str) -> PyErr {
    match error {
        RenderError::Setup(error) => PyValueError::new_err(format!("{before}{error}")),
        error => failed(format!("{before}{error}")),
    }
}

/// The cameras of an argument.
enum Cameras {
    Usual,
    One(Camera),
    Many(Vec<Camera>),
}

impl Cameras {
    fn new(camera: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(value) = camera.filter(|camera| !camera.is_none()) else { return Ok(Self::Usual) };
        if let Ok(camera) = value.cast::<Camera>() {
            return Ok(Self::One(camera.get().clone()));
        }
        let wrong = || PyTypeError::new_err("camera is neither a Camera nor a sequence of them");
        let mut all = Vec::new();
        for camera in value.try_iter().map_err(|_| wrong())? {
            all.push(camera?.cast::<Camera>().map_err(|_| wrong())?.get().clone());
        }
        Ok(Self::Many(all))
    }

    fn all(&self) -> &[Camera] {
        match self {
            Self::Usual => &[],
            Self::One(camera) => std::slice::from_ref(camera),
            Self::Many(all) => all,
        }
    }

    /// The size of their pictures: `size`, or else their own.
    fn size(&self, asked: Option<(i64, i64)>) -> PyResult<[u32; 2]> {
        if let Some(size) = asked {
            return camera::size(size.into());
        }
        let sizes = || self.all().iter().map(|camera| camera.own_size().unwrap_or(SIZE));
        let first = sizes().next().unwrap_or(SIZE);
        match sizes().position(|size| size != first) {
            None => Ok(first),
            Some(number) => Err(PyValueError::new_err(format!(
                "camera {number} has another size than camera 0; name a size for all, or render them one by one"
            ))),
        }
    }

    /// The views of pictures of this size, one or more.
    fn views(&self, scene: &Parts, size: [u32; 2]) -> Vec<View> {
        match self {
            Self::Usual => vec![scene.usual_camera(size)],
            _ => self.all().iter().map(|camera| camera.at(size)).collect(),
        }
    }
}

/// A scene and its cameras as they are now, for the aov "motion" of pictures after it has changed.
///
/// Args:
///     scene: The scene.
///     camera: A Camera or several, as those of `render` later; the file's first one if not given.
#[pyclass(frozen, module = "rtrt")]
pub struct Before {
    moment: Moment,
    cameras: Vec<Camera>,
}

#[pymethods]
impl Before {
    #[new]
    #[pyo3(signature = (scene, camera = None))]
    fn new(scene: &Scene, camera: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let cameras = Cameras::new(camera)?;
        let scene = &*scene.read()?;
        let cameras = match cameras {
            Cameras::Usual => vec![scene.first_camera().ok_or_else(|| {
                PyValueError::new_err("camera is missing: the scene has no camera of a file")
            })?],
            cameras => cameras.all().to_vec(),
        };
        // Each picture puts a camera in the place of this one.
        let camera = scene.usual_camera(SIZE).camera;
        Ok(Self { moment: Moment::new(&scene.scene, &camera), cameras })
    }

    fn __repr__(&self) -> String {
        format!("<rtrt.Before with {} cameras>", self.cameras.len())
    }
}

impl Before {
    /// How each of `count` pictures of the scene was.
    fn all(&self, scene: &Parts, count: usize, size: [u32; 2]) -> PyResult<Vec<Moment>> {
        if !self.moment.is_of(&scene.scene) {
            return Err(PyValueError::new_err("before is of another scene"));
        }
        if self.cameras.len() != count {
            let has = self.cameras.len();
            return Err(PyValueError::new_err(format!("before has {has} cameras, but there are {count}")));
        }
        Ok(self.cameras.iter().map(|camera| self.moment.seen_from(&camera.at(size).camera)).collect())
    }
}

/// The names of the requested arrays.
fn aovs(aov: Option<&Bound<'_, PyAny>>, out: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<Aov>> {
    let names: Vec<String> = match (aov, out) {
        (Some(aov), _) => match aov.extract::<String>() {
            Ok(name) => vec![name],
            Err(_) => aov
                .extract()
                .map_err(|_| PyTypeError::new_err("aov is neither a name nor a list of names"))?,
        },
        (None, Some(out)) if !out.is_empty() => {
            let names = out.keys().extract();
            names.map_err(|_| PyTypeError::new_err("the keys of out are not all names"))?
        }
        (None, _) => vec!["rgba".into()],
    };
    let mut all: Vec<Aov> = Vec::new();
    for name in names {
        let aov = Aov::named(&name)?;
        if all.iter().all(|known| known.name != aov.name) {
            all.push(aov);
        }
    }
    Ok(all)
}

/// Renders a scene, and returns a dict of arrays, one for each name in `aov`.
///
/// One camera gives arrays of the shape (height, width, ...); a sequence of n cameras gives (n, height, width, ...): small
/// pictures are then rendered side by side, which keeps more threads busy than one after the other. The interpreter is free
/// meanwhile, and Ctrl-C ends the call, with buffers partly filled. Bits depend neither on that, nor on threads, machine or backend.
///
/// | aov | dtype | what |
/// |---|---|---|
/// | rgba | uint8, 4 | the picture, sRGB and straight alpha: the bytes that the command `rtrt render` writes |
/// | color | float32, 4 | linear light, neither exposed nor tone mapped, times alpha, and alpha |
/// | depth | float32 | along the view, units of the scene; inf without a surface |
/// | normal | float32, 3 | world space, toward the viewer; 0 without a surface |
/// | albedo | float32, 3 | base color, linear, without light |
/// | object, material | int32 | ids; -1 without a surface |
/// | triangle, source | int32 | the triangle, as the scene numbers it and as its source does; -1 without one |
/// | barycentrics, uv | float32, 2 | on the triangle; texture coordinates |
/// | position | float32, 3 | world space |
/// | shadow | float32 | the share of the scene's lights that arrives |
/// | motion | float32, 2 | pixels to the right and downward since `before`; NaN for what was behind the camera |
///
/// rgba, color, normal, albedo and shadow are means over a pixel's samples, so that a normal is shorter than 1 at edges. The
/// others come from the first sample, the upper left one; with 1 sample all are those of the middle of the pixel. position is
/// the point of that sample's ray at depth.
///
/// Args:
///     scene: The scene.
///     camera: A Camera, or several; the file's first one, or one that sees everything, if not given.
///     size: Width and height; the camera's own, or 640 x 360, if not given.
///     aov: A name or names; those in `out`, or "rgba", if not given.
///     out: A dict of arrays that are filled and returned, such as the result of an earlier call. Names that it lacks are
///         added.
///     samples: 1, 4 or 16 a pixel.
///     shading: "sample" for a color for each sample, or "pixel" for one for each triangle that a pixel's samples meet: faster, with
///         smooth edges of objects, but not of shadows. Scenes with transparency or soft shadows have a color for each sample.
///     shadows: "off", "hard", "soft" (analytic penumbras) or "area" (sampled penumbras).
///     layers: The most transparent surfaces that a ray passes.
///     exposure: Stops; see `meter`.
///     tone_map: "neutral", "agx", "aces" or "none".
///     before: A Before, for the aov "motion", with as many cameras as `camera`.
///     backend: A Backend; one for all calls if not given, on the first GPU that works, else on the processor.
#[pyfunction]
#[pyo3(signature = (scene, camera = None, size = None, aov = None, *, out = None, samples = 4, shading = "sample", shadows = "soft", layers = 8, exposure = 0.0, tone_map = "neutral", before = None, backend = None))]
#[expect(clippy::too_many_arguments, reason = "they are named arguments of Python")]
pub fn render<'py>(
    py: Python<'py>,
    scene: &Scene,
    camera: Option<&Bound<'py, PyAny>>,
    size: Option<(i64, i64)>,
    aov: Option<&Bound<'py, PyAny>>,
    out: Option<Bound<'py, PyDict>>,
    samples: i64,
    shading: &str,
    shadows: &str,
    layers: i64,
    exposure: f32,
    tone_map: &str,
    before: Option<&Before>,
    backend: Option<&Bound<'py, Backend>>,
) -> PyResult<Bound<'py, PyDict>> {
    let quality = Quality::new(samples, shading, shadows, layers, exposure, tone_map)?;
    let (cameras, aovs) = (Cameras::new(camera)?, aovs(aov, out.as_ref())?);
    let size = cameras.size(size)?;
    let scene = &*scene.read()?;
    let (views, are_many) = (cameras.views(scene, size), matches!(cameras, Cameras::Many(_)));
    let count = are_many.then_some(views.len());
    let moments = match before {
        Some(before) => before.all(scene, views.len(), size)?,
        None if aovs.iter().any(|aov| aov.is_motion()) => {
            return Err(PyValueError::new_err("the aov motion needs before: a Before of the scene"));
        }
        None => vec![],
    };
    let deferred = aovs.iter().any(|aov| aov.is_deferred());
    let rays = size.map(u64::from).iter().product::<u64>() * u64::from(quality.samples);
    if deferred && rays > MOST_RAYS {
        let why = format!(
            "{rays} rays a picture, but at most {MOST_RAYS} can have aovs; try a smaller size or fewer samples"
        );
        return Err(PyValueError::new_err(why));
    }
    let machine = machine(py, backend)?;
    let out = out.unwrap_or_else(|| PyDict::new(py));
    let mut memories: Vec<Memory<'py>> = Vec::new();
    for aov in aovs {
        let array = match out.get_item(aov.name)? {
            Some(array) => array,
            None => {
                let array = aov.zeros(py, count, size)?;
                out.set_item(aov.name, &array)?;
                array
            }
        };
        memories.push(aov.memory(&array, count, size)?);
    }
    let pixels = size[0] as usize * size[1] as usize;
    type Wanted<'a> = (Vec<Part<'a>>, Option<&'a Moment>);
    let stop = AtomicBool::new(false);
    let request = |view| quality.request(view, size, deferred).until(&stop);
    let job = |(number, view)| (request(view), (Vec::new(), moments.get(number)));
    let mut jobs: Vec<(Request<'_>, Wanted<'_>)> = views.iter().enumerate().map(job).collect();
    for memory in &mut memories {
        for ((_, (parts, _)), part) in jobs.iter_mut().zip(memory.parts(pixels)?) {
            parts.push(part);
        }
    }
    let is_long = rays.saturating_mul(views.len() as u64) > LONG;
    let result = machine.with(py, is_long.then_some(&stop), |batch| {
        batch.render(&scene.scene, &mut jobs, |request, picture, (parts, before)| {
            parts.iter_mut().for_each(|part| part.fill(scene, request, picture, *before));
        })
    })?;
    result.map_err(|error| {
        let before = if are_many { format!("camera {}: ", error.number) } else { String::new() };
        raised(&error.source, &before)
    })?;
    drop(jobs);
    drop(memories);
    Ok(out)
}

/// The exposure that suits a picture, in stops, for the argument `exposure` of `render`. Meter an animation once, so that it
/// does not flicker.
///
/// Args:
///     scene, camera, size, shadows, backend: See `render`; one camera.
#[pyfunction]
#[pyo3(signature = (scene, camera = None, size = None, *, shadows = "soft", backend = None))]
pub fn meter(
    py: Python<'_>,
    scene: &Scene,
    camera: Option<&Camera>,
    size: Option<(i64, i64)>,
    shadows: &str,
    backend: Option<&Bound<'_, Backend>>,
) -> PyResult<f32> {
    let quality = Quality::new(4, "sample", shadows, i64::from(LAYERS), 0.0, "none")?;
    let size = camera.map_or(Cameras::Usual, |camera| Cameras::One(camera.clone())).size(size)?;
    let scene = &*scene.read()?;
    let camera = camera.map_or_else(|| scene.usual_camera(size), |camera| camera.at(size));
    let (machine, core) = (machine(py, backend)?, &scene.scene);
    let stops = machine
        .with(py, None, |batch| batch.backend().meter(core, &quality.request(&camera, size, false)))?;
    stops.map_err(|error| raised(&error, ""))
}
