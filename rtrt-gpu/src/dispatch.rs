//! The commands of a frame: its schedule, stage after stage, as dispatches.

use crate::buffers::Buffers;
use crate::device::Device;
use crate::entry::{ENTRIES, Entry, entries};
use crate::pipeline::Pipeline;
use crate::raster::Raster;
use crate::slot::Slot;
use crate::timer::Timer;
use rtrt_core::layout::{Frame, Hit};
use rtrt_core::schedule::{Stage, Step, steps};

/// The pipelines of [`ENTRIES`], each once a frame has needed it.
pub(crate) struct Pipelines(Vec<Option<Pipeline>>);

impl Pipelines {
    /// None of them.
    pub fn new() -> Self {
        Self(vec![None; ENTRIES.len()])
    }

    /// Compiles what the frame dispatches, one entry point after the other, until `is_stopped` says so. Returns whether
    /// all of it is there.
    pub fn compile_all(&mut self, device: &Device, frame: &Frame, is_stopped: &impl Fn() -> bool) -> bool {
        for step in steps(frame) {
            for (row, entry) in entries(step).filter(|(_, entry)| entry.groups(step, frame).is_some()) {
                if self.0[row].is_none() && is_stopped() {
                    return false;
                }
                self.compile(device, row, entry);
            }
        }
        true
    }

    /// Compiles what the frame dispatches, and makes what its dispatches bind, where these are not
    /// there yet.
    pub fn make(&mut self, device: &Device, frame: &Frame, buffers: &mut Buffers) {
        for step in steps(frame) {
            for (row, entry) in entries(step).filter(|(_, entry)| entry.groups(step, frame).is_some()) {
                let pipeline = self.compile(device, row, entry);
                buffers.make_group(group_number(step, row), |buffers| {
                    let bound = entry.slots().filter_map(|slot| buffers.of_layer(slot, step.layer));
                    pipeline.group(&device.device, bound)
                });
            }
        }
    }

    /// The pipeline of a row; that of another row with the same entry point if there is one.
    fn compile(&mut self, device: &Device, row: usize, entry: &Entry) -> &Pipeline {
        let rows = &mut self.0;
        if rows[row].is_none() {
            let mut same = ENTRIES.iter().zip(&*rows).filter(|(other, _)| other.name == entry.name);
            rows[row] = same.find_map(|(_, pipeline)| pipeline.clone());
        }
        rows[row].get_or_insert_with(|| device.pipeline(entry.name, entry.accesses()))
    }
}

/// The number of the buffers that a row binds for a step.
fn group_number(step: Step, row: usize) -> usize {
    step.layer as usize * ENTRIES.len() + row
}

/// What makes commands for a band of a frame.
pub(crate) struct Encoder<'a> {
    pub device: &'a Device,
    pub pipelines: &'a Pipelines,
    pub buffers: &'a Buffers,
    pub timer: &'a Timer,
    /// What draws the closest surfaces, unless they are traced.
    pub raster: Option<&'a Raster>,
    pub frame: &'a Frame,
    /// Whether the hits of layers behind the first are copied.
    pub keeps_layers: bool,
}

impl Encoder<'_> {
    /// Appends a stage to the commands. One without steps takes its time all the same.
    pub fn stage(&self, commands: &mut wgpu::CommandEncoder, stage: Stage) {
        let drawn = self.raster.filter(|_| stage == Stage::Visibility);
        if let Some(raster) = drawn {
            raster.encode(self.device, commands, self.timer, self.frame, self.buffers);
        }
        let behind = self.frame.layers_behind();
        let [first, last] = if stage == Stage::Layers { [1, behind.max(1)] } else { [0, 0] };
        for layer in first..=last {
            let writes = self.timer.writes(stage, layer == first && drawn.is_none(), layer == last);
            self.layer(commands, stage, layer, writes);
            if self.keeps_layers && (1..=behind).contains(&layer) {
                self.keep_hits(commands, layer);
            }
        }
    }

    /// Appends the steps of a stage over one layer of surfaces.
    fn layer(
        &self,
        commands: &mut wgpu::CommandEncoder,
        stage: Stage,
        layer: u32,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let steps = || steps(self.frame).filter(|step| step.stage() == stage && step.layer == layer);
        for (_, entry) in steps().flat_map(entries).filter(|_| layer == 0) {
            if let Some(buffer) =
                self.buffers.get(entry.writes[0]).filter(|_| (entry.starts_at_zero)(self.frame))
            {
                commands.clear_buffer(buffer, 0, None);
            }
        }
        let label = Some(stage.name());
        let mut pass = commands.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        for step in steps() {
            self.step(&mut pass, step);
        }
    }

    /// Appends the dispatches of a step.
    pub fn step(&self, pass: &mut wgpu::ComputePass<'_>, step: Step) {
        for (row, entry) in entries(step) {
            let (pipeline, group) = (&self.pipelines.0[row], self.buffers.group(group_number(step, row)));
            if let (Some(groups), Some(pipeline), Some(group)) =
                (entry.groups(step, self.frame), pipeline, group)
            {
                pipeline.dispatch(pass, group, groups);
            }
        }
    }

    /// Appends the copy of the hits of a layer.
    fn keep_hits(&self, commands: &mut wgpu::CommandEncoder, layer: u32) {
        let bytes = u64::from(self.frame.rays) * size_of::<Hit>() as u64;
        if let (Some(hits), Some(layers)) = (self.buffers.get(Slot::Hits), self.buffers.get(Slot::Layers)) {
            commands.copy_buffer_to_buffer(hits, 0, layers, u64::from(layer - 1) * bytes, bytes);
        }
    }
}
