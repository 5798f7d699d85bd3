//! What the kernels of the canary are asked with: views, an instance, textures and an environment.

use crate::kernel::area::hash;
use crate::kernel::environment::{IRRADIANCE_SIDE, Sky};
use crate::kernel::texture::{DECODE_WORDS, Maps};
use crate::layout::{Frame, Instance, Material, NONE, Texture, View, ViewKind, Wrap};

/// All zero.
const NO_VIEW: View = View {
    center: [0.0; 3],
    kind: ViewKind::Off as u32,
    x: [0.0; 3],
    w_offset: 0.0,
    y: [0.0; 3],
    spread: 0.0,
    w: [0.0; 3],
    spread_w: 0.0,
    depth: [0.0; 3],
    width: 0,
    start: [0.0; 3],
    height: 0,
    start_x: [0.0; 3],
    first_block: 0,
    start_y: [0.0; 3],
    inv_reach: 0.0,
    along: [0.0; 3],
    inverse_square: 0.0,
    along_x: [0.0; 3],
    pixel: 0.0,
    along_y: [0.0; 3],
    pixel_t: 0.0,
    color: [0.0; 3],
    reach_squared: 0.0,
    axis: [0.0; 3],
    cone_scale: 0.0,
    cone_offset: 0.0,
    radius: 0.0,
    disc: 0.0,
    margin: 0.0,
    jitter: 0,
    one_list: 0,
    by_angle: 0,
    shadow_distance: 0.0,
};

/// A camera with a picture of 4 by 4 blocks, that looks along −z.
pub(super) const CAMERA: View = View {
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
    ..NO_VIEW
};

/// A spot light with a radius, one face of its cube.
pub(super) const SPOT: View = View {
    center: [0.3, 5.7, -0.9],
    kind: ViewKind::Point as u32,
    width: 8,
    height: 8,
    x: [4.0, 4.0, 0.0],
    y: [0.0, 4.0, 4.0],
    w: [0.0, 1.0, 0.0],
    inv_reach: 0.03,
    inverse_square: 1.0,
    reach_squared: 1112.0,
    axis: [0.48, -0.8, 0.36],
    cone_scale: 3.7,
    cone_offset: -1.9,
    radius: 0.25,
    disc: 0.25,
    margin: 0.25,
    jitter: 0x9e37_79b9,
    ..NO_VIEW
};

/// A sun, whose `inv_reach` only [`falloff`](crate::kernel::falloff) reads.
pub(super) const SUN: View = View {
    center: [-10.0, -10.0, 0.0],
    kind: ViewKind::Sun as u32,
    width: 8,
    height: 8,
    w_offset: 1.0,
    x: [0.32, 0.1, 0.0],
    y: [0.0, 0.1, 0.32],
    along: [0.36, -0.8, -0.48],
    inv_reach: 0.03,
    margin: 0.01,
    shadow_distance: 6.3,
    ..NO_VIEW
};

/// A frame of 64 by 64 pixels with four sub-rays each.
pub(super) const FRAME: Frame = Frame {
    width: 64,
    height: 64,
    side: 2,
    views: 0,
    instances: 0,
    lights: 0,
    blocks: 0,
    mask_words: 0,
    capacity: 0,
    shadows: 0,
    first_ray: 0,
    rays: 0,
    ambient_r: 0.0,
    ambient_g: 0.0,
    ambient_b: 0.0,
    background_r: 0.0,
    background_g: 0.0,
    background_b: 0.0,
    magnitude: 16.0,
    details: 0,
    sky_first: 0,
    sky_side: 0,
    sky_levels: 0,
    layers: 0,
    penumbra_window: 0,
    seen: 0,
    first_seen: 0,
    backdrop: 0,
    first_block: 0,
    is_drawn: 0,
    unused_0: 0,
    unused_1: 0,
};

/// An instance that is turned, stretched and moved.
pub(super) const INSTANCE: Instance = Instance {
    to_object: [[0.6, 0.8, 0.0, 3.1], [-1.6, 1.2, 0.0, -0.7], [0.0, 0.0, 0.3, 12.3]],
    to_world: [[0.6, -0.4, 0.0, -2.14], [0.8, 0.3, 0.0, -2.27], [0.0, 0.0, 3.333_333_3, -41.0]],
    low: [0.0; 3],
    root: 0,
    high: [0.0; 3],
    first_vertex: 0,
    center: [0.0; 3],
    radius: 0.0,
    first_index: 0,
    triangles: 0,
    material: 0,
    is_identity: 0,
    slack: 1.0 / 8192.0,
    first_tangent: 0,
    first_second_uv: 0,
    transparency: 0,
    kind: 0,
    start: 0,
    opened_from: NONE,
    double_sided: 1,
};

/// Words of [`TEXELS`].
const WORDS: usize = 1024;

/// A texture of 8 by 4 texels with four levels.
const WIDE: Texture = Texture {
    first: DECODE_WORDS as u32,
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
    first: DECODE_WORDS as u32 + 64,
    width: 5,
    height: 3,
    levels: 3,
    log_size: 2.45,
    wrap_u: Wrap::Clamp as u32,
    wrap_v: Wrap::Repeat as u32,
    set: 1,
    turn: [[0.8, -1.2], [1.7, 0.6]],
    shift: [0.3, -0.2],
};

/// Where the environment of three squares lies.
pub(super) const SKY: Sky = Sky { first: DECODE_WORDS as u32 + 128, side: 8, levels: 3 };

/// Words that look random, where the tables of [`WIDE`], [`ODD`] and [`SKY`] lead; before them, what
/// bytes stand for.
const TEXELS: [u32; WORDS] = texels();

const fn texels() -> [u32; WORDS] {
    let mut texels = [0; WORDS];
    let mut word = 0;
    while word < WORDS {
        texels[word] = if word < DECODE_WORDS {
            ((word * word) as f32 * (1.0 / 65_025.0)).to_bits()
        } else {
            hash(word as u32)
        };
        word += 1;
    }
    texels = table(texels, WIDE.first, &[32, 8, 2, 1]);
    texels = table(texels, ODD.first, &[15, 2, 1]);
    table(texels, SKY.first, &[10 * 10, 6 * 6, 4 * 4, (IRRADIANCE_SIDE + 2) * (IRRADIANCE_SIDE + 2)])
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

const fn material(color: Texture) -> Material {
    let mut textures = [Texture::NONE; Material::TEXTURES];
    textures[Material::COLOR] = color;
    Material {
        base: [0.0; 3],
        shininess: 0.0,
        specular: [0.0; 3],
        metallic: 0.0,
        emission: [0.0; 3],
        roughness: 0.0,
        bump: 0.0,
        occlusion: 0.0,
        unlit: 0,
        alpha: 0.0,
        alpha_mode: 0,
        cutoff: 0.0,
        double_sided: 0,
        textures,
    }
}

/// A material for each texture, and their texels.
pub const MAPS: Maps<'_> = Maps { materials: &[material(WIDE), material(ODD)], texels: &TEXELS };
