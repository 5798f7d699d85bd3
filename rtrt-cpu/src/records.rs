//! The deferred buffers, block by block.

use crate::block::Shadows;
use crate::wide::Wide;
use bytemuck::Zeroable;
use rtrt_core::backend::Deferred;
use rtrt_core::grid::BLOCK_RAYS;
use rtrt_core::kernel::traverse::Best;
use rtrt_core::lane::Bits;
use rtrt_core::layout::{Frame, Hit, Lit, Surface};
use rtrt_core::stage::light::Arriving;
use rtrt_core::stage::surface::Surfaces;
use rtrt_core::stage::visibility::hit;

/// Where a block's deferred records go.
pub struct Records<'a> {
    pub hits: &'a mut [Hit],
    pub surfaces: &'a mut [Surface],
    pub masks: &'a mut [u32],
    pub tints: &'a mut [u32],
    pub lit: &'a mut [Lit],
    pub colors: &'a mut [[f32; 4]],
    pub layers: &'a mut [Hit],
}

/// Where to keep what the first layer's shadows are before they are blurred.
pub struct Kept<'a> {
    pub left: &'a mut Vec<u32>,
    pub penumbras: &'a mut Vec<f32>,
}

impl Records<'_> {
    /// Keeps what the packet from `first` on has found in the layer of this number.
    #[inline(always)]
    pub fn keep<L: Wide, const G: usize>(
        &mut self,
        frame: &Frame,
        number: usize,
        first: usize,
        best: &[Best<L>; G],
        surfaces: &[Surfaces<L>; G],
        shadows: &Shadows<'_, L, G>,
        arriving: &[Arriving<L>; G],
    ) {
        for g in 0..G {
            let none = surfaces[g].material.like(0);
            for lane in 0..L::WIDTH {
                let at = first + g * L::WIDTH + lane;
                if number > 0 {
                    let behind = frame.layers as usize - 1;
                    self.layers[at * behind + number - 1] = hit(&best[g], lane);
                    continue;
                }
                self.hits[at] = hit(&best[g], lane);
                self.surfaces[at] = surfaces[g].lane(lane);
                let words = frame.mask_words;
                for w in 0..words {
                    let mask = shadows.word(frame, w, none, g);
                    self.masks[(at as u32 * words + w) as usize] = mask.lane(lane);
                }
                let lights = if frame.is_tinted() { frame.lights } else { 0 };
                for light in 0..lights {
                    let tint = shadows.tint(light, none, g);
                    self.tints[(at as u32 * lights + light) as usize] = tint.lane(lane);
                }
                self.lit[at] = arriving[g].lane(lane);
            }
        }
    }
}

/// `count` parts of `length` elements; empty ones where there are none.
fn chunks<T: Send>(all: &mut [T], count: usize, length: usize) -> Vec<&mut [T]> {
    if length == 0 {
        return (0..count).map(|_| Default::default()).collect();
    }
    all.chunks_mut(length).collect()
}

/// The parts of the deferred buffers that blocks fill; and those of shadows before they are
/// blurred, which are filled as a whole.
pub fn block_records<'a>(deferred: &'a mut Deferred, frame: &Frame) -> (Vec<Option<Records<'a>>>, Kept<'a>) {
    let (blocks, rays) = (frame.grid().blocks() as usize, BLOCK_RAYS as usize);
    let mut surfaces = deferred.surfaces.chunks_mut(rays);
    let mut masks = deferred.masks.chunks_mut(rays * frame.mask_words as usize);
    let mut tints = chunks(&mut deferred.tints, blocks, rays * deferred.tint_words as usize).into_iter();
    let mut lit = deferred.lit.chunks_mut(rays);
    let mut colors = deferred.colors.chunks_mut(rays);
    let mut layers = chunks(&mut deferred.layers, blocks, rays * deferred.layer_count as usize).into_iter();
    let one = |hits| {
        let (surfaces, masks, tints) = (surfaces.next()?, masks.next()?, tints.next()?);
        let (lit, colors, layers) = (lit.next()?, colors.next()?, layers.next()?);
        Some(Records { hits, surfaces, masks, tints, lit, colors, layers })
    };
    let records = deferred.hits.chunks_mut(rays).map(one).collect();
    (records, Kept { left: &mut deferred.left, penumbras: &mut deferred.penumbras })
}

/// Makes room for a frame.
pub fn deferred_room(deferred: &mut Deferred, frame: &Frame, lists: &[u32]) {
    let rays = frame.rays as usize;
    deferred.mask_words = frame.mask_words;
    deferred.tint_words = if frame.is_tinted() { frame.lights } else { 0 };
    deferred.layer_count = frame.layers.max(1) - 1;
    deferred.lists.clear();
    deferred.lists.extend_from_slice(lists);
    deferred.hits.resize(rays, Hit::MISS);
    deferred.surfaces.resize(rays, Zeroable::zeroed());
    deferred.masks.resize(rays * frame.mask_words as usize, 0);
    deferred.left.clear();
    deferred.penumbras.clear();
    deferred.tints.clear();
    deferred.tints.resize(rays * deferred.tint_words as usize, 0);
    deferred.layers.clear();
    deferred.layers.resize(rays * deferred.layer_count as usize, Hit::MISS);
    deferred.lit.resize(rays, Zeroable::zeroed());
    deferred.colors.resize(rays, [0.0; 4]);
}
