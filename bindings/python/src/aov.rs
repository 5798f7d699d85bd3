//! What a frame can give of each pixel.

use crate::arrays::{borrowed, output};
use crate::parts::Parts;
use numpy::{PyArrayDyn, PyReadwriteArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtrt::layers::Pixels;
use rtrt::motion::{Before, Motion, Point};
use rtrt_core::backend::{Picture, Request};

/// What a frame gives of each pixel.
#[derive(Debug, Clone, Copy)]
pub struct Aov {
    pub name: &'static str,
    read: Read,
}

#[derive(Debug, Clone, Copy)]
enum Read {
    /// The picture: red, green, blue, alpha, 8 bits each.
    Picture,
    Number(fn(&Pixels<'_>, u32) -> f32),
    Two(fn(&Pixels<'_>, u32) -> [f32; 2]),
    Three(fn(&Pixels<'_>, u32) -> [f32; 3]),
    Four(fn(&Pixels<'_>, u32) -> [f32; 4]),
    /// How far it moved, two numbers.
    Motion,
    /// A number of a thing, −1 for none.
    Id(fn(&Pixels<'_>, u32) -> u32),
    /// The number of an object, −1 for none.
    Object,
}

const ALL: [Aov; 14] = [
    Aov { name: "rgba", read: Read::Picture },
    Aov { name: "color", read: Read::Four(|pixels, n| pixels.color(n)) },
    Aov { name: "depth", read: Read::Number(|pixels, n| pixels.depth(n)) },
    Aov { name: "normal", read: Read::Three(|pixels, n| pixels.normal(n)) },
    Aov { name: "albedo", read: Read::Three(|pixels, n| pixels.albedo(n)) },
    Aov { name: "object", read: Read::Object },
    Aov { name: "material", read: Read::Id(|pixels, n| pixels.material(n)) },
    Aov { name: "triangle", read: Read::Id(|pixels, n| pixels.triangle(n)) },
    Aov { name: "source", read: Read::Id(|pixels, n| pixels.source(n)) },
    Aov { name: "barycentrics", read: Read::Two(|pixels, n| pixels.barycentrics(n)) },
    Aov { name: "uv", read: Read::Two(|pixels, n| pixels.uv(n)) },
    Aov { name: "position", read: Read::Three(|pixels, n| pixels.position(n)) },
    Aov { name: "shadow", read: Read::Number(|pixels, n| pixels.shadow(n)) },
    Aov { name: "motion", read: Read::Motion },
];

/// The names of all.
pub fn names() -> impl Iterator<Item = &'static str> {
    ALL.iter().map(|aov| aov.name)
}

impl Aov {
    /// The one of this name.
    pub fn named(name: &str) -> PyResult<Self> {
        ALL.into_iter().find(|aov| aov.name == name).ok_or_else(|| {
            let known = names().collect::<Vec<_>>().join(", ");
            PyValueError::new_err(format!("aov {name:?} is not one of {known}"))
        })
    }

    /// Whether it comes from the deferred buffers.
    pub fn is_deferred(self) -> bool {
        !matches!(self.read, Read::Picture)
    }

    /// Whether it needs to know how the scene was before.
    pub fn is_motion(self) -> bool {
        matches!(self.read, Read::Motion)
    }

    /// Numbers a pixel.
    fn components(self) -> usize {
        match self.read {
            Read::Number(_) | Read::Id(_) | Read::Object => 1,
            Read::Two(_) | Read::Motion => 2,
            Read::Three(_) => 3,
            Read::Four(_) | Read::Picture => 4,
        }
    }

    /// The shape of its array: `before` (a number of pictures, or nothing), rows, columns, and numbers a pixel.
    fn shape(self, before: Option<usize>, [width, height]: [u32; 2]) -> Vec<usize> {
        let pixels = [height as usize, width as usize];
        let components = Some(self.components()).filter(|count| *count > 1);
        before.into_iter().chain(pixels).chain(components).collect()
    }

    /// A new array.
    pub fn zeros<'py>(
        self,
        py: Python<'py>,
        before: Option<usize>,
        size: [u32; 2],
    ) -> PyResult<Bound<'py, PyAny>> {
        let dtype = match self.read {
            Read::Picture => numpy::dtype::<u8>(py),
            Read::Id(_) | Read::Object => numpy::dtype::<i32>(py),
            _ => numpy::dtype::<f32>(py),
        };
        // By NumPy itself, which raises MemoryError.
        py.import("numpy")?.call_method1("zeros", (self.shape(before, size), dtype))
    }

    /// The memory of an array.
    pub fn memory<'py>(
        self,
        array: &Bound<'py, PyAny>,
        before: Option<usize>,
        size: [u32; 2],
    ) -> PyResult<Memory<'py>> {
        let (name, shape) = (self.name, &self.shape(before, size));
        Ok(match self.read {
            Read::Picture => Memory::Bytes(output(name, array, shape)?),
            Read::Id(_) | Read::Object => Memory::Ids(self, output(name, array, shape)?),
            _ => Memory::Floats(self, output(name, array, shape)?),
        })
    }
}

/// The memory of an array.
pub enum Memory<'py> {
    Bytes(PyReadwriteArrayDyn<'py, u8>),
    Floats(Aov, PyReadwriteArrayDyn<'py, f32>),
    Ids(Aov, PyReadwriteArrayDyn<'py, i32>),
}

/// The part of an array that belongs to one picture.
pub enum Part<'a> {
    Bytes(&'a mut [u8]),
    Floats(Aov, &'a mut [f32]),
    Ids(Aov, &'a mut [i32]),
}

impl Memory<'_> {
    /// The parts that belong to each of the pictures of so many pixels.
    pub fn parts(&mut self, pixels: usize) -> PyResult<Vec<Part<'_>>> {
        Ok(match self {
            Self::Bytes(array) => {
                array.as_slice_mut()?.chunks_exact_mut(4 * pixels).map(Part::Bytes).collect()
            }
            Self::Floats(aov, array) => {
                let parts = array.as_slice_mut()?.chunks_exact_mut(aov.components() * pixels);
                parts.map(|part| Part::Floats(*aov, part)).collect()
            }
            Self::Ids(aov, array) => {
                array.as_slice_mut()?.chunks_exact_mut(pixels).map(|part| Part::Ids(*aov, part)).collect()
            }
        })
    }
}

impl Part<'_> {
    /// Fills it with what the picture gives. What of motion there is, is that since `before`.
    pub fn fill(&mut self, parts: &Parts, request: &Request<'_>, picture: &Picture, before: Option<&Before>) {
        if let Part::Bytes(part) = self {
            part.copy_from_slice(&picture.bytes());
            return;
        }
        // What needs them has asked for the deferred buffers.
        let Some(pixels) = Pixels::new(&parts.scene, request, picture) else { return };
        match self {
            Part::Bytes(_) => {}
            Part::Floats(aov, part) => match aov.read {
                Read::Number(read) => {
                    (0..).zip(part.iter_mut()).for_each(|(n, value)| *value = read(&pixels, n))
                }
                Read::Two(read) => each(part, &pixels, read),
                Read::Three(read) => each(part, &pixels, read),
                Read::Four(read) => each(part, &pixels, read),
                Read::Motion => {
                    let Some(before) = before else { return };
                    let motion = Motion::new(&parts.scene, request.camera, request.size, before);
                    each(part, &pixels, |pixels, n| {
                        motion.of(&Point {
                            object: pixels.object(n),
                            triangle: pixels.triangle(n),
                            barycentrics: pixels.barycentrics(n),
                            position: pixels.position(n),
                        })
                    });
                }
                Read::Picture | Read::Id(_) | Read::Object => {}
            },
            Part::Ids(aov, part) => {
                let objects = &parts.objects;
                for (n, id) in (0..).zip(part.iter_mut()) {
                    *id = match aov.read {
                        Read::Id(read) => read(&pixels, n).cast_signed(),
                        _ => objects.at(pixels.object(n)),
                    };
                }
            }
        }
    }
}

fn each<const N: usize>(part: &mut [f32], pixels: &Pixels<'_>, read: impl Fn(&Pixels<'_>, u32) -> [f32; N]) {
    (0..).zip(part.as_chunks_mut::<N>().0).for_each(|(n, values)| *values = read(pixels, n));
}

/// The ids of objects in an array of two dimensions, as pictures have them.
pub fn objects(array: &Bound<'_, PyAny>) -> PyResult<(u32, u32, Vec<u32>)> {
    use numpy::{PyArrayMethods, PyUntypedArrayMethods};
    let wrong = || {
        PyValueError::new_err("objects is no array of int32 with two dimensions, as the aov \"object\" is")
    };
    let array = array.cast::<PyArrayDyn<i32>>().map_err(|_| wrong())?;
    let &[height, width] = array.shape() else { return Err(wrong()) };
    let array = array.try_readonly().map_err(|error| borrowed("objects", &error))?;
    let ids = array.as_array().iter().copied().map(i32::cast_unsigned).collect();
    Ok((u32::try_from(width).map_err(|_| wrong())?, u32::try_from(height).map_err(|_| wrong())?, ids))
}
