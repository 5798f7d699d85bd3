//! Share: one invocation a pixel.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::layout::{Frame, Hit};
use rtrt_core::stage;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Which sub-rays of each pixel take the color of another.
#[spirv(compute(threads(64), entry_point_name = "share"))]
pub fn share(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] hits: &mut [Hit],
) {
    let index = index(id);
    let grid = frame.grid();
    let [first, count] = grid.pixels(RayIndex(frame.first_ray), frame.rays);
    if index < count {
        stage::share::share(frame, hits, grid.first_ray(first + index).0 - frame.first_ray);
    }
}
