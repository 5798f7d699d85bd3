//! Occlusion: one invocation a ray and light.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::layout::{Frame, Instance, Node, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::arch::atomic_or;
use spirv_std::glam::UVec3;
use spirv_std::memory::{Scope, Semantics};
use spirv_std::spirv;

/// Which lights reach each surface: every layer of invocations asks for one light, and sets
/// its bit in the masks, which were zero.
#[spirv(compute(threads(64), entry_point_name = "occlusion"))]
pub fn occlusion(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] masks: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
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
        let surface = [Surfaces::new(&surfaces[index as usize])];
        let lit = stage::occlusion::occlusion(&context, light, ray, &surface);
        if lit[0].0 == 1 {
            let (word, bit) = stage::occlusion::place(frame, index, light);
            // SAFETY: the word is in a storage buffer, and every access to it during the
            // dispatch is this one.
            unsafe {
                atomic_or::<u32, { Scope::Device as u32 }, { Semantics::NONE.bits() }>(
                    &mut masks[word as usize],
                    1 << bit,
                );
            }
        }
    }
}
