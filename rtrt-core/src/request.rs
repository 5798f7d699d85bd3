//! What is asked of a backend: plain data, read by scenes and by backends.

use crate::layout::ToneMap;
use core::sync::atomic::{AtomicBool, Ordering};
use glam::Vec3;

/// How the camera projects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Rays leave one point; `fov_y` is the angle between the top and the bottom of the
    /// picture, radians, more than 0 and less than π.
    Perspective {
        /// Radians.
        fov_y: f32,
    },
    /// Rays leave one point, and the middle of the picture need not be straight ahead, nor its pixels square: where
    /// the edges of the picture are at distance 1 in front of the camera. `left < right` and `bottom < top`, each
    /// within ±2²⁰, and apart by 2⁻²⁰ at least.
    ///
    /// A lens of focal lengths `fx`, `fy` and a principal point `cx`, `cy`, in pixels from the upper left corner of a
    /// picture of `width` × `height`, has `left = −cx / fx`, `right = (width − cx) / fx`, `top = cy / fy` and
    /// `bottom = (cy − height) / fy`.
    OffCenter {
        /// The tangent of the angle to the right at which the left edge is.
        left: f32,
        /// That of the right edge.
        right: f32,
        /// The tangent of the angle upward at which the lower edge is.
        bottom: f32,
        /// That of the upper edge.
        top: f32,
    },
    /// Rays are parallel; `height` is what the picture shows from top to bottom, world
    /// units, more than 0.
    Orthographic {
        /// World units.
        height: f32,
    },
}

/// Where the camera is, where it looks, and how it projects. Right-handed: looking along
/// −z with y up, x is to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// World space. Rays of an orthographic camera start in the plane through it.
    pub eye: Vec3,
    /// A point in the middle of the picture.
    pub look_at: Vec3,
    /// What is up in the picture; need not be at a right angle to the view.
    pub up: Vec3,
    /// How it projects.
    pub projection: Projection,
}

/// How lights cast shadows. Without a radius, a light casts the same hard shadow under the last three.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shadows {
    /// No shadows: a surface that faces a light is lit.
    Off,
    /// Hard shadows: each light is a point in its middle.
    Hard,
    /// Analytic soft shadows: hard shadows, blurred on the screen by the radius of their penumbra.
    #[default]
    Soft,
    /// Sampled soft shadows: each sub-ray of a pixel asks for another point of the light (see
    /// `kernel::area`).
    Area {
        /// The seed of the jitter that gives each pixel other points of the light. Without one, all
        /// pixels take the same points.
        jitter: Option<u32>,
    },
}

/// How many colors are computed for a pixel of several sub-rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shading {
    /// One for each sub-ray.
    #[default]
    Sample,
    /// One for each triangle that its sub-rays meet, as with multisampling on GPUs ([`share`](crate::stage::share)): edges are
    /// as smooth, but textures, highlights and edges of shadows are as with one sub-ray. Frames in which that cannot be are shaded as
    /// [`Shading::Sample`] says: those with layers behind surfaces, penumbras ([`Shadows::Soft`] and [`Shadows::Area`]
    /// with lights that have a radius) or ambient occlusion.
    Pixel,
}

/// The usual number of transparent layers: that of a [`Request`] that names none.
pub const LAYERS: u32 = 8;

