//! What the kernels of the canary are asked with: views, an instance, textures and an environment.

use crate::kernel::area::hash;
use crate::kernel::environment::IRRADIANCE_SIDE;
use crate::kernel::texture::Maps;
use crate::layout::{Filter, Frame, Instance, MaterialRecord, NONE, Sky, Texture, View, ViewKind, Wrap};
use bytemuck::Zeroable;

/// What a device reads beside the words.
#[derive(Clone, Copy)]
pub struct Given<'a> {
    /// A frame, of which the kernels take grid and magnitude.
    pub frame: &'a Frame,
    /// `CAMERA`, `SPOT` and `SUN`.
    pub views: &'a [View],
    /// One instance.
    pub instances: &'a [Instance],
    /// Two materials, and the texels of their textures.
    pub maps: Maps<'a>,
}

/// The memory behind a [`Given`].
#[derive(Debug, Clone)]
pub struct Fixture {
    /// See [`Given`].
    pub frame: Frame,
    /// See [`Given`].
    pub views: [View; 3],
    /// See [`Given`].
    pub instances: [Instance; 1],
    /// See [`Given`].
    pub materials: [MaterialRecord; 2],
}

impl Default for Fixture {
    fn default() -> Self {
        Self {
            // Four sub-rays a pixel.
            frame: Frame { width: 64, height: 64, side: 2, magnitude: 16.0, ..Frame::zeroed() },
            views: [camera(), spot(), sun()],
            instances: [instance()],
            materials: [WIDE, ODD].map(|texture| {
                let mut material = MaterialRecord::zeroed();
                material.textures[MaterialRecord::COLOR] = texture;
                material
            }),
        }
    }
}

impl Fixture {
    /// The slices.
    pub fn given(&self) -> Given<'_> {
        let maps = Maps { materials: &self.materials, texels: &TEXELS };
        Given { frame: &self.frame, views: &self.views, instances: &self.instances, maps }
    }
}

/// A camera with a picture of 4 by 4 blocks, that looks along −z.
pub(super) const CAMERA: usize = 0;
/// A spot light with a radius, one face of its cube.
pub(super) const SPOT: usize = 1;
/// A sun, whose reach only [`falloff`](crate::kernel::falloff) reads.
pub(super) const SUN: usize = 2;

fn camera() -> View {
    View {
        center: [0.3, -0.7, 2.1],
        kind: ViewKind::Camera as u32,
        width: 4,
        height: 4,
        depth: [0.0, 0.0, -1.0],
        w: [0.0, 0.0, -1.0],
        x: [2.1, 0.0, -2.0],
        y: [0.0, -2.1, -2.0],
        along: [-0.95, 0.95, -1.0],
        along_x: [0.475, 0.0, 0.0],
        along_y: [0.0, -0.475, 0.0],
        spread_w: 0.34,
        reach_squared: f32::MAX,
        ..View::zeroed()
    }
}

fn spot() -> View {
    View {
        center: [0.3, 5.7, -0.9],
        kind: ViewKind::Point as u32,
        width: 8,
        height: 8,
        inv_reach: 0.03,
        inverse_square: 1.0,
        axis: [0.48, -0.8, 0.36],
        cone_scale: 3.7,
        cone_offset: -1.9,
        radius: 0.25,
        disc: 0.25,
        jitter: 0x9e37_79b9,
        ..View::zeroed()
    }
}

fn sun() -> View {
    View {
        center: [-10.0, -10.0, 0.0],
        kind: ViewKind::Sun as u32,
        width: 8,
        height: 8,
        x: [0.32, 0.1, 0.0],
        y: [0.0, 0.1, 0.32],
        inv_reach: 0.03,
        radius: 0.01,
        shadow_distance: 6.3,
        ..View::zeroed()
    }
}

/// Turned, stretched and moved.
fn instance() -> Instance {
    Instance {
        to_object: [[0.6, 0.8, 0.0, 3.1], [-1.6, 1.2, 0.0, -0.7], [0.0, 0.0, 0.3, 12.3]],
        to_world: [[0.6, -0.4, 0.0, 3.1], [0.8, 0.3, 0.0, -0.7], [0.0, 0.0, 3.3, 12.3]],
        slack: 1.0 / 8192.0,
        opened_from: NONE,
        ..Instance::zeroed()
    }
}

/// A texture of 8 by 4 texels with four levels.
const WIDE: Texture = Texture {
    first: 1,
    width: 8,
    height: 4,
    levels: 4,
    log_size: 2.5,
    wrap_u: Wrap::Repeat as u32,
    wrap_v: Wrap::Mirror as u32,
    ..Texture::NONE
};

/// A texture of 5 by 3 texels with three levels, turned, for the second texture coordinates.
const ODD: Texture = Texture {
    first: 65,
    width: 5,
    height: 3,
    levels: 3,
    log_size: 2.45,
    wrap_u: Wrap::Clamp as u32,
    wrap_v: Wrap::Repeat as u32,
    filter: Filter::NearestMagnified as u32,
    set: 1,
    turn: [[0.8, -1.2], [1.7, 0.6]],
    shift: [0.3, -0.2],
};

/// Where the environment of two squares lies.
pub(super) const SKY: Sky = Sky { first: 129, side: 32, levels: 2, turn: [0.8, -0.6], intensity: 1.5 };

/// Words of [`TEXELS`].
const WORDS: usize = 3072;

/// Words that look random, where the tables of [`WIDE`], [`ODD`] and [`SKY`] lead.
const TEXELS: [u32; WORDS] = texels();

const fn texels() -> [u32; WORDS] {
    let mut texels = [0; WORDS];
    let mut word = 0;
    while word < WORDS {
        texels[word] = hash(word as u32);
        word += 1;
    }
    texels = table(texels, WIDE.first, &[32, 8, 2, 1]);
    texels = table(texels, ODD.first, &[15, 2, 1]);
    table(texels, SKY.first, &[34 * 34, 34 * 34, (IRRADIANCE_SIDE + 2) * (IRRADIANCE_SIDE + 2)])
}

/// Says at `first` where parts of these sizes start that follow it and one another.
const fn table(mut texels: [u32; WORDS], first: u32, sizes: &[u32]) -> [u32; WORDS] {
    let mut start = first + sizes.len() as u32;
    let mut part = 0;
    while part < sizes.len() {
        texels[first as usize + part] = start;
        start += sizes[part];
        part += 1;
    }
    assert!(start as usize <= WORDS);
    texels
}
