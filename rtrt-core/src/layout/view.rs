//! Viewpoints (the camera and the lights) and the numbers of a frame.

use crate::grid::{BlockIndex, Grid};
use crate::layout::MaterialRecord;
use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// The purpose of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ViewKind {
    /// Unused: no instance is binned.
    Off = 0,
    /// The camera: entries ordered by depth.
    Camera = 1,
    /// One cube face around a point light.
    Point = 2,
    /// Parallel light.
    Sun = 3,
}

/// One viewpoint with its grid of blocks.
///
/// A point `p` lies in column `X/W` and row `Y/W`, where `X`, `Y`, `W` are the rows below
/// applied to `p − center`. The ray through column `a` and row `b` (not whole numbers)
/// starts at `center + start + a·start_x + b·start_y` and goes along
/// `along + a·along_x + b·along_y`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct View {
    /// Eye, light, or the corner of a parallel view; world space.
    pub center: [f32; 3],
    /// [`ViewKind`].
    pub kind: u32,
    /// Column, times `W`.
    pub x: [f32; 3],
    /// Added to `W`: 0 for perspective, 1 for a parallel view (whose `w` is zero).
    pub w_offset: f32,
    /// Row, times `W`.
    pub y: [f32; 3],
    /// Radius of a block's rays around its middle ray at its start, world units.
    pub spread: f32,
    /// `W`.
    pub w: [f32; 3],
    /// How much `spread` grows a unit of `W`.
    pub spread_w: f32,
    /// Depth: the `t` of the point on its ray.
    pub depth: [f32; 3],
    /// Blocks in a row.
    pub width: u32,
    /// Start of the ray at column 0, row 0, from `center`.
    pub start: [f32; 3],
    /// Rows of blocks.
    pub height: u32,
    /// How `start` changes a column.
    pub start_x: [f32; 3],
    /// The first of the view's blocks in the lists.
    pub first_block: u32,
    /// How `start` changes a row.
    pub start_y: [f32; 3],
    /// Light: 1 / reach, in 1/world units; 0 for no limit.
    pub inv_reach: f32,
    /// Direction of the ray at column 0, row 0.
    pub along: [f32; 3],
    /// Light: 1 for falloff with the square of the distance, else 0.
    pub inverse_square: f32,
    /// How `along` changes a column.
    pub along_x: [f32; 3],
    /// The footprint of a ray at `t` = 0, world units.
    pub pixel: f32,
    /// How `along` changes a row.
    pub along_y: [f32; 3],
    /// How the footprint grows with `t`.
    pub pixel_t: f32,
    /// Light: linear RGB.
    pub color: [f32; 3],
    /// Light: the squared reach, widened by its rounding error; `f32::MAX` for no limit.
    pub reach_squared: f32,
    /// Spot light: the axis of its cone, unit length.
    pub axis: [f32; 3],
    /// Spot light: how fast the cone fades, a unit of cosine; 0 for a light without a cone.
    pub cone_scale: f32,
    /// Spot light: the cone's share where the cosine is 0.
    pub cone_offset: f32,
    /// Light: its radius, world units; for a sun the tangent of its angular radius.
    pub radius: f32,
    /// Light: the radius over which the sub-rays of a pixel choose their points (see
    /// `kernel::area`); 0 where all of them take its middle.
    pub disc: f32,
    /// Light: the largest distance that such a point moves a shadow ray, world units.
    pub margin: f32,
    /// Light: the value that ray numbers are hashed with to jitter these points; 0 for no jitter.
    pub jitter: u32,
    /// 1 where all blocks share one list, of every instance in order.
    pub one_list: u32,
    /// Camera: 1 if footprints grow with the angle between ray and normal, else 0.
    pub by_angle: u32,
    /// Sun: how far from the camera its shadows end, world units; 0 for nowhere.
    pub shadow_distance: f32,
}
const _: () = assert!(size_of::<View>() == 240 && offset_of!(View, depth) == 64);
const _: () = assert!(offset_of!(View, along) == 128 && offset_of!(View, axis) == 192);

