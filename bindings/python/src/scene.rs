//! Scenes.

use crate::arrays::{finite_vector, named, refused, rows};
use crate::backend::threads;
use crate::camera::{self, Camera, View};
use crate::file::{self, import_error};
use crate::forked::PerProcess;
use crate::given::{ball, image, mesh, place};
use crate::in_use::InUse;
use crate::light::Light;
use crate::material::changed;
use crate::parts::{NamedMesh, Parts};
use crate::rays::{self, Question};
use crate::{environment, objects};
use pyo3::exceptions::{PyFileNotFoundError, PyRuntimeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rtrt::import::{Animation, framing, framing_from, light_by_default};
use rtrt::orbit::orbit;
use rtrt::poses::{self, Poses};
use rtrt_core::scene::{Backdrop, Content, Material, Scene as CoreScene, Wrap};
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::{RwLockReadGuard, RwLockWriteGuard};

/// A scene: meshes and spheres with their places and materials, lights, surroundings.
///
/// Things are named by numbers: `add_mesh`, `add_material`, `add_texture`, `add_instance` and `add_sphere` return them, from 0
/// on. Those of objects and materials are the ids in the aovs "object" and "material". The number of what was removed names
/// nothing; it is not given again.
///
/// `Scene()` is empty: no lights, faint ambient light, a dark background. A scene cannot be changed while another thread
/// renders it: that raises RuntimeError.
#[pyclass(frozen, module = "rtrt")]
pub struct Scene(InUse<Parts>);

impl Scene {
    /// What it is made of, to be looked at.
    ///
    /// # Errors
    /// It is being changed.
    pub fn read(&self) -> PyResult<RwLockReadGuard<'_, Parts>> {
        self.0.read()
    }

    /// What it is made of, to be changed.
    ///
    /// # Errors
    /// It is being changed, or looked at.
    pub fn change(&self) -> PyResult<RwLockWriteGuard<'_, Parts>> {
        self.0.change()
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self(InUse::new(Parts::around(CoreScene::new(), vec![])))
    }

    /// A copy, in which the same numbers name the same things; `copy.copy` and `copy.deepcopy` make it, too. What changes in
    /// one of them stays as it is in the other, so that one is changed while another is rendered. It takes as much memory
    /// again.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let parts = &*self.read()?;
        Ok(Self(InUse::new(py.detach(|| Parts {
            scene: parts.scene.clone(),
            // Made when the first ray asks.
            tree: PerProcess::new(),
            objects: parts.objects.clone(),
            meshes: parts.meshes.clone(),
            materials: parts.materials.clone(),
            textures: parts.textures.clone(),
            material_names: parts.material_names.clone(),
            cameras: parts.cameras.clone(),
            animation: parts.animation.clone(),
            warnings: parts.warnings.clone(),
            files: parts.files.clone(),
            ..*parts
        }))))
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        self.copy(py)
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.copy(py)
    }

    /// The scene of a file: glTF 2.0 (.glb, .gltf), OBJ, STL or PLY; or a built-in one, `demo:matchbox`, `demo:glass`,
    /// `demo:spheres`, `demo:levels`, `demo:moving`.
    ///
    /// Args:
    ///     path: The file.
    ///     light: Whether a scene without lights is lit as the command `rtrt` does it: in a studio, with its key light.
    ///     point_size: The diameter of points and lines; 1/250 of the diagonal if not given.
    #[staticmethod]
    #[pyo3(signature = (path, *, light = true, point_size = None))]
    fn load(py: Python<'_>, path: PathBuf, light: bool, point_size: Option<f32>) -> PyResult<Self> {
        Ok(Self(InUse::new(file::load(py, &path, light, point_size)?)))
    }

    /// Lights a scene without lights as the command `rtrt` does it: in a studio, with its key light.
    fn light_by_default(&self, py: Python<'_>) -> PyResult<()> {
        let parts = &mut *self.change()?;
        py.detach(|| light_by_default(&mut parts.scene).map_err(refused))
    }

    /// Adds a mesh, and returns its number. Any number of objects may show it.
    ///
    /// Args:
    ///     positions: Vertices, (n, 3), in the mesh's own space.
    ///     triangles: Numbers of vertices, (m, 3), counterclockwise from the front; each three vertices if not given.
    ///     normals: (n, 3); flat triangles if not given.
    ///     uvs: Texture coordinates, (n, 2); v grows downward.
    ///     colors: Linear RGB or RGBA of vertices, uint8, (n, 3) or (n, 4); multiplied with that of the material.
    ///     tangents: Directions of u and the sign of the bitangent, (n, 4), for normal maps; made from uvs if not given and
    ///         `make_tangents`.
    ///     name: What `labels` calls it; its number if not given.
    #[pyo3(signature = (positions, triangles = None, *, normals = None, uvs = None, colors = None, tangents = None, make_tangents = false, name = None))]
    #[expect(clippy::too_many_arguments, reason = "they are named arguments of Python")]
    fn add_mesh(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        triangles: Option<&Bound<'_, PyAny>>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        tangents: Option<&Bound<'_, PyAny>>,
        make_tangents: bool,
        name: Option<String>,
    ) -> PyResult<i32> {
        let mut mesh = mesh(positions, triangles, normals, uvs, colors)?;
        if let Some(tangents) = tangents {
            mesh = mesh.with_tangents(&rows::<4>("tangents", tangents)?).map_err(refused)?;
        }
        let (pool, parts) = (threads(py)?, &mut *self.change()?);
        py.detach(|| {
            if make_tangents {
                mesh = mesh.with_made_tangents(false);
            }
            pool.install(|| parts.add_mesh(&mesh, name))
        })
    }

    /// Gives a mesh that was added another shape: the same triangles with their corners elsewhere.
    ///
    /// Args:
    ///     mesh: Its number.
    ///     positions, triangles, normals: See `add_mesh`; the triangles are those that it was added with.
    #[pyo3(signature = (mesh, positions, triangles = None, *, normals = None))]
    fn reshape(
        &self,
        mesh: i64,
        positions: &Bound<'_, PyAny>,
        triangles: Option<&Bound<'_, PyAny>>,
        normals: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let shape = self::mesh(positions, triangles, normals, None, None)?;
        let parts = &mut *self.change()?;
        let index = parts.meshes.get(mesh)?.index;
        parts.scene.reshape(index, &shape).map_err(refused)
    }

    /// Removes a mesh that was added, so that the next ones have its memory. Its number names nothing from now on, and no other
    /// mesh gets it. Materials and textures stay.
    ///
    /// Raises:
    ///     IndexError: There is no such mesh, or it was removed.
    ///     ValueError: Objects show it, seen or hidden; remove those first.
    fn remove_mesh(&self, py: Python<'_>, mesh: i64) -> PyResult<()> {
        let parts = &mut *self.change()?;
        py.detach(|| parts.remove_mesh(mesh))
    }

    /// Adds a texture, and returns its number.
    ///
    /// Args:
    ///     pixels: uint8, (height, width), with 3 or 4 channels or none, from top to bottom.
    ///     content: "color" (sRGB), "cutout" (sRGB, and alpha that hides), "numbers" or "normals".
    ///     wrap: "repeat", "clamp" or "mirror".
    #[pyo3(signature = (pixels, *, content = "color", wrap = "repeat"))]
    fn add_texture(&self, pixels: &Bound<'_, PyAny>, content: &str, wrap: &str) -> PyResult<usize> {
        let kinds = [
            ("color", Content::Color),
            ("cutout", Content::SeeThrough),
            ("numbers", Content::Numbers),
            ("normals", Content::Normals),
        ];
        let content = named("content", content, &kinds)?;
        let wraps = [("repeat", Wrap::Repeat), ("clamp", Wrap::Clamp), ("mirror", Wrap::Mirror)];
        let wrap = named("wrap", wrap, &wraps)?;
        let image = image(pixels)?;
        let parts = &mut *self.change()?;
        let texture = parts.scene.add_map(&image, [wrap; 2], content).map_err(refused)?;
        parts.textures.push(texture);
        Ok(parts.textures.len() - 1)
    }

    /// Adds a material, and returns its number; without arguments it is white and matte. Its arguments are those of glTF's
    /// metallic-roughness; see the type stub. Colors are linear RGB, maps are numbers of textures; `labels` calls it by its
    /// `name`, or its number. One with `shadow_catcher` shows the shadows on it and nothing else, and has no other properties.
    #[pyo3(signature = (*, name = None, **properties))]
    fn add_material(&self, name: Option<String>, properties: Option<&Bound<'_, PyDict>>) -> PyResult<u32> {
        let textures = self.read()?.textures.clone();
        let material = changed(Material::default(), properties, &textures)?;
        let parts = &mut *self.change()?;
        let index = parts.scene.add_material(material).map_err(refused)?;
        parts.materials.insert(index.number(), index);
        if let Some(name) = name {
            parts.material_names.insert(index.number(), name);
        }
        Ok(index.number())
    }

    /// Changes a material; what is not named stays. A shadow catcher is first made an ordinary material, with
    /// `shadow_catcher=False`.
    #[pyo3(signature = (material, **properties))]
    fn set_material(&self, material: i64, properties: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let (index, old, textures) = {
            let parts = &*self.read()?;
            let index = parts.material_index(material)?;
            (index, parts.scene.material(index).copied().unwrap_or_default(), parts.textures.clone())
        };
        let new = changed(old, properties, &textures)?;
        self.change()?.scene.set_material(index, new).map_err(refused)
    }

    /// Places a mesh in the world, and returns the number of the object.
    ///
    /// Args:
    ///     mesh, material: Their numbers.
    ///     transform: The matrix from the mesh's space to the world, 4 x 4 or 3 x 4; the identity if not given.
    ///     name: What `labels` calls it; its number if not given.
    #[pyo3(signature = (mesh, material, transform = None, *, name = None))]
    fn add_instance(
        &self,
        mesh: i64,
        material: i64,
        transform: Option<&Bound<'_, PyAny>>,
        name: Option<String>,
    ) -> PyResult<i32> {
        let to_world = place(transform)?;
        let parts = &mut *self.change()?;
        let NamedMesh { index, name: mesh } = parts.meshes.get(mesh)?.clone();
        let material = parts.material_index(material)?;
        parts.add_object(name, mesh, material, |scene| scene.add_instance(index, material, to_world))
    }

    /// Adds a sphere, round however close one looks, and returns the number of the object.
    ///
    /// Args:
    ///     material: Its number.
    ///     center, radius: Where it is.
    ///     transform: Instead, the matrix that places a sphere of radius 1 around the origin, and may make an ellipsoid of it.
    ///     name: What `labels` calls it; its number if not given.
    #[pyo3(signature = (material, center = None, radius = None, *, transform = None, name = None))]
    fn add_sphere(
        &self,
        material: i64,
        center: Option<&Bound<'_, PyAny>>,
        radius: Option<f32>,
        transform: Option<&Bound<'_, PyAny>>,
        name: Option<String>,
    ) -> PyResult<i32> {
        let to_world = ball(center, radius, transform)?;
        let parts = &mut *self.change()?;
        let material = parts.material_index(material)?;
        parts.add_object(name, "sphere".into(), material, |scene| scene.add_sphere(material, to_world))
    }

    /// Moves an object; one that was hidden is seen again.
    fn set_transform(&self, object: i64, transform: &Bound<'_, PyAny>) -> PyResult<()> {
        let to_world = place(Some(transform))?;
        let parts = &mut *self.change()?;
        let object = parts.objects.index(&parts.scene, object)?;
        parts.scene.set_transform(object, to_world).map_err(refused)
    }

    /// Moves many objects. What does not move costs nothing. None is moved if a number names nothing.
    ///
    /// Args:
    ///     objects: Their numbers, (n,).
    ///     transforms: (n, 4, 4) or (n, 3, 4).
    fn set_transforms(&self, objects: &Bound<'_, PyAny>, transforms: &Bound<'_, PyAny>) -> PyResult<()> {
        objects::set_transforms(self, objects, transforms)
    }

    /// Removes an object: pictures and rays are as if it had never been. Its number names nothing from now on, and no other
    /// object gets it. Its mesh and material stay.
    ///
    /// Raises:
    ///     IndexError: There is no such object, or it was removed.
    fn remove_object(&self, object: i64) -> PyResult<()> {
        self.change()?.remove_object(object)
    }

    /// Hides an object until it gets a transform again.
    fn hide(&self, object: i64) -> PyResult<()> {
        let parts = &mut *self.change()?;
        let object = parts.objects.index(&parts.scene, object)?;
        parts.scene.hide(object).map_err(refused)
    }

    /// The matrices of all objects to world space, float32, (n, 4, 4), in the order of `labels`.
    #[getter]
    fn transforms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        objects::transforms(py, &*self.read()?)
    }

    /// The lights. What is assigned replaces all of them.
    #[getter]
    fn lights(&self) -> PyResult<Vec<Light>> {
        Ok(self.read()?.scene.lights().iter().map(|&light| Light { light }).collect())
    }

    #[setter]
    fn set_lights(&self, lights: Vec<Light>) -> PyResult<()> {
        let parts = &mut *self.change()?;
        parts.own_lights = false;
        *parts.scene.lights_mut() = lights.into_iter().map(|light| light.light).collect();
        Ok(())
    }

    /// Adds a light.
    fn add_light(&self, light: &Light) -> PyResult<()> {
        self.change()?.scene.add_light(light.light);
        Ok(())
    }

    /// Ambient light, linear RGB; an environment replaces it.
    #[getter]
    fn ambient(&self) -> PyResult<(f32, f32, f32)> {
        Ok(self.read()?.scene.ambient.into())
    }

    #[setter]
    fn set_ambient(&self, color: &Bound<'_, PyAny>) -> PyResult<()> {
        let color = finite_vector("ambient", color)?;
        self.change()?.scene.ambient = color.into();
        Ok(())
    }

    /// What is behind all surfaces: a color (linear RGB), "environment", or None for nothing, so that the alpha of a pixel is
    /// the share that surfaces cover.
    #[getter]
    fn background<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let scene = &self.read()?.scene;
        Ok(match scene.backdrop {
            Backdrop::Environment => "environment".into_pyobject(py)?.into_any(),
            Backdrop::Color => <(f32, f32, f32)>::from(scene.background).into_pyobject(py)?.into_any(),
            Backdrop::Nothing => py.None().into_bound(py),
        })
    }

    #[setter]
    fn set_background(&self, background: &Bound<'_, PyAny>) -> PyResult<()> {
        let (backdrop, color) = match background.extract::<String>() {
            Ok(name) => (named("background", &name, &[("environment", Backdrop::Environment)])?, None),
            Err(_) if background.is_none() => (Backdrop::Nothing, None),
            Err(_) => (Backdrop::Color, Some(finite_vector("background", background)?)),
        };
        let scene = &mut self.change()?.scene;
        scene.backdrop = backdrop;
        scene.background = color.map_or(scene.background, Into::into);
        Ok(())
    }

    /// Surrounds the scene with light.
    ///
    /// Args:
    ///     source: A panorama or cube in a file (.hdr, .exr, .png, .jpg, or a folder), "studio", or an array of linear RGB,
    ///         (height, width, 3), whose rows run from straight up to straight down and whose middle column is +x. Its
    ///         numbers are finite; those below 0 count as 0.
    ///     rotation: Degrees around y.
    ///     intensity: What its light is multiplied by.
    ///     blur: How blurred it is behind the surfaces, 0 to 1.
    ///     sun: Whether its brightest light is taken out of it and added as a light, which casts sharp shadows.
    #[pyo3(signature = (source, *, rotation = 0.0, intensity = 1.0, blur = 0.0, sun = true))]
    fn set_environment(
        &self,
        py: Python<'_>,
        source: &Bound<'_, PyAny>,
        rotation: f32,
        intensity: f32,
        blur: f32,
        sun: bool,
    ) -> PyResult<()> {
        let light = environment::Options { rotation, intensity, blur, sun };
        environment::set(py, self, source, &light)
    }

    /// The cameras of the file.
    #[getter]
    fn cameras(&self) -> PyResult<Vec<Camera>> {
        Ok(self.read()?.cameras.iter().cloned().map(Camera::of).collect())
    }

    /// A camera that sees the whole scene in a picture of this size (width, height).
    ///
    /// Args:
    ///     direction: From the middle of the scene to the camera; from the front, slightly above and right, if not given.
    #[pyo3(signature = (size, direction = None))]
    fn framing(&self, size: [i64; 2], direction: Option<&Bound<'_, PyAny>>) -> PyResult<Camera> {
        let [width, height] = camera::size(size)?;
        let aspect = width as f32 / height as f32;
        let direction = direction.map(|direction| finite_vector("direction", direction)).transpose()?;
        let scene = &self.read()?.scene;
        let camera = match direction {
            None => framing(scene, aspect),
            Some(direction) => framing_from(scene, aspect, direction.into()),
        };
        Ok(Camera::around(camera, String::new()))
    }

    /// The cameras of a file of cameras, as the option `--cameras` of the command reads it: rtrt's JSON, or NeRF's
    /// transforms.json. Each has a `name`, a `size`, and perhaps a `time`.
    ///
    /// Args:
    ///     path: The file.
    ///     size: Width and height of pictures of which the file does not say them; 640 x 360 if not given.
    #[pyo3(signature = (path, size = None))]
    fn load_cameras(&self, py: Python<'_>, path: PathBuf, size: Option<(i64, i64)>) -> PyResult<Vec<Camera>> {
        let read = poses::read(&path, camera::usual_size(size)?);
        let Poses { poses, warnings } = read.map_err(|error| {
            let why = error.to_string();
            if error.is_missing { PyFileNotFoundError::new_err(why) } else { PyValueError::new_err(why) }
        })?;
        for warning in warnings {
            let text = CString::new(format!("{}: {warning}", path.display())).unwrap_or_default();
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)?;
        }
        let origin = self.read()?.origin;
        Ok(poses.iter().map(|pose| Camera::posed(pose, origin)).collect())
    }

    /// Cameras evenly around the point that one looks at, as the option `--orbit` of the command has them: the first is that
    /// one, and the others follow counterclockwise, seen from above.
    ///
    /// Args:
    ///     count: How many.
    ///     camera: The first; the file's first one, or one that sees everything, as all others then do, if not given.
    ///     size: Width and height of the pictures that they see everything in; 640 x 360 if not given.
    #[pyo3(signature = (count, camera = None, size = None))]
    fn orbit(&self, count: i64, camera: Option<&Camera>, size: Option<(i64, i64)>) -> PyResult<Vec<Camera>> {
        let size = camera::usual_size(size)?;
        let count = u32::try_from(count).ok().filter(|count| (1..=1_000_000).contains(count));
        let count = count.ok_or_else(|| PyValueError::new_err("count is not within 1 .. 1000000"))?;
        let parts = self.read()?;
        let is_framed = camera.is_none() && parts.cameras.is_empty();
        let aspect = is_framed.then(|| size[0] as f32 / size[1] as f32);
        let first = camera.map_or_else(|| parts.usual_camera(size), |camera| camera.at(size));
        let all = orbit(&parts.scene, &first.camera, count, aspect);
        let name = |number: usize| format!("orbit-{number:04}");
        let all = all.into_iter().enumerate();
        let view =
            |(number, camera)| Camera::clipped(View { camera, clip: first.clip }, name(number)).sized(size);
        Ok(all.map(view).collect())
    }

    /// What coordinates are relative to, in those of the file: 0, 0, 0 unless that is so far away that single precision would
    /// round them.
    #[getter]
    fn origin(&self) -> PyResult<(f64, f64, f64)> {
        Ok(self.read()?.origin.into())
    }

    /// What is known of each object, in the order of their numbers: a list of dicts with its number `object`, its `node`, `mesh`
    /// and `material` as the file calls them, the number `material_id`, and `box`, the lower and upper corner of a box around it.
    #[getter]
    fn labels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        objects::labels(py, &*self.read()?)
    }

    /// What a picture shows of each object: a list of dicts with its number `object`, its visible `pixels`, `box_2d` (left,
    /// top, and the first column and row beyond) and `box_3d` (lower and upper corner around all of it, world space).
    ///
    /// Args:
    ///     objects: The aov "object" of a picture. What was removed since is left out.
    fn seen<'py>(&self, objects: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyList>> {
        objects::seen(&*self.read()?, objects)
    }

    /// Shows the animation of the file at a time, seconds: objects, deformed meshes, cameras and lights. What was removed stays
    /// away.
    fn play(&self, time: f64) -> PyResult<()> {
        if !(time >= 0.0 && time.is_finite()) {
            return Err(PyValueError::new_err(format!("time is {time}, and not a number of 0 or more")));
        }
        let parts = &mut *self.change()?;
        let Some(animation) = &parts.animation else { return Ok(()) };
        let pose = animation.at(time).map_err(|error| import_error(&error))?;
        pose.apply(&mut parts.scene).map_err(|error| import_error(&error))?;
        if parts.own_lights {
            pose.aim(parts.scene.lights_mut());
        }
        for (index, camera) in pose.cameras {
            parts.cameras[index].camera = camera;
        }
        Ok(())
    }

    /// The end of the animation of the file, seconds; None without one.
    #[getter]
    fn duration(&self) -> PyResult<Option<f64>> {
        Ok(self.read()?.animation.as_ref().map(Animation::end))
    }

    /// What of the file is not drawn as it says, a line each.
    #[getter]
    fn warnings(&self) -> PyResult<Vec<String>> {
        Ok(self.read()?.warnings.clone())
    }

    /// The files that the scene was read from.
    #[getter]
    fn files(&self) -> PyResult<Vec<PathBuf>> {
        Ok(self.read()?.files.clone())
    }

    /// Objects.
    #[getter]
    fn objects(&self) -> PyResult<usize> {
        Ok(self.read()?.objects.len())
    }

    /// Triangles of all objects: those of a mesh count once for each object.
    #[getter]
    fn triangles(&self) -> PyResult<u64> {
        Ok(self.read()?.scene.drawn_triangles())
    }

    /// Lower and upper corner of a box around all that is not hidden; None for an empty scene.
    #[getter]
    fn extent(&self) -> PyResult<Option<([f32; 3], [f32; 3])>> {
        Ok(self.read()?.scene.extent().map(|(low, high)| (low.to_array(), high.to_array())))
    }

    /// The closest hit of each ray, on all threads: a dict of arrays with the shape of the rays.
    ///
    /// "t" (distance in lengths of the direction; inf for a miss), "object" and "triangle" (-1 for a miss), "barycentrics"
    /// (of the triangle's second and third corner); with `surfaces` also "position", "normal" (between those of the vertices),
    /// "uv" and "material".
    ///
    /// Args:
    ///     origins: (..., 3), or one for all.
    ///     directions: (..., 3), any length but 0.
    ///     near, far: The range of t; far may be an array, one number a ray.
    ///     sides: The sides of triangles that count: "both", "fronts", "backs", or "drawn", those that a camera sees.
    #[pyo3(signature = (origins, directions, *, near = 0.0, far = None, sides = "both", surfaces = false))]
    #[expect(clippy::too_many_arguments, reason = "they are named arguments of Python")]
    fn closest<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        near: f32,
        far: Option<&Bound<'py, PyAny>>,
        sides: &str,
        surfaces: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        rays::closest(py, self, &Question { origins, directions, near, far, sides }, surfaces)
    }

    /// Whether each ray hits anything, on all threads: an array of bool. The arguments are those of `closest`.
    #[pyo3(signature = (origins, directions, *, near = 0.0, far = None, sides = "both"))]
    fn occluded<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        near: f32,
        far: Option<&Bound<'py, PyAny>>,
        sides: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        rays::occluded(py, self, &Question { origins, directions, near, far, sides })
    }

    fn __repr__(&self) -> String {
        // A debugger may show it while it is changed.
        let Ok(parts) = self.read() else { return "<rtrt.Scene that is being changed>".into() };
        let (objects, triangles) = (parts.objects.len(), parts.scene.drawn_triangles());
        format!("<rtrt.Scene of {objects} objects, {triangles} triangles>")
    }
}

/// An exception for what happens to the backend rather than to the arguments.
pub fn failed(error: impl std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}
