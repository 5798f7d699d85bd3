//! The entry points of the module, as one table: which pass of a frame each serves, what it binds,
//! and how many invocations it takes.

use crate::slot::Slot;
use rtrt_core::layout::Frame;
use rtrt_core::schedule::{Pass, Step, Unit};
use rtrt_shaders::{GROUP, ROW, SCANNERS, SHARES};

/// How an entry point uses a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    Uniform,
    Read,
    Write,
}

/// An entry point that a frame dispatches.
pub(crate) struct Entry {
    pub name: &'static str,
    /// Which pass it serves. The entry points of a pass run one after another, in the table's order.
    pub pass: Pass,
    /// Buffers read, bound from 0 on: the frame first.
    pub reads: &'static [Slot],
    /// Buffers written, bound after those.
    pub writes: &'static [Slot],
    /// Whether the first of them has to be zero in the first layer.
    pub starts_at_zero: fn(&Frame) -> bool,
    /// Which frames it serves.
    serves: fn(&Frame) -> bool,
    work: Work,
}

/// How many invocations an entry point takes.
#[derive(Clone, Copy)]
enum Work {
    /// One for each unit of its pass.
    Units,
    /// [`SHARES`] for the bounds of each instance in each view.
    Shares,
    /// [`SCANNERS`].
    Scanners,
    /// One for each entry that the lists have room for: only the device knows how many there are, and those
    /// beyond do nothing.
    ListEntries,
}

/// What entry points read that search for surfaces of any transparency.
const TRACE: &[Slot] = &[
    Slot::Frame,
    Slot::Views,
    Slot::BlockLists,
    Slot::Instances,
    Slot::Nodes,
    Slot::MeshData,
    Slot::Positions,
    Slot::Texels,
];
/// What the entry points read that sum light.
const LIGHT: &[Slot] = &[
    Slot::Frame,
    Slot::Views,
    Slot::Materials,
    Slot::Texels,
    Slot::Surfaces,
    Slot::Masks,
    Slot::Transmittance,
];
/// What the entry points that shade read.
const SHADE: &[Slot] =
    &[Slot::Frame, Slot::Views, Slot::Materials, Slot::Texels, Slot::Surfaces, Slot::Lit, Slot::Ambient];

const fn entry(pass: Pass, name: &'static str, reads: &'static [Slot], writes: &'static [Slot]) -> Entry {
    Entry { name, pass, reads, writes, starts_at_zero: |_| false, serves: |_| true, work: Work::Units }
}

