//! The deferred buffers, block by block.

use crate::shadows::Shadows;
use crate::wide::Wide;
use bytemuck::Zeroable;
use rtrt_core::backend::Deferred;
use rtrt_core::grid::BLOCK_RAYS;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::lane::Bits;
use rtrt_core::layout::{Frame, Hit, Lit, Surface};
use rtrt_core::stage::light::IncomingLight;
use rtrt_core::stage::surface::Surfaces;
use rtrt_core::stage::visibility::hit;

/// Where a block's deferred records go.
pub struct Records<'a> {
    pub hits: &'a mut [Hit],
    pub surfaces: &'a mut [Surface],
    pub masks: &'a mut [u32],
    pub transmittance: &'a mut [u32],
    pub lit: &'a mut [Lit],
    pub colors: &'a mut [[f32; 4]],
    pub layers: &'a mut [Hit],
}

/// What the stages have found of a packet.
pub struct Found<'a, L: Wide, const G: usize> {
    pub closest: &'a [ClosestHit<L>; G],
    pub surfaces: &'a [Surfaces<L>; G],
    pub shadows: &'a Shadows<'a, L, G>,
    pub light: &'a [IncomingLight<L>; G],
}

/// Where the first layer's shadows go before they are filtered.
pub struct RawShadows<'a> {
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
        found: &Found<'_, L, G>,
    ) {
        let Found { closest, surfaces, shadows, light } = found;
        for g in 0..G {
            let none = surfaces[g].material.broadcast(0);
            for lane in 0..L::WIDTH {
                let at = first + g * L::WIDTH + lane;
                if number > 0 {
                    let behind = frame.layers as usize - 1;
                    self.layers[at * behind + number - 1] = hit(&closest[g], lane);
                    continue;
                }
                self.hits[at] = hit(&closest[g], lane);
                self.surfaces[at] = surfaces[g].lane(lane);
                let words = frame.mask_words;
                for w in 0..words {
                    let mask = shadows.word(frame, w, none, g);
                    self.masks[(at as u32 * words + w) as usize] = mask.lane(lane);
                }
                let lights = if frame.has_transmittance() { frame.lights } else { 0 };
                for number in 0..lights {
                    let transmittance = shadows.transmittance(number, none, g);
                    self.transmittance[(at as u32 * lights + number) as usize] = transmittance.lane(lane);
                }
                self.lit[at] = light[g].lane(lane);
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
pub fn block_records<'a>(
    deferred: &'a mut Deferred,
    frame: &Frame,
) -> (Vec<Option<Records<'a>>>, RawShadows<'a>) {
    let (blocks, rays) = (frame.grid().blocks() as usize, BLOCK_RAYS as usize);
    let mut surfaces = deferred.surfaces.chunks_mut(rays);
    let mut masks = deferred.masks.chunks_mut(rays * frame.mask_words as usize);
    let mut transmittance =
        chunks(&mut deferred.transmittance, blocks, rays * deferred.transmittance_words as usize).into_iter();
    let mut lit = deferred.lit.chunks_mut(rays);
    let mut colors = deferred.colors.chunks_mut(rays);
    let mut layers = chunks(&mut deferred.layers, blocks, rays * deferred.layer_count as usize).into_iter();
    let one = |hits| {
        let (surfaces, masks, transmittance) = (surfaces.next()?, masks.next()?, transmittance.next()?);
        let (lit, colors, layers) = (lit.next()?, colors.next()?, layers.next()?);
        Some(Records { hits, surfaces, masks, transmittance, lit, colors, layers })
    };
    let records = deferred.hits.chunks_mut(rays).map(one).collect();
    (records, RawShadows { left: &mut deferred.raw_transmittance, penumbras: &mut deferred.penumbra_radii })
}

/// Makes room for a frame.
pub fn deferred_room(deferred: &mut Deferred, frame: &Frame, lists: &[u32]) {
    let rays = frame.rays as usize;
    deferred.mask_words = frame.mask_words;
    deferred.transmittance_words = if frame.has_transmittance() { frame.lights } else { 0 };
    deferred.layer_count = frame.layers.max(1) - 1;
    deferred.lists.clear();
    deferred.lists.extend_from_slice(lists);
    deferred.hits.resize(rays, Hit::MISS);
    deferred.surfaces.resize(rays, Zeroable::zeroed());
    deferred.masks.resize(rays * frame.mask_words as usize, 0);
    deferred.raw_transmittance.clear();
    deferred.penumbra_radii.clear();
    deferred.transmittance.clear();
    deferred.transmittance.resize(rays * deferred.transmittance_words as usize, 0);
    deferred.layers.clear();
    deferred.layers.resize(rays * deferred.layer_count as usize, Hit::MISS);
    deferred.lit.resize(rays, Zeroable::zeroed());
    deferred.colors.resize(rays, [0.0; 4]);
}
