//! Shade: one invocation a ray.

use crate::ambient::share;
use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::layout::{Frame, Lit, MaterialRecord, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::beyond::Beyond;
use rtrt_core::stage::light::IncomingLight;
use rtrt_core::stage::peel::LayerSum;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Keeps what a ray has seen. Behind the first records of all rays of the dispatch are their second ones, and so on.
pub fn store(frame: &Frame, colors: &mut [[f32; 4]], index: u32, sum: &LayerSum<f32>) {
    let mut number = 0;
    while number < frame.records() {
        colors[(number * frame.rays + index) as usize] = sum.record(number);
        number += 1;
    }
}

/// The record of a ray with this number; zeros where frames keep none.
pub fn record(frame: &Frame, colors: &[[f32; 4]], index: u32, number: u32) -> [f32; 4] {
    if number < frame.records() { colors[(number * frame.rays + index) as usize] } else { [0.0; 4] }
}

/// What [`shade`] and [`shade_plain`] read, besides the frame.
struct Inputs<'a> {
    views: &'a [View],
    materials: &'a [MaterialRecord],
    texels: &'a [u32],
    surfaces: &'a [Surface],
    lit: &'a [Lit],
    found: &'a [[f32; 2]],
}

/// Keeps the color that a ray brings back.
#[inline(always)]
fn shade_ray(frame: &Frame, inputs: &Inputs<'_>, colors: &mut [[f32; 4]], index: u32) {
    let &Inputs { views, materials, texels, surfaces, lit, found } = inputs;
    let ray = RayIndex(frame.first_ray + index);
    let camera = &views[Frame::CAMERA as usize];
    let [direction] = stage::visibility::directions::<f32, 1>((), frame, camera, ray);
    let surface = Surfaces::new(&surfaces[index as usize]);
    let arriving = IncomingLight::new(&lit[index as usize]);
    let share = share(frame, index, surfaces, found);
    let maps = Maps { materials, texels };
    let beyond = Beyond::new(direction);
    let shaded = stage::shade::shade(frame, &maps, direction, &beyond, &surface, &arriving, share);
    if frame.has_layers() {
        store(frame, colors, index, &LayerSum::new(direction).blend(frame, &shaded));
    } else {
        colors[index as usize] = shaded.record();
    }
}

/// The color that each ray brings back.
#[spirv(compute(threads(64), entry_point_name = "shade"))]
pub fn shade(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[MaterialRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] lit: &[Lit],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] found: &[[f32; 2]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] colors: &mut [[f32; 4]],
) {
    let index = index(id);
    if index < frame.rays {
        let inputs = Inputs { views, materials, texels, surfaces, lit, found };
        shade_ray(frame, &inputs, colors, index);
    }
}

/// The same in a frame without extensions of materials: compilers leave out what they would take.
#[spirv(compute(threads(64), entry_point_name = "shade_plain"))]
pub fn shade_plain(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[MaterialRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] lit: &[Lit],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] found: &[[f32; 2]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] colors: &mut [[f32; 4]],
) {
    let index = index(id);
    if index < frame.rays {
        let inputs = Inputs { views, materials, texels, surfaces, lit, found };
        shade_ray(&Frame { extensions: 0, ..*frame }, &inputs, colors, index);
    }
}
