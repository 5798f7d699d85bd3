//! Light: one invocation a ray.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::lane::Word;
use rtrt_core::layout::{Frame, Lit, MaterialRecord, ShadowBuffer, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::light::ShadowTerms;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// What [`light`] and [`light_plain`] read, besides the frame.
struct Inputs<'a> {
    views: &'a [View],
    materials: &'a [MaterialRecord],
    texels: &'a [u32],
    surfaces: &'a [Surface],
    masks: &'a [u32],
    transmittance: &'a [u32],
}

/// The light that arrives at the surface of a ray.
#[inline(always)]
fn light_ray(frame: &Frame, inputs: &Inputs<'_>, index: u32) -> Lit {
    let &Inputs { views, materials, texels, surfaces, masks, transmittance } = inputs;
    let ray = RayIndex(frame.first_ray + index);
    let camera = &views[Frame::CAMERA as usize];
    let [direction] = stage::visibility::directions::<f32, 1>((), frame, camera, ray);
    let surface = Surfaces::new(&surfaces[index as usize]);
    let mask = |word: u32| Word(masks[(index * frame.mask_words + word) as usize]);
    let buffer = ShadowBuffer::new(frame);
    let transmittance = |light: u32| Word(transmittance[buffer.transmittance(index, light)]);
    let shadows = ShadowTerms::new(mask, transmittance);
    let maps = Maps { materials, texels };
    stage::light::light(frame, views, &maps, &shadows, ray, direction, &surface).lane(0)
}

/// The light that arrives at each surface.
#[spirv(compute(threads(64), entry_point_name = "light"))]
pub fn light(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[MaterialRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] masks: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] transmittance: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] lit: &mut [Lit],
) {
    let index = index(id);
    if index < frame.rays {
        let inputs = Inputs { views, materials, texels, surfaces, masks, transmittance };
        lit[index as usize] = light_ray(frame, &inputs, index);
    }
}

/// The same in a frame without extensions of materials: compilers leave out what they would take.
#[spirv(compute(threads(64), entry_point_name = "light_plain"))]
pub fn light_plain(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[MaterialRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] masks: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] transmittance: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] lit: &mut [Lit],
) {
    let index = index(id);
    if index < frame.rays {
        let inputs = Inputs { views, materials, texels, surfaces, masks, transmittance };
        lit[index as usize] = light_ray(&Frame { extensions: 0, ..*frame }, &inputs, index);
    }
}
