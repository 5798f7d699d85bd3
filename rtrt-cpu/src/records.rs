//! The deferred buffers, block by block.

use crate::block::RAYS;
use crate::shadows::Shadows;
use alloc::vec::Vec;
use rtrt_core::backend::Deferred;
use rtrt_core::layout::{Frame, Hit, Lit, Surface};

/// Where a block's deferred records go.
pub struct Records<'a> {
    pub hits: &'a mut [Hit],
    pub surfaces: &'a mut [Surface],
    pub masks: &'a mut [u32],
    pub raw_transmittance: &'a mut [u32],
    pub penumbra_radii: &'a mut [f32],
    pub transmittance: &'a mut [u32],
    pub lit: &'a mut [Lit],
    pub colors: &'a mut [[f32; 4]],
    pub layers: &'a mut [Hit],
}

impl Records<'_> {
    /// Writes the shadows before they are filtered.
    pub fn raw_shadows(&mut self, shadows: &Shadows) {
        let lights = self.raw_transmittance.len() / RAYS;
        for light in 0..lights {
            let planes = shadows.both(light as u32);
            for (ray, (transmittance, radius)) in planes[0].iter().zip(&planes[1]).enumerate() {
                self.raw_transmittance[ray * lights + light] = *transmittance;
                self.penumbra_radii[ray * lights + light] = f32::from_bits(*radius);
            }
        }
    }
}

/// Makes room for a frame, and gives the parts of it that blocks fill.
pub fn block_records<'a>(deferred: &'a mut Deferred, frame: &Frame) -> Vec<Records<'a>> {
    let rays = frame.rays as usize;
    deferred.resize(frame);
    let [masks, transmittance, layers] =
        [deferred.mask_words, deferred.transmittance_words, deferred.layer_count].map(|words| words as usize);
    let raw = deferred.raw_transmittance.len() / rays * RAYS;
    let mut rest = Records {
        hits: &mut deferred.hits,
        surfaces: &mut deferred.surfaces,
        masks: &mut deferred.masks,
        raw_transmittance: &mut deferred.raw_transmittance,
        penumbra_radii: &mut deferred.penumbra_radii,
        transmittance: &mut deferred.transmittance,
        lit: &mut deferred.lit,
        colors: &mut deferred.colors,
        layers: &mut deferred.layers,
    };
    let block = |_| Records {
        hits: first(&mut rest.hits, RAYS),
        surfaces: first(&mut rest.surfaces, RAYS),
        masks: first(&mut rest.masks, RAYS * masks),
        raw_transmittance: first(&mut rest.raw_transmittance, raw),
        penumbra_radii: first(&mut rest.penumbra_radii, raw),
        transmittance: first(&mut rest.transmittance, RAYS * transmittance),
        lit: first(&mut rest.lit, RAYS),
        colors: first(&mut rest.colors, RAYS),
        layers: first(&mut rest.layers, RAYS * layers),
    };
    (0..rays / RAYS).map(block).collect()
}

/// Takes so many elements from the front of a slice.
fn first<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, others) = core::mem::take(rest).split_at_mut(count);
    *rest = others;
    first
}
