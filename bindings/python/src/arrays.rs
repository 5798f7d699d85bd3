//! Arguments as numbers of one kind, in the order of rows, with errors that name the argument.

use glam::{DMat4, DVec4, Mat4};
use numpy::{
    BorrowError, Element, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadwriteArrayDyn,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyIndexError, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;
use pyo3::types::PyType;

/// The most elements of an argument: those of the positions of a mesh in which no triangles share vertices.
const MOST: usize = 9 << 25;

/// A copy of an array.
pub struct Array<T> {
    pub shape: Vec<usize>,
    pub values: Vec<T>,
}

/// Numbers with or without fractions, as `f32` or `f64`.
pub fn floats<T: Element + Copy>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Array<T>> {
    array(name, value, "fiu", "numbers")
}

/// Whole numbers.
pub fn integers(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Array<i64>> {
    array(name, value, "iu", "whole numbers")
}

/// Bytes.
pub fn bytes(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Array<u8>> {
    array(name, value, "u1", "bytes (uint8)")
}

/// A copy of what NumPy makes an array of, if its kind is among `kinds`: letters, or, with a size, exactly that.
fn array<T: Element + Copy>(
    name: &str,
    value: &Bound<'_, PyAny>,
    kinds: &str,
    what: &str,
) -> PyResult<Array<T>> {
    let py = value.py();
    let numpy = py.import("numpy")?;
    let found = numpy.call_method1("asarray", (value,));
    let found = found.map_err(|error| renamed(py, error, name))?;
    let plain =
        found.cast::<PyUntypedArray>().map_err(|_| PyTypeError::new_err(format!("{name} is no array")))?;
    let (kind, size) = (char::from(plain.dtype().kind()), plain.dtype().itemsize());
    let is_known = kinds.contains(kind) && (!kinds.ends_with('1') || size == 1);
    // An empty list is an array of `float64`.
    if !is_known && !plain.is_empty() {
        let dtype = plain.dtype();
        return Err(PyTypeError::new_err(format!(
            "{name} has the dtype {dtype}, which is not one of {what}"
        )));
    }
    if plain.len() > MOST {
        let count = plain.len();
        return Err(PyValueError::new_err(format!("{name} has {count} elements, more than {MOST}")));
    }
    let options =
        [("dtype", numpy::dtype::<T>(py).into_any()), ("requirements", "CA".into_pyobject(py)?.into_any())];
    let options = options.into_py_dict(py)?;
    let converted = numpy.call_method("require", (found,), Some(&options))?;
    let converted =
        converted.cast_into::<PyArrayDyn<T>>().map_err(|error| PyTypeError::new_err(error.to_string()))?;
    let read = converted.try_readonly().map_err(|error| borrowed(name, &error))?;
    Ok(Array { shape: converted.shape().to_vec(), values: read.as_slice()?.to_vec() })
}

/// The error for an array that another call fills.
pub fn borrowed(name: &str, error: &BorrowError) -> PyErr {
    match error {
        BorrowError::AlreadyBorrowed => PyRuntimeError::new_err(format!(
            "{name} is in use by another call, or twice by this one: give each its own array"
        )),
        error => PyValueError::new_err(format!("{name}: {error}")),
    }
}

/// The error with the name of the argument before it.
fn renamed(py: Python<'_>, error: PyErr, name: &str) -> PyErr {
    let kind: Bound<'_, PyType> = error.get_type(py);
    PyErr::from_type(kind, format!("{name}: {}", error.value(py)))
}

/// A shape as NumPy prints it, with names for what may be any number.
pub fn wrong_shape(name: &str, shape: &[usize], expected: &str) -> PyErr {
    let shape = match shape {
        [one] => format!("({one},)"),
        shape => format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
    };
    PyValueError::new_err(format!("{name} has the shape {shape}, and not {expected}"))
}

/// Rows of `N` numbers.
pub fn rows<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f32; N]>> {
    let Array { shape, values } = floats::<f32>(name, value)?;
    if values.is_empty() && (shape.len() == 1 || shape.last() == Some(&N)) {
        return Ok(vec![]);
    }
    if shape.len() != 2 || shape[1] != N {
        return Err(wrong_shape(name, &shape, &format!("(n, {N})")));
    }
    Ok(values.as_chunks::<N>().0.to_vec())
}

/// A vector.
pub fn vector<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[f32; N]> {
    let Array { shape, values } = floats::<f32>(name, value)?;
    values.try_into().map_err(|_| wrong_shape(name, &shape, &format!("({N},)")))
}

/// A finite vector.
pub fn finite_vector<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[f32; N]> {
    let found = vector(name, value)?;
    are_finite(name, &[N], &found)?;
    Ok(found)
}

/// Checks that no number of an array of this shape is infinite or NaN.
pub fn are_finite(name: &str, shape: &[usize], values: &[f32]) -> PyResult<()> {
    let Some(place) = values.iter().position(|value| !value.is_finite()) else { return Ok(()) };
    let value = values[place];
    if shape.is_empty() {
        return Err(PyValueError::new_err(format!("{name} is {value}, which is not finite")));
    }
    let mut rest = place;
    let mut index: Vec<String> = Vec::new();
    for side in shape.iter().rev() {
        index.insert(0, (rest % side).to_string());
        rest /= side;
    }
    let index = index.join(", ");
    Err(PyValueError::new_err(format!("{name} holds {value} at [{index}], which is not finite")))
}

/// How many things there are, in words: `there are 2 meshes, 0 and 1`.
pub fn there_are(count: usize, what: &str) -> String {
    let plural = if what.ends_with('h') { "es" } else { "s" };
    match count {
        0 => format!("there are no {what}{plural}"),
        1 => format!("there is one {what}, 0"),
        count => format!("there are {count} {what}{plural}, 0 to {}", count - 1),
    }
}

/// Numbers from 0 below `count`, each of which is one of `what`.
pub fn indices(name: &str, value: &Bound<'_, PyAny>, count: usize, what: &str) -> PyResult<Array<u32>> {
    let Array { shape, values } = integers(name, value)?;
    let index = |(place, value): (usize, i64)| {
        let found = u32::try_from(value).ok().filter(|&index| (index as usize) < count);
        found.ok_or_else(|| {
            PyIndexError::new_err(format!(
                "{name} holds {value} at place {place}: {}",
                there_are(count, what)
            ))
        })
    };
    let values = values.into_iter().enumerate().map(index).collect::<PyResult<_>>()?;
    Ok(Array { shape, values })
}

/// Matrices of 4 rows, or of the 3 that are not 0, 0, 0, 1.
pub fn matrices(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Array<Mat4>> {
    let Array { shape, values } = floats::<f32>(name, value)?;
    let read = |numbers: &[f32]| {
        let row = |row: usize| match numbers.get(4 * row..4 * row + 4) {
            Some(&[x, y, z, w]) => [x, y, z, w],
            _ => [0.0, 0.0, 0.0, 1.0],
        };
        Mat4::from_cols_array_2d(&[0, 1, 2, 3].map(row)).transpose()
    };
    match shape[..] {
        [ref before @ .., rows @ (3 | 4), 4] => {
            let values = values.chunks_exact(4 * rows).map(read).collect();
            Ok(Array { shape: before.to_vec(), values })
        }
        _ => Err(wrong_shape(name, &shape, "(..., 4, 4) or (..., 3, 4)")),
    }
}

/// One such matrix, in double precision.
pub fn matrix(name: &str, value: &Bound<'_, PyAny>) -> PyResult<DMat4> {
    let Array { shape, values } = floats::<f64>(name, value)?;
    let [rows @ (3 | 4), 4] = shape[..] else { return Err(wrong_shape(name, &shape, "(4, 4) or (3, 4)")) };
    let row = |row: usize| if row < rows { DVec4::from_slice(&values[4 * row..]) } else { DVec4::W };
    Ok(DMat4::from_cols(row(0), row(1), row(2), row(3)).transpose())
}

/// The memory of an array of this shape that results are written into.
pub fn output<'py, T: Element>(
    name: &str,
    value: &Bound<'py, PyAny>,
    shape: &[usize],
) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    let py = value.py();
    let wanted = numpy::dtype::<T>(py);
    let array = value
        .cast::<PyUntypedArray>()
        .map_err(|_| PyTypeError::new_err(format!("out[{name:?}] is no array of NumPy")))?;
    let has = array.dtype();
    let array = value
        .cast::<PyArrayDyn<T>>()
        .map_err(|_| PyTypeError::new_err(format!("out[{name:?}] has the dtype {has}, and not {wanted}")))?;
    if array.shape() != shape {
        let expected = format!("{shape:?}").replace('[', "(").replace(']', ")");
        return Err(wrong_shape(&format!("out[{name:?}]"), array.shape(), &expected));
    }
    let refused = |why: String| PyValueError::new_err(format!("out[{name:?}]: {why}"));
    if !array.is_c_contiguous() || !array.is_aligned() {
        return Err(refused("it is not contiguous in the order of rows, or not aligned".into()));
    }
    array.try_readwrite().map_err(|error| borrowed(&format!("out[{name:?}]"), &error))
}

/// `ValueError` with what an error says.
pub fn refused(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The one of these that is called so.
pub fn named<T: Copy>(what: &str, name: &str, all: &[(&str, T)]) -> PyResult<T> {
    all.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<_> = all.iter().map(|(known, _)| *known).collect();
        PyValueError::new_err(format!("{what} is {name:?}, and not one of {}", known.join(", ")))
    })
}
