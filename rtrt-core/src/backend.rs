//! What every backend does: render a frame of a scene.

use crate::exposure;
use crate::layout::{Frame, ShadowKind};
use crate::scene::{Scene, SetupError};
use crate::schedule::Stage;
use alloc::borrow::Cow;
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use bytemuck::{Pod, Zeroable};
use core::sync::atomic::AtomicBool;

pub use crate::layout::{Hit, Lit, NONE, Surface, ToneMap};
pub use crate::request::{LAYERS, Request, Shading, Shadows};

/// The deferred buffers of a frame, one record a ray in the order of
/// [`crate::grid::Grid`], and the lists they came from. Those up to `lit` are of the first
/// layer of surfaces.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Deferred {
    /// The lists of all blocks of all views, as words (see
    /// [`crate::kernel::lists::BlockLists`]).
    pub lists: Vec<u32>,
    /// The closest surfaces.
    pub hits: Vec<Hit>,
    /// What is known about them.
    pub surfaces: Vec<Surface>,
    /// Which lights reach them: [`Deferred::mask_words`] words a ray.
    pub masks: Vec<u32>,
    /// Before soft shadows are blurred: what is left of each light (see [`crate::kernel::transmittance`]),
    /// a word a light; nothing in frames without soft shadows.
    pub raw_transmittance: Vec<u32>,
    /// The radii of the penumbras there (see [`crate::kernel::penumbra`]).
    pub penumbra_radii: Vec<f32>,
    /// The color of each light's shadow, a word a light; nothing where every instance is opaque
    /// and no shadow is soft.
    pub transmittance: Vec<u32>,
    /// The light that arrives.
    pub lit: Vec<Lit>,
    /// Linear RGB and alpha of all layers.
    pub colors: Vec<[f32; 4]>,
    /// The surfaces behind the first, nearest first: [`Deferred::layer_count`] a ray.
    pub layers: Vec<Hit>,
    /// Words of the shadow mask a ray.
    pub mask_words: u32,
    /// Layers a ray behind the first.
    pub layer_count: u32,
    /// Words of the shadow colors a ray.
    pub transmittance_words: u32,
}

impl Deferred {
    /// Each buffer with its name, as [`little_endian`] bytes, in the order of the stages that write them.
    pub fn buffers(&self) -> [(&'static str, Cow<'_, [u8]>); 10] {
        [
            ("lists", little_endian(&self.lists)),
            ("hits", little_endian(&self.hits)),
            ("surfaces", little_endian(&self.surfaces)),
            ("left", little_endian(&self.raw_transmittance)),
            ("penumbras", little_endian(&self.penumbra_radii)),
            ("masks", little_endian(&self.masks)),
            ("tints", little_endian(&self.transmittance)),
            ("lit", little_endian(&self.lit)),
            ("layers", little_endian(&self.layers)),
            ("colors", little_endian(&self.colors)),
        ]
    }

    /// Makes room for a frame. No layer behind the first has hit anything; what else is there is of no use.
    pub fn resize(&mut self, frame: &Frame) {
        self.mask_words = frame.mask_words;
        self.transmittance_words = frame.transmittance_words();
        self.layer_count = frame.layers_behind();
        let count = |words: u32| frame.rays as usize * words as usize;
        let raw = if frame.shadow_kind() == ShadowKind::Penumbra { self.transmittance_words } else { 0 };
        self.hits.resize(count(1), Hit::MISS);
        self.surfaces.resize(count(1), Surface::zeroed());
        self.masks.resize(count(self.mask_words), 0);
        self.raw_transmittance.resize(count(raw), 0);
        self.penumbra_radii.resize(count(raw), 0.0);
        self.transmittance.resize(count(self.transmittance_words), 0);
        self.lit.resize(count(1), Lit::zeroed());
        self.colors.resize(count(1), [0.0; 4]);
        self.layers.clear();
        self.layers.resize(count(self.layer_count), Hit::MISS);
    }
}

/// A rendered frame. Give the same one again, and its memory is used again.
#[derive(Debug, Clone, Default)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rows from top to bottom: sRGB with 8 bits a channel, red lowest, alpha highest.
    pub pixels: Vec<u32>,
    /// The deferred buffers, if they were asked for.
    pub deferred: Option<Deferred>,
    /// Milliseconds in each of [`Stage::ALL`].
    pub stages_ms: [f64; Stage::COUNT],
    /// Milliseconds in which the host worked for a frame of another device, without those in which
    /// it waited for it; none where the host itself renders.
    pub host_ms: Option<f64>,
}