/// All that frames dispatch.
#[rustfmt::skip]
pub(crate) const ENTRIES: &[Entry] = {
    use Slot::*;
    &[
        entry(Pass::Prepare, "prepare", &[Frame, Views, Instances], &[ScreenBounds]),
        entry(Pass::Bin, "count", &[Frame, Views, Instances, ScreenBounds], &[Counts]).work(Work::Shares).zero_if(|_| true),
        entry(Pass::Bin, "scan_totals", &[Frame], &[Counts]).work(Work::Scanners),
        entry(Pass::Bin, "scan", &[Frame], &[Counts, BlockLists]).work(Work::Scanners),
        entry(Pass::Bin, "scatter", &[Frame, Views, Instances, ScreenBounds, BlockLists], &[Counts, Placed]).work(Work::Shares),
        entry(Pass::Bin, "rank", &[Frame, Placed], &[BlockLists]).work(Work::ListEntries),
        entry(Pass::Pick, "pick", &[Frame, Views, Instances, MeshData, Positions, Drawn], &[Hits]),
        entry(Pass::Visibility, "visibility", &[Frame, Views, BlockLists, Instances, Nodes, MeshData, Positions], &[Hits]),
        entry(Pass::EndCovered, "end_covered", &[Frame, Colors], &[Hits]),
        // What was drawn is there already.
        entry(Pass::Peel, "peel", TRACE, &[Hits]).zero_if(|frame| frame.is_drawn == 0),
        entry(Pass::Share, "share", &[Frame], &[Hits]),
        entry(Pass::Surface, "surface", &[Frame, Views, Hits, Instances, Nodes, MeshData, Positions, Attributes], &[Surfaces]),
        entry(Pass::Detail, "detail", &[Frame, Hits, Instances, MeshData, Attributes, Materials, Texels], &[Surfaces]),
        entry(Pass::Occlusion, "occlusion", &[Frame, Views, BlockLists, Instances, Nodes, MeshData, Positions, Surfaces], &[Masks]).zero_if(|_| true),
        entry(Pass::Transmittance, "potentially_lit", &[Frame, Views, Surfaces], &[Transmittance]),
        entry(Pass::Transmittance, "transmittance", TRACE, &[Transmittance]),
        entry(Pass::BlockerSearch, "potentially_lit", &[Frame, Views, Surfaces], &[Shadows]),
        entry(Pass::BlockerSearch, "blocker_search", TRACE, &[Shadows]),
        entry(Pass::SummarizePenumbras, "summarize_penumbras", &[Frame, Shadows], &[PenumbraSummary]),
        entry(Pass::SelectFilterBlocks, "select_filter_blocks", &[Frame, PenumbraSummary], &[FilterBlocks]),
        entry(Pass::FilterPenumbra, "filter_penumbra", &[Frame, Views, Surfaces, Shadows, FilterBlocks], &[Transmittance]),
        entry(Pass::Mask, "mask", &[Frame, Transmittance], &[Masks]),
        entry(Pass::Ambient, "ambient", &[Frame, Views, BlockLists, Instances, Nodes, MeshData, Positions, Surfaces], &[Ambient]),
        entry(Pass::Light, "light", LIGHT, &[Lit]).serve(|frame| frame.extensions != 0),
        entry(Pass::Light, "light_plain", LIGHT, &[Lit]).serve(|frame| frame.extensions == 0),
        entry(Pass::Shade, "shade", SHADE, &[Colors]).serve(|frame| frame.extensions != 0),
        entry(Pass::Shade, "shade_plain", SHADE, &[Colors]).serve(|frame| frame.extensions == 0),
        entry(Pass::Blend, "blend", SHADE, &[Colors]),
        entry(Pass::Resolve, "resolve", &[Frame, Hits, Colors], &[Pixels]),
    ]
};

/// The rows that a step dispatches, with their numbers in the table.
pub(crate) fn entries(step: Step) -> impl Iterator<Item = (usize, &'static Entry)> {
    ENTRIES.iter().enumerate().filter(move |(_, entry)| entry.pass == step.pass)
}

impl Entry {
    const fn work(self, work: Work) -> Self {
        Self { work, ..self }
    }
    const fn serve(self, serves: fn(&Frame) -> bool) -> Self {
        Self { serves, ..self }
    }
    const fn zero_if(self, starts_at_zero: fn(&Frame) -> bool) -> Self {
        Self { starts_at_zero, ..self }
    }
    /// The buffers in the order of their bindings.
    pub fn slots(&self) -> impl Iterator<Item = Slot> {
        self.reads.iter().chain(self.writes).copied()
    }
    /// How each is used.
    pub fn accesses(&self) -> impl Iterator<Item = Access> {
        self.reads.iter().map(read).chain(self.writes.iter().map(|_| Access::Write))
    }
    /// Workgroups for a step of a frame; `None` where there is nothing to do.
    pub fn groups(&self, step: Step, frame: &Frame) -> Option<[u32; 3]> {
        let [bounds, _] = Unit::Bounds.count(frame);
        let groups = groups(match self.work {
            Work::Units => step.unit().count(frame),
            Work::Shares => [SHARES * bounds, 1],
            Work::Scanners => [SCANNERS, 1],
            Work::ListEntries => [frame.capacity, 1],
        });
        ((self.serves)(frame) && !groups.contains(&0)).then_some(groups)
    }
}

/// How a buffer is used that is read.
fn read(slot: &Slot) -> Access {
    if *slot == Slot::Frame { Access::Uniform } else { Access::Read }
}

/// Workgroups in x, y and z for so many invocations of each light.
///
/// A light has its own, because an invocation for all of them would take more turns of a loop than
/// some devices allow.
pub(crate) fn groups([invocations, lights]: [u32; 2]) -> [u32; 3] {
    [invocations.min(ROW).div_ceil(GROUP), invocations.div_ceil(ROW), lights]
}

/// The entry points that draw.
pub(crate) const VERTEX: &str = "vertex";
pub(crate) const FRAGMENT: &str = "fragment";
/// What the first of them binds: these slots from 0 on, with the window second.
pub(crate) const VERTEX_SLOTS: [Slot; 6] =
    [Slot::Frame, Slot::Views, Slot::ScreenBounds, Slot::Instances, Slot::MeshData, Slot::Positions];