/// The background.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Backdrop {
    /// The environment, or the background's color without one.
    #[default]
    Environment = 0,
    /// The background's color. Surfaces reflect the environment all the same.
    Color = 1,
    /// Nothing: the alpha of a pixel is the share that surfaces cover.
    Nothing = 2,
}

/// How linear light becomes the linear color of a display, 0 to 1 a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum ToneMap {
    /// Channels are cut off at 1.
    #[default]
    None = 0,
    /// [Khronos PBR Neutral](https://github.com/KhronosGroup/ToneMapping/blob/main/PBR_Neutral/README.md):
    /// base colors keep their hue and saturation up to 0.8, highlights turn white.
    Neutral = 1,
    /// AgX as in Blender 4.0: 16.5 stops, and colors fade with their brightness.
    Agx = 2,
    /// The Academy's reference rendering and output transforms, in Stephen Hill's fit.
    Aces = 3,
}

impl ToneMap {
    /// All of them, with their names.
    pub const ALL: [(&'static str, Self); 4] =
        [("neutral", Self::Neutral), ("agx", Self::Agx), ("aces", Self::Aces), ("none", Self::None)];
}

/// The place of an environment's squares in the texels (see `kernel::environment`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// The word that holds the start of the sharpest square. Those of the others follow it, the last one for
    /// diffuse surfaces. 0 for no environment.
    pub first: u32,
    /// Texels along a side of the sharpest square, without its border: a power of two, at least 64. Each square is
    /// half as large as the one before, but has at least 32.
    pub side: u32,
    /// Squares for reflections, from smooth to rough; at least two.
    pub levels: u32,
    /// Cosine and sine of the angle by which directions are turned before they are looked up, from z
    /// toward x.
    pub turn: [f32; 2],
    /// What its light is multiplied by.
    pub intensity: f32,
}

impl Default for Sky {
    /// No environment, neither turned nor brightened.
    fn default() -> Self {
        Self { first: 0, side: 0, levels: 0, turn: [1.0, 0.0], intensity: 1.0 }
    }
}

/// What a frame knows of its shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ShadowKind {
    /// One bit a light: whether it reaches a surface.
    Bits,
    /// A color a light, as some instances let light through: see
    /// `kernel::transmittance`.
    Transmittance,
    /// A color a light, blurred by the radius of its penumbra: see
    /// [`penumbra_filter`](crate::stage::penumbra_filter).
    Penumbra,
}