impl Picture {
    /// The pixels as bytes: red, green, blue, alpha, on every host.
    pub fn bytes(&self) -> Cow<'_, [u8]> {
        little_endian(&self.pixels)
    }
}

/// The words of these values as bytes, the lowest of each word first, on every host. Nothing is copied where
/// memory is so already.
pub fn little_endian<T: Pod>(values: &[T]) -> Cow<'_, [u8]> {
    const { assert!(size_of::<T>().is_multiple_of(4), "all that a frame holds is made of words of 32 bits") }
    let bytes = bytemuck::cast_slice::<T, u8>(values);
    if cfg!(target_endian = "little") {
        return Cow::Borrowed(bytes);
    }
    Cow::Owned(bytes.as_chunks().0.iter().flat_map(|&[a, b, c, d]| [d, c, b, a]).collect())
}

/// Which machine a backend runs on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Description {
    /// `"cpu"` or `"gpu"`, or another backend's own name.
    pub kind: String,
    /// The processor or adapter.
    pub adapter: String,
    /// Numbers side by side in one instruction; 1 where that is not the backend's choice.
    pub lanes: u32,
    /// Threads; 0 where that is not the backend's choice.
    pub threads: u32,
}

/// Why a frame could not be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The request makes no picture.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The flag of [`Request::until`] was set before the frame was done.
    #[error("the frame was stopped")]
    Stopped,
    /// The backend failed.
    #[error("{backend}: {source}")]
    Backend {
        /// Which one.
        backend: &'static str,
        /// Why.
        source: Box<dyn core::error::Error + Send + Sync>,
    },
}

/// A machine that renders: a function from scene and request to picture, the same bits
/// whichever implements it.
///
/// ```
/// use rtrt_core::backend::{Backend, Description, Picture, RenderError, Request};
/// use rtrt_core::scene::Scene;
///
/// /// Renders as another does, and counts frames.
/// struct Counting<B> {
///     backend: B,
///     frames: u32,
/// }
///
/// impl<B: Backend> Backend for Counting<B> {
///     fn describe(&self) -> Description {
///         Description { kind: "counting".into(), ..self.backend.describe() }
///     }
///     fn render(
///         &mut self,
///         scene: &Scene,
///         request: &Request<'_>,
///         picture: &mut Picture,
///     ) -> Result<(), RenderError> {
///         self.frames += 1;
///         self.backend.render(scene, request, picture)
///     }
/// }
/// ```
pub trait Backend: Send {
    /// Where it runs.
    fn describe(&self) -> Description;

    /// Renders a frame into `picture`.
    ///
    /// # Errors
    /// The request makes no picture, or the backend failed; `picture` then holds nothing
    /// of use.
    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError>;

    /// Does in advance what the first frame of a kind would have to do once, such as to compile shaders: nothing on
    /// the CPU. `frame` is the [`Setup::frame`](crate::scene::Setup) of such a request, so that the scene is not
    /// needed. Setting `stop` ends it early.
    ///
    /// # Errors
    /// The backend failed, or was stopped.
    fn warm_up(&mut self, _frame: &Frame, _stop: &AtomicBool) -> Result<(), RenderError> {
        Ok(())
    }

    /// The exposure that suits the request's picture, in stops, whatever the request says of it; 0 for a
    /// black one. It comes from the linear colors of a picture of at most 160 pixels along its longer
    /// side, by integers, so every backend gives the same. Meter an animation once, so that it does not
    /// flicker.
    ///
    /// Only rays count that hit a surface, or all if hardly any (less than 1 in 256) does. The *bright
    /// end* is the luminance that 1 in 64 exceeds. The mean of the logarithms from 8 stops below it up to
    /// it becomes middle gray (0.18); but the bright end becomes 0.7 at least, as in a picture of one white
    /// wall, and 4 at most.
    ///
    /// # Errors
    /// As for [`Backend::render`].
    fn meter(&mut self, scene: &Scene, request: &Request<'_>) -> Result<f32, RenderError> {
        let mut picture = Picture::default();
        self.render(scene, &exposure::metering(request), &mut picture)?;
        let deferred = picture.deferred.as_ref();
        let size = [picture.width, picture.height];
        Ok(deferred.map_or(0.0, |Deferred { hits, colors, .. }| exposure::stops(size, hits, colors)))
    }
}
