//! What the penumbra filter reads of a block's rays, as planes: a word of all rays, then the next word.
//!
//! | planes | of a ray                        |
//! |--------|---------------------------------|
//! | 3      | origin of its shadow rays       |
//! | 3      | normal                          |
//! | 2      | of each light: transmittance, radius of the penumbra |

use rtrt_core::grid::BLOCK_RAYS;
use rtrt_core::layout::Frame;

/// Rays in a block: words of a plane.
pub const RAYS: usize = BLOCK_RAYS as usize;
/// The first of three planes: the origin.
pub const ORIGIN: usize = 0;
/// The first of three planes: the normal.
pub const NORMAL: usize = 3;
/// The first plane of the first light.
const LIGHTS: usize = 6;

/// The planes of a block.
pub fn count(frame: &Frame) -> usize {
    LIGHTS + 2 * frame.lights as usize
}

/// The plane of the transmittance of a light.
#[inline(always)]
pub fn transmittance(light: usize) -> usize {
    LIGHTS + 2 * light
}

/// The plane of the radii of the penumbras of a light.
#[inline(always)]
pub fn radius(light: usize) -> usize {
    transmittance(light) + 1
}

/// The transmittances and the radii of each light.
#[inline(always)]
pub fn lights(cells: &[u32]) -> impl Iterator<Item = (&[u32], &[u32])> {
    cells[LIGHTS * RAYS..].chunks(2 * RAYS).map(
        #[inline(always)]
        |planes| planes.split_at(RAYS),
    )
}

/// The same, to be written.
#[inline(always)]
pub fn lights_mut(cells: &mut [u32]) -> impl Iterator<Item = (&mut [u32], &mut [u32])> {
    cells[LIGHTS * RAYS..].chunks_mut(2 * RAYS).map(
        #[inline(always)]
        |planes| planes.split_at_mut(RAYS),
    )
}
