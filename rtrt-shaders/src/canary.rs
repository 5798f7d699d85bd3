//! The canary: kernels and layouts that a device computes before it is trusted.

use crate::index;
use rtrt_core::kernel::canary::{Given, OUTPUTS, canary};
use rtrt_core::kernel::texture::Maps;
use rtrt_core::lane::groups;
use rtrt_core::layout::{Attribute, Frame, Hit, Instance, MaterialRecord, Node, Surface, View, probe};
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// The kernels' answers to arrays of words, as many an invocation as
/// [`rtrt_core::kernel::canary::NAMES`] has names.
#[spirv(compute(threads(64), entry_point_name = "kernels"))]
pub fn kernels(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] words: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] materials: &[MaterialRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] texels: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] answers: &mut [[u32; OUTPUTS]],
) {
    let index = index(id);
    if (index as usize) < answers.len() {
        let given = Given { frame, views, instances, maps: Maps { materials, texels } };
        let found = canary::<f32>((), words, &given, index);
        answers[index as usize] = groups(
            #[inline(always)]
            |i| found[i].0,
        );
    }
}

/// Where this device finds the fields of what both sides read.
#[spirv(compute(threads(1), entry_point_name = "probe_layout"))]
pub fn probe_layout(
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] views: &[View],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] nodes: &[Node],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] attributes: &[Attribute],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] materials: &[MaterialRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] surfaces: &[Surface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] hits: &[Hit],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] answers: &mut [u32],
) {
    let found = probe(frame, views, instances, nodes, attributes, materials, surfaces, hits);
    let mut i = 0;
    while i < found.len() {
        answers[i] = found[i];
        i += 1;
    }
}
