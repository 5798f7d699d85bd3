//! Prepare: the covers, in parallel.

use rayon::prelude::*;
use rtrt_core::kernel::cover::Cover;
use rtrt_core::layout::{Frame, Object, View};
use rtrt_core::stage::prepare;

/// Makes the covers of the camera, and, unless the lists of lights are kept, of lights.
pub fn prepare(
    frame: &Frame,
    views: &[View],
    objects: &[Object],
    covers: &mut Vec<Cover>,
    keeps_lights: bool,
) {
    covers.resize(prepare::count(frame) as usize, Cover::NONE);
    let wanted = if keeps_lights { frame.seen as usize } else { covers.len() };
    covers[..wanted]
        .par_iter_mut()
        .with_min_len(256)
        .enumerate()
        .for_each(|(index, cover)| *cover = prepare::prepare(frame, views, objects, index as u32));
}
