//! Penumbra: the shadows of lights with a radius.

use crate::index;
use crate::tint::start_at;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::lists::Lists;
use rtrt_core::kernel::traverse::Geometry;
use rtrt_core::lane::{V3, Word};
use rtrt_core::layout::{Frame, Node, Object, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::penumbra::{left_at, size_at};
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// What is left of each light, and how wide the penumbras are: one invocation a ray and light.
#[spirv(compute(threads(64), entry_point_name = "near"))]
pub fn near(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] objects: &[Object],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] words: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] shadows: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let at = left_at(frame, index, light);
        let lists = Lists { words: lists, blocks: frame.blocks };
        let geometry = Geometry { objects, nodes, words, positions, texels, magnitude: frame.magnitude };
        let start = start_at(frame, index);
        let origin = [V3 {
            x: f32::from_bits(shadows[start]),
            y: f32::from_bits(shadows[start + 1]),
            z: f32::from_bits(shadows[start + 2]),
        }];
        let asked = [Word(shadows[at])];
        let ray = RayIndex(frame.first_ray + index);
        let found =
            stage::penumbra::near::<f32, 1>(frame, views, &lists, &geometry, light, ray, &origin, &asked);
        let (left, size) = found[0];
        shadows[at] = left.0;
        shadows[size_at(frame, index, light)] = size.to_bits();
    }
}

/// The same, blurred as far as the penumbras reach: one invocation a ray and light.
#[spirv(compute(threads(64), entry_point_name = "soften"))]
pub fn soften(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] shadows: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] tints: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let left = stage::penumbra::soften(frame, views, surfaces, shadows, index, light);
        tints[left_at(frame, index, light)] = left;
    }
}
