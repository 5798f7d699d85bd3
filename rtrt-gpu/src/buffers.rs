//! The buffers of a device: the scene's, kept until it changes, and a frame's, kept for
//! the next.

use crate::Error;
use crate::device::Device;
use crate::group::Groups;
use crate::pipeline::Pipeline;
use bytemuck::Pod;
use rtrt_core::layout::Frame;
use rtrt_core::scene::{Scene, Setup, Versions};
use wgpu::BufferUsages;

/// What a buffer holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Slot {
    Frame,
    Views,
    Instances,
    Nodes,
    MeshData,
    Positions,
    Attributes,
    Materials,
    Texels,
    ScreenBounds,
    Counts,
    Placed,
    BlockLists,
    Drawn,
    Hits,
    Surfaces,
    Masks,
    Shadows,
    PenumbraSummary,
    Soft,
    Transmittance,
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
            "instances",
            "nodes",
            "mesh data",
            "positions",
            "attributes",
            "materials",
            "texels",
            "screen bounds",
            "counts",
            "placed",
            "block lists",
            "drawn",
            "hits",
            "surfaces",
            "masks",
            "shadows",
            "penumbra summary",
            "soft",
            "transmittance",
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
    /// What dispatches bind of them.
    groups: Groups,
    /// The scene whose arrays are there, as it was, with the levels of detail and the
    /// parts that were chosen.
    resident: Option<(u32, Versions, (u32, Option<u32>))>,
    /// What [`Buffers::renew`] has copied.
    copied: [Vec<u8>; Slot::COUNT],
}

impl Buffers {
    /// The buffer, if it was ever asked for.
    pub fn get(&self, slot: Slot) -> Option<&wgpu::Buffer> {
        self.slots[slot as usize].as_ref()
    }

    /// What a row of the table of dispatches binds, for one of the layers that it is repeated for.
    pub fn group(&self, row: usize, layer: usize) -> Option<&wgpu::BindGroup> {
        self.groups.get(row, layer)
    }

    /// Makes what the dispatches of a frame bind, where that is not there yet. `layers` are what
    /// layers get for the numbers of the frame.
    pub fn bind(
        &mut self,
        device: &Device,
        frame: &Frame,
        pipelines: &[Option<Pipeline>],
        layers: &[wgpu::Buffer],
    ) {
        let Self { slots, groups, .. } = self;
        groups.make(&device.device, frame, pipelines, layers, |slot| slots[slot as usize].as_ref());
    }

    /// Makes room for `count` elements, and for one where there are none: entry points bind no
    /// less. What was there is lost if the buffer has to grow.
    pub fn reserve<T>(&mut self, device: &Device, slot: Slot, count: u64) -> Result<(), Error> {
        let bytes = count.max(1) * size_of::<T>() as u64;
        if self.get(slot).is_none_or(|buffer| buffer.size() < bytes) {
            let bound = if slot == Slot::Frame { BufferUsages::UNIFORM } else { BufferUsages::STORAGE };
            let usage = bound | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            // The old one goes first, and what holds on to it: there may not be memory for both.
            self.groups.clear();
            self.copied[slot as usize].clear();
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

    /// Copies into the buffer what differs from what was copied last: from the first element that
    /// does to the last. Gives whether there are any.
    pub fn renew<T: Pod>(&mut self, device: &Device, slot: Slot, elements: &[T]) -> Result<bool, Error> {
        self.reserve::<T>(device, slot, elements.len() as u64)?;
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

    /// Uploads what has changed in the scene since the last call, and its instances if other levels of
    /// detail are seen.
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
