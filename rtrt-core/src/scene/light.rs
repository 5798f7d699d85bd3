//! Lights.

use crate::layout::{Frame, LIGHT_LIMIT, View, ViewKind};
use crate::num::flush;
use crate::scene::SetupError;
use crate::scene::bvh::Bounds;
use crate::scene::camera::{single, unit};
use crate::scene::floor::floored;
use bytemuck::Zeroable;
use core::f32::consts::PI;
use glam::{DVec3, Vec3};

/// Where a light shines from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightKind {
    /// From a point in all directions.
    Point,
    /// From a point within a cone.
    Spot,
    /// From infinitely far away.
    Sun,
}

/// A light. A constructor for each kind asks for what the kind cannot do without; setters change the
/// rest, which is otherwise a white light that does not fade and casts hard shadows, as bright as shows a white
/// surface that faces it as white. Each field names
/// the kinds that read it.
///
/// ```
/// use rtrt_core::scene::Light;
///
/// let lamp = Light::point([0.0, 2.0, 0.0]).color([1.0, 0.9, 0.7]).reach(9.0).radius(0.1);
/// assert_eq!((lamp.reach, lamp.inverse_square), (Some(9.0), false));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Light {
    /// Where it shines from.
    pub kind: LightKind,
    /// Points and spots: world space, within ± [`Light::FARTHEST`].
    pub position: Vec3,
    /// Spots and suns: where the light goes, for a spot in the middle of its cone; any length but 0.
    pub direction: Vec3,
    /// Linear RGB, within ± [`LIGHT_LIMIT`]: the illuminance of a surface that faces the light. Lux for a sun, candela for
    /// points and spots with `inverse_square`; otherwise what arrives at distance 0. A surface of the diffuse color `c`
    /// shows `c / π` times it. π unless set.
    pub color: Vec3,
    /// Points and spots: world units, more than 0; beyond it the light is 0. `None` for no limit.
    pub reach: Option<f32>,
    /// Points and spots: whether the light fades with the square of the distance. Otherwise it fades
    /// linearly toward `reach`, or not at all without one.
    pub inverse_square: bool,
    /// Spots: the angle off the middle at which the light begins to fade, radians, 0 or more.
    pub inner: f32,
    /// Spots: the angle off the middle at which the light is 0, radians: more than 0, not less than
    /// `inner`, at most π/2.
    pub outer: f32,
    /// Size of the light, 0 or more; only shadows show it. World units, or, for a sun, the angle
    /// between its middle and its edge, radians, below π/4. The radius of the sun in the sky is 0.0047.
    pub radius: f32,
    /// Whether surfaces that face it may lie in the shadow of others. One without shadows lights them all.
    pub casts_shadows: bool,
}

/// The least reach of a light, 2⁻⁴⁵: no denormal decides whether a surface is within its square.
const LEAST_REACH: f32 = f32::from_bits((127 - 45) << 23);

impl Light {
    /// The largest coordinate of a light's position, 2⁴⁰: directions from farther away have no length
    /// that single precision can tell.
    pub const FARTHEST: f32 = 1_099_511_627_776.0;

    /// A light that shines from `position` in all directions.
    pub fn point(position: impl Into<Vec3>) -> Self {
        Self {
            kind: LightKind::Point,
            position: position.into(),
            direction: Vec3::ZERO,
            color: Vec3::splat(PI),
            reach: None,
            inverse_square: false,
            inner: 0.0,
            outer: 0.0,
            radius: 0.0,
            casts_shadows: true,
        }
    }

    /// A light that shines from `position` within a cone around `direction`. It fades from the middle
    /// of the cone to its edge, `outer` radians off.
    pub fn spot(position: impl Into<Vec3>, direction: impl Into<Vec3>, outer: f32) -> Self {
        Self { kind: LightKind::Spot, direction: direction.into(), outer, ..Self::point(position) }
    }

    /// A light from infinitely far away that goes in `direction`.
    pub fn sun(direction: impl Into<Vec3>) -> Self {
        Self { kind: LightKind::Sun, direction: direction.into(), ..Self::point(Vec3::ZERO) }
    }

    /// The light in another color, linear RGB.
    #[must_use]
    pub fn color(self, color: impl Into<Vec3>) -> Self {
        Self { color: color.into(), ..self }
    }

    /// The light with an end, world units, or, for `None`, without one.
    #[must_use]
    pub fn reach(self, reach: impl Into<Option<f32>>) -> Self {
        Self { reach: reach.into(), ..self }
    }

    /// The light that fades with the square of the distance, or does not.
    #[must_use]
    pub fn inverse_square(self, inverse_square: bool) -> Self {
        Self { inverse_square, ..self }
    }

