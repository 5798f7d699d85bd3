//! The objects of a scene, as Python names them: instances of meshes, and spheres.

use crate::aov::objects;
use crate::arrays::{Array, integers, matrices};
use crate::numbers::Numbers;
use crate::parts::Parts;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rtrt::import::Label;
use rtrt::layers::Layers;
use rtrt::objects::Seen;
use rtrt_core::layout::{Instance, NONE};
use rtrt_core::scene::{InstanceIndex, Scene};
use std::cell::Cell;

/// An object: where the scene has it, and what it is called.
#[derive(Clone)]
struct Object {
    index: InstanceIndex,
    label: Label,
}

/// The objects of a scene, by numbers that are given once.
///
/// A scene gives the place of an instance that was removed to the next one. Pictures and rays name places.
#[derive(Clone)]
pub struct Objects {
    all: Numbers<Object>,
    /// The numbers of the objects at the places of the scene, or that were there last.
    of_places: Vec<i32>,
}

impl Objects {
    /// Those of a scene whose places have these labels.
    pub fn new(scene: &Scene, labels: Vec<Label>) -> Self {
        let mut objects = Self { all: Numbers::new("object", ""), of_places: vec![] };
        let labels = labels.into_iter().chain(std::iter::repeat_with(Label::default));
        for (place, label) in (0..scene.instances().len() as u32).zip(labels) {
            if let Some(index) = scene.instance_index(place) {
                objects.add(index, label);
            }
        }
        objects
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// The number of the object that is added next.
    ///
    /// # Errors
    /// All numbers were given.
    pub fn next(&self) -> PyResult<i32> {
        self.all.next()
    }

    /// Adds what the scene has at a place, and returns its number.
    pub fn add(&mut self, index: InstanceIndex, label: Label) -> i32 {
        let (place, number) = (index.number() as usize, self.all.add(Object { index, label }));
        self.of_places.resize(self.of_places.len().max(place + 1), -1);
        self.of_places[place] = number;
        number
    }

    /// Forgets what was removed from the scene.
    pub fn remove(&mut self, number: i64) {
        self.all.remove(number);
    }

    /// The object with a number, in the scene that these are of.
    fn find(&self, scene: &Scene, number: i64) -> Option<InstanceIndex> {
        match u32::try_from(number) {
            // As long as no place is taken again, numbers are places: many are found in less time.
            Ok(place) if i64::from(self.at(place)) == number => scene.instance_index(place),
            _ => self.all.find(number).map(|object| object.index),
        }
    }

    /// The object with a number, in the scene that these are of.
    ///
    /// # Errors
    /// `IndexError`: there is none.
    pub fn index(&self, scene: &Scene, number: i64) -> PyResult<InstanceIndex> {
        self.find(scene, number).ok_or_else(|| self.all.missing(number))
    }

    /// The number of what is at a place; −1 for [`NONE`].
    pub fn at(&self, place: u32) -> i32 {
        self.of_places.get(place as usize).copied().unwrap_or(-1)
    }

    /// Numbers, labels and instances, in the order of numbers.
    fn all<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = (i32, &'a Label, &'a Instance)> {
        let instance = |object: &Object| scene.instances().get(object.index.number() as usize);
        self.all.iter().filter_map(move |(number, object)| Some((number, &object.label, instance(object)?)))
    }
}

/// Moves many objects; none if one of them is not there.
pub fn set_transforms(
    scene: &crate::scene::Scene,
    objects: &Bound<'_, PyAny>,
    transforms: &Bound<'_, PyAny>,
) -> PyResult<()> {
    let Array { shape, values: numbers } = integers("objects", objects)?;
    let Array { shape: many, values: transforms } = matrices("transforms", transforms)?;
    if shape.len() != 1 || many.len() != 1 || many != shape {
        let expected = "n numbers of objects and n matrices";
        let why =
            format!("objects and transforms are not {expected}, but have the shapes {shape:?} and {many:?}");
        return Err(PyValueError::new_err(why));
    }
    let parts = &mut *scene.change()?;
    let known = &parts.objects;
    let index = |(at, &number): (usize, &i64)| {
        known.find(&parts.scene, number).ok_or_else(|| {
            let why = known.all.why_not(number);
            PyIndexError::new_err(format!("objects holds {number} at place {at}: {why}"))
        })
    };
    let moved: Vec<_> = numbers.iter().enumerate().map(index).collect::<PyResult<_>>()?;
    let place = Cell::new(0);
    let moves = moved.into_iter().zip(transforms).enumerate().map(|(at, one)| {
        place.set(at);
        one
    });
    parts.scene.set_transforms(moves).map_err(|error| {
        let at = place.get();
        PyValueError::new_err(format!("transforms[{at}], of object {}: {error}", numbers[at]))
    })
}

/// The matrices of all objects.
pub fn transforms<'py>(py: Python<'py>, parts: &Parts) -> PyResult<Bound<'py, PyAny>> {
    use numpy::{PyArray1, PyArrayMethods};
    let last = [0.0, 0.0, 0.0, 1.0];
    let all = parts.objects.all(&parts.scene);
    let numbers = all.flat_map(|(_, _, i)| i.to_world.into_iter().chain([last]).flatten()).collect();
    Ok(PyArray1::<f32>::from_vec(py, numbers).reshape([parts.objects.len(), 4, 4])?.into_any())
}

/// What is known of each object.
pub fn labels<'py>(py: Python<'py>, parts: &Parts) -> PyResult<Bound<'py, PyList>> {
    let all = PyList::empty(py);
    for (number, label, instance) in parts.objects.all(&parts.scene) {
        let entry = PyDict::new(py);
        entry.set_item("object", number)?;
        entry.set_item("node", &label.node)?;
        entry.set_item("mesh", &label.mesh)?;
        entry.set_item("material", &label.material)?;
        entry.set_item("material_id", instance.material)?;
        entry.set_item("box", (instance.low.to_vec(), instance.high.to_vec()))?;
        all.append(entry)?;
    }
    Ok(all)
}

/// What the aov "object" of a picture shows of each object.
pub fn seen<'py>(parts: &Parts, picture: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyList>> {
    let (width, height, mut object) = objects(picture)?;
    for number in &mut object {
        let index = parts.objects.find(&parts.scene, number.cast_signed().into());
        *number = index.map_or(NONE, InstanceIndex::number);
    }
    let mut found = rtrt::objects::seen(&parts.scene, &Layers { width, height, object, ..Layers::default() });
    found.sort_by_key(|seen| parts.objects.at(seen.object));
    let all = PyList::empty(picture.py());
    for Seen { object, pixels, box_2d, box_3d } in found {
        let entry = PyDict::new(picture.py());
        entry.set_item("object", parts.objects.at(object))?;
        entry.set_item("pixels", pixels)?;
        entry.set_item("box_2d", box_2d.to_vec())?;
        entry.set_item("box_3d", box_3d.map(|corner| corner.to_vec()).to_vec())?;
        all.append(entry)?;
    }
    Ok(all)
}
