//! What dispatches bind: made once for the buffers that there are.

use crate::buffers::Slot;
use crate::pipeline::{LAYERS, PASSES, Pipeline, groups};
use rtrt_core::layout::Frame;

/// The bind groups of a frame's dispatches. They hold on to the buffers that they bind.
#[derive(Default)]
pub(crate) struct Groups(Vec<Option<wgpu::BindGroup>>);

impl Groups {
    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// That of a row of [`PASSES`]; of what is repeated for layers of surfaces, for one of them,
    /// counted from 0.
    pub fn get(&self, row: usize, layer: usize) -> Option<&wgpu::BindGroup> {
        self.0.get(layer * PASSES.len() + row)?.as_ref()
    }

    /// Makes those that the frame needs and that are not there. `layers` are what layers get for
    /// the numbers of the frame.
    pub fn make<'a>(
        &mut self,
        device: &wgpu::Device,
        frame: &Frame,
        pipelines: &[Option<Pipeline>],
        layers: &[wgpu::Buffer],
        buffer: impl Fn(Slot) -> Option<&'a wgpu::Buffer>,
    ) {
        let count = PASSES.len() * layers.len().max(1);
        if self.0.len() < count {
            self.0.resize(count, None);
        }
        for (row, (pass, pipeline)) in PASSES.iter().zip(pipelines).enumerate() {
            let Some(pipeline) = pipeline.as_ref().filter(|_| !groups((pass.work)(frame)).contains(&0))
            else {
                continue;
            };
            let repeats = if pass.stage == LAYERS { frame.layers.max(1) as usize - 1 } else { 1 };
            for layer in 0..repeats {
                let group = &mut self.0[layer * PASSES.len() + row];
                if group.is_none() {
                    let uniform = layers.get(layer).filter(|_| pass.stage == LAYERS);
                    let buffers = pass.slots().filter_map(|slot| match (slot, uniform) {
                        (Slot::Frame, Some(uniform)) => Some(uniform),
                        _ => buffer(slot),
                    });
                    *group = Some(pipeline.group(device, buffers));
                }
            }
        }
    }
}
