//! Meshes, pictures and places, from arrays of Python.

use crate::arrays::{
    Array, are_finite, bytes, finite_vector, floats, indices, matrices, refused, rows, wrong_shape,
};
use glam::{Mat4, Quat, Vec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtrt_core::layout::Attribute;
use rtrt_core::scene::{Image, Mesh, Panorama};

/// One matrix, or the identity.
pub fn place(transform: Option<&Bound<'_, PyAny>>) -> PyResult<Mat4> {
    let Some(value) = transform else { return Ok(Mat4::IDENTITY) };
    let Array { shape, values } = matrices("transform", value)?;
    match values[..] {
        [matrix] if shape.is_empty() => Ok(matrix),
        _ => Err(PyValueError::new_err("transform is not one matrix of 4 x 4 or 3 x 4")),
    }
}

/// The matrix of a sphere that has a center and a radius, or a matrix.
pub fn ball(
    center: Option<&Bound<'_, PyAny>>,
    radius: Option<f32>,
    transform: Option<&Bound<'_, PyAny>>,
) -> PyResult<Mat4> {
    if transform.is_some() && (center.is_some() || radius.is_some()) {
        return Err(PyValueError::new_err("a sphere has a center and a radius, or a transform"));
    }
    match transform {
        Some(_) => place(transform),
        None => {
            let center = center.map_or(Ok([0.0; 3]), |center| finite_vector("center", center))?;
            let radius = radius.unwrap_or(1.0);
            if !(radius > 0.0 && radius.is_finite()) {
                return Err(PyValueError::new_err(format!("radius is {radius}, and not a number above 0")));
            }
            let (size, center) = (Vec3::splat(radius), center.into());
            Ok(Mat4::from_scale_rotation_translation(size, Quat::IDENTITY, center))
        }
    }
}

/// Vertices with what is known of them.
pub fn mesh(
    positions: &Bound<'_, PyAny>,
    triangles: Option<&Bound<'_, PyAny>>,
    normals: Option<&Bound<'_, PyAny>>,
    uvs: Option<&Bound<'_, PyAny>>,
    colors: Option<&Bound<'_, PyAny>>,
) -> PyResult<Mesh> {
    let positions = rows::<3>("positions", positions)?;
    let count = positions.len();
    let triangles = match triangles {
        None => (0..count as u32).collect(),
        Some(value) => {
            let Array { shape, values } = indices("triangles", value, count, "position")?;
            if !(values.is_empty() || shape.len() == 2 && shape[1] == 3) {
                return Err(wrong_shape("triangles", &shape, "(m, 3)"));
            }
            values
        }
    };
    let fits = |name: &str, has: usize| {
        if has == count {
            return Ok(());
        }
        Err(PyValueError::new_err(format!("{name} has {has} rows, but there are {count} positions")))
    };
    let normals = normals.map(|value| rows::<3>("normals", value)).transpose()?;
    let uvs = uvs.map(|value| rows::<2>("uvs", value)).transpose()?;
    let colors = colors.map(vertex_colors).transpose()?;
    normals.as_ref().map_or(Ok(()), |all| fits("normals", all.len()))?;
    uvs.as_ref().map_or(Ok(()), |all| fits("uvs", all.len()))?;
    colors.as_ref().map_or(Ok(()), |all| fits("colors", all.len()))?;
    let attribute = |vertex: usize| Attribute {
        normal: normals.as_ref().map_or([0.0; 3], |all| all[vertex]),
        uv: uvs.as_ref().map_or([0.0; 2], |all| all[vertex]),
        color: colors.as_ref().map_or(Attribute::WHITE, |all| all[vertex]),
    };
    Mesh::new(positions, (0..count).map(attribute).collect(), triangles).map_err(refused)
}

/// Colors of vertices: bytes of linear RGB or RGBA.
fn vertex_colors(value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 2]>> {
    let Array { shape, values } = bytes("colors", value)?;
    let pack = |rgba: [u8; 4]| Attribute::pack_color(rgba.map(|byte| f32::from(byte) / 255.0));
    match shape[..] {
        [_, 3] => Ok(values.as_chunks::<3>().0.iter().map(|&[r, g, b]| pack([r, g, b, 255])).collect()),
        [_, 4] => Ok(values.as_chunks::<4>().0.iter().map(|&rgba| pack(rgba)).collect()),
        _ => Err(wrong_shape("colors", &shape, "(n, 3) or (n, 4)")),
    }
}

/// Bytes of a picture with alpha.
pub fn image(value: &Bound<'_, PyAny>) -> PyResult<Image> {
    let Array { shape, values } = bytes("pixels", value)?;
    let (height, width, rgba) = match shape[..] {
        [height, width] => (height, width, values.iter().flat_map(|&v| [v, v, v, 255]).collect()),
        [height, width, 3] => {
            let rgb = values.as_chunks::<3>().0;
            (height, width, rgb.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect())
        }
        [height, width, 4] => (height, width, values),
        _ => return Err(wrong_shape("pixels", &shape, "(height, width), with 3 or 4 channels or none")),
    };
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    Ok(Image { width: side(width), height: side(height), rgba })
}

/// Linear light from all around.
pub fn panorama(source: &Bound<'_, PyAny>) -> PyResult<Panorama> {
    let Array { shape, values } = floats::<f32>("source", source)?;
    let [height, width, 3] = shape[..] else {
        return Err(wrong_shape("source", &shape, "(height, width, 3)"));
    };
    are_finite("source", &shape, &values)?;
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    Ok(Panorama { width: side(width), height: side(height), rgb: values.as_chunks::<3>().0.to_vec() })
}
