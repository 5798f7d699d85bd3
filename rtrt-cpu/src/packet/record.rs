//! Records, for who asks what each stage has found.

use super::PacketState;
use crate::records::Records;
use crate::shadows::Shadows;
use crate::wide::Wide;
use rtrt_core::lane::Bits;
use rtrt_core::stage::occlusion;
use rtrt_core::stage::visibility::hit;

impl<L: Wide, const G: usize> PacketState<'_, L, G> {
    /// Writes the records of the layer.
    #[inline(always)]
    pub(super) fn record(&self, layer: u32, shadows: &Shadows, records: &mut Records<'_>) {
        let frame = self.context.trace.frame;
        let none = L::splat(self.token, 0.0).broadcast_bits(0);
        for g in 0..G {
            let first = self.first + g * L::WIDTH;
            for lane in 0..L::WIDTH {
                let (at, mut found) = (first + lane, hit(&self.closest[g], lane));
                if frame.is_shared == 1 {
                    found.triangle = self.closest[g].triangle.lane(lane);
                }
                if layer > 0 {
                    records.layers[at * frame.layers_behind() as usize + layer as usize - 1] = found;
                    continue;
                }
                records.hits[at] = found;
                records.surfaces[at] = self.surfaces[g].lane(lane);
                records.lit[at] = self.incoming[g].lane(lane);
                let (words, lights) = (frame.mask_words, frame.transmittance_words());
                for (word, to) in (0..).zip(of_ray(records.masks, at, words)) {
                    let mask = if lights == 0 {
                        self.mask(word, g)
                    } else {
                        occlusion::mask(
                            frame,
                            word,
                            none,
                            #[inline(always)]
                            |light| self.transmittance_of(light, shadows, g),
                        )
                    };
                    *to = mask.lane(lane);
                }
                for (light, to) in (0..).zip(of_ray(records.transmittance, at, lights)) {
                    *to = self.transmittance_of(light, shadows, g).lane(lane);
                }
            }
        }
    }

    /// The transmittance of a light at a group.
    #[inline(always)]
    fn transmittance_of(&self, light: u32, shadows: &Shadows, g: usize) -> L::Bits {
        L::load(self.token, &shadows.transmittance(light)[self.first + g * L::WIDTH..])
    }

    /// A word of the shadow mask, where shadows are bits.
    #[inline(always)]
    fn mask(&self, word: u32, g: usize) -> L::Bits {
        if word == 0 { self.mask[g] } else { self.more_masks[word as usize - 1][g] }
    }
}

/// The words of a ray, among those of rays that follow one another.
fn of_ray(words: &mut [u32], ray: usize, count: u32) -> &mut [u32] {
    &mut words[ray * count as usize..][..count as usize]
}