/// What to render: a camera and a size, and how well. Fields can be read; setters change them, so that
/// a request that names what it needs keeps compiling when there are more of them.
///
/// ```
/// use rtrt_core::backend::{Request, Shadows};
/// # use rtrt_core::scene::{Camera, Projection};
/// # let camera = Camera {
/// #     eye: [0.0, 0.0, 4.0].into(),
/// #     look_at: [0.0; 3].into(),
/// #     up: [0.0, 1.0, 0.0].into(),
/// #     projection: Projection::Perspective { fov_y: 1.0 },
/// # };
/// let request = Request::new(&camera, [640, 360]).samples(4).shadows(Shadows::Hard);
/// assert_eq!((request.size, request.samples, request.deferred), ([640, 360], 4, false));
/// ```
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Request<'a> {
    /// Where the picture is taken from.
    pub camera: &'a Camera,
    /// Pixels in a row, and rows: 1 to 16,384 each.
    pub size: [u32; 2],
    /// Sub-rays a pixel: 1, 4 or 16. One unless set.
    pub samples: u32,
    /// How many colors are computed for a pixel. One a sub-ray unless set.
    pub shading: Shading,
    /// How lights cast shadows. Soft unless set.
    pub shadows: Shadows,
    /// The most layers of surfaces that a ray looks at, 1 ..= [`crate::scene::Setup::MAX_LAYERS`].
    /// The last of them counts as opaque. [`LAYERS`] unless set.
    pub layers: u32,
    /// Stops by which light is raised before it is tone mapped, within ±64: one more is twice as bright.
    /// 0 unless set; [`Backend::meter`](crate::backend::Backend::meter) finds what suits a scene. The
    /// deferred buffers are as they are without it.
    pub exposure: f32,
    /// How linear light becomes a color of the picture. [`ToneMap::None`] unless set: pixels are then
    /// the encoded light, which can be computed with, and light beyond 1 is cut off.
    pub tone_map: ToneMap,
    /// The depths of a near and a far plane, world units along the view: the camera draws only surfaces between them.
    /// 0 and infinity unless set. Shadows and reflections know nothing of them.
    pub clip: [f32; 2],
    /// From how far away surfaces hide the light of the environment, or ambient light, from one another (see
    /// [`ambient`](crate::stage::ambient)), world units. 0, for not at all, unless set.
    pub ambient_occlusion: f32,
    /// Whether the picture comes with the deferred buffers. It does not unless set.
    pub deferred: bool,
    /// Ends the frame once it is true. Nothing unless set.
    pub stop: Option<&'a AtomicBool>,
}

impl<'a> Request<'a> {
    /// One sample a pixel, soft shadows, [`LAYERS`] layers, light as it is, no deferred buffers.
    pub const fn new(camera: &'a Camera, size: [u32; 2]) -> Self {
        Self {
            camera,
            size,
            samples: 1,
            shading: Shading::Sample,
            shadows: Shadows::Soft,
            layers: LAYERS,
            exposure: 0.0,
            tone_map: ToneMap::None,
            clip: [0.0, f32::INFINITY],
            ambient_occlusion: 0.0,
            deferred: false,
            stop: None,
        }
    }

    /// The request from another camera.
    #[must_use]
    pub const fn camera(self, camera: &'a Camera) -> Self {
        Self { camera, ..self }
    }

    /// The request for a picture of another size.
    #[must_use]
    pub const fn size(self, size: [u32; 2]) -> Self {
        Self { size, ..self }
    }

    /// The request with so many sub-rays a pixel.
    #[must_use]
    pub const fn samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    /// The request with so many colors a pixel.
    #[must_use]
    pub const fn shading(self, shading: Shading) -> Self {
        Self { shading, ..self }
    }

    /// The request with such shadows.
    #[must_use]
    pub const fn shadows(self, shadows: Shadows) -> Self {
        Self { shadows, ..self }
    }

    /// The request whose rays look at so many layers of surfaces.
    #[must_use]
    pub const fn layers(self, layers: u32) -> Self {
        Self { layers, ..self }
    }

    /// The request exposed by so many stops.
    #[must_use]
    pub const fn exposure(self, exposure: f32) -> Self {
        Self { exposure, ..self }
    }

    /// The request whose light becomes colors so.
    #[must_use]
    pub const fn tone_map(self, tone_map: ToneMap) -> Self {
        Self { tone_map, ..self }
    }

    /// The request whose camera draws only what is between planes at these depths: a near one of at least 0, which only a
    /// frame has to pay for that has one, and a far one, which may be infinitely far.
    #[must_use]
    pub const fn clip(self, near: f32, far: f32) -> Self {
        Self { clip: [near, far], ..self }
    }

    /// The request in which surfaces hide light from all around from one another, if they are nearer than this.
    #[must_use]
    pub const fn ambient_occlusion(self, reach: f32) -> Self {
        Self { ambient_occlusion: reach, ..self }
    }

    /// The request with or without the deferred buffers.
    #[must_use]
    pub const fn deferred(self, deferred: bool) -> Self {
        Self { deferred, ..self }
    }

    /// The request whose frame ends with [`RenderError::Stopped`](crate::backend::RenderError::Stopped) soon after
    /// another thread has set `stop`. A frame that is not stopped has the same bits.
    #[must_use]
    pub const fn until(self, stop: &'a AtomicBool) -> Self {
        Self { stop: Some(stop), ..self }
    }

    /// Whether the frame is to end.
    pub fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}
