//! A frame in parts, for devices whose buffers are limited.

use rtrt_core::grid::BLOCK_RAYS;
use rtrt_core::layout::{Frame, ShadowBuffer, Surface};
use rtrt_core::stage::penumbra_blocks::around;
use std::ops::Range;

/// Words a ray of the buffers `Shadows` and `Transmittance`. The one that shadow rays are traced in is a
/// [`ShadowBuffer`].
pub fn shadow_words(frame: &Frame) -> [u64; 2] {
    let (lights, traced) = (u64::from(frame.lights), u64::from(ShadowBuffer::new(frame).words_per_ray()));
    match (frame.penumbra_window, frame.layers) {
        (0, 0) => [0, 0],
        (0, _) => [0, traced],
        _ => [traced, lights],
    }
}

/// A part of a frame that is rendered at once.
#[derive(Clone, Copy)]
pub struct Band {
    /// The frame, with the rays that are worked on.
    pub frame: Frame,
    /// The first ray that is kept. Those around are worked on because penumbras reach from them
    /// to it.
    pub first: u32,
    /// How many are kept.
    pub rays: u32,
}

impl Band {
    /// Where the rays that are kept are, in a buffer of so many elements a ray.
    pub fn kept(&self, elements: u32) -> Range<usize> {
        let first = self.first - self.frame.first_ray;
        (first * elements) as usize..((first + self.rays) * elements) as usize
    }
}

/// The frame in bands: whole rows of blocks, as many as no buffer of more than `bytes`
/// needs, but at least one; and, where shadows are soft, the rows around from which penumbras
/// reach.
pub fn bands(frame: &Frame, bytes: u64) -> impl Iterator<Item = Band> + use<> {
    let frame = *frame;
    let row = frame.grid().blocks_x() * BLOCK_RAYS;
    let [shadows, transmittance] = shadow_words(&frame).map(|words| 4 * words);
    let largest =
        (size_of::<Surface>() as u64).max(4 * u64::from(frame.mask_words)).max(transmittance).max(shadows);
    let around = if frame.penumbra_window == 0 { 0 } else { around(&frame) };
    let rows = (bytes / largest / u64::from(row)).saturating_sub(2 * u64::from(around)).max(1);
    let step = (rows * u64::from(row)).min(u64::from(frame.rays)) as u32;
    let all = frame.rays;
    (0..all).step_by(step as usize).map(move |first| {
        let rays = step.min(all - first);
        let first_ray = first.saturating_sub(around * row);
        let end = (first + rays).saturating_add(around * row).min(all);
        Band { frame: Frame { first_ray, rays: end - first_ray, ..frame }, first, rays }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn bands_are_whole_rows_of_blocks_and_make_the_frame() {
        let frame = Frame { width: 100, height: 90, side: 1, mask_words: 1, ..Frame::zeroed() };
        let frame = Frame { rays: frame.grid().rays(), ..frame };
        let row = 7 * BLOCK_RAYS;
        let split = |bytes| bands(&frame, bytes).map(|band| (band.first, band.rays)).collect::<Vec<_>>();
        assert_eq!(split(u64::MAX), [(0, 6 * row)]);
        assert_eq!(split(0).len(), 6);
        assert_eq!(split(56 * 4 * u64::from(row) + 55), [(0, 4 * row), (4 * row, 2 * row)]);
        let soft = Frame { penumbra_window: 24, lights: 1, ..frame };
        let split: Vec<_> =
            bands(&soft, 0).map(|band| (band.first, band.frame.first_ray, band.frame.rays)).collect();
        assert_eq!(split[0], (0, 0, 3 * row));
        assert_eq!(split[3], (3 * row, row, 5 * row));
    }
}
