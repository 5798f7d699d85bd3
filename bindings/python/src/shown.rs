//! Pictures of the module `mujoco`.

use crate::arrays::{Array, bytes, wrong_shape};
use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray3};
use pyo3::prelude::*;

/// Red, green and blue of a picture, (height, width, 3), through a table of 256 bytes, and in front of another picture of that
/// shape where it is not opaque; that is needed if it is not opaque everywhere.
#[pyfunction]
#[pyo3(signature = (picture, table, behind = None))]
pub fn shown<'py>(
    py: Python<'py>,
    picture: PyReadonlyArray3<'py, u8>,
    table: &Bound<'py, PyAny>,
    behind: Option<PyReadonlyArray3<'py, u8>>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let (pixels, behind) =
        (picture.as_slice()?, behind.as_ref().map(|behind| behind.as_slice()).transpose()?);
    let [height, width, channels] = picture.as_array().shape().try_into().unwrap_or([0; 3]);
    let Array { shape, values } = bytes("table", table)?;
    let table: [u8; 256] = values.try_into().map_err(|_| wrong_shape("table", &shape, "(256,)"))?;
    if channels != 4 || behind.is_some_and(|behind| behind.len() != 3 * height * width) {
        return Err(wrong_shape("picture", &[height, width, channels], "(height, width, 4), as behind is"));
    }
    let back = |number: usize| behind.map_or([0; 3], |behind| behind.as_chunks::<3>().0[number]);
    let pixel = |(number, &[red, green, blue, alpha]): (usize, &[u8; 4])| {
        let color = [red, green, blue].map(|byte| table[usize::from(byte)]);
        match alpha {
            255 => color,
            0 => back(number),
            alpha => {
                let (share, back) = (f32::from(alpha) / 255.0, back(number));
                let mix = |n: usize| f32::from(color[n]) * share + f32::from(back[n]) * (1.0 - share);
                [0, 1, 2].map(|n| mix(n).round_ties_even() as u8)
            }
        }
    };
    let all: Vec<[u8; 3]> = py.detach(|| pixels.as_chunks::<4>().0.iter().enumerate().map(pixel).collect());
    PyArray1::from_vec(py, all.into_flattened()).reshape([height, width, 3])
}
