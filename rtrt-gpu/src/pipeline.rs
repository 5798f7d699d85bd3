//! What a frame dispatches, as a table, and the pipelines made from it.

use crate::barriers::ZERO_GROUP;
use crate::buffers::Slot;
use crate::device::Zero;
use rtrt_core::grid::{BLOCK_RAYS, RayIndex};
use rtrt_core::layout::Frame;
use rtrt_core::stage;
use rtrt_shaders::{GROUP, ROW, SHARES};

/// How an entry point uses a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    Uniform,
    Read,
    Write,
}

/// One dispatch of a frame.
pub(crate) struct Pass {
    /// Which of [`rtrt_core::backend::STAGES`] it belongs to.
    pub stage: usize,
    /// The entry point.
    pub entry: &'static str,
    /// Buffers read, bound from 0 on: the frame first.
    pub reads: &'static [Slot],
    /// Buffers written, bound after those.
    pub writes: &'static [Slot],
    /// How many invocations it takes.
    pub work: fn(&Frame) -> Work,
}

/// What finds the closest surfaces where they were drawn, in place of the stage's own passes.
#[rustfmt::skip]
pub(crate) const DRAWN: &[Pass] = {
    use Slot::*;
    &[
        Pass { stage: FIRST_OF_BAND, entry: "pick", reads: &[Frame, Views, Instances, MeshData, Positions, Drawn], writes: &[Hits], work: rays },
        Pass { stage: FIRST_OF_BAND, entry: "peel", reads: LAYER, writes: &[Hits], work: rays },
    ]
};

/// Invocations of a dispatch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Work {
    /// How many a layer has.
    pub invocations: u32,
    /// How many layers there are.
    pub layers: u32,
}

impl From<u32> for Work {
    /// One layer.
    fn from(invocations: u32) -> Self {
        Self { invocations, layers: 1 }
    }
}

/// Stages whose dispatches add to a buffer that has to be zero when they begin.
/// Hits of zero tell `layer` that nothing has been looked for yet.
pub(crate) const ZEROED: [(usize, Slot); 3] = [(1, Slot::Counts), (2, Slot::Hits), (5, Slot::Masks)];

impl Pass {
    /// The buffers in the order of their bindings.
    pub fn slots(&self) -> impl Iterator<Item = Slot> {
        self.reads.iter().chain(self.writes).copied()
    }
    /// How each is used.
    pub fn accesses(&self) -> impl Iterator<Item = Access> {
        let read = |slot: &Slot| if *slot == Slot::Frame { Access::Uniform } else { Access::Read };
        self.reads.iter().map(read).chain(self.writes.iter().map(|_| Access::Write))
    }
}

/// The first stage that works on rays, and is repeated for each band of them.
pub(crate) const FIRST_OF_BAND: usize = 2;

/// The stage that is repeated for every layer of surfaces behind the first.
pub(crate) const LAYERS: usize = 8;

/// What entry points read that are in the table twice.
const LAYER: &[Slot] = &[
    Slot::Frame,
    Slot::Views,
    Slot::BlockLists,
    Slot::Instances,
    Slot::Nodes,
    Slot::MeshData,
    Slot::Positions,
    Slot::Texels,
];
const TINT: &[Slot] = LAYER;
const SURFACE: &[Slot] = &[
    Slot::Frame,
    Slot::Views,
    Slot::Hits,
    Slot::Instances,
    Slot::Nodes,
    Slot::MeshData,
    Slot::Positions,
    Slot::Attributes,
];
const DETAIL: &[Slot] = &[
    Slot::Frame,
    Slot::Hits,
    Slot::Instances,
    Slot::MeshData,
    Slot::Attributes,
    Slot::Materials,
    Slot::Texels,
];
const LIGHT: &[Slot] = &[
    Slot::Frame,
    Slot::Views,
    Slot::Materials,
    Slot::Texels,
    Slot::Surfaces,
    Slot::Masks,
    Slot::Transmittance,
];

