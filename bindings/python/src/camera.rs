//! Cameras.

use crate::arrays::{Array, floats, named, refused, vector, wrong_shape};
use glam::{DMat4, DVec3, DVec4};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtrt::import::NamedCamera;
use rtrt::pose::{Pinhole, pixel, placed, to_world};
use rtrt::poses::Pose;
use rtrt_core::scene::{Camera as CoreCamera, Projection};

/// Where a picture is taken from, and through which lens.
///
/// The lens is one of: `fov_y`, the vertical angle of view in degrees; `fx` with `fy`, `cx`, `cy`, focal lengths and
/// principal point in pixels of the picture that is rendered, from its upper left corner (`fy` is `fx` and the principal
/// point is the middle if they are not given); or `height`, the height of the picture in units of the scene, with
/// parallel rays. Without any, `fov_y` is 45.
///
/// Args:
///     eye: Where the camera is.
///     look_at: A point in the middle of the picture (with `cx` and `cy`: at the principal point).
///     up: What is up in the picture.
///     near, far: The depths between which surfaces are drawn.
#[pyclass(frozen, module = "rtrt", from_py_object)]
#[derive(Clone)]
pub struct Camera {
    named: NamedCamera,
    lens: Option<Lens>,
    /// The size of its picture, if it has one of its own.
    size: Option<[u32; 2]>,
    /// Its time, seconds.
    time: Option<f64>,
}

/// A lens in pixels; without a principal point it is the middle.
#[derive(Debug, Clone, Copy)]
struct Lens {
    fx: f64,
    fy: f64,
    cx: Option<f64>,
    cy: Option<f64>,
}

/// A camera for pictures of one size, and the depths of its near and its far plane.
#[derive(Debug, Clone, Copy)]
pub struct View {
    pub camera: CoreCamera,
    pub clip: [f32; 2],
}

/// What the arguments say of the lens.
struct Arguments {
    near: f32,
    far: f32,
    fov_y: Option<f64>,
    height: Option<f64>,
    fx: Option<f64>,
    fy: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
}

impl Arguments {
    fn read(self) -> PyResult<(Projection, Option<Lens>)> {
        let Self { near, far, fov_y, height, fx, fy, cx, cy } = self;
        let wrong = |why: String| Err(PyValueError::new_err(why));
        if !(near >= 0.0 && near < far) {
            return wrong(format!(
                "near and far are {near} and {far}, and not 0 or more, and more than that"
            ));
        }
        if [fov_y.is_some(), height.is_some(), fx.is_some()].iter().filter(|given| **given).count() > 1 {
            return wrong("a camera has one of fov_y, height and fx".into());
        }
        if fx.is_none() && (fy.is_some() || cx.is_some() || cy.is_some()) {
            return wrong("fy, cx and cy need fx".into());
        }
        if let Some(height) = height {
            if !(height > 0.0 && height.is_finite()) {
                return wrong(format!("height is {height}, and not a number above 0"));
            }
            return Ok((Projection::Orthographic { height: height as f32 }, None));
        }
        let degrees = fov_y.unwrap_or(45.0);
        if !(degrees > 0.0 && degrees < 180.0) {
            return wrong(format!("fov_y is {degrees}, which is not within 0 and 180 degrees"));
        }
        let projection = Projection::Perspective { fov_y: degrees.to_radians() as f32 };
        let Some(fx) = fx else { return Ok((projection, None)) };
        let lens = Lens { fx, fy: fy.unwrap_or(fx), cx, cy };
        for (name, focal) in [("fx", lens.fx), ("fy", lens.fy)] {
            if !(focal > 0.0 && focal.is_finite()) {
                return wrong(format!("{name} is {focal}, and not a number above 0"));
            }
        }
        for (name, place) in [("cx", cx), ("cy", cy)] {
            if let Some(place) = place.filter(|place| !place.is_finite()) {
                return wrong(format!("{name} is {place}"));
            }
        }
        Ok((projection, Some(lens)))
    }
}

impl Camera {
    /// A camera of a file.
    pub fn of(named: NamedCamera) -> Self {
        Self { named, lens: None, size: None, time: None }
    }

    /// A camera that draws surfaces at any depth.
    pub fn around(camera: CoreCamera, name: String) -> Self {
        Self::clipped(View { camera, clip: [0.0, f32::INFINITY] }, name)
    }

    /// A camera with its planes.
    pub fn clipped(View { camera, clip }: View, name: String) -> Self {
        Self::of(NamedCamera { name, camera, aspect: None, clip })
    }

    /// A camera of a file of cameras, in a scene whose coordinates are relative to this origin.
    pub fn posed(pose: &Pose, origin: DVec3) -> Self {
        let view = View { camera: pose.camera(origin), clip: pose.clip };
        Self { time: pose.time, ..Self::clipped(view, pose.name.clone()).sized(pose.size) }
    }

