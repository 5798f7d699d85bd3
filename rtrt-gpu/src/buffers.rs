//! The buffers of a device: the scene's, kept until it changes, and a frame's, kept for
//! the next.

use crate::device::Device;
use crate::error::Error;
use crate::slot::{Slot, rows};
use bytemuck::Pod;
use rtrt_core::layout::Frame;
use rtrt_core::scene::{Scene, Setup, Versions};
use wgpu::BufferUsages;

/// All buffers that entry points bind.
#[derive(Default)]
pub(crate) struct Buffers {
    slots: [Option<wgpu::Buffer>; Slot::COUNT],
    /// The numbers of the frame for each layer of surfaces behind the first.
    layers: Vec<wgpu::Buffer>,
    /// What dispatches bind, by numbers that the caller gives them.
    groups: Vec<Option<wgpu::BindGroup>>,
    /// The scene whose arrays are there, as it was, with the levels of detail and the
    /// parts that were chosen.
    resident: Option<(u32, Versions, (u32, Option<u32>))>,
    /// What [`Buffers::renew`] has copied.
    copied: [Vec<u8>; Slot::COUNT],
}

impl Buffers {
    /// The buffer, if it exists.
    pub fn get(&self, slot: Slot) -> Option<&wgpu::Buffer> {
        self.slots[slot as usize].as_ref()
    }

    /// The buffer as a layer of surfaces sees it: each has its own numbers of the frame.
    pub fn of_layer(&self, slot: Slot, layer: u32) -> Option<&wgpu::Buffer> {
        match layer.checked_sub(1).filter(|_| slot == Slot::Frame) {
            Some(behind) => self.layers.get(behind as usize),
            None => self.get(slot),
        }
    }

    /// The group of buffers with this number, if it is there.
    pub fn group(&self, number: usize) -> Option<&wgpu::BindGroup> {
        self.groups.get(number)?.as_ref()
    }

    /// Makes the group with this number, unless it is there. It is gone once any buffer is replaced.
    pub fn make_group(&mut self, number: usize, make: impl FnOnce(&Self) -> wgpu::BindGroup) {
        if self.groups.len() <= number {
            self.groups.resize(number + 1, None);
        }
        if self.groups[number].is_none() {
            self.groups[number] = Some(make(self));
        }
    }

    /// Makes room for a band of a frame, and copies its numbers.
    pub fn prepare(&mut self, device: &Device, frame: &Frame, keeps_layers: bool) -> Result<(), Error> {
        for row in rows(keeps_layers) {
            if let Some(count) = row.elements(frame) {
                self.reserve(device, row.slot, count)?;
            }
        }
        let behind = frame.layers_behind();
        while self.layers.len() < behind as usize {
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            self.layers.push(device.buffer("frame of a layer", size_of::<Frame>() as u64, usage)?);
        }
        if self.renew(device, Slot::Frame, &[*frame])? {
            for (layer, buffer) in (1..=behind).zip(&self.layers) {
                device.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&frame.of_layer(layer)));
            }
        }
        Ok(())
    }

    /// Makes room for `count` elements, and for one where there are none: entry points bind no
    /// less. What was there is lost if the buffer has to grow.
    fn reserve(&mut self, device: &Device, slot: Slot, count: u64) -> Result<(), Error> {
        let bytes = count.max(1) * slot.row().stride;
        if self.get(slot).is_none_or(|buffer| buffer.size() < bytes) {
            let bound = if slot == Slot::Frame { BufferUsages::UNIFORM } else { BufferUsages::STORAGE };
            let usage = bound | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            // The old one is dropped first with its bind groups: memory may not hold both.
            self.groups.clear();
            self.copied[slot as usize].clear();
            self.slots[slot as usize] = None;
            self.slots[slot as usize] = Some(device.buffer(slot.row().name, bytes, usage)?);
        }
        Ok(())
    }

    /// Copies the elements into the buffer.
    fn upload<T: Pod>(&mut self, device: &Device, slot: Slot, elements: &[T]) -> Result<(), Error> {
        self.reserve(device, slot, elements.len() as u64)?;
        if let Some(buffer) = self.get(slot) {
            device.queue.write_buffer(buffer, 0, bytemuck::cast_slice(elements));
        }
        Ok(())
    }

    /// Copies into the buffer what differs from what was copied last: from the first element that
    /// does to the last. Gives whether there are any.
    pub fn renew<T: Pod>(&mut self, device: &Device, slot: Slot, elements: &[T]) -> Result<bool, Error> {
        self.reserve(device, slot, elements.len() as u64)?;
        let bytes = bytemuck::cast_slice::<T, u8>(elements);
        let copied = &mut self.copied[slot as usize];
        let place = |element: usize| element * size_of::<T>()..(element + 1) * size_of::<T>();
        let differs = |element: &usize| copied.get(place(*element)) != bytes.get(place(*element));
        let mut all = 0..elements.len();
        let (Some(first), Some(buffer)) = (all.find(differs), &self.slots[slot as usize]) else {
            return Ok(false);
        };
        let last = all.rfind(differs).unwrap_or(first);
        let changed = place(first).start..place(last).end;
        device.queue.write_buffer(buffer, changed.start as u64, &bytes[changed.clone()]);
        copied.resize(bytes.len(), 0);
        copied[changed.clone()].copy_from_slice(&bytes[changed]);
        Ok(true)
    }

    /// Uploads the changes of the scene since the last call, and its instances if the levels of detail
    /// changed.
    pub fn upload_scene(&mut self, device: &Device, scene: &Scene, setup: &Setup) -> Result<(), Error> {
        let versions = scene.versions();
        let known = self.resident.take().filter(|(id, ..)| *id == scene.id());
        let known_version =
            |part: fn(&Versions) -> u32| known.as_ref().map(|(_, versions, _)| part(versions));
        let changed = |part: fn(&Versions) -> u32| known_version(part) != Some(part(&versions));
        let chosen = (setup.lod_revision(), setup.cut_triangles());
        if changed(|v| v.geometry) {
            self.upload(device, Slot::Nodes, scene.nodes())?;
            self.upload(device, Slot::MeshData, scene.mesh_data())?;
            self.upload(device, Slot::Positions, scene.positions())?;
            self.upload(device, Slot::Attributes, scene.attributes())?;
        }
        if changed(|v| v.texels) {
            self.upload(device, Slot::Texels, scene.texels())?;
        }
        if changed(|v| v.materials) {
            self.upload(device, Slot::Materials, scene.materials())?;
        }
        if changed(|v| v.instances) || known.is_some_and(|(.., known)| known != chosen) {
            self.upload(device, Slot::Instances, setup.instances(scene))?;
        }
        self.resident = Some((scene.id(), versions, chosen));
        Ok(())
    }
}
