//! Ambient: one invocation a ray.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::layout::{Frame, Instance, Node, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::ambient::record;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// What each ray finds of the light from all around.
#[spirv(compute(threads(64), entry_point_name = "ambient"))]
pub fn ambient(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] found: &mut [[f32; 2]],
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
        let surface = [Surfaces::new(&surfaces[index as usize])];
        let ray = RayIndex(frame.first_ray + index);
        found[index as usize] = stage::ambient::ambient::<f32, 1>(&context, ray, &surface)[0];
    }
}

/// The share of the light from all around that reaches the surface of a ray of the dispatch.
pub fn share(frame: &Frame, index: u32, surfaces: &[Surface], found: &[[f32; 2]]) -> f32 {
    let record = |ray: u32| record(found[ray as usize], &surfaces[ray as usize]);
    stage::ambient::share::<f32>((), frame, index, record)
}
