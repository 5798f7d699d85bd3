//! Prepare: one invocation a cover.

use crate::index;
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::layout::{Frame, Instance, View};
use rtrt_core::stage;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Which blocks of which view an instance covers.
#[spirv(compute(threads(64), entry_point_name = "prepare"))]
pub fn prepare(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] screen_bounds: &mut [ScreenBounds],
) {
    let index = index(id);
    if index < stage::prepare::count(frame) {
        screen_bounds[index as usize] = stage::prepare::prepare(frame, views, instances, index);
    }
}