    /// The light that is full up to `inner` radians off the middle of its cone.
    #[must_use]
    pub fn inner(self, inner: f32) -> Self {
        Self { inner, ..self }
    }

    /// The light with a radius: world units, or, for a sun, radians.
    #[must_use]
    pub fn radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// The light with shadows, or without.
    #[must_use]
    pub fn casts_shadows(self, casts_shadows: bool) -> Self {
        Self { casts_shadows, ..self }
    }

    /// The views of the light: six faces of a cube around a point (those that a spot light
    /// does not shine through bin nothing), one parallel view and five that bin nothing for a
    /// sun. Those of a light without shadows bin nothing at all. `cells` is the number of blocks along one side; `jitter` is that of the view, none
    /// if all sub-rays take the light's middle.
    pub(super) fn views(
        &self,
        bounds: &Bounds,
        cells: u32,
        first_block: u32,
        jitter: Option<u32>,
    ) -> Result<[View; Frame::VIEWS_PER_LIGHT as usize], SetupError> {
        if self.kind == LightKind::Sun {
            return self.sun_views(bounds, cells, first_block, jitter);
        }
        let mut light = self.bulb()?;
        let cone = if self.kind == LightKind::Spot { Some(self.cone()?) } else { None };
        if let Some(cone) = &cone {
            (light.axis, light.cone_scale, light.cone_offset) = (single(cone.axis), cone.scale, cone.offset);
        }
        let light = with_radius(light, self.radius, 1.0, jitter)?;
        let mut faces = cube(&light, cells, first_block);
        for (face, view) in faces.iter_mut().enumerate() {
            // Cones that start beside the middle reach into other faces.
            let is_beside =
                |cone: &Cone| libm::acos(cone.axis.dot(forward(face))) > f64::from(self.outer) + FACE;
            if !self.casts_shadows || light.disc == 0.0 && cone.as_ref().is_some_and(is_beside) {
                view.kind = ViewKind::Off as u32;
            }
        }
        Ok(faces)
    }

    /// The views of a sun.
    fn sun_views(
        &self,
        bounds: &Bounds,
        cells: u32,
        first_block: u32,
        jitter: Option<u32>,
    ) -> Result<[View; Frame::VIEWS_PER_LIGHT as usize], SetupError> {
        let direction =
            unit(self.direction.as_dvec3()).filter(|_| is_color(self.color)).ok_or(SetupError::Light {
                why: "the direction must not be zero, and the color within ±2^48",
            })?;
        let mut views = [View::zeroed(); Frame::VIEWS_PER_LIGHT as usize];
        let sun = parallel(direction, self.color, bounds, cells, first_block);
        if self.radius >= core::f32::consts::FRAC_PI_4 {
            return Err(SetupError::Light { why: "a sun's radius must be below 45 degrees" });
        }
        // From any surface of the scene to what casts a shadow on it.
        let size = DVec3::from(bounds.high.map(f64::from)) - DVec3::from(bounds.low.map(f64::from));
        let farthest = Some(libm::sqrt(size.length_squared())).filter(|size| size.is_finite());
        let tangent = libm::tan(f64::from(self.radius)) as f32;
        views[0] = with_radius(sun, tangent, farthest.unwrap_or(0.0), jitter)?;
        if !self.casts_shadows {
            // What its rays reach is of no meaning to a sun's light: its lists alone read it.
            views[0].reach_squared = -1.0;
        }
        Ok(views)
    }

    /// What the faces around a point light have in common.
    fn bulb(&self) -> Result<View, SetupError> {
        let reach = self.reach.unwrap_or(f32::INFINITY);
        let is_near = self.position.abs().cmple(Vec3::splat(Self::FARTHEST)).all();
        if !is_near || !is_color(self.color) || reach.is_nan() || reach <= 0.0 {
            return Err(SetupError::Light {
                why: "the position must be within ±2^40, the color within ±2^48, and the reach positive",
            });
        }
        let reach = reach.max(LEAST_REACH);
        let wider = reach * (1.0 + 1.0 / 65536.0);
        let squared = wider * wider;
        Ok(View {
            center: self.position.map(floored).to_array(),
            kind: ViewKind::Point as u32,
            inv_reach: flush(1.0 / reach),
            inverse_square: f32::from(u8::from(self.inverse_square)),
            color: self.color.map(floored).to_array(),
            reach_squared: if squared.is_finite() { squared } else { f32::MAX },
            ..View::zeroed()
        })
    }

