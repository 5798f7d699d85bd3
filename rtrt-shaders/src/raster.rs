//! Raster: the closest surfaces, rasterized instead of traced.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::project::ClipWindow;
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::layout::{Frame, Hit, Instance, View};
use rtrt_core::stage;
use rtrt_core::stage::raster::{Drawn, Meshes};
use spirv_std::glam::{UVec2, UVec3, Vec4};
use spirv_std::spirv;

/// A vertex of a triangle, three a triangle of the instance whose number is that of the instance.
#[spirv(vertex(entry_point_name = "vertex"))]
pub fn vertex(
    #[spirv(vertex_index)] number: u32,
    #[spirv(instance_index)] instance: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(uniform, descriptor_set = 0, binding = 1)] window: &ClipWindow,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] screen_bounds: &[ScreenBounds],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(position)] place: &mut Vec4,
    #[spirv(flat)] drawn: &mut UVec2,
) {
    let meshes = Meshes { instances, mesh_data, positions };
    let camera = &views[Frame::CAMERA as usize];
    let (clip, numbers) =
        stage::raster::vertex(frame, camera, window, screen_bounds, &meshes, instance, number);
    *place = Vec4::new(clip[0], clip[1], clip[2], clip[3]);
    *drawn = UVec2::new(numbers[0], numbers[1]);
}

/// What is drawn.
#[spirv(fragment(entry_point_name = "fragment"))]
pub fn fragment(#[spirv(flat)] drawn: UVec2, pixel: &mut UVec2) {
    *pixel = drawn;
}

/// The hit of each ray whose pixel identifies it.
#[spirv(compute(threads(64), entry_point_name = "pick"))]
pub fn pick(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] drawn: &[Drawn],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] hits: &mut [Hit],
) {
    let index = index(id);
    if index < frame.rays {
        let ray = RayIndex(frame.first_ray + index);
        let meshes = Meshes { instances, mesh_data, positions };
        let camera = &views[Frame::CAMERA as usize];
        let drawn = drawn[stage::raster::pixel(frame, ray) as usize];
        hits[index as usize] = stage::raster::pick(frame, camera, &meshes, ray, drawn);
    }
}
