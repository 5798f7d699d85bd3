//! Penumbra: the shadows of lights with a radius.

use crate::index;
use crate::tint::start_at;
use rtrt_core::grid::{BLOCK_RAYS, RayIndex};
use rtrt_core::kernel::lists::Lists;
use rtrt_core::kernel::traverse::Geometry;
use rtrt_core::lane::{V3, Word};
use rtrt_core::layout::{Frame, Node, Object, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::edges::{Edges, edges_at};
use rtrt_core::stage::penumbra::{left_at, size_at};
use rtrt_core::stage::soften::Band;
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

/// What the shadows of each block have in common: one invocation a block and light.
#[spirv(compute(threads(64), entry_point_name = "edges"))]
pub fn edges(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] shadows: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] edges: &mut [Edges],
) {
    let (block, light) = (index(id), id.z);
    if block < frame.rays / BLOCK_RAYS {
        edges[edges_at(frame, block, light)] = stage::edges::edges(frame, shadows, block, light);
    }
}

/// Whether the shadows of each block are blurred: one invocation a block and light.
#[spirv(compute(threads(64), entry_point_name = "choose"))]
pub fn choose(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] edges: &[Edges],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] soft: &mut [u32],
) {
    let (block, light) = (index(id), id.z);
    if block < frame.rays / BLOCK_RAYS {
        soft[edges_at(frame, block, light)] = stage::edges::are_soft(frame, edges, block, light);
    }
}

/// What is left of each light, blurred as far as the penumbras reach: one invocation a ray and light.
#[spirv(compute(threads(64), entry_point_name = "soften"))]
pub fn soften(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] shadows: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] soft: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] tints: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let at = left_at(frame, index, light);
        if soft[edges_at(frame, index / BLOCK_RAYS, light)] == 0 {
            tints[at] = shadows[at];
        } else {
            let ray = frame.grid().ray(RayIndex(frame.first_ray + index));
            let band = Band { frame, surfaces, shadows, light, at: ray };
            tints[at] = stage::soften::soften::<f32, Band<'_>>(frame, views, &band, light).0;
        }
    }
}
