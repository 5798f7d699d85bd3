//! A frame in parts, for devices whose buffers are limited.

use crate::slot::rows;
use rtrt_core::grid::BLOCK_RAYS;
use rtrt_core::layout::{Frame, ShadowKind};
use rtrt_core::stage::penumbra_blocks::around;
use std::ops::Range;

/// A part of a frame that is rendered at once.
#[derive(Clone, Copy)]
pub struct Band {
    /// The frame, with the rays that are worked on.
    pub frame: Frame,
    /// The first ray that is kept. Those around are worked on because penumbras reach from them
    /// to it.
    pub first: u32,
    /// The number of kept rays.
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
pub fn bands(frame: &Frame, bytes: u64, keeps_layers: bool) -> impl Iterator<Item = Band> + use<> {
    let frame = *frame;
    let row = frame.grid().blocks_x() * BLOCK_RAYS;
    let largest = rows(keeps_layers).map(|row| row.bytes_per_ray(&frame)).max().unwrap_or(1);
    let around = if frame.shadow_kind() == ShadowKind::Penumbra { around(&frame) } else { 0 };
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
    use rtrt_core::layout::Surface;

    #[test]
    fn bands_are_whole_rows_of_blocks_and_make_the_frame() {
        let frame = Frame { width: 100, height: 90, side: 1, mask_words: 1, ..Frame::zeroed() };
        let frame = Frame { rays: frame.grid().rays(), ..frame };
        let row = 7 * BLOCK_RAYS;
        let split =
            |bytes| bands(&frame, bytes, false).map(|band| (band.first, band.rays)).collect::<Vec<_>>();
        let surface = size_of::<Surface>() as u64;
        assert_eq!(split(u64::MAX), [(0, 6 * row)]);
        assert_eq!(split(0).len(), 6);
        assert_eq!(split(surface * 4 * u64::from(row) + surface - 1), [(0, 4 * row), (4 * row, 2 * row)]);
        let layers = Frame { layers: 8, ..frame };
        let count = |keeps_layers| bands(&layers, surface * u64::from(6 * row), keeps_layers).count();
        assert_eq!([count(false), count(true)], [1, 2], "seven hits a ray are more than a surface");
        let soft = Frame { penumbra_window: 24, lights: 1, ..frame };
        let split: Vec<_> =
            bands(&soft, 0, false).map(|band| (band.first, band.frame.first_ray, band.frame.rays)).collect();
        assert_eq!(split[0], (0, 0, 3 * row));
        assert_eq!(split[3], (3 * row, row, 5 * row));
    }
}