/// The numbers of one frame. Scalars only, so that it may be a uniform block.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Frame {
    /// Pixels in a row.
    pub width: u32,
    /// Rows of pixels.
    pub height: u32,
    /// Sub-rays along one side of a pixel.
    pub side: u32,
    /// Views whose lists are built: the camera, then [`Frame::VIEWS_PER_LIGHT`] a light unless their lists
    /// are reused.
    pub views: u32,
    /// Instances in the scene.
    pub instances: u32,
    /// Lights in the scene.
    pub lights: u32,
    /// Blocks in the lists, of all views.
    pub blocks: u32,
    /// 32-bit words of the shadow mask per ray.
    pub mask_words: u32,
    /// Room in the lists, in entries.
    pub capacity: u32,
    /// 1 to cast shadows, 0 to light everything that faces a light.
    pub shadows: u32,
    /// First ray that this dispatch works on.
    pub first_ray: u32,
    /// Rays that this dispatch works on.
    pub rays: u32,
    /// Ambient light, linear RGB: red.
    pub ambient_r: f32,
    /// Green.
    pub ambient_g: f32,
    /// Blue.
    pub ambient_b: f32,
    /// The background's color, linear RGB as the display shows it: red.
    pub background_r: f32,
    /// Green.
    pub background_g: f32,
    /// Blue.
    pub background_b: f32,
    /// The largest coordinate of anything in the frame, in magnitude: instances, camera,
    /// lights. Rounding errors of culling are relative to it.
    pub magnitude: f32,
    /// 1 where a material asks for normal maps, a second set of texture coordinates, a coat's normals or tangents.
    pub details: u32,
    /// The environment, see [`Sky`]: where it starts.
    pub sky_first: u32,
    /// Side of its sharpest square.
    pub sky_side: u32,
    /// The number of squares for reflections.
    pub sky_levels: u32,
    /// The largest number of layers of surfaces that a ray may still hit, this dispatch's included; 0 if
    /// every instance is opaque.
    pub layers: u32,
    /// The radius of the largest penumbra, in rays (see [`penumbra`](crate::stage::penumbra_filter));
    /// 0 for a frame without soft shadows.
    pub penumbra_window: u32,
    /// The number of instances, or parts of instances, that the camera's lists choose from.
    pub seen: u32,
    /// The first of them: 0 for instances; for parts, which follow the instances, the number of instances.
    pub first_seen: u32,
    /// [`Backdrop`].
    pub backdrop: u32,
    /// The first block whose list is built. Blocks of lights come first, and their lists may be reused.
    pub first_block: u32,
    /// 1 if the closest surfaces were rasterized, and only rays without a certain pixel are traced (see [`raster`](crate::stage::raster)).
    pub is_drawn: u32,
    /// What light is multiplied by before it is tone mapped: 2 to the power of the request's stops.
    pub exposure: f32,
    /// [`ToneMap`].
    pub tone_map: u32,
    /// The environment's turn: cosine.
    pub sky_cosine: f32,
    /// Sine.
    pub sky_sine: f32,
    /// What the environment's light is multiplied by.
    pub sky_intensity: f32,
    /// How rough a mirror would have to be to show the environment as blurred as it is behind
    /// everything, 0 ..= 1.
    pub backdrop_blur: f32,
    /// What any of the materials has beyond metallic-roughness (see
    /// [`MaterialRecord`]).
    pub extensions: u32,
    /// Surfaces at this depth of the camera and nearer are not drawn, world units; 0 for none.
    pub near: f32,
    /// Surfaces beyond this depth are not drawn.
    pub far: f32,
    /// The first of the views from which light from all around comes (see [`ambient`](crate::stage::ambient)); 0 for none.
    pub ambient_view: u32,
    /// From how far away a surface hides that light, world units.
    pub ambient_reach: f32,
    /// What the environment's light is multiplied by where it is the background.
    pub backdrop_strength: f32,
    /// 1 if sub-rays of a pixel that meet the same triangle are shaded as one (see [`share`](crate::stage::share)).
    pub is_shared: u32,
    /// Unused: a uniform block is a multiple of 16 bytes.
    pub unused: u32,
}
const _: () = assert!(size_of::<Frame>() == 176 && offset_of!(Frame, ambient_r) == 48);

impl View {
    /// The camera's list for a block of the frame.
    #[inline(always)]
    pub fn list(&self, block: BlockIndex) -> u32 {
        if self.one_list == 1 { self.first_block } else { self.first_block + block.0 }
    }
}

impl Frame {
    /// The most [records](Self::records) that a ray keeps.
    pub const RECORDS: usize = 4;

    /// Whether any of the materials has one of these extensions.
    #[inline(always)]
    pub fn has(&self, extensions: u32) -> bool {
        self.extensions & extensions != 0
    }

    /// Views of one light: the six faces of a cube, of which parallel light uses one.
    pub const VIEWS_PER_LIGHT: u32 = 6;

    /// The camera's view.
    pub const CAMERA: u32 = 0;

    /// The radius of the largest penumbra, in pixels: wider ones are cut off.
    pub const PENUMBRA_WINDOW: u32 = 24;

