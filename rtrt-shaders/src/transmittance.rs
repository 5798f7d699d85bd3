//! Shadow rays in frames whose shadows are not bits.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::lane::{V3, Word};
use rtrt_core::layout::{Frame, Instance, Node, ShadowBuffer, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Where each ray's shadow rays start, and whether they are to be traced: one invocation a ray and light.
#[spirv(compute(threads(64), entry_point_name = "potentially_lit"))]
pub fn potentially_lit(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] shadows: &mut [u32],
) {
    let (index, light) = (index(id), id.z);
    if index < frame.rays {
        let surface = Surfaces::new(&surfaces[index as usize]);
        let ray = RayIndex(frame.first_ray + index);
        let buffer = ShadowBuffer::new(frame);
        let active = stage::occlusion::potentially_lit(frame, views, light, ray, &surface).0;
        shadows[buffer.transmittance(index, light)] = active;
        if light == 0 {
            let origin = buffer.origin(index);
            shadows[origin] = surface.origin.x.to_bits();
            shadows[origin + 1] = surface.origin.y.to_bits();
            shadows[origin + 2] = surface.origin.z.to_bits();
        }
    }
}

/// The transmittance of each light: one invocation a ray and light.
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
        let lists = BlockLists { data: lists, blocks: frame.blocks };
        let geometry =
            Geometry { instances, nodes, mesh_data, positions, texels, magnitude: frame.magnitude };
        let context = Context { frame, views, lists, geometry };
        shadow_ray::<false>(&context, index, light, transmittance);
    }
}

/// Traces the shadow ray of a ray and light, if it is to be, and stores what arrives in the shadow buffer;
/// the radius of the penumbra only with `BLOCKER`.
pub(crate) fn shadow_ray<const BLOCKER: bool>(
    context: &Context<'_>,
    index: u32,
    light: u32,
    shadows: &mut [u32],
) {
    let buffer = ShadowBuffer::new(context.frame);
    let (at, origin) = (buffer.transmittance(index, light), buffer.origin(index));
    let origins = [V3 {
        x: f32::from_bits(shadows[origin]),
        y: f32::from_bits(shadows[origin + 1]),
        z: f32::from_bits(shadows[origin + 2]),
    }];
    let active = [Word(shadows[at])];
    let ray = RayIndex(context.frame.first_ray + index);
    let [arrival] =
        stage::occlusion::transmittance::<f32, BLOCKER, 1>(context, light, ray, &origins, &active);
    shadows[at] = arrival.transmittance.0;
    if BLOCKER {
        shadows[buffer.penumbra_radius(index, light)] = arrival.penumbra_radius.to_bits();
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
        let buffer = ShadowBuffer::new(frame);
        let transmittance = |light: u32| Word(transmittance[buffer.transmittance(index, light)]);
        let mut word = 0;
        while word < frame.mask_words {
            let mask = stage::occlusion::mask(frame, word, Word(0), transmittance).0;
            masks[(index * frame.mask_words + word) as usize] = mask;
            word += 1;
        }
    }
}