/// How [`VERTEX`] uses what it binds.
pub(crate) fn vertex_accesses() -> impl Iterator<Item = Access> {
    let (frame, others) = VERTEX_SLOTS.split_at(1);
    frame.iter().map(read).chain([Access::Uniform]).chain(others.iter().map(read))
}

/// The entry point that runs the kernels of the canary, and what it binds.
pub(crate) const KERNELS: (&str, &[Access]) = (
    "kernels",
    &[Access::Uniform, Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write],
);
/// Uniform numbers, seven buffers that are read, and one that is written.
const SEVEN_READ: &[Access] = &[
    Access::Uniform,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Write,
];
/// The entry point that tells where it finds fields, and what it binds.
pub(crate) const PROBE: (&str, &[Access]) = ("probe_layout", SEVEN_READ);
/// The entry points for rays of programs, and what they bind.
pub(crate) const QUERY_CLOSEST: (&str, &[Access]) = ("query_closest", SEVEN_READ);
pub(crate) const QUERY_OCCLUDED: (&str, &[Access]) = ("query_occluded", SEVEN_READ);

/// The most storage buffers that an entry point binds.
pub(crate) fn most_storage_buffers() -> u32 {
    let storage = |entry: &Entry| entry.accesses().filter(|access| *access != Access::Uniform).count();
    ENTRIES.iter().map(storage).max().unwrap_or(0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use rtrt_core::schedule::{Stage, steps};
    use rtrt_shaders::reflect::{BindingKind, entry_points};

    #[test]
    fn the_module_has_the_entry_points_of_the_table_with_their_bindings() {
        let mut expected: Vec<(&str, Vec<Access>)> =
            ENTRIES.iter().map(|entry| (entry.name, entry.accesses().collect())).collect();
        expected.sort_unstable_by_key(|(name, _)| *name);
        expected.dedup();
        expected.extend(
            [KERNELS, PROBE, QUERY_CLOSEST, QUERY_OCCLUDED].map(|(name, accesses)| (name, accesses.to_vec())),
        );
        expected.extend([(VERTEX, vertex_accesses().collect()), (FRAGMENT, vec![])]);
        let found = entry_points(rtrt_shaders::SPIRV).unwrap();
        assert_eq!(found.len(), expected.len());
        for (name, accesses) in expected {
            let entry = found.iter().find(|entry| entry.name == name).unwrap();
            let group = match name {
                "probe_layout" => Some(1),
                VERTEX | FRAGMENT => None,
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
        let frame =
            Frame { width: 16, height: 16, side: 1, rays: 256, lights: 1, views: 7, ..Frame::zeroed() };
        let frame =
            Frame { seen: 1, instances: 1, blocks: 2, capacity: 1, details: 1, ambient_view: 7, ..frame };
        let mut rows = Vec::new();
        for frame in [0, 3].into_iter().flat_map(|layers| {
            [0, 24].into_iter().flat_map(move |penumbra_window| {
                [0, 1].map(|is_drawn| Frame {
                    layers,
                    penumbra_window,
                    is_drawn,
                    is_shared: is_drawn,
                    extensions: is_drawn,
                    ..frame
                })
            })
        }) {
            let mut stages: Vec<_> = Vec::new();
            for step in steps(&frame) {
                for (row, entry) in entries(step).filter(|(_, entry)| (entry.serves)(&frame)) {
                    assert!(entry.groups(step, &frame).is_some(), "{}", entry.name);
                    stages.push(step.stage() as usize);
                    rows.push(row);
                }
            }
            assert!(stages.is_sorted(), "{stages:?}");
            stages.dedup();
            let without_layers = usize::from(!frame.has_layers());
            assert_eq!(stages.len(), Stage::COUNT - without_layers);
        }
        rows.sort_unstable();
        rows.dedup();
        assert_eq!(rows, (0..ENTRIES.len()).collect::<Vec<_>>(), "an entry point serves no frame");
    }

    #[test]
    fn work_beyond_a_row_of_groups_takes_another_row() {
        assert_eq!(groups([1, 1]), [1, 1, 1]);
        assert_eq!(groups([ROW, 1]), [65_535, 1, 1]);
        assert_eq!(groups([ROW + 1, 1]), [65_535, 2, 1]);
        assert_eq!(groups([65, 7]), [2, 1, 7]);
    }
}