/// A frame, in order.
#[rustfmt::skip]
pub(crate) const PASSES: &[Pass] = {
    use Slot::*;
    &[
        Pass { stage: 0, entry: "prepare", reads: &[Frame, Views, Instances], writes: &[ScreenBounds], work: screen_bounds },
        Pass { stage: 1, entry: "count", reads: &[Frame, Views, Instances, ScreenBounds], writes: &[Counts], work: shares },
        Pass { stage: 1, entry: "scan", reads: &[Frame], writes: &[Counts, BlockLists], work: one_group },
        Pass { stage: 1, entry: "scatter", reads: &[Frame, Views, Instances, ScreenBounds, BlockLists], writes: &[Counts, Placed], work: shares },
        Pass { stage: 1, entry: "rank", reads: &[Frame, Placed], writes: &[BlockLists], work: entries },
        Pass { stage: 2, entry: "visibility", reads: &[Frame, Views, BlockLists, Instances, Nodes, MeshData, Positions], writes: &[Hits], work: opaque },
        Pass { stage: 2, entry: "peel", reads: LAYER, writes: &[Hits], work: see_through },
        Pass { stage: 3, entry: "surface", reads: SURFACE, writes: &[Surfaces], work: rays },
        Pass { stage: 4, entry: "detail", reads: DETAIL, writes: &[Surfaces], work: details },
        Pass { stage: 5, entry: "occlusion", reads: &[Frame, Views, BlockLists, Instances, Nodes, MeshData, Positions, Surfaces], writes: &[Masks], work: lights },
        Pass { stage: 5, entry: "potentially_lit", reads: &[Frame, Views, Surfaces], writes: &[Transmittance], work: colored_lights },
        Pass { stage: 5, entry: "transmittance", reads: TINT, writes: &[Transmittance], work: colored_lights },
        Pass { stage: 5, entry: "potentially_lit", reads: &[Frame, Views, Surfaces], writes: &[Shadows], work: soft_lights },
        Pass { stage: 5, entry: "blocker_search", reads: TINT, writes: &[Shadows], work: soft_lights },
        Pass { stage: 5, entry: "summarize_penumbras", reads: &[Frame, Shadows], writes: &[PenumbraSummary], work: soft_blocks },
        Pass { stage: 5, entry: "select_filter_blocks", reads: &[Frame, PenumbraSummary], writes: &[Soft], work: soft_blocks },
        Pass { stage: 5, entry: "filter_penumbra", reads: &[Frame, Views, Surfaces, Shadows, Soft], writes: &[Transmittance], work: soft_lights },
        Pass { stage: 5, entry: "mask", reads: &[Frame, Transmittance], writes: &[Masks], work: tinted },
        Pass { stage: 6, entry: "light", reads: LIGHT, writes: &[Lit], work: rays },
        Pass { stage: 7, entry: "shade", reads: &[Frame, Views, Materials, Texels, Surfaces, Lit], writes: &[Colors], work: rays },
        Pass { stage: LAYERS, entry: "end_covered", reads: &[Frame, Colors], writes: &[Hits], work: rays },
        Pass { stage: LAYERS, entry: "peel", reads: LAYER, writes: &[Hits], work: rays },
        Pass { stage: LAYERS, entry: "surface", reads: SURFACE, writes: &[Surfaces], work: rays },
        Pass { stage: LAYERS, entry: "detail", reads: DETAIL, writes: &[Surfaces], work: details },
        Pass { stage: LAYERS, entry: "potentially_lit", reads: &[Frame, Views, Surfaces], writes: &[Transmittance], work: colored_lights },
        Pass { stage: LAYERS, entry: "transmittance", reads: TINT, writes: &[Transmittance], work: colored_lights },
        Pass { stage: LAYERS, entry: "potentially_lit", reads: &[Frame, Views, Surfaces], writes: &[Shadows], work: soft_lights },
        Pass { stage: LAYERS, entry: "blocker_search", reads: TINT, writes: &[Shadows], work: soft_lights },
        Pass { stage: LAYERS, entry: "summarize_penumbras", reads: &[Frame, Shadows], writes: &[PenumbraSummary], work: soft_blocks },
        Pass { stage: LAYERS, entry: "select_filter_blocks", reads: &[Frame, PenumbraSummary], writes: &[Soft], work: soft_blocks },
        Pass { stage: LAYERS, entry: "filter_penumbra", reads: &[Frame, Views, Surfaces, Shadows, Soft], writes: &[Transmittance], work: soft_lights },
        Pass { stage: LAYERS, entry: "light", reads: LIGHT, writes: &[Lit], work: rays },
        Pass { stage: LAYERS, entry: "blend", reads: &[Frame, Views, Materials, Texels, Surfaces, Lit], writes: &[Colors], work: rays },
        Pass { stage: 9, entry: "resolve", reads: &[Frame, Colors], writes: &[Pixels], work: pixels },
    ]
};