    /// The camera for pictures of this size.
    pub fn sized(self, size: [u32; 2]) -> Self {
        Self { size: Some(size), ..self }
    }

    /// The size of its picture, if it has one of its own.
    pub fn own_size(&self) -> Option<[u32; 2]> {
        self.size
    }

    fn new(camera: CoreCamera, lens: Option<Lens>, clip: [f32; 2]) -> Self {
        Self { lens, ..Self::of(NamedCamera { name: String::new(), camera, aspect: None, clip }) }
    }

    /// The camera for a picture of this size.
    pub fn at(&self, size: [u32; 2]) -> View {
        let camera = match self.lens {
            None => self.named.fitted(size[0] as f32 / size[1] as f32),
            Some(Lens { fx, fy, cx, cy }) => {
                let middle = size.map(|side| 0.5 * f64::from(side));
                let lens = Pinhole { fx, fy, cx: cx.unwrap_or(middle[0]), cy: cy.unwrap_or(middle[1]) };
                CoreCamera { projection: lens.projection(size), ..self.named.camera }
            }
        };
        View { camera, clip: self.named.clip }
    }
}

/// What a pickle has of a camera: its name; eye, look_at, up; the edges of the picture; the shape that it is made for; the
/// lens in pixels; its planes, size and time.
type State = (
    String,
    [[f32; 3]; 3],
    Vec<f32>,
    Option<f32>,
    Option<(f64, f64, Option<f64>, Option<f64>)>,
    [f32; 2],
    Option<[i64; 2]>,
    Option<f64>,
);

impl Camera {
    fn state(&self) -> State {
        let Self { named: NamedCamera { name, camera, aspect, clip }, lens, size, time } = self.clone();
        // The number of numbers says which kind it is.
        let projection = match camera.projection {
            Projection::Perspective { fov_y } => vec![fov_y],
            Projection::Orthographic { height } => vec![0.0, height],
            Projection::OffCenter { left, right, bottom, top } => vec![left, right, bottom, top],
        };
        let points = [camera.eye, camera.look_at, camera.up].map(|point| point.to_array());
        let lens = lens.map(|Lens { fx, fy, cx, cy }| (fx, fy, cx, cy));
        (name, points, projection, aspect, lens, clip, size.map(|size| size.map(i64::from)), time)
    }

    fn of_state((name, points, projection, aspect, lens, clip, size, time): State) -> PyResult<Self> {
        let projection = match projection[..] {
            [fov_y] => Projection::Perspective { fov_y },
            [_, height] => Projection::Orthographic { height },
            [left, right, bottom, top] => Projection::OffCenter { left, right, bottom, top },
            _ => return Err(PyValueError::new_err("the pickle is of another version of rtrt")),
        };
        let [eye, look_at, up] = points.map(Into::into);
        let camera = CoreCamera { eye, look_at, up, projection };
        let lens = lens.map(|(fx, fy, cx, cy)| Lens { fx, fy, cx, cy });
        let size = size.map(self::size).transpose()?;
        Ok(Self { named: NamedCamera { name, camera, aspect, clip }, lens, size, time })
    }
}

/// A size that pictures may have.
pub fn size([width, height]: [i64; 2]) -> PyResult<[u32; 2]> {
    let most = i64::from(rtrt_core::scene::Setup::MAX_SIDE);
    if !(1..=most).contains(&width) || !(1..=most).contains(&height) {
        let why = format!("size is {width} x {height}, and each is within 1 .. {most}");
        return Err(PyValueError::new_err(why));
    }
    Ok([width as u32, height as u32])
}

/// The size of pictures that have none of their own.
pub const SIZE: [u32; 2] = [640, 360];

