//! Prepare: the covers, in parallel.

use rayon::prelude::*;
use rtrt_core::kernel::cover::Cover;
use rtrt_core::layout::{Frame, Object, View};
use rtrt_core::stage::prepare;

/// Fills `covers`.
pub fn prepare(frame: &Frame, views: &[View], objects: &[Object], covers: &mut Vec<Cover>) {
    covers.resize(prepare::count(frame) as usize, Cover::NONE);
    covers
        .par_iter_mut()
        .with_min_len(256)
        .enumerate()
        .for_each(|(index, cover)| *cover = prepare::prepare(frame, views, objects, index as u32));
}
