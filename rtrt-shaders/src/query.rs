//! Queries: one invocation a ray.

use crate::index;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::layout::{Hit, Instance, Node, QueryFrame, RayRecord};
use rtrt_core::stage::query::{QueryWorld, closest, occluded};
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// The closest hit on each ray.
#[spirv(compute(threads(64), entry_point_name = "query_closest"))]
pub fn query_closest(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &QueryFrame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] masks: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] rays: &[RayRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] hits: &mut [Hit],
) {
    let index = index(id);
    if index < frame.rays {
        let magnitude = frame.magnitude;
        let geometry = Geometry { instances, nodes, mesh_data, positions, texels, magnitude };
        let world = QueryWorld { frame, geometry, masks };
        hits[index as usize] = closest(&world, &rays[index as usize]);
    }
}

/// Whether each ray hits anything: 1 or 0.
#[spirv(compute(threads(64), entry_point_name = "query_occluded"))]
pub fn query_occluded(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &QueryFrame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] masks: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] rays: &[RayRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] answers: &mut [u32],
) {
    let index = index(id);
    if index < frame.rays {
        let magnitude = frame.magnitude;
        let geometry = Geometry { instances, nodes, mesh_data, positions, texels, magnitude };
        let world = QueryWorld { frame, geometry, masks };
        answers[index as usize] = occluded(&world, &rays[index as usize]);
    }
}
