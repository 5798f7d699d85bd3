//! The deferred buffers, read back.

use crate::Error;
use crate::band::Band;
use crate::buffers::Slot;
use crate::frame::Renderer;
use bytemuck::Pod;
use rtrt_core::backend::Deferred;
use rtrt_core::layout::{Hit, ShadowBuffer};
use std::ops::Range;

impl Renderer {
    /// Appends what a band's first layer has left to the deferred buffers, if they were asked
    /// for.
    pub(crate) fn fetch_first_layer(
        &self,
        band: &Band,
        deferred: &mut Option<Deferred>,
    ) -> Result<(), Error> {
        let Some(deferred) = deferred else { return Ok(()) };
        let (frame, transmittance) = (&band.frame, deferred.transmittance_words);
        self.fetch(Slot::Hits, band.kept(1), &mut deferred.hits)?;
        self.fetch(Slot::Surfaces, band.kept(1), &mut deferred.surfaces)?;
        self.fetch(Slot::Masks, band.kept(frame.mask_words), &mut deferred.masks)?;
        self.fetch(Slot::Lit, band.kept(1), &mut deferred.lit)?;
        self.fetch(Slot::Transmittance, band.kept(transmittance), &mut deferred.transmittance)?;
        if frame.penumbra_window > 0 {
            let (words, radii) = (band.kept(transmittance), ShadowBuffer::new(frame).penumbra_radius(0, 0));
            self.fetch(Slot::Shadows, words.clone(), &mut deferred.raw_transmittance)?;
            let radii = words.start + radii..words.end + radii;
            self.fetch(Slot::Shadows, radii, &mut deferred.penumbra_radii)?;
        }
        Ok(())
    }

    /// Appends a band's colors and what its layers have hit to the deferred buffers, if they
    /// were asked for.
    pub(crate) fn fetch_colors(&self, band: &Band, deferred: &mut Option<Deferred>) -> Result<(), Error> {
        let Some(deferred) = deferred else { return Ok(()) };
        let (rays, count) = (band.frame.rays as usize, deferred.layer_count as usize);
        self.fetch(Slot::Colors, band.kept(1), &mut deferred.colors)?;
        if count > 0 {
            let mut layers: Vec<Hit> = Vec::new();
            self.fetch(Slot::Layers, 0..rays * count, &mut layers)?;
            let kept = band.kept(deferred.layer_count);
            deferred.layers.extend(kept.map(|at| layers[at % count * rays + at / count]));
        }
        Ok(())
    }

    /// Appends these elements of a buffer to `to`.
    pub(crate) fn fetch<T: Pod>(
        &self,
        slot: Slot,
        range: Range<usize>,
        to: &mut Vec<T>,
    ) -> Result<(), Error> {
        let Some(buffer) = self.buffers.get(slot).filter(|_| !range.is_empty()) else { return Ok(()) };
        let size = size_of::<T>();
        let bytes = self.device.fetch(buffer, (range.end * size) as u64)?;
        to.extend(bytemuck::pod_collect_to_vec::<u8, T>(&bytes[range.start * size..]));
        Ok(())
    }
}