fn screen_bounds(frame: &Frame) -> Work {
    stage::prepare::count(frame).into()
}
fn shares(frame: &Frame) -> Work {
    (SHARES * stage::prepare::count(frame)).into()
}
fn one_group(_: &Frame) -> Work {
    1.into()
}
/// Only the device knows how many entries there are; those beyond do nothing.
fn entries(frame: &Frame) -> Work {
    frame.capacity.into()
}
fn rays(frame: &Frame) -> Work {
    frame.rays.into()
}
fn details(frame: &Frame) -> Work {
    (frame.rays * frame.details).into()
}
/// The rays of a frame in which every instance is opaque.
fn opaque(frame: &Frame) -> Work {
    (if frame.layers == 0 { frame.rays } else { 0 }).into()
}
/// The rays of a frame in which not every instance is.
fn see_through(frame: &Frame) -> Work {
    (if frame.layers == 0 { 0 } else { frame.rays }).into()
}
/// The rays of a frame whose shadows are not bits.
fn tinted(frame: &Frame) -> Work {
    (if frame.has_transmittance() { frame.rays } else { 0 }).into()
}
/// The rays and lights of a frame in which not every instance is opaque, and shadows are hard.
fn colored_lights(frame: &Frame) -> Work {
    let work = if frame.penumbra_window == 0 { see_through(frame) } else { 0.into() };
    Work { layers: frame.lights, ..work }
}
/// The rays and lights of a frame with soft shadows.
fn soft_lights(frame: &Frame) -> Work {
    Work { invocations: if frame.penumbra_window == 0 { 0 } else { frame.rays }, layers: frame.lights }
}
/// The blocks and lights of such a frame.
fn soft_blocks(frame: &Frame) -> Work {
    let rays = soft_lights(frame);
    Work { invocations: rays.invocations / BLOCK_RAYS, ..rays }
}
/// A layer a light: an invocation that asked for all of them would take more loop turns than
/// some devices allow.
fn lights(frame: &Frame) -> Work {
    Work { invocations: if frame.has_transmittance() { 0 } else { frame.rays }, layers: frame.lights }
}
fn pixels(frame: &Frame) -> Work {
    frame.grid().pixels(RayIndex(frame.first_ray), frame.rays)[1].into()
}

/// Workgroups in x, y and z for this work.
pub(crate) fn groups(Work { invocations, layers }: Work) -> [u32; 3] {
    [invocations.min(ROW).div_ceil(GROUP), invocations.div_ceil(ROW), layers]
}

/// A compiled entry point.
#[derive(Clone)]
pub(crate) struct Pipeline {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    zero: Option<wgpu::BindGroup>,
}

impl Pipeline {
    /// Compiles the entry point; its buffers are bound from 0 on. `zero` is what the module's barriers read, if it
    /// has any.
    pub fn new(
        device: &wgpu::Device,
        module: &wgpu::ShaderModule,
        entry: &str,
        accesses: impl Iterator<Item = Access>,
        zero: Option<&Zero>,
    ) -> Self {
        let layout = bind_group_layout(device, entry, wgpu::ShaderStages::COMPUTE, accesses);
        let pipeline_layout = pipeline_layout(device, entry, &layout, zero);
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&pipeline_layout),
            module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { pipeline, layout, zero: zero.map(|zero| zero.group.clone()) }
    }

    /// What binds these buffers, from 0 on.
    pub fn group<'a>(
        &self,
        device: &wgpu::Device,
        buffers: impl Iterator<Item = &'a wgpu::Buffer>,
    ) -> wgpu::BindGroup {
        bind_group(device, &self.layout, buffers.map(wgpu::Buffer::as_entire_binding))
    }

    /// Dispatches it with what [`Pipeline::group`] has made.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, group: &wgpu::BindGroup, [x, y, z]: [u32; 3]) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        if let Some(zero) = &self.zero {
            pass.set_bind_group(ZERO_GROUP, zero, &[]);
        }
        pass.dispatch_workgroups(x, y, z);
    }
}

