//! The buffers that entry points bind, as one table.

use rtrt_core::grid::{BLOCK, BLOCK_RAYS};
use rtrt_core::kernel::lists::{BlockLists, ListEntry};
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::layout::{
    Attribute, Frame, Hit, Instance, Lit, MaterialRecord, Node, ShadowBuffer, ShadowKind, Surface, View,
};
use rtrt_core::schedule::Unit;
use rtrt_core::stage::penumbra_blocks::PenumbraSummary;
use rtrt_core::stage::raster::{Drawn, pitch};
use rtrt_shaders::SCANNERS;

/// What a buffer holds: a row of [`TABLE`].
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
    FilterBlocks,
    Transmittance,
    Ambient,
    Lit,
    Colors,
    Layers,
    Pixels,
}

impl Slot {
    pub const COUNT: usize = Self::Pixels as usize + 1;

    /// Its row.
    pub fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }
}

/// One buffer.
pub(crate) struct Row {
    pub slot: Slot,
    /// What errors call it.
    pub name: &'static str,
    /// Bytes of an element.
    pub stride: u64,
    pub count: Count,
}

/// How many elements a buffer has.
pub(crate) enum Count {
    /// As many as are copied into it.
    Uploaded,
    /// As many as a frame, or a band of it, needs.
    Frame(fn(&Frame) -> u64),
    /// So many for each ray of a band.
    Ray(fn(&Frame) -> u64),
}

const fn row<T>(slot: Slot, name: &'static str, count: Count) -> Row {
    Row { slot, name, stride: size_of::<T>() as u64, count }
}

/// All buffers, in the order of their slots.
pub(crate) const TABLE: [Row; Slot::COUNT] = {
    use Count::{Ray, Uploaded};
    [
        row::<Frame>(Slot::Frame, "frame", Uploaded),
        row::<View>(Slot::Views, "views", Uploaded),
        row::<Instance>(Slot::Instances, "instances", Uploaded),
        row::<Node>(Slot::Nodes, "nodes", Uploaded),
        row::<u32>(Slot::MeshData, "mesh data", Uploaded),
        row::<[f32; 3]>(Slot::Positions, "positions", Uploaded),
        row::<Attribute>(Slot::Attributes, "attributes", Uploaded),
        row::<MaterialRecord>(Slot::Materials, "materials", Uploaded),
        row::<u32>(Slot::Texels, "texels", Uploaded),
        row::<ScreenBounds>(
            Slot::ScreenBounds,
            "screen bounds",
            Count::Frame(|frame| all(Unit::Bounds, frame)),
        ),
        // Behind the counts of blocks are those of their shares.
        row::<u32>(Slot::Counts, "counts", Count::Frame(|frame| u64::from(frame.blocks + SCANNERS))),
        row::<ListEntry>(Slot::Placed, "placed", Count::Frame(|frame| frame.capacity.into())),
        row::<u32>(Slot::BlockLists, "block lists", Count::Frame(|frame| list_words(frame, frame.capacity))),
        row::<Drawn>(Slot::Drawn, "drawn", Count::Frame(drawn)),
        row::<Hit>(Slot::Hits, "hits", Ray(|_| 1)),
        row::<Surface>(Slot::Surfaces, "surfaces", Ray(|_| 1)),
        row::<u32>(Slot::Masks, "masks", Ray(|frame| frame.mask_words.into())),
        row::<u32>(Slot::Shadows, "shadows", Ray(|frame| shadow_words(frame)[0])),
        row::<PenumbraSummary>(Slot::PenumbraSummary, "penumbra summary", Count::Frame(penumbra_blocks)),
        row::<u32>(Slot::FilterBlocks, "filter blocks", Count::Frame(penumbra_blocks)),
        row::<u32>(Slot::Transmittance, "transmittance", Ray(|frame| shadow_words(frame)[1])),
        row::<[f32; 2]>(Slot::Ambient, "ambient", Ray(|frame| frame.has_ambient_rays().into())),
        row::<Lit>(Slot::Lit, "lit", Ray(|_| 1)),
        row::<[f32; 4]>(Slot::Colors, "colors", Ray(|frame| frame.records().into())),
        row::<Hit>(Slot::Layers, "layers", Ray(|frame| frame.layers_behind().into())),
        row::<u32>(Slot::Pixels, "pixels", Count::Frame(|frame| all(Unit::Pixel, frame))),
    ]
};

impl Row {
    /// The number of elements that a band of a frame needs; `None` for uploaded buffers.
    pub fn elements(&self, frame: &Frame) -> Option<u64> {
        match self.count {
            Count::Uploaded => None,
            Count::Frame(count) => Some(count(frame)),
            Count::Ray(count) => Some(u64::from(frame.rays) * count(frame)),
        }
    }

    /// How many bytes grow with the rays of a band, a ray.
    pub fn bytes_per_ray(&self, frame: &Frame) -> u64 {
        if let Count::Ray(count) = self.count { self.stride * count(frame) } else { 0 }
    }
}

/// The buffers that a frame fills: without deferred buffers, no hits of layers are copied.
pub(crate) fn rows(keeps_layers: bool) -> impl Iterator<Item = &'static Row> {
    TABLE.iter().filter(move |row| keeps_layers || row.slot != Slot::Layers)
}

/// Words of the lists with so many entries.
pub(crate) fn list_words(frame: &Frame, entries: u32) -> u64 {
    u64::from(BlockLists::header(frame.blocks)) + 2 * u64::from(entries)
}

/// Words a ray of [`Slot::Shadows`] and [`Slot::Transmittance`]. The one that shadow rays are traced in is
/// a [`ShadowBuffer`].
fn shadow_words(frame: &Frame) -> [u64; 2] {
    let [lights, traced] = [frame.lights, ShadowBuffer::new(frame).words_per_ray()].map(u64::from);
    match frame.shadow_kind() {
        ShadowKind::Bits => [0, 0],
        ShadowKind::Transmittance => [0, traced],
        ShadowKind::Penumbra => [traced, lights],
    }
}

fn penumbra_blocks(frame: &Frame) -> u64 {
    if frame.shadow_kind() == ShadowKind::Penumbra { all(Unit::BlockAndLight, frame) } else { 0 }
}

/// Whole rows of blocks, see [`pitch`].
fn drawn(frame: &Frame) -> u64 {
    let rows = frame.rays / (frame.grid().blocks_x() * BLOCK_RAYS) * BLOCK;
    u64::from(frame.is_drawn) * u64::from(rows) * u64::from(pitch(frame))
}

/// How many units there are, for all lights.
fn all(unit: Unit, frame: &Frame) -> u64 {
    let [count, lights] = unit.count(frame).map(u64::from);
    count * lights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_are_the_numbers_of_their_rows() {
        assert!((0..).zip(&TABLE).all(|(number, row)| row.slot as usize == number));
    }
}
