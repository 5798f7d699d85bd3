//! Arrays of a host that a device has copies of.

use crate::device::Device;
use crate::error::Error;
use bytemuck::Pod;
use rtrt_core::query::Changed;
use wgpu::BufferUsages;

/// So many bytes between two changes are copied with them.
const GAP: usize = 1 << 14;
const USAGE: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::COPY_DST);

/// A copy of an array.
pub(crate) struct Array {
    name: &'static str,
    pub buffer: wgpu::Buffer,
}

impl Array {
    /// Room for this many bytes.
    pub fn new(device: &Device, name: &'static str, bytes: u64) -> Result<Self, Error> {
        Ok(Self { name, buffer: device.buffer(name, bytes, USAGE)? })
    }

    /// Copies what has changed of the parts that the array consists of; all of them if it has another size now.
    pub fn renew<T: Pod>(&mut self, device: &Device, parts: &[(&[T], &Changed)]) -> Result<(), Error> {
        let bytes = parts.iter().map(|(part, _)| size_of_val(*part) as u64).sum();
        let has_size = self.buffer.size() == Device::buffer_bytes(bytes);
        if !has_size {
            *self = Self::new(device, self.name, bytes)?;
        }
        let mut start = 0;
        for (part, changed) in parts {
            let changed = if has_size { *changed } else { &Changed::All };
            for range in changed.ranges(part.len(), GAP / size_of::<T>()) {
                let offset = start + range.start * size_of::<T>();
                device.queue.write_buffer(&self.buffer, offset as u64, bytemuck::cast_slice(&part[range]));
            }
            start += size_of_val(*part);
        }
        Ok(())
    }
}
