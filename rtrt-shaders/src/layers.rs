//! Layers: one invocation a ray.

use crate::index;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::lists::Lists;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::kernel::traverse::{Best, Geometry};
use rtrt_core::layout::{Frame, Hit, Lit, Material, Node, Object, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::light::Arriving;
use rtrt_core::stage::raster::is_untraced;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Makes the rays that nothing shines through any more look for nothing.
#[spirv(compute(threads(64), entry_point_name = "end"))]
pub fn end(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] colors: &[[f32; 4]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] hits: &mut [Hit],
) {
    let index = index(id);
    if index < frame.rays && stage::layers::is_covered(colors[index as usize][3]) {
        hits[index as usize] = Hit::MISS;
    }
}

/// The closest surface behind the last one; the closest of all where the hits are zero, and only
/// there if surfaces were drawn.
#[spirv(compute(threads(64), entry_point_name = "layer"))]
pub fn layer(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] objects: &[Object],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] words: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] hits: &mut [Hit],
) {
    let index = index(id);
    if index < frame.rays && (frame.is_drawn == 0 || is_untraced(&hits[index as usize])) {
        let lists = Lists { words: lists, blocks: frame.blocks };
        let geometry = Geometry { objects, nodes, words, positions, texels, magnitude: frame.magnitude };
        let ray = RayIndex(frame.first_ray + index);
        let last = [Best::new(&hits[index as usize])];
        let found = stage::layers::layer::<f32, 1>((), frame, views, &lists, &geometry, ray, &last);
        hits[index as usize] = stage::visibility::hit(&found[0], 0);
    }
}

/// Adds the color of the layer to that of the layers before it.
#[spirv(compute(threads(64), entry_point_name = "blend"))]
pub fn blend(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] lit: &[Lit],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] colors: &mut [[f32; 4]],
) {
    let index = index(id);
    if index < frame.rays && !stage::layers::is_covered(colors[index as usize][3]) {
        let ray = RayIndex(frame.first_ray + index);
        let camera = &views[Frame::CAMERA as usize];
        let [direction] = stage::visibility::directions::<f32, 1>((), frame, camera, ray);
        let surface = Surfaces::new(&surfaces[index as usize]);
        let arriving = Arriving::new(&lit[index as usize]);
        let shaded = stage::shade::shade(frame, &Maps { materials, texels }, direction, &surface, &arriving);
        colors[index as usize] = stage::layers::blend(frame, colors[index as usize], shaded);
    }
}
