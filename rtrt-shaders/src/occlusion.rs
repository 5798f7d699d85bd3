//! Occlusion: one invocation a ray.

use crate::index;
use rtrt_core::kernel::lists::Lists;
use rtrt_core::kernel::traverse::Geometry;
use rtrt_core::layout::{Frame, Node, Object, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Which lights reach each surface.
#[spirv(compute(threads(64), entry_point_name = "occlusion"))]
pub fn occlusion(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] objects: &[Object],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] words: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] masks: &mut [u32],
) {
    let index = index(id);
    if index < frame.rays {
        let lists = Lists { words: lists, blocks: frame.blocks };
        let geometry = Geometry { objects, nodes, words, positions, magnitude: frame.magnitude };
        let surface = [Surfaces::new(&surfaces[index as usize])];
        let mut word = 0;
        while word < frame.mask_words {
            let mask = stage::occlusion::word(frame, views, &lists, &geometry, word, &surface);
            masks[(index * frame.mask_words + word) as usize] = mask[0].0;
            word += 1;
        }
    }
}