    /// The cone of a spot light.
    fn cone(&self) -> Result<Cone, SetupError> {
        let Self { inner, outer, .. } = *self;
        let axis = unit(self.direction.as_dvec3())
            .ok_or(SetupError::Light { why: "the direction of a spot light must not be zero" })?;
        if !(outer > 0.0 && outer <= core::f32::consts::FRAC_PI_2 && inner >= 0.0 && inner <= outer) {
            return Err(SetupError::Light {
                why: "a spot light's angles must be within 0 and 90 degrees, the inner one not above the outer",
            });
        }
        let [inner, outer] = [inner, outer].map(|angle| libm::cos(f64::from(angle)));
        let scale = 1.0 / (inner - outer).max(1e-3);
        Ok(Cone { axis, scale: scale as f32, offset: flush((-outer * scale) as f32) })
    }
}

/// The cone of a spot light; see [`crate::kernel::cone::cone`].
struct Cone {
    axis: DVec3,
    scale: f32,
    offset: f32,
}

/// Whether a light may have this color.
pub(super) fn is_color(color: Vec3) -> bool {
    color.abs().cmple(Vec3::splat(LIGHT_LIMIT)).all()
}

/// The light with a radius. Where its sub-rays spread over it, they are off the ray to its
/// middle by `lever` times the radius, at most; there is room for the roundings of that.
fn with_radius(light: View, radius: f32, lever: f64, jitter: Option<u32>) -> Result<View, SetupError> {
    if !(radius >= 0.0 && radius.is_finite()) {
        return Err(SetupError::Light { why: "the radius must be finite and not negative" });
    }
    let radius = floored(radius);
    let light = View { radius, ..light };
    let Some(jitter) = jitter else { return Ok(light) };
    let margin = (f64::from(radius) * lever * (1.0 + 1.0 / 1024.0)) as f32;
    Ok(View { disc: radius, margin, jitter, ..light })
}

/// How far the directions of a face are off its middle, at most: at the corners, where the
/// cosine is 1/√3. Radians, with room for the roundings of a cone's edge.
const FACE: f64 = 0.9554 + 1e-3;

/// The middle of a face of the cube around a point light.
fn forward(face: usize) -> DVec3 {
    [DVec3::X, DVec3::Y, DVec3::Z][face / 2] * if face.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// The faces of the cube around a point light.
fn cube(light: &View, cells: u32, first_block: u32) -> [View; Frame::VIEWS_PER_LIGHT as usize] {
    let blocks = cells * cells;
    core::array::from_fn(|face| cube_face(light, face, cells, first_block + face as u32 * blocks))
}

/// One face of the cube around a point light, in the order and with the axes of
/// [`crate::kernel::view::light_block`].
fn cube_face(light: &View, face: usize, cells: u32, first_block: u32) -> View {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let [u, v] = [[1, 2], [0, 2], [0, 1]][face / 2].map(|axis: usize| axes[axis]);
    let forward = forward(face);
    let half = f64::from(cells) * 0.5;
    View {
        x: single((u + forward) * half),
        y: single((v + forward) * half),
        w: single(forward),
        depth: single(forward),
        along: single(forward - u - v),
        along_x: single(u / half),
        along_y: single(v / half),
        spread_w: (core::f64::consts::FRAC_1_SQRT_2 / half) as f32,
        width: cells,
        height: cells,
        first_block,
        ..*light
    }
}

/// The view along parallel light, fitted to the scene's bounds.
pub(super) fn parallel(direction: DVec3, color: Vec3, bounds: &Bounds, cells: u32, first_block: u32) -> View {
    let helper = if direction.x.abs() < 0.5 { DVec3::X } else { DVec3::Y };
    let u = unit(direction.cross(helper)).unwrap_or(DVec3::Y);
    let v = direction.cross(u);
    let low = DVec3::from(bounds.low.map(f64::from));
    let high = DVec3::from(bounds.high.map(f64::from));
    // Extent of the box along an axis.
    let extent = |axis: DVec3| {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in 0..8 {
            let pick = |bit: u32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
            let p = DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z));
            (least, most) = (least.min(axis.dot(p)), most.max(axis.dot(p)));
        }
        let slack = (most - least) * 1e-3 + 1e-6;
        (least - slack, most - least + 2.0 * slack)
    };
    let ((u0, u_size), (v0, v_size)) = (extent(u), extent(v));
    let (step_u, step_v) = (u_size / f64::from(cells), v_size / f64::from(cells));
    View {
        center: single(u * u0 + v * v0),
        kind: ViewKind::Sun as u32,
        x: single(u / step_u),
        y: single(v / step_v),
        w_offset: 1.0,
        spread: (0.5 * libm::sqrt(step_u * step_u + step_v * step_v)) as f32,
        depth: single(direction),
        width: cells,
        height: cells,
        first_block,
        start_x: single(u * step_u),
        start_y: single(v * step_v),
        along: single(direction),
        color: color.map(floored).to_array(),
        reach_squared: f32::MAX,
        ..View::zeroed()
    }
}
