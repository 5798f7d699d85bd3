//! Layers: one invocation a ray.

use crate::ambient::share;
use crate::index;
use crate::shade::{record, store};
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::layout::{Frame, Hit, Instance, Lit, MaterialRecord, Node, Surface, View};
use rtrt_core::stage;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::light::IncomingLight;
use rtrt_core::stage::peel::LayerSum;
use rtrt_core::stage::raster::is_untraced;
use rtrt_core::stage::surface::Surfaces;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Makes the rays that nothing shines through any more look for nothing.
#[spirv(compute(threads(64), entry_point_name = "end_covered"))]
pub fn end_covered(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] colors: &[[f32; 4]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] hits: &mut [Hit],
) {
    let index = index(id);
    if index < frame.rays && stage::peel::is_covered(colors[index as usize][3]) {
        hits[index as usize] = Hit::MISS;
    }
}

/// The closest surface behind the last one; the closest of all where the hits are zero, and only
/// there if surfaces were drawn.
#[spirv(compute(threads(64), entry_point_name = "peel"))]
pub fn peel(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] lists: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] mesh_data: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] positions: &[[f32; 3]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] hits: &mut [Hit],
) {
    let index = index(id);
    if index < frame.rays && (frame.is_drawn == 0 || is_untraced(&hits[index as usize])) {
        let lists = BlockLists { data: lists, blocks: frame.blocks };
        let geometry =
            Geometry { instances, nodes, mesh_data, positions, texels, magnitude: frame.magnitude };
        let context = Context { frame, views, lists, geometry };
        let ray = RayIndex(frame.first_ray + index);
        let last = [ClosestHit::new(&hits[index as usize])];
        let found = stage::peel::peel::<f32, 1>((), &context, ray, &last);
        hits[index as usize] = stage::visibility::hit(&found[0], 0);
    }
}

/// Adds the color of the layer to that of the layers before it.
#[spirv(compute(threads(64), entry_point_name = "blend"))]
pub fn blend(
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
    if index < frame.rays && !stage::peel::is_covered(colors[index as usize][3]) {
        let ray = RayIndex(frame.first_ray + index);
        let camera = &views[Frame::CAMERA as usize];
        let [direction] = stage::visibility::directions::<f32, 1>((), frame, camera, ray);
        let surface = Surfaces::new(&surfaces[index as usize]);
        let arriving = IncomingLight::new(&lit[index as usize]);
        let share = share(frame, index, surfaces, found);
        let records = [
            record(frame, colors, index, 0),
            record(frame, colors, index, 1),
            record(frame, colors, index, 2),
            record(frame, colors, index, 3),
        ];
        let before = LayerSum::load(frame, direction, records);
        let (maps, beyond) = (Maps { materials, texels }, before.beyond);
        let shaded = stage::shade::shade(frame, &maps, direction, &beyond, &surface, &arriving, share);
        store(frame, colors, index, &before.blend(frame, &shaded));
    }
}
