//! The deferred buffers, read back.

use crate::band::Band;
use crate::buffers::Buffers;
use crate::device::Device;
use crate::error::Error;
use crate::slot::Slot;
use bytemuck::Pod;
use rtrt_core::backend::Deferred;
use rtrt_core::layout::{Hit, ShadowBuffer, ShadowKind};
use std::ops::Range;

/// Where results are read from.
#[derive(Clone, Copy)]
pub(crate) struct Results<'a> {
    pub device: &'a Device,
    pub buffers: &'a Buffers,
}

impl Results<'_> {
    /// Appends the first layer of a band to the deferred buffers.
    pub async fn first_layer(self, band: &Band, deferred: &mut Deferred) -> Result<(), Error> {
        let (frame, transmittance) = (&band.frame, deferred.transmittance_words);
        self.read(Slot::Hits, band.kept(1), &mut deferred.hits).await?;
        self.read(Slot::Surfaces, band.kept(1), &mut deferred.surfaces).await?;
        self.read(Slot::Masks, band.kept(frame.mask_words), &mut deferred.masks).await?;
        self.read(Slot::Lit, band.kept(1), &mut deferred.lit).await?;
        self.read(Slot::Transmittance, band.kept(transmittance), &mut deferred.transmittance).await?;
        if frame.shadow_kind() == ShadowKind::Penumbra {
            let (words, radii) = (band.kept(transmittance), ShadowBuffer::new(frame).penumbra_radius(0, 0));
            self.read(Slot::Shadows, words.clone(), &mut deferred.raw_transmittance).await?;
            let radii = words.start + radii..words.end + radii;
            self.read(Slot::Shadows, radii, &mut deferred.penumbra_radii).await?;
        }
        Ok(())
    }

    /// Appends the colors of a band, and the hits of its layers behind the first, to the deferred
    /// buffers.
    pub async fn colors(self, band: &Band, deferred: &mut Deferred) -> Result<(), Error> {
        let (rays, count) = (band.frame.rays as usize, deferred.layer_count as usize);
        self.read(Slot::Colors, band.kept(1), &mut deferred.colors).await?;
        if count > 0 {
            let mut layers: Vec<Hit> = Vec::new();
            self.read(Slot::Layers, 0..rays * count, &mut layers).await?;
            let kept = band.kept(deferred.layer_count);
            deferred.layers.extend(kept.map(|at| layers[at % count * rays + at / count]));
        }
        Ok(())
    }

    /// Appends these elements of a buffer to `to`.
    pub async fn read<T: Pod>(self, slot: Slot, range: Range<usize>, to: &mut Vec<T>) -> Result<(), Error> {
        let Some(buffer) = self.buffers.get(slot).filter(|_| !range.is_empty()) else { return Ok(()) };
        let size = size_of::<T>();
        let bytes = self.device.fetch(buffer, (range.end * size) as u64).await?;
        to.extend(bytemuck::pod_collect_to_vec::<u8, T>(&bytes[range.start * size..]));
        Ok(())
    }
}
