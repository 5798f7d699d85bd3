//! An opened device, and how its failures become errors.

use crate::barriers::with_barriers;
use crate::entry::{Access, most_storage_buffers};
use crate::error::Error;
use crate::info::{Kind, Route, has_passthrough, label};
use crate::pipeline::{Pipeline, Zero};
use crate::spirv::entry_point;
use crate::wait::{Signal, Waiting, until};
use rtrt_core::layout::{MaterialRecord, View};
use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

/// Features that a device is to have where its adapter has them.
pub(crate) const FEATURES: wgpu::Features =
    wgpu::Features::PASSTHROUGH_SHADERS.union(wgpu::Features::TIMESTAMP_QUERY);

/// A device, ready to compile entry points.
#[derive(Clone)]
pub(crate) struct Device {
    pub name: String,
    pub kind: Kind,
    pub route: Route,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Who moves its work along while something waits for it.
    pub waiting: Waiting,
    /// The most bytes a storage buffer may have.
    pub limit: u64,
    /// What barriers in modules read, if they have any.
    pub zero: Option<Zero>,
    /// Why the device is gone, where it tells.
    lost: Arc<Mutex<Option<String>>>,
}

/// Bytes of the smallest buffer: the largest element of any fits.
const LARGEST: u64 = 2048;
const _: () =
    assert!(size_of::<MaterialRecord>() <= LARGEST as usize && size_of::<View>() <= LARGEST as usize);

impl Device {
    /// Opens the adapter with all it allows.
    pub async fn open(adapter: &wgpu::Adapter, route: Route, waiting: Waiting) -> Result<Self, Error> {
        let opened = adapter.request_device(&wgpu::DeviceDescriptor {
            label: None,
            required_features: adapter.features() & FEATURES,
            required_limits: adapter.limits(),
            experimental_features: wgpu::ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        });
        let failed = |source| Error::Open { adapter: label(&adapter.get_info()), source };
        let (device, queue) = opened.await.map_err(failed)?;
        let lost = Arc::new(Mutex::new(None));
        let kept = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, reason| {
            *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(reason);
        });
        Ok(Self { lost, ..Self::new(device, queue, route, waiting).await? })
    }

    /// Takes over a device that is open.
    pub async fn new(
        device: wgpu::Device,
        queue: wgpu::Queue,
        route: Route,
        waiting: Waiting,
    ) -> Result<Self, Error> {
        let info = device.adapter_info();
        let name = label(&info);
        let passthrough = has_passthrough(&info, device.features());
        let route = match route {
            Route::Auto if passthrough => Route::Passthrough,
            Route::Auto | Route::Naga => Route::Naga,
            Route::Passthrough if passthrough => Route::Passthrough,
            Route::Passthrough => return Err(Error::NoPassthrough { adapter: name }),
        };
        let limits = device.limits();
        let needed = most_storage_buffers();
        if limits.max_storage_buffers_per_shader_stage < needed {
            let limit = limits.max_storage_buffers_per_shader_stage;
            return Err(Error::TooFewBindings { adapter: name, limit, needed });
        }
        let kind = Kind::new(info.device_type);
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let zero = async { Ok((route == Route::Naga).then(|| Zero::new(&device))) };
        let zero = watched(&device, zero).await?;
        Ok(Self { name, kind, route, device, queue, waiting, limit, zero, lost: Arc::default() })
    }

    /// Whether the device is still there.
    pub fn check(&self) -> Result<(), Error> {
        let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone();
        lost.map_or(Ok(()), |reason| Err(Error::Lost { reason }))
    }

    /// A pipeline of the entry point, whose buffers are bound from 0 on.
    pub fn pipeline(&self, entry: &str, accesses: impl Iterator<Item = Access>) -> Pipeline {
        Pipeline::new(&self.device, &self.module(entry), entry, accesses, self.zero.as_ref())
    }

    /// A module of this entry point alone, as the route wants it.
    pub fn module(&self, entry: &str) -> wgpu::ShaderModule {
        let words = bytemuck::pod_collect_to_vec::<u8, u32>(rtrt_shaders::SPIRV);
        let words = entry_point(&words, entry).unwrap_or(words);
        if self.route == Route::Naga {
            return self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(entry),
                source: wgpu::ShaderSource::SpirV(Cow::Owned(with_barriers(&words))),
            });
        }
        let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
            label: Some(entry),
            entry_points: Cow::Owned(vec![wgpu::PassthroughShaderEntryPoint {
                name: Cow::Borrowed(entry),
                workgroup_size: (rtrt_shaders::GROUP, 1, 1),
            }]),
            spirv: Some(Cow::Owned(words)),
            ..Default::default()
        };
        // SAFETY: the device gets these words unchecked. They are of the committed module, which the builder
        // passes through spirv-val and whose bindings a test compares with the pipelines' layouts; rust-gpu
        // checks every index; loops end because trees, lists and counts are finite.
        unsafe { self.device.create_shader_module_passthrough(descriptor) }
    }

    /// The size of a buffer of at least `bytes`.
    pub fn buffer_bytes(bytes: u64) -> u64 {
        // No binding may be smaller than an element, even of nothing.
        bytes.next_multiple_of(4).max(LARGEST)
    }

    /// A buffer of at least `bytes`, for anything.
    pub fn buffer(
        &self,
        what: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, Error> {
        let needed = Self::buffer_bytes(bytes);
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

    /// Waits until the device has finished its work.
    pub async fn finished(&self) -> Result<(), Error> {
        let begin = |signal: Signal| {
            self.queue.on_submitted_work_done(move || signal.give(Ok::<(), std::convert::Infallible>(())));
        };
        let waited = until(&self.device, self.waiting, begin).await;
        self.check()?;
        waited
    }

    /// Waits until the device has finished its work, and calls `read` with the first bytes
    /// of `buffer`.
    pub async fn read(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        read: impl FnOnce(&[u8]),
    ) -> Result<(), Error> {
        let begin = |signal: Signal| {
            buffer.map_async(wgpu::MapMode::Read, ..bytes, move |mapped| signal.give(mapped));
        };
        let mapped = until(&self.device, self.waiting, begin).await;
        self.check()?;
        mapped?;
        read(&buffer.get_mapped_range(..bytes).map_err(Error::read_back)?);
        buffer.unmap();
        Ok(())
    }

    /// The first `bytes` of a buffer.
    pub async fn fetch(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, Error> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let copy = self.buffer("read back", bytes, usage)?;
        let mut commands = self.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(buffer, 0, &copy, 0, bytes);
        let mut fetched = Vec::new();
        self.queue.submit([commands.finish()]);
        self.read(&copy, bytes, |mapped| fetched.extend_from_slice(mapped)).await?;
        Ok(fetched)
    }
}

/// Does some work, and gives the first thing that the device had against it.
///
/// What nobody catches goes to the handler of the device, which may be an application's own, or
/// panics. Scopes are of a thread, so the future stays on the one that polls it first.
pub(crate) async fn watched<T>(
    device: &wgpu::Device,
    work: impl Future<Output = Result<T, Error>>,
) -> Result<T, Error> {
    // Three variables: those of a future that is dropped are dropped from the last to the first, as scopes must be.
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let result = work.await;
    // Pops all before it waits for one, so that no other work gets in between.
    let (internal, validation, memory) = (internal.pop(), validation.pop(), memory.pop());
    // Without memory, buffers are not there, and their use is an error as well.
    let (internal, validation, memory) = (internal.await, validation.await, memory.await);
    let caught = memory.or(validation).or(internal);
    caught.map_or(result, |error| Err(Error::Device(error)))
}
