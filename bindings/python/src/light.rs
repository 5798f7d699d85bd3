//! Lights.

use crate::arrays::finite_vector as finite;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtrt_core::scene::{Light as CoreLight, LightKind};

/// A light; `Light.point`, `Light.spot` and `Light.sun` make them.
///
/// `color` is linear RGB: lux for a sun, candela for points and spots with `inverse_square`, and otherwise what arrives at
/// distance 0. A white surface that faces a light of pi is white, which is the color if none is given.
#[pyclass(frozen, module = "rtrt", from_py_object)]
#[derive(Clone)]
pub struct Light {
    pub light: CoreLight,
}

fn colored(light: CoreLight, color: Option<&Bound<'_, PyAny>>) -> PyResult<CoreLight> {
    color.map_or(Ok(light), |color| Ok(light.color(finite("color", color)?)))
}

/// A number from `low` to `high`.
fn within(name: &str, value: f32, low: f32, high: f32) -> PyResult<f32> {
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(PyValueError::new_err(format!("{name} is {value}, which is not within {low} .. {high}")))
}

fn reaching(light: CoreLight, reach: Option<f32>, inverse_square: bool, radius: f32) -> PyResult<CoreLight> {
    if let Some(reach) = reach.filter(|reach| reach.is_nan() || *reach <= 0.0) {
        return Err(PyValueError::new_err(format!("reach is {reach}, and not a number above 0")));
    }
    Ok(light.reach(reach).inverse_square(inverse_square).radius(within("radius", radius, 0.0, f32::MAX)?))
}

#[pymethods]
impl Light {
    /// A light that shines from a point in all directions.
    ///
    /// Args:
    ///     position: Where it is.
    ///     color: See `Light`.
    ///     reach: The distance at which it ends; without an end if not given.
    ///     inverse_square: Whether it fades with the square of the distance; otherwise it fades linearly toward
    ///         `reach`, or not at all without one.
    ///     radius: Its size, units of the scene; only shadows show it.
    ///     casts_shadows: Whether surfaces may lie in the shadow of others.
    #[staticmethod]
    #[pyo3(signature = (position, color = None, *, reach = None, inverse_square = false, radius = 0.0, casts_shadows = true))]
    fn point(
        position: &Bound<'_, PyAny>,
        color: Option<&Bound<'_, PyAny>>,
        reach: Option<f32>,
        inverse_square: bool,
        radius: f32,
        casts_shadows: bool,
    ) -> PyResult<Self> {
        let light = CoreLight::point(finite("position", position)?).casts_shadows(casts_shadows);
        Ok(Self { light: reaching(colored(light, color)?, reach, inverse_square, radius)? })
    }

    /// A light that shines from a point within a cone.
    ///
    /// Args:
    ///     position, color, reach, inverse_square, radius, casts_shadows: See `Light.point`.
    ///     direction: The middle of the cone, any length.
    ///     outer: The angle off the middle at which the light is 0, degrees, at most 90.
    ///     inner: The angle up to which it is full, degrees.
    #[staticmethod]
    #[pyo3(signature = (position, direction, color = None, *, outer = 45.0, inner = 0.0, reach = None, inverse_square = false, radius = 0.0, casts_shadows = true))]
    #[expect(clippy::too_many_arguments, reason = "they are named arguments of Python")]
    fn spot(
        position: &Bound<'_, PyAny>,
        direction: &Bound<'_, PyAny>,
        color: Option<&Bound<'_, PyAny>>,
        outer: f32,
        inner: f32,
        reach: Option<f32>,
        inverse_square: bool,
        radius: f32,
        casts_shadows: bool,
    ) -> PyResult<Self> {
        let inner = within("inner", inner, 0.0, within("outer", outer, f32::MIN_POSITIVE, 90.0)?)?;
        let [inner, outer] =
            [inner, outer].map(|degrees| degrees.to_radians().min(core::f32::consts::FRAC_PI_2));
        let light = CoreLight::spot(finite("position", position)?, finite("direction", direction)?, outer);
        let light = light.casts_shadows(casts_shadows);
        Ok(Self { light: reaching(colored(light, color)?.inner(inner), reach, inverse_square, radius)? })
    }

    /// A light from infinitely far away.
    ///
    /// Args:
    ///     direction: Where the light goes, any length.
    ///     color: See `Light`.
    ///     radius: The angle between its middle and its edge, degrees, below 45; only shadows show it. 0.27 for the sun.
    ///     casts_shadows: See `Light.point`.
    #[staticmethod]
    #[pyo3(signature = (direction, color = None, *, radius = 0.0, casts_shadows = true))]
    fn sun(
        direction: &Bound<'_, PyAny>,
        color: Option<&Bound<'_, PyAny>>,
        radius: f32,
        casts_shadows: bool,
    ) -> PyResult<Self> {
        let light = CoreLight::sun(finite("direction", direction)?).casts_shadows(casts_shadows);
        Ok(Self { light: colored(light, color)?.radius(within("radius", radius, 0.0, 44.99)?.to_radians()) })
    }

    /// "point", "spot" or "sun".
    #[getter]
    fn kind(&self) -> &'static str {
        match self.light.kind {
            LightKind::Point => "point",
            LightKind::Spot => "spot",
            LightKind::Sun => "sun",
        }
    }

    /// Where it is; of no meaning for a sun.
    #[getter]
    fn position(&self) -> (f32, f32, f32) {
        self.light.position.into()
    }

    /// Where its light goes; of no meaning for a point.
    #[getter]
    fn direction(&self) -> (f32, f32, f32) {
        self.light.direction.into()
    }

    /// Whether surfaces may lie in the shadow of others.
    #[getter]
    fn casts_shadows(&self) -> bool {
        self.light.casts_shadows
    }

    /// Linear RGB.
    #[getter]
    fn color(&self) -> (f32, f32, f32) {
        self.light.color.into()
    }

    fn __repr__(&self) -> String {
        let CoreLight { position, direction, color, .. } = self.light;
        match self.light.kind {
            LightKind::Sun => format!("<rtrt.Light sun toward {direction}, color {color}>"),
            _ => format!("<rtrt.Light {} at {position}, color {color}>", self.kind()),
        }
    }
}
