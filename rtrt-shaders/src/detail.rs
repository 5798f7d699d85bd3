//! Detail: one invocation a ray.

use crate::index;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::layout::{Attribute, Frame, Hit, Instance, MaterialRecord, Surface};
use rtrt_core::stage;
use rtrt_core::stage::surface::{Surfaces, Vertices};
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Adds normal maps, second texture coordinates, coats' normals and tangents to each surface.
#[spirv(compute(threads(64), entry_point_name = "detail"))]
pub fn detail(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] hits: &[Hit],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] attributes: &[Attribute],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] materials: &[MaterialRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] surfaces: &mut [Surface],
) {
    let index = index(id);
    if index < frame.rays {
        let maps = Maps { materials, texels };
        let vertices = Vertices { instances, mesh_data, attributes };
        let best = ClosestHit::new(&hits[index as usize]);
        let surface = Surfaces::new(&surfaces[index as usize]);
        let found = stage::detail::detail(frame, &maps, &vertices, &best, &surface);
        surfaces[index as usize] = found.lane(0);
    }
}
