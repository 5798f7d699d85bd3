//! The buffers of a device: the scene's, kept until it changes, and a frame's, kept for
//! the next.

use crate::Error;
use crate::device::Device;
use bytemuck::Pod;
use rtrt_core::scene::{Scene, Setup, Versions};
use wgpu::BufferUsages;

/// What a buffer holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Slot {
    Frame,
    Views,
    Objects,
    Nodes,
    Words,
    Positions,
    Attributes,
    Materials,
    Texels,
    Covers,
    Counts,
    Placed,
    Lists,
    Hits,
    Surfaces,
    Masks,
    Shadows,
    Edges,
    Soft,
    Tints,
    Lit,
    Colors,
    Layers,
    Pixels,
}

impl Slot {
    const COUNT: usize = Self::Pixels as usize + 1;

    /// What the buffer is called in errors.
    fn name(self) -> &'static str {
        const NAMES: [&str; Slot::COUNT] = [
            "frame",
            "views",
            "objects",
            "nodes",
            "words",
            "positions",
            "attributes",
            "materials",
            "texels",
            "covers",
            "counts",
            "placed",
            "lists",
            "hits",
            "surfaces",
            "masks",
            "shadows",
            "edges",
            "soft",
            "tints",
            "lit",
            "colors",
            "layers",
            "pixels",
        ];
        NAMES[self as usize]
    }
}

/// All buffers that entry points bind.
#[derive(Default)]
pub(crate) struct Buffers {
    slots: [Option<wgpu::Buffer>; Slot::COUNT],
    /// The scene whose arrays are there, as it was.
    resident: Option<(u32, Versions)>,
}

impl Buffers {
    /// The buffer, if it was ever asked for.
    pub fn get(&self, slot: Slot) -> Option<&wgpu::Buffer> {
        self.slots[slot as usize].as_ref()
    }

    /// Makes room for `count` elements, and for one where there are none: entry points bind no
    /// less. What was there is lost if the buffer has to grow.
    pub fn reserve<T>(&mut self, device: &Device, slot: Slot, count: u64) -> Result<(), Error> {
        let bytes = count.max(1) * size_of::<T>() as u64;
        if self.get(slot).is_none_or(|buffer| buffer.size() < bytes) {
            let bound = if slot == Slot::Frame { BufferUsages::UNIFORM } else { BufferUsages::STORAGE };
            let usage = bound | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            // The old one goes first: there may not be memory for both.
            self.slots[slot as usize] = None;
            self.slots[slot as usize] = Some(device.buffer(slot.name(), bytes, usage)?);
        }
        Ok(())
    }

    /// Copies the elements into the buffer.
    pub fn upload<T: Pod>(&mut self, device: &Device, slot: Slot, elements: &[T]) -> Result<(), Error> {
        self.reserve::<T>(device, slot, elements.len() as u64)?;
        if let Some(buffer) = self.get(slot) {
            device.queue.write_buffer(buffer, 0, bytemuck::cast_slice(elements));
        }
        Ok(())
    }

    /// Uploads what has changed in the scene since the last call, and the objects wherever they
    /// have levels of detail.
    pub fn upload_scene(&mut self, device: &Device, scene: &Scene, setup: &Setup) -> Result<(), Error> {
        let versions = scene.versions();
        let known = self.resident.take().filter(|(id, _)| *id == scene.id()).map(|(_, versions)| versions);
        let changed = |part: fn(&Versions) -> u32| known.as_ref().map(part) != Some(part(&versions));
        if changed(|v| v.geometry) {
            self.upload(device, Slot::Nodes, scene.nodes())?;
            self.upload(device, Slot::Words, scene.words())?;
            self.upload(device, Slot::Positions, scene.positions())?;
            self.upload(device, Slot::Attributes, scene.attributes())?;
        }
        if changed(|v| v.texels) {
            self.upload(device, Slot::Texels, scene.texels())?;
        }
        if changed(|v| v.materials) {
            self.upload(device, Slot::Materials, scene.materials())?;
        }
        if changed(|v| v.objects) || setup.has_levels() {
            self.upload(device, Slot::Objects, setup.objects(scene))?;
        }
        self.resident = Some((scene.id(), versions));
        Ok(())
    }
}
