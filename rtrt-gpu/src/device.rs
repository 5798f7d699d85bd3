//! An opened device with the compiled module, and how its failures become errors.

use crate::adapter::{Kind, has_passthrough, kind, label};
use crate::barriers::with_barriers;
use crate::pipeline::{Access, PASSES, Pipeline, bind_group_layout};
use crate::{Error, Route};
use rtrt_core::layout::{Material, View};
use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError, mpsc};

/// A device, ready to compile entry points.
pub(crate) struct Device {
    pub name: String,
    pub kind: Kind,
    pub route: Route,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// The most bytes a storage buffer may have.
    pub limit: u64,
    module: wgpu::ShaderModule,
    zero: Option<Zero>,
    failure: Arc<Mutex<Option<Error>>>,
}

/// Bytes of the smallest buffer: the largest element of any fits.
const LARGEST: u64 = 512;
const _: () = assert!(size_of::<Material>() <= LARGEST as usize && size_of::<View>() <= LARGEST as usize);

impl Device {
    /// Opens the adapter with all it allows, and hands it the module.
    pub fn open(adapter: &wgpu::Adapter, route: Route) -> Result<Self, Error> {
        let name = label(adapter);
        let passthrough = has_passthrough(adapter);
        let route = match route {
            Route::Auto if passthrough => Route::Passthrough,
            Route::Auto | Route::Naga => Route::Naga,
            Route::Passthrough if passthrough => Route::Passthrough,
            Route::Passthrough => return Err(Error::NoPassthrough { adapter: name }),
        };
        let limits = adapter.limits();
        let needed = most_storage_buffers();
        if limits.max_storage_buffers_per_shader_stage < needed {
            let limit = limits.max_storage_buffers_per_shader_stage;
            return Err(Error::TooFewBindings { adapter: name, limit, needed });
        }
        let wanted = wgpu::Features::PASSTHROUGH_SHADERS | wgpu::Features::TIMESTAMP_QUERY;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: None,
            required_features: adapter.features() & wanted,
            required_limits: limits.clone(),
            experimental_features: wgpu::ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        }))
        .map_err(|source| Error::Open { adapter: name.clone(), source })?;
        let failure = Arc::new(Mutex::new(None));
        keep_failures(&device, &failure);
        let module = module(&device, route);
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let zero = (route == Route::Naga).then(|| Zero::new(&device));
        let this = Self { name, kind: kind(adapter), route, device, queue, limit, module, zero, failure };
        this.check()?;
        Ok(this)
    }

    /// The first failure since the last call, if there was one.
    pub fn check(&self) -> Result<(), Error> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        failure.map_or(Ok(()), Err)
    }

    /// A pipeline of the entry point, whose buffers are bound from 0 on.
    pub fn pipeline(&self, entry: &str, accesses: impl Iterator<Item = Access>) -> Pipeline {
        Pipeline::new(&self.device, &self.module, entry, accesses, self.zero.as_ref())
    }

    /// A buffer of at least `bytes`, for anything.
    pub fn buffer(
        &self,
        what: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, Error> {
        // No binding may be smaller than an element, even of nothing.
        let needed = bytes.next_multiple_of(4).max(LARGEST);
        if needed > self.limit {
            return Err(Error::BufferTooLarge { buffer: what, needed, limit: self.limit });
        }
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size: needed,
            usage,
            mapped_at_creation: false,
        });
        self.check()?;
        Ok(buffer)
    }

    /// Hands the commands to the device, waits until they are done, and calls `read` with
    /// the first bytes of `buffer`.
    pub fn finish(
        &self,
        commands: wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        bytes: u64,
        read: impl FnOnce(&[u8]),
    ) -> Result<(), Error> {
        self.queue.submit([commands.finish()]);
        let (send, receive) = mpsc::channel();
        // The receiver is only gone when this function has failed already.
        buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| drop(send.send(result)));
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        polled.map_err(Error::read_back)?;
        receive.recv().map_err(Error::read_back)?.map_err(Error::read_back)?;
        read(&buffer.get_mapped_range(..bytes).map_err(Error::read_back)?);
        buffer.unmap();
        Ok(())
    }

    /// The first `bytes` of a buffer.
    pub fn fetch(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, Error> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let copy = self.buffer("read back", bytes, usage)?;
        let mut commands = self.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(buffer, 0, &copy, 0, bytes);
        let mut fetched = Vec::new();
        self.finish(commands, &copy, bytes, |mapped| fetched.extend_from_slice(mapped))?;
        Ok(fetched)
    }
}

/// The zero that [`crate::barriers`] reads.
pub(crate) struct Zero {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
}

impl Zero {
    fn new(device: &wgpu::Device) -> Self {
        // New buffers are filled with zeros. Uniform buffers want 16 bytes.
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("zero"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM,
            mapped_at_creation: false,
        });
        let layout = bind_group_layout(device, "zero", [Access::Uniform].into_iter());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("zero"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        Self { layout, group }
    }
}

/// The most storage buffers that an entry point binds.
fn most_storage_buffers() -> u32 {
    let storage = |access: &Access| u32::from(*access != Access::Uniform);
    PASSES.iter().map(|pass| pass.accesses().map(|a| storage(&a)).sum()).max().unwrap_or(0)
}

/// Without this wgpu panics. The first failure is kept: others follow from it.
fn keep_failures(device: &wgpu::Device, failure: &Arc<Mutex<Option<Error>>>) {
    let keep = |failure: &Mutex<Option<Error>>, error| {
        failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    };
    let kept = Arc::clone(failure);
    device.on_uncaptured_error(Arc::new(move |error| keep(&kept, Error::Device(error))));
    let kept = Arc::clone(failure);
    device.set_device_lost_callback(move |_, reason| keep(&kept, Error::Lost { reason }));
}

/// The compiled module, as the route wants it.
fn module(device: &wgpu::Device, route: Route) -> wgpu::ShaderModule {
    let words = bytemuck::pod_collect_to_vec::<u8, u32>(rtrt_shaders::SPIRV);
    if route == Route::Passthrough {
        let entry = |name: &'static str| wgpu::PassthroughShaderEntryPoint {
            name: Cow::Borrowed(name),
            workgroup_size: (rtrt_shaders::GROUP, 1, 1),
        };
        let passes = PASSES.iter().map(|pass| entry(pass.entry));
        let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
            label: None,
            entry_points: passes.chain(["kernels", "layout"].map(entry)).collect(),
            spirv: Some(Cow::Borrowed(&words)),
            ..Default::default()
        };
        // SAFETY: the device gets these bytes unchecked. They are the committed module, which the builder
        // passes through spirv-val and whose bindings a test compares with the pipelines' layouts; rust-gpu
        // checks every index; loops end because trees, lists and counts are finite.
        unsafe { device.create_shader_module_passthrough(descriptor) }
    } else {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::SpirV(Cow::Owned(with_barriers(&words))),
        })
    }
}