/// The size that a call names, or else [`SIZE`].
pub fn usual_size(size: Option<(i64, i64)>) -> PyResult<[u32; 2]> {
    size.map_or(Ok(SIZE), |size| self::size(size.into()))
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (eye, look_at, up = None, *, fov_y = None, height = None, fx = None, fy = None, cx = None, cy = None, near = 0.0, far = f32::INFINITY))]
    #[expect(clippy::too_many_arguments, reason = "they are named arguments of Python")]
    fn init(
        eye: &Bound<'_, PyAny>,
        look_at: &Bound<'_, PyAny>,
        up: Option<&Bound<'_, PyAny>>,
        fov_y: Option<f64>,
        height: Option<f64>,
        fx: Option<f64>,
        fy: Option<f64>,
        cx: Option<f64>,
        cy: Option<f64>,
        near: f32,
        far: f32,
    ) -> PyResult<Self> {
        let (projection, lens) = Arguments { near, far, fov_y, height, fx, fy, cx, cy }.read()?;
        let camera = CoreCamera {
            eye: vector("eye", eye)?.into(),
            look_at: vector("look_at", look_at)?.into(),
            up: up.map_or(Ok([0.0, 1.0, 0.0]), |up| vector("up", up))?.into(),
            projection,
        };
        if to_world(&camera).is_none() {
            let why = "the camera looks nowhere: eye, look_at and up are finite, eye is not look_at, and up leads elsewhere";
            return Err(PyValueError::new_err(why));
        }
        Ok(Self::new(camera, lens, [near, far]))
    }

    /// The camera with this matrix from its axes to world space.
    ///
    /// Args:
    ///     matrix: 4 x 4, or its first three rows. Its axes may have any length.
    ///     axes: "opengl" (x to the right, y up, z backward, as in Blender and NeRF) or "opencv" (y down, z forward).
    ///     fov_y, height, fx, fy, cx, cy, near, far: The lens; see `Camera`.
    #[staticmethod]
    #[pyo3(signature = (matrix, *, axes = "opengl", fov_y = None, height = None, fx = None, fy = None, cx = None, cy = None, near = 0.0, far = f32::INFINITY))]
    #[expect(clippy::too_many_arguments, reason = "they are named arguments of Python")]
    fn from_matrix(
        matrix: &Bound<'_, PyAny>,
        axes: &str,
        fov_y: Option<f64>,
        height: Option<f64>,
        fx: Option<f64>,
        fy: Option<f64>,
        cx: Option<f64>,
        cy: Option<f64>,
        near: f32,
        far: f32,
    ) -> PyResult<Self> {
        let (projection, lens) = Arguments { near, far, fov_y, height, fx, fy, cx, cy }.read()?;
        let turned = DMat4::from_diagonal(DVec4::new(1.0, -1.0, -1.0, 1.0));
        let axes = named("axes", axes, &[("opengl", DMat4::IDENTITY), ("opencv", turned)])?;
        let matrix = crate::arrays::matrix("matrix", matrix)? * axes;
        Ok(Self::new(placed(&matrix, projection).map_err(refused)?, lens, [near, far]))
    }

    /// What the file calls it; empty for a camera that is in no file.
    #[getter]
    fn name(&self) -> &str {
        &self.named.name
    }

    /// The size of its picture (width, height), for a camera of a file of cameras or of an orbit; else None.
    #[getter]
    fn size(&self) -> Option<(u32, u32)> {
        self.size.map(|[width, height]| (width, height))
    }

    /// Its time of the animation, seconds, if a file of cameras says so; else None. See `Scene.play`.
    #[getter]
    fn time(&self) -> Option<f64> {
        self.time
    }

    /// The depths of its near and its far plane, between which surfaces are drawn.
    #[getter]
    fn clip(&self) -> (f32, f32) {
        self.named.clip.into()
    }

    /// Where it is.
    #[getter]
    fn eye<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.named.camera.eye.to_array())
    }

    /// The matrix from its axes (x to the right, y up, z backward) to world space, 4 x 4.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let matrix = to_world(&self.named.camera).unwrap_or(DMat4::IDENTITY);
        PyArray1::from_slice(py, &matrix.transpose().to_cols_array()).reshape([4, 4])
    }

    /// The lens for a picture of this size (width, height): `fx`, `fy`, `cx`, `cy` in pixels; None with parallel rays.
    fn intrinsics(&self, size: [i64; 2]) -> PyResult<Option<(f64, f64, f64, f64)>> {
        let size = self::size(size)?;
        let lens = Pinhole::new(&self.at(size).camera, size);
        Ok(lens.map(|Pinhole { fx, fy, cx, cy }| (fx, fy, cx, cy)))
    }

    /// Where points are in a picture of this size (width, height): columns and rows, from its upper left corner, in an
    /// array of the shape (n, 2). NaN for points that are not in front of the camera.
    fn project<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'_, PyAny>,
        size: [i64; 2],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let size = self::size(size)?;
        let Array { shape, values } = floats::<f64>("points", points)?;
        if shape.len() != 2 || shape[1] != 3 {
            return Err(wrong_shape("points", &shape, "(n, 3)"));
        }
        let View { camera, .. } = self.at(size);
        let place = |point: &[f64; 3]| pixel(&camera, size, DVec3::from(*point)).unwrap_or([f64::NAN; 2]);
        let places: Vec<f64> = values.as_chunks::<3>().0.iter().flat_map(place).collect();
        PyArray1::from_vec(py, places).reshape([shape[0], 2])
    }

    /// How a pickle makes it again.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (State,))> {
        Ok((slf.get_type().getattr("_of_pickle")?, (slf.get().state(),)))
    }

    #[staticmethod]
    fn _of_pickle(state: State) -> PyResult<Self> {
        Self::of_state(state)
    }

    fn __repr__(&self) -> String {
        let CoreCamera { eye, look_at, .. } = self.named.camera;
        format!("<rtrt.Camera at {eye} that looks at {look_at}>")
    }
}
