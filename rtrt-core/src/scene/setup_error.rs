//! Why a frame cannot be set up.

use glam::Vec3;

/// See [`Setup::MAX_LAYERS`](crate::scene::Setup::MAX_LAYERS).
pub(super) const MAX_LAYERS: u32 = 64;
/// See [`Setup::MAX_STOPS`](crate::scene::Setup::MAX_STOPS).
pub(super) const MAX_STOPS: f32 = 64.0;

/// Why a frame cannot be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// The camera shows nothing.
    #[error("the camera is not usable: {why}")]
    Camera {
        /// What is wrong with it.
        why: &'static str,
    },
    /// A light has numbers that are not usable.
    #[error("a light is not usable: {why}")]
    Light {
        /// What is wrong with it.
        why: &'static str,
    },
    /// A color of the scene is not finite, or beyond [`LIGHT_LIMIT`](crate::layout::LIGHT_LIMIT).
    #[error("the {what} is {value}, which is not within ±2^48")]
    Color {
        /// The ambient light or the background.
        what: &'static str,
        /// What it is.
        value: Vec3,
    },
    /// The distance at which shadows of suns end is NaN.
    #[error("{value} is not a distance up to which suns may have shadows")]
    Distance {
        /// What it is.
        value: f32,
    },
    /// The frame has no pixels, or too many.
    #[error("a frame of {width} x {height} is not within 1 .. 16384 on a side")]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// More rays than 32 bits can number with room to spare.
    #[error("{rays} rays are more than a frame may have (2^31)")]
    Rays {
        /// Rays of all blocks.
        rays: u64,
    },
    /// The number of sub-rays a pixel is not 1, 4 or 16.
    #[error("{samples} samples a pixel; only 1, 4 and 16 are possible")]
    Samples {
        /// Sub-rays a pixel.
        samples: u32,
    },
    /// The number of layers is 0 or too large.
    #[error("{layers} layers of surfaces a ray; 1 to {} are possible", MAX_LAYERS)]
    Layers {
        /// Layers a ray.
        layers: u32,
    },
    /// A near or far plane that is not usable.
    #[error(
        "planes at depths of {near} and {far}: the near one must be 0 or more, and the far one beyond it"
    )]
    Clip {
        /// Depth of the near plane.
        near: f32,
        /// Depth of the far plane.
        far: f32,
    },
    /// A reach of ambient occlusion that is not usable.
    #[error("{reach} is not a distance up to which surfaces may hide ambient light: 0, or 2^-60 to 2^60")]
    AmbientReach {
        /// What it is.
        reach: f32,
    },
    /// A number of the environment that is not usable.
    #[error("the {what} of the environment is {value}, which is not within {low} ..= {high}")]
    Environment {
        /// Which number.
        what: &'static str,
        /// What it is.
        value: f32,
        /// The least that it may be.
        low: f32,
        /// The most.
        high: f32,
    },
    /// The exposure is NaN or too large.
    #[error("an exposure of {stops} stops is not within ±{}", MAX_STOPS)]
    Exposure {
        /// What it is.
        stops: f32,
    },
    /// More parts of instances than block lists can hold; see [`Structure::Parts`](crate::scene::Structure::Parts).
    #[error("the instances have more than {limit} parts of {triangles} triangles")]
    BvhCut {
        /// The largest number of triangles of a part.
        triangles: u32,
        /// The most parts there may be.
        limit: usize,
    },
    /// More lights than block lists can number.
    #[error("{lights} lights are more than a scene may have ({limit})")]
    Lights {
        /// Lights in the scene.
        lights: usize,
        /// The most there may be.
        limit: usize,
    },
}