/// The layout of a pipeline with a group of buffers, and the zero of the module's barriers if it has any.
pub(crate) fn pipeline_layout(
    device: &wgpu::Device,
    label: &str,
    group: &wgpu::BindGroupLayout,
    zero: Option<&Zero>,
) -> wgpu::PipelineLayout {
    let layouts: Vec<_> = [Some(group)].into_iter().chain(zero.map(|zero| Some(&zero.layout))).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &layouts,
        immediate_size: 0,
    })
}

/// A group of buffers, bound from 0 on.
pub(crate) fn bind_group<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: impl Iterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// The layout of a group of buffers, bound from 0 on.
pub(crate) fn bind_group_layout(
    device: &wgpu::Device,
    label: &str,
    visibility: wgpu::ShaderStages,
    accesses: impl Iterator<Item = Access>,
) -> wgpu::BindGroupLayout {
    let binding = |(binding, access): (usize, Access)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty: match access {
                Access::Uniform => wgpu::BufferBindingType::Uniform,
                Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
                Access::Write => wgpu::BufferBindingType::Storage { read_only: false },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<_> = accesses.enumerate().map(binding).collect();
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canary::{KERNELS, LAYOUT};
    use crate::raster;
    use rtrt_core::backend::STAGES;
    use rtrt_shaders::reflect::{BindingKind, entry_points};

    #[test]
    fn the_module_has_the_entry_points_of_the_table_with_their_bindings() {
        let mut expected: Vec<(&str, Vec<Access>)> =
            PASSES.iter().chain(DRAWN).map(|pass| (pass.entry, pass.accesses().collect())).collect();
        expected.sort_unstable_by_key(|(name, _)| *name);
        expected.dedup();
        expected.extend([("kernels", KERNELS.to_vec()), ("probe_layout", LAYOUT.to_vec())]);
        expected.extend([(raster::VERTEX, raster::accesses().collect()), (raster::FRAGMENT, vec![])]);
        let found = entry_points(rtrt_shaders::SPIRV).unwrap();
        assert_eq!(found.len(), expected.len());
        for (name, accesses) in expected {
            let entry = found.iter().find(|entry| entry.name == name).unwrap();
            let group = match name {
                "scan" => Some(256),
                "probe_layout" => Some(1),
                raster::VERTEX | raster::FRAGMENT => None,
                _ => Some(GROUP),
            };
            assert_eq!(entry.workgroup_size, group.map(|group| [group, 1, 1]), "{name}");
            for (number, binding) in entry.bindings.iter().enumerate() {
                assert_eq!((binding.set, binding.binding), (0, number as u32), "{name}");
            }
            let kinds = entry.bindings.iter().map(|binding| match binding.kind {
                BindingKind::Uniform => Access::Uniform,
                BindingKind::ReadOnlyStorage => Access::Read,
                BindingKind::Storage => Access::Write,
            });
            assert_eq!(kinds.collect::<Vec<_>>(), accesses, "{name}");
        }
    }

    #[test]
    fn every_stage_is_dispatched_in_order() {
        let stages: Vec<usize> = PASSES.iter().map(|pass| pass.stage).collect();
        assert!(stages.is_sorted() && (0..STAGES.len()).all(|stage| stages.contains(&stage)));
        assert_eq!(STAGES[FIRST_OF_BAND], "visibility");
    }

    #[test]
    fn work_beyond_a_row_of_groups_takes_another_row() {
        assert_eq!(groups(1.into()), [1, 1, 1]);
        assert_eq!(groups(ROW.into()), [65_535, 1, 1]);
        assert_eq!(groups((ROW + 1).into()), [65_535, 2, 1]);
        assert_eq!(groups(Work { invocations: 65, layers: 7 }), [2, 1, 7]);
    }
}
