//! Rays that programs ask.

use crate::arrays::{Array, floats, named, wrong_shape};
use crate::backend::threads;
use crate::parts::Parts;
use crate::scene::Scene;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rtrt_core::layout::NONE;
use rtrt_core::query::{Hit, QueryError, Ray, Sides, Tree, World};
use std::sync::PoisonError;

/// The options of all rays of a call.
pub struct Question<'a, 'py> {
    pub origins: &'a Bound<'py, PyAny>,
    pub directions: &'a Bound<'py, PyAny>,
    pub near: f32,
    pub far: Option<&'a Bound<'py, PyAny>>,
    pub sides: &'a str,
}

impl Question<'_, '_> {
    /// The rays, and the shape of the results.
    fn rays(&self) -> PyResult<(Vec<Ray>, Vec<usize>)> {
        let kinds = [
            ("both", Sides::Both),
            ("fronts", Sides::Fronts),
            ("backs", Sides::Backs),
            ("drawn", Sides::Drawn),
        ];
        let sides = named("sides", self.sides, &kinds)?;
        let (starts, before) = vectors("origins", self.origins)?;
        let (ways, shape) = vectors("directions", self.directions)?;
        // One origin serves all directions.
        if starts.len() != 1 && before != shape {
            let expected = format!("(3,) or that of directions, {shape:?} x 3");
            return Err(wrong_shape("origins", &[&before[..], &[3]].concat(), &expected));
        }
        let ends = match self.far {
            None => vec![f32::INFINITY],
            Some(far) => floats::<f32>("far", far)?.values,
        };
        if ends.len() != 1 && ends.len() != ways.len() {
            let why = format!("far holds {} numbers, but there are {} rays", ends.len(), ways.len());
            return Err(PyValueError::new_err(why));
        }
        let of = |all: &[[f32; 3]], n: usize| if all.len() == 1 { all[0] } else { all[n] };
        let ray = |(n, way): (usize, &[f32; 3])| {
            let end = if ends.len() == 1 { ends[0] } else { ends[n] };
            Ray::new(of(&starts, n), *way).starting(self.near).until(end).sides(sides)
        };
        Ok((ways.iter().enumerate().map(ray).collect(), shape))
    }
}

/// Vectors of three, and the shape around them.
fn vectors(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<[f32; 3]>, Vec<usize>)> {
    let Array { shape, values } = floats::<f32>(name, value)?;
    match shape[..] {
        [ref before @ .., 3] => Ok((values.as_chunks::<3>().0.to_vec(), before.to_vec())),
        _ => Err(wrong_shape(name, &shape, "(..., 3)")),
    }
}

/// The answers, or the first ray that was refused.
fn answered<T>(answers: Vec<Result<T, QueryError>>) -> PyResult<Vec<T>> {
    let answer = |(number, answer): (usize, Result<T, QueryError>)| {
        answer.map_err(|error| PyValueError::new_err(format!("ray {number}: {error}")))
    };
    answers.into_iter().enumerate().map(answer).collect()
}

/// Does this with the world of a scene, detached from Python.
fn with_world<T: Send>(
    py: Python<'_>,
    scene: &Parts,
    work: impl FnOnce(&rtrt_cpu::Cpu, &World<'_>) -> T + Send,
) -> PyResult<T> {
    let (cpu, tree) = (threads(py)?, scene.tree.get(py));
    py.detach(|| {
        let mut tree = tree.lock().unwrap_or_else(PoisonError::into_inner);
        let tree: &mut Tree = &mut tree;
        cpu.install(|| Tree::update(tree, &scene.scene, &rtrt_cpu::Parallel));
        Ok(work(&cpu, &tree.world(&scene.scene)))
    })
}

/// Whether each ray hits anything.
pub fn occluded<'py>(
    py: Python<'py>,
    scene: &Scene,
    question: &Question<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let (rays, shape) = question.rays()?;
    let scene = &*scene.read()?;
    let answers = with_world(py, scene, |cpu, world| {
        let mut answers = vec![Ok(false); rays.len()];
        cpu.occluded(world, &rays, &mut answers);
        answers
    })?;
    Ok(PyArray1::from_vec(py, answered(answers)?).reshape(shape)?.into_any())
}

/// What is known of hits: arrays to be.
#[derive(Default)]
struct Columns {
    t: Vec<f32>,
    object: Vec<i32>,
    triangle: Vec<i32>,
    barycentrics: Vec<f32>,
    position: Vec<f32>,
    normal: Vec<f32>,
    uv: Vec<f32>,
    material: Vec<i32>,
}

impl Columns {
    fn new(scene: &Parts, world: &World<'_>, hits: &[Option<Hit>], surfaces: bool) -> Self {
        let mut all = Self::default();
        let id = |number: Option<u32>| number.unwrap_or(NONE).cast_signed();
        for hit in hits {
            all.t.push(hit.map_or(f32::INFINITY, |hit| hit.t));
            all.object.push(hit.map_or(-1, |hit| scene.objects.at(hit.instance.number())));
            all.triangle.push(id(hit.and_then(|hit| world.source_triangle(&hit))));
            all.barycentrics.extend(hit.map_or([0.0; 2], |hit| [hit.u, hit.v]));
            if surfaces {
                let surface = hit.and_then(|hit| world.surface(&hit));
                all.position.extend(surface.map_or([0.0; 3], |surface| surface.position));
                all.normal.extend(surface.map_or([0.0; 3], |surface| surface.smooth_normal));
                all.uv.extend(surface.and_then(|surface| surface.uv).unwrap_or_default());
                let instance =
                    hit.and_then(|hit| scene.scene.instances().get(hit.instance.number() as usize));
                all.material.push(id(instance.map(|instance| instance.material)));
            }
        }
        all
    }
}

/// The closest hit of each ray.
pub fn closest<'py>(
    py: Python<'py>,
    scene: &Scene,
    question: &Question<'_, 'py>,
    surfaces: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (rays, shape) = question.rays()?;
    let scene = &*scene.read()?;
    let columns = with_world(py, scene, |cpu, world| {
        let mut answers = vec![Ok(None); rays.len()];
        cpu.closest(world, &rays, &mut answers);
        Ok::<_, PyErr>(Columns::new(scene, world, &answered(answers)?, surfaces))
    })??;
    let wide = |count: usize| [&shape[..], &[count]].concat();
    let result = PyDict::new(py);
    let Columns { t, object, triangle, barycentrics, position, normal, uv, material } = columns;
    result.set_item("t", PyArray1::from_vec(py, t).reshape(&shape[..])?)?;
    result.set_item("object", PyArray1::from_vec(py, object).reshape(&shape[..])?)?;
    result.set_item("triangle", PyArray1::from_vec(py, triangle).reshape(&shape[..])?)?;
    result.set_item("barycentrics", PyArray1::from_vec(py, barycentrics).reshape(wide(2))?)?;
    if surfaces {
        result.set_item("position", PyArray1::from_vec(py, position).reshape(wide(3))?)?;
        result.set_item("normal", PyArray1::from_vec(py, normal).reshape(wide(3))?)?;
        result.set_item("uv", PyArray1::from_vec(py, uv).reshape(wide(2))?)?;
        result.set_item("material", PyArray1::from_vec(py, material).reshape(&shape[..])?)?;
    }
    Ok(result)
}
