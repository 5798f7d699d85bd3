//! Tint: the colors of shadows, where not every object is opaque.

use crate::index;
use rtrt_core::kernel::lists::Lists;
use rtrt_core::kernel::traverse::Geometry;
use rtrt_core::lane::{V3, Word};
use rtrt_core::layout::{Frame, Node, Object, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Words of a shadow ray's start.
const START: u32 = 3;

/// Where, in the tints, a ray's word of a light is. Before all of them are the places where
/// the rays' shadow rays start: an entry point may bind eight buffers, and with those of the
/// surfaces there would be nine.
pub(crate) fn tint_at(frame: &Frame, ray: u32, light: u32) -> u32 {
    START * frame.rays + ray * frame.lights + light
}

/// Where each ray's shadow rays start, and whether they are to be asked for: one invocation a
/// ray and light.
#[spirv(compute(threads(64), entry_point_name = "ask"))]
pub fn ask(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tints: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let surface = Surfaces::new(&surfaces[index as usize]);
        tints[tint_at(frame, index, light) as usize] = stage::occlusion::ask(frame, views, light, &surface).0;
        if light == 0 {
            let start = (START * index) as usize;
            tints[start] = surface.origin.x.to_bits();
            tints[start + 1] = surface.origin.y.to_bits();
            tints[start + 2] = surface.origin.z.to_bits();
        }
    }
}

/// What is left of each light: one invocation a ray and light.
#[spirv(compute(threads(64), entry_point_name = "tint"))]
pub fn tint(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] objects: &[Object],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] words: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] tints: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let at = tint_at(frame, index, light) as usize;
        let lists = Lists { words: lists, blocks: frame.blocks };
        let geometry = Geometry { objects, nodes, words, positions, texels, magnitude: frame.magnitude };
        let start = (START * index) as usize;
        let origin = [V3 {
            x: f32::from_bits(tints[start]),
            y: f32::from_bits(tints[start + 1]),
            z: f32::from_bits(tints[start + 2]),
        }];
        let asked = [Word(tints[at])];
        let left = stage::occlusion::tint::<f32, 1>(frame, views, &lists, &geometry, light, &origin, &asked);
        tints[at] = left[0].0;
    }
}

/// The shadow masks that follow from the tints: one invocation a ray.
#[spirv(compute(threads(64), entry_point_name = "fold"))]
pub fn fold(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] tints: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] masks: &mut [u32],
) {
    let index = index(id);
    if index < frame.rays {
        let tint = |light: u32| Word(tints[tint_at(frame, index, light) as usize]);
        let mut word = 0;
        while word < frame.mask_words {
            let mask = stage::occlusion::mask(frame, word, Word(0), tint).0;
            masks[(index * frame.mask_words + word) as usize] = mask;
            word += 1;
        }
    }
}
