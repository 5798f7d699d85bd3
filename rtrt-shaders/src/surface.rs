//! Surface: one invocation a ray.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::layout::{Attribute, Frame, Hit, Instance, Node, Surface, View};
use rtrt_core::stage;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// What is known about each ray's hit.
#[spirv(compute(threads(64), entry_point_name = "surface"))]
pub fn surface(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] hits: &[Hit],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] attributes: &[Attribute],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] surfaces: &mut [Surface],
) {
    let index = index(id);
    if index < frame.rays {
        let geometry = Geometry {
            instances,
            nodes,
            mesh_data,
            positions,
            texels: mesh_data,
            magnitude: frame.magnitude,
        };
        let ray = RayIndex(frame.first_ray + index);
        let camera = &views[Frame::CAMERA as usize];
        let [direction] = stage::visibility::directions::<f32, 1>((), frame, camera, ray);
        let best = ClosestHit::new(&hits[index as usize]);
        let found = stage::surface::surface(camera, &geometry, attributes, direction, &best);
        surfaces[index as usize] = found.lane(0);
    }
}
