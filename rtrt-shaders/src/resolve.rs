//! Resolve: one invocation a pixel.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::layout::{Frame, Hit};
use rtrt_core::stage::resolve::average;
use rtrt_core::stage::{self, share};
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// The pixels that the rays of this dispatch make, row by row.
#[spirv(compute(threads(64), entry_point_name = "resolve"))]
pub fn resolve(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] hits: &[Hit],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] colors: &[[f32; 4]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] pixels: &mut [u32],
) {
    let index = index(id);
    let grid = frame.grid();
    let [first, count] = grid.pixels(RayIndex(frame.first_ray), frame.rays);
    if index < count {
        let first = grid.first_ray(first + index);
        let color = |ray: RayIndex| {
            let mut ray = ray.0 - frame.first_ray;
            if frame.is_shared == 1 {
                ray = share::shaded(ray, &hits[ray as usize]);
            }
            colors[ray as usize]
        };
        let color = average(frame.side, first, color);
        let mut through = [0.0; 4];
        if frame.has_colored_layers() {
            let of_ray = |ray: RayIndex| colors[(ray.0 - frame.first_ray + frame.rays) as usize];
            through = average(frame.side, first, of_ray);
        }
        pixels[index as usize] = stage::resolve::resolve::<f32>((), frame, |_| color, |_| through).0;
    }
}
