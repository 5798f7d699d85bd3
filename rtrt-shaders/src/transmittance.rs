//! Tint: the colors of shadows, where not every instance is opaque.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::kernel::traverse::Geometry;
use rtrt_core::lane::{V3, Word};
use rtrt_core::layout::{Frame, Instance, Node, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::blocker_search::transmittance_at;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Where, in the transmittance (or, where lights have a radius, in the shadows), the place is where a
/// ray's shadow rays start. It is behind all else: an entry point may bind eight buffers, and
/// with those of the surfaces there would be nine.
pub(crate) fn start_at(frame: &Frame, ray: u32) -> usize {
    let mesh_data = if frame.penumbra_window == 0 { frame.lights } else { 2 * frame.lights };
    (frame.rays * mesh_data + 3 * ray) as usize
}

/// Where each ray's shadow rays start, and whether they are to be asked for: one invocation a
/// ray and light.
#[spirv(compute(threads(64), entry_point_name = "potentially_lit"))]
pub fn potentially_lit(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] transmittance: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let surface = Surfaces::new(&surfaces[index as usize]);
        let ray = RayIndex(frame.first_ray + index);
        let asked = stage::occlusion::potentially_lit(frame, views, light, ray, &surface).0;
        transmittance[transmittance_at(frame, index, light)] = asked;
        if light == 0 {
            let start = start_at(frame, index);
            transmittance[start] = surface.origin.x.to_bits();
            transmittance[start + 1] = surface.origin.y.to_bits();
            transmittance[start + 2] = surface.origin.z.to_bits();
        }
    }
}

/// What is left of each light: one invocation a ray and light.
#[spirv(compute(threads(64), entry_point_name = "transmittance"))]
pub fn transmittance(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] transmittance: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let at = transmittance_at(frame, index, light);
        let lists = BlockLists { data: lists, blocks: frame.blocks };
        let geometry =
            Geometry { instances, nodes, mesh_data, positions, texels, magnitude: frame.magnitude };
        let start = start_at(frame, index);
        let origin = [V3 {
            x: f32::from_bits(transmittance[start]),
            y: f32::from_bits(transmittance[start + 1]),
            z: f32::from_bits(transmittance[start + 2]),
        }];
        let asked = [Word(transmittance[at])];
        let ray = RayIndex(frame.first_ray + index);
        let left = stage::occlusion::transmittance::<f32, 1>(
            frame, views, &lists, &geometry, light, ray, &origin, &asked,
        );
        transmittance[at] = left[0].0;
    }
}

/// The shadow masks that follow from the transmittance: one invocation a ray.
#[spirv(compute(threads(64), entry_point_name = "mask"))]
pub fn mask(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] transmittance: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] masks: &mut [u32],
) {
    let index = index(id);
    if index < frame.rays {
        let tint = |light: u32| Word(transmittance[transmittance_at(frame, index, light)]);
        let mut word = 0;
        while word < frame.mask_words {
            let mask = stage::occlusion::mask(frame, word, Word(0), tint).0;
            masks[(index * frame.mask_words + word) as usize] = mask;
            word += 1;
        }
    }
}
