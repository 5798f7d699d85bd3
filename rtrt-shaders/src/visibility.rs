//! Visibility: one invocation a ray.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::layout::{Frame, Hit, Instance, Node, View};
use rtrt_core::stage;
use rtrt_core::stage::context::Context;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// The closest surface on each ray.
#[spirv(compute(threads(64), entry_point_name = "visibility"))]
pub fn visibility(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] hits: &mut [Hit],
) {
    let index = index(id);
    if index < frame.rays {
        let lists = BlockLists { data: lists, blocks: frame.blocks };
        let geometry = Geometry {
            instances,
            nodes,
            mesh_data,
            positions,
            texels: mesh_data,
            magnitude: frame.magnitude,
        };
        let context = Context { frame, views, lists, geometry };
        let ray = RayIndex(frame.first_ray + index);
        let best = stage::visibility::visibility::<f32, 1>((), &context, ray);
        hits[index as usize] = stage::visibility::hit(&best[0], 0);
    }
}
