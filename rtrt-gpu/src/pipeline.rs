//! Compiled entry points, and their bind groups.

use crate::barriers::ZERO_GROUP;
use crate::entry::Access;

/// A compiled entry point.
#[derive(Clone, PartialEq)]
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

    /// Dispatches it with a bind group of [`Pipeline::group`].
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

/// The zero that [`crate::barriers`] reads.
#[derive(Clone)]
pub(crate) struct Zero {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
}

impl Zero {
    pub fn new(device: &wgpu::Device) -> Self {
        // New buffers are filled with zeros. Uniform buffers want 16 bytes.
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("zero"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM,
            mapped_at_creation: false,
        });
        let layout = bind_group_layout(
            device,
            "zero",
            wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::VERTEX_FRAGMENT,
            [Access::Uniform].into_iter(),
        );
        let group = bind_group(device, &layout, [buffer.as_entire_binding()].into_iter());
        Self { layout, group }
    }
}