    /// The frame's grid of rays.
    #[inline(always)]
    pub fn grid(&self) -> Grid {
        Grid { width: self.width, height: self.height, side: self.side }
    }
    /// The environment.
    #[inline(always)]
    pub fn sky(&self) -> Sky {
        Sky {
            first: self.sky_first,
            side: self.sky_side,
            levels: self.sky_levels,
            turn: [self.sky_cosine, self.sky_sine],
            intensity: self.sky_intensity,
        }
    }
    /// What it knows of its shadows.
    #[inline(always)]
    pub fn shadow_kind(&self) -> ShadowKind {
        if self.penumbra_window != 0 {
            ShadowKind::Penumbra
        } else if self.has_layers() {
            ShadowKind::Transmittance
        } else {
            ShadowKind::Bits
        }
    }
    /// Words of the transmittance a ray.
    #[inline(always)]
    pub fn transmittance_words(&self) -> u32 {
        if self.has_transmittance() { self.lights } else { 0 }
    }
    /// The most layers of surfaces behind the first.
    #[inline(always)]
    pub fn layers_behind(&self) -> u32 {
        if self.has_layers() { self.layers - 1 } else { 0 }
    }
    /// The numbers for a layer of surfaces with so many in front: the last that a ray looks at counts
    /// as opaque, and those behind the first are never drawn.
    #[inline(always)]
    pub fn of_layer(&self, in_front: u32) -> Self {
        if in_front == 0 {
            return *self;
        }
        Self { layers: self.layers - in_front, is_drawn: 0, ..*self }
    }
    /// Whether rays go on behind surfaces: not every instance is opaque.
    #[inline(always)]
    pub fn has_layers(&self) -> bool {
        self.layers != 0
    }
    /// Whether rays ask how much of the light from all around reaches surfaces.
    #[inline(always)]
    pub fn has_ambient_rays(&self) -> bool {
        self.ambient_view != 0
    }
    /// Whether closest surfaces are found by [`peel`](crate::stage::peel), because some that a ray meets are not drawn.
    #[inline(always)]
    pub fn is_peeled(&self) -> bool {
        self.has_layers() || self.near > 0.0
    }
    /// Whether rays that hit nothing show the environment. Otherwise they have no color and an alpha of 0, and
    /// [`resolve`](crate::stage::resolve) adds the background's color.
    #[inline(always)]
    pub fn shows_sky(&self) -> bool {
        self.sky_first != 0 && self.backdrop == Backdrop::Environment as u32
    }
    /// Whether layers let colored light through, so that rays keep its share a channel behind their colors.
    #[inline(always)]
    pub fn has_colored_layers(&self) -> bool {
        self.has_layers() && self.has(MaterialRecord::TRANSMITS)
    }
    /// Whether layers turn or scatter the light that they let through, so that rays keep behind that share where it
    /// comes from.
    #[inline(always)]
    pub fn has_deflecting_layers(&self) -> bool {
        self.has_colored_layers() && self.has(MaterialRecord::DEFLECTS)
    }
    /// Records that a ray keeps: its color, and see [`Frame::has_colored_layers`] and [`Frame::has_deflecting_layers`].
    #[inline(always)]
    pub fn records(&self) -> u32 {
        if self.has_deflecting_layers() {
            4
        } else if self.has_colored_layers() {
            2
        } else {
            1
        }
    }
    /// Whether shadows are transmittances instead of bits.
    #[inline(always)]
    pub fn has_transmittance(&self) -> bool {
        self.has_layers() || self.penumbra_window != 0
    }
    /// The view and the instance, or part of one, of the cover with this index: those of the camera
    /// first, then, view after view, those of lights.
    #[inline(always)]
    pub fn of_screen_bounds(&self, index: u32) -> [u32; 2] {
        if index < self.seen {
            return [Self::CAMERA, self.first_seen + index];
        }
        let index = index - self.seen;
        [1 + index / self.instances, index % self.instances]
    }
    /// The first view of a light.
    #[inline(always)]
    pub fn light_view(&self, light: u32) -> u32 {
        1 + light * Self::VIEWS_PER_LIGHT
    }
}
