//! Penumbra: the shadows of lights with a radius.

use crate::index;
use crate::transmittance::shadow_ray;
use rtrt_core::grid::{BLOCK_RAYS, RayIndex};
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::layout::{Frame, Instance, Node, ShadowBuffer, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::penumbra_blocks::{PenumbraSummary, edges_at};
use rtrt_core::stage::penumbra_filter::Band;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// The transmittance of each light, and the radii of penumbras: one invocation a ray and light.
#[spirv(compute(threads(64), entry_point_name = "blocker_search"))]
pub fn blocker_search(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] shadows: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let lists = BlockLists { data: lists, blocks: frame.blocks };
        let geometry =
            Geometry { instances, nodes, mesh_data, positions, texels, magnitude: frame.magnitude };
        let context = Context { frame, views, lists, geometry };
        shadow_ray::<true>(&context, index, light, shadows);
    }
}

/// A summary of the penumbras in each block: one invocation a block and light.
#[spirv(compute(threads(64), entry_point_name = "summarize_penumbras"))]
pub fn summarize_penumbras(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] shadows: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] edges: &mut [PenumbraSummary],
) {
    let (block, light) = (index(id), id.z);
    if block < frame.rays / BLOCK_RAYS {
        edges[edges_at(frame, block, light)] = stage::penumbra_blocks::edges(frame, shadows, block, light);
    }
}

/// Whether the shadows of each block are filtered: one invocation a block and light.
#[spirv(compute(threads(64), entry_point_name = "select_filter_blocks"))]
pub fn select_filter_blocks(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] edges: &[PenumbraSummary],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] soft: &mut [u32],
) {
    let (block, light) = (index(id), id.z);
    if block < frame.rays / BLOCK_RAYS {
        soft[edges_at(frame, block, light)] = stage::penumbra_blocks::are_soft(frame, edges, block, light);
    }
}

/// The transmittance of each light, filtered as far as penumbras reach: one invocation a ray and light.
#[spirv(compute(threads(64), entry_point_name = "filter_penumbra"))]
pub fn filter_penumbra(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] shadows: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] soft: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] transmittance: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let at = ShadowBuffer::new(frame).transmittance(index, light);
        if soft[edges_at(frame, index / BLOCK_RAYS, light)] == 0 {
            transmittance[at] = shadows[at];
        } else {
            let ray = frame.grid().ray(RayIndex(frame.first_ray + index));
            let band = Band { frame, surfaces, shadows, light, at: ray };
            transmittance[at] =
                stage::penumbra_filter::filter_penumbra::<f32, Band<'_>>(frame, views, &band, light).0;
        }
    }
}
